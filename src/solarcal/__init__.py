"""solarcal: calibrate a sun tracker from the terminal."""

__version__ = "0.1.0"
