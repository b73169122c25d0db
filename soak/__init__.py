"""What takes long: a thousand killed journals, a month in the workstation (``make soak``)."""
