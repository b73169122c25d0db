"""Angle constants and wrapping, shared by all packages."""

from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""float64 array; its shape is in the docstring of whoever takes or returns it."""

RAD_PER_DEG = np.pi / 180.0
ARCSEC_PER_DEG = 3600.0

SUN_RADIUS_DEG = 0.2666
"""Of the Sun's disc at the mean distance; it is 9.3 mrad across."""


Angles = TypeVar("Angles", float, FloatArray)
"""Degrees as a float or as an array: a function of ``Angles`` returns what it was given."""


def wrap_deg(angle_deg: Angles, centre_deg: float = 0.0) -> Angles:
    """Bring angles onto the branch (centre - 180, centre + 180], elementwise.

    An angle already on the branch is returned unchanged to the last bit.
    """
    turns = np.ceil((angle_deg - centre_deg - 180.0) / 360.0)
    # An angle just above centre - 180 rounds to a whole turn below it.
    on_branch = (angle_deg > centre_deg - 180.0) & (angle_deg <= centre_deg + 180.0)
    return angle_deg - 360.0 * turns * np.logical_not(on_branch)  # type: ignore[no-any-return]


def format_degrees(angle_deg: float, decimals: int = 3) -> str:
    """A signed angle for a table, without a negative zero."""
    return f"{angle_deg:+z.{decimals}f}"


def rms(values: FloatArray) -> float:
    """Root mean square of all values; there must be one."""
    return float(np.sqrt(np.mean(values**2)))
