"""An honest stand-in for a sun tracker: a world with a hidden truth, and a controller in it."""
