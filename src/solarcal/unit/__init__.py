"""Talk to a controller."""
