"""Where is the Sun? Four models behind one function, refraction, day events and a fast path."""

from solarcal.sun.position import SUN_MODELS, SunPosition, sun_position
from solarcal.sun.refraction import REFRACTIONS, apparent_zenith_deg

__all__ = ["REFRACTIONS", "SUN_MODELS", "SunPosition", "apparent_zenith_deg", "sun_position"]
