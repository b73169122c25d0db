"""Directions and mirrors as vectors: the plane of reflection without lost quadrants.

All vectors are East-North-Up (E, N, U) and point AWAY from the mirror: to the Sun, to the target,
along the mirror's normal. Azimuths run from North through East, zenith angles from straight up;
degrees. Arrays broadcast; vectors have the shape (..., 3).

The cosine of the angle Sun-target and the place of the normal half-way between them follow
10-physics, section 6. The printed arcsine forms lose the quadrant; the vectors do not.
"""

import numpy as np
from numpy.typing import ArrayLike

from solarcal.errors import ConfigurationError
from solarcal.units import RAD_PER_DEG, FloatArray

_TINY = 1e-12


def direction_enu(azimuth_deg: ArrayLike, zenith_deg: ArrayLike) -> FloatArray:
    """Unit vectors (..., 3) of directions."""
    azimuth = np.asarray(azimuth_deg, dtype=np.float64) * RAD_PER_DEG
    zenith = np.asarray(zenith_deg, dtype=np.float64) * RAD_PER_DEG
    flat = np.sin(zenith)
    return np.stack(
        np.broadcast_arrays(flat * np.sin(azimuth), flat * np.cos(azimuth), np.cos(zenith)), axis=-1
    )


def horizontal_deg(vector_enu: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(azimuth in [0, 360), zenith angle) of vectors of any length but zero, each (...)."""
    east, north, up = vector_enu[..., 0], vector_enu[..., 1], vector_enu[..., 2]
    azimuth = np.arctan2(east, north) / RAD_PER_DEG % 360.0
    # A hair west of North plus 360 rounds up to 360.
    azimuth = np.where(azimuth >= 360.0, 0.0, azimuth)
    return azimuth, np.arctan2(np.hypot(east, north), up) / RAD_PER_DEG


def unit(vector: FloatArray) -> FloatArray:
    """Vectors (..., 3) brought to length one; a zero vector stays (nearly) zero."""
    return np.asarray(vector / np.maximum(_length(vector), _TINY)[..., np.newaxis])


def angle_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angle between directions, 0..180, also where it is tiny."""
    a, b = unit(first), unit(second)
    return np.asarray(2.0 * np.arctan2(_length(a - b), _length(a + b)) / RAD_PER_DEG)


def bisector(sun: FloatArray, target: FloatArray) -> FloatArray:
    """The normal (..., 3) that reflects the Sun to the target: delta = unit(sun + target).

    Both must be unit vectors. Where Sun and target stand exactly opposite each other no normal
    does it; the caller asks before (``require_reflection``) where that can happen.
    """
    return unit(sun + target)


def reflected(light: FloatArray, normal: FloatArray) -> FloatArray:
    """Where light from the direction ``light`` leaves to: both point away from the mirror."""
    return np.asarray(2.0 * np.sum(light * normal, axis=-1, keepdims=True) * normal - light)


def require_above_horizon(sun_zenith_deg: float) -> None:
    """Refuse a Sun that does not shine.

    Raises
    ------
    ConfigurationError
        Below the horizon, or no angle at all.
    """
    if not -180.0 <= sun_zenith_deg <= 180.0:
        raise ConfigurationError(f"a zenith angle of {sun_zenith_deg:g} deg of the Sun cannot be")
    if abs(sun_zenith_deg) >= 90.0:
        raise ConfigurationError(
            f"the Sun is {abs(sun_zenith_deg) - 90.0:.2f} deg below the horizon: there is nothing "
            "to reflect"
        )


def require_reflection(sun: FloatArray, target: FloatArray) -> None:
    """Refuse a Sun and a target no mirror joins: they stand opposite each other.

    Raises
    ------
    ConfigurationError
        Within 0.1 deg of opposite: the light would graze along the mirror.
    """
    apart = float(angle_deg(sun, target))
    if apart > 179.9:
        raise ConfigurationError(
            f"Sun and target stand opposite each other ({apart:.2f} deg apart): the light would "
            "graze along the mirror, and no normal joins them"
        )


def _length(vector: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.sum(vector * vector, axis=-1)))
