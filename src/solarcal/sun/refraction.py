"""How far the air lifts the Sun. The original controller applies none of this.

Both formulas take the TRUE altitude and are scaled by P/P0 * 283/(273 + T): density, to the
accuracy that a field thermometer deserves.
"""

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.site import Weather
from solarcal.units import ARCSEC_PER_DEG, RAD_PER_DEG, Angles, FloatArray

REFRACTIONS = ("none", "hughes", "saemundsson")


def apparent_zenith_deg(
    true_zenith_deg: Angles, refraction: str, weather: Weather | None = None
) -> Angles:
    """Zenith angle as seen through the air, from the airless one, elementwise.

    ``weather``: STATION pressure and temperature; the standard atmosphere at sea level where left
    out. ConfigurationError: the refraction is not one of ``REFRACTIONS``.
    """
    if refraction == "none":
        return true_zenith_deg
    air = weather or Weather()
    if refraction == "hughes" and isinstance(true_zenith_deg, float):
        lift = _hughes_arcsec_of_one(90.0 - true_zenith_deg) / ARCSEC_PER_DEG * air.pressure_hpa
        return true_zenith_deg - lift / 1013.25 * (283.0 / (273.0 + air.temperature_c))
    altitude_deg = np.asarray(90.0 - true_zenith_deg, dtype=np.float64)
    if refraction == "hughes":
        lift_deg = _hughes_arcsec(altitude_deg) / ARCSEC_PER_DEG * air.pressure_hpa / 1013.25
    elif refraction == "saemundsson":
        lift_deg = _saemundsson_arcmin(altitude_deg) / 60.0 * air.pressure_hpa / 1010.0
    else:
        raise ConfigurationError(
            f"unknown refraction {refraction!r}; choose one of {', '.join(REFRACTIONS)}"
        )
    apparent = true_zenith_deg - lift_deg * (283.0 / (273.0 + air.temperature_c))
    return apparent if isinstance(true_zenith_deg, np.ndarray) else float(apparent)


def _hughes_arcsec(altitude_deg: FloatArray) -> FloatArray:
    """Refraction at 1013.25 hPa and 10 C (Hughes 1985 in Zimmerman's piecewise form)."""
    # Clipped per branch, so that each is evaluated only where it is finite.
    tan_high = np.tan(np.maximum(altitude_deg, 5.0) * RAD_PER_DEG)
    high = (58.1 - (0.07 - 0.000086 / tan_high**2) / tan_high**2) / tan_high
    h = np.clip(altitude_deg, -0.575, 5.0)
    middle = 1735.0 + h * (-518.2 + h * (103.4 + h * (-12.79 + h * 0.711)))
    low = -20.774 / np.tan(np.minimum(altitude_deg, -0.575) * RAD_PER_DEG)
    return np.where(altitude_deg > 5.0, high, np.where(altitude_deg > -0.575, middle, low))


def _hughes_arcsec_of_one(altitude_deg: float) -> float:
    """The same of one altitude, bit for bit: emulators ask tens of thousands of times a day."""
    if altitude_deg > 5.0:
        tan = float(np.tan(altitude_deg * RAD_PER_DEG))
        square = tan * tan
        return (58.1 - (0.07 - 0.000086 / square) / square) / tan
    if altitude_deg > -0.575:
        h = altitude_deg
        return 1735.0 + h * (-518.2 + h * (103.4 + h * (-12.79 + h * 0.711)))
    return -20.774 / float(np.tan(altitude_deg * RAD_PER_DEG))


def _saemundsson_arcmin(altitude_deg: FloatArray) -> FloatArray:
    """Refraction at 1010 hPa and 10 C (Saemundsson 1986)."""
    # The formula turns over 1.9 deg below the horizon and is meaningless from there on down.
    h = np.maximum(altitude_deg, -1.9)
    return 1.02 / np.tan((h + 10.3 / (h + 5.11)) * RAD_PER_DEG)
