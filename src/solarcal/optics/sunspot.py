"""The sunspot device: an orifice plate over a mirror throws a spot of the Sun back onto itself.

With the plate at height H above the mirror the light travels F = 2H from hole to spot. When the
collector points exactly at the Sun, the spot surrounds the hole evenly and the distance E from the
edge of the hole to the edge of the spot is the difference of the radii, Rs - Ro, on every side. A
pointing error moves the spot: error = atan((E - (Rs - Ro)) / F).
"""

import math

from solarcal.errors import ConfigurationError
from solarcal.units import RAD_PER_DEG

LARGEST_ERROR_RAD = 0.1
"""The relation is for small angles; beyond this the spot is not on any plate."""


def spot_error_deg(height: float, hole_diameter: float, spot_diameter: float, edge: float) -> float:
    """Pointing error along one direction of the plate.

    Parameters
    ----------
    height : H, orifice plate above the mirror.
    hole_diameter, spot_diameter : Do and Ds.
    edge : E, from the edge of the hole to the edge of the spot, on the side asked about; negative
        where the spot's edge lies within the hole.

    All four in one unit, whichever.

    Returns
    -------
    float
        Degrees on the sky, positive when the spot stands too far to that side.

    Raises
    ------
    ConfigurationError
        A height or diameter that no device has, or an error beyond 0.1 rad.
    """
    for name, value in (
        ("the height H", height),
        ("the hole's diameter Do", hole_diameter),
        ("the spot's diameter Ds", spot_diameter),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise ConfigurationError(f"{name} must be greater than zero, not {value:g}")
    if not math.isfinite(edge):
        raise ConfigurationError(f"the edge distance E must be a number, not {edge:g}")
    error_rad = math.atan((edge - 0.5 * (spot_diameter - hole_diameter)) / (2.0 * height))
    if abs(error_rad) > LARGEST_ERROR_RAD:
        raise ConfigurationError(
            f"these readings mean an error of {error_rad / RAD_PER_DEG:.1f} deg, beyond what the "
            "device can show (0.1 rad); check that all four are in the same unit"
        )
    return error_rad / RAD_PER_DEG
