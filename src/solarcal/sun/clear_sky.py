"""What the Sun gives through clear air: from percent of full Sun to W/m2 and kWh a day.

Direct beam by Ineichen and Perez, with the Linke turbidity as the one number that says how clear
the air is (2 very clean and cold, 3 clean and warm, 5 hazy), and the relative air mass of Kasten
and Young. SUNCALC itself counts 1.40 kW/m2 outside the air.

References
----------
P. Ineichen and R. Perez, Solar Energy 73 (2002) 151. F. Kasten and A. T. Young, Applied Optics 28
(1989) 4735. Both as in pvlib-python (`clearsky.ineichen`, `atmosphere.get_relative_airmass`).
"""

import numpy as np

from solarcal.sun.circular_orbit import CircularDay
from solarcal.sun.energy import Collector
from solarcal.units import RAD_PER_DEG, FloatArray

SUNCALC_W_M2 = 1400.0
"""SUNCALC's flux outside the air."""
SOLAR_CONSTANT_W_M2 = 1361.0
CLEAN_TURBIDITY = 3.0
_STEPS = 720


def air_mass(zenith_deg: FloatArray) -> FloatArray:
    """Relative air mass at an apparent zenith angle, infinite below the horizon; (...)."""
    z = np.minimum(zenith_deg, 90.0)
    mass = 1.0 / (np.cos(z * RAD_PER_DEG) + 0.50572 * (96.07995 - z) ** -1.6364)
    return np.where(np.asarray(zenith_deg) > 90.0, np.inf, mass)


def direct_w_m2(
    zenith_deg: FloatArray, turbidity: float = CLEAN_TURBIDITY, elevation_m: float = 0.0
) -> FloatArray:
    """Direct beam on a surface that faces the Sun, W/m2; 0 below the horizon; (...)."""
    up = np.asarray(zenith_deg) < 90.0
    z = np.where(up, zenith_deg, 89.0)
    # Air mass at the site's own pressure, of a standard atmosphere.
    pressure = (1.0 - 2.25577e-5 * elevation_m) ** 5.25588
    mass = air_mass(z) * pressure
    cos_z = np.maximum(np.cos(z * RAD_PER_DEG), 1e-6)
    fh1, fh2 = np.exp(-elevation_m / 8000.0), np.exp(-elevation_m / 1250.0)
    cg1, cg2 = 5.09e-5 * elevation_m + 0.868, 3.92e-5 * elevation_m + 0.0387
    level = cg1 * cos_z * np.exp(-cg2 * mass * (fh1 + fh2 * (turbidity - 1.0)))
    beam = (0.664 + 0.163 / fh1) * np.exp(-0.09 * mass * (turbidity - 1.0))
    # Never more than the level flux less the least diffuse light leaves.
    least = 1.0 - (0.1 - 0.2 * np.exp(-turbidity)) / (0.1 + 0.882 / fh1)
    share = np.minimum(beam, np.maximum(level * least / cos_z, 0.0))
    return np.where(up, SOLAR_CONSTANT_W_M2 * share, 0.0)


def moment_w_m2(
    collector: Collector,
    day: CircularDay,
    solar_time_h: float,
    turbidity: float = CLEAN_TURBIDITY,
    elevation_m: float = 0.0,
) -> float:
    """Direct beam that a collector catches at one moment under a clear sky, W/m2."""
    sun = day.direction_neu(solar_time_h)
    beam = direct_w_m2(_zenith_deg(sun), turbidity, elevation_m)
    return float(collector.share(sun) * beam)


def day_kwh_m2(
    collector: Collector,
    day: CircularDay,
    turbidity: float = CLEAN_TURBIDITY,
    elevation_m: float = 0.0,
) -> float:
    """Direct beam that a collector catches over a clear day, kWh/m2."""
    middle = (np.arange(_STEPS) + 0.5) / _STEPS - 0.5
    sun = day.direction_neu(12.0 + day.daylight_h * middle)
    beam = direct_w_m2(_zenith_deg(sun), turbidity, elevation_m)
    return float(np.mean(collector.share(sun) * beam)) * day.daylight_h / 1e3


def _zenith_deg(sun_neu: FloatArray) -> FloatArray:
    return np.asarray(np.arccos(np.clip(sun_neu[..., 2], -1.0, 1.0)) / RAD_PER_DEG)
