"""The workstation's widgets."""
