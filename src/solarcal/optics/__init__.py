"""Light and mirrors: what a technician sees, turned into angles."""
