"""Directions and mirrors as vectors, the plane of reflection; a heliostat's target.

All vectors are East-North-Up (E, N, U) and point AWAY from the mirror: to the Sun, to the target,
along the mirror's normal. Azimuths run from North through East, zenith angles from straight up;
degrees. Arrays broadcast; vectors have the shape (..., 3).

The cosine of the angle Sun-target and the place of the normal half-way between them follow
10-physics, section 6. The printed arcsine forms lose the quadrant; the vectors do not.

**Aiming**: Sun and target given, the mirror's normal stands half-way between them, gamma/2 from
either. **Targeting** is the inverse: the normal is read from the axes while the beam is seen on
the target, and the target lies where the Sun is reflected to. Both for a mirror whose surface
passes through the crossing of the axes; ``offset_mirror`` is about those that do not.
"""

import math
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from solarcal.decimals import require_between, require_positive
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
    """Refuse (ConfigurationError) a Sun below the horizon, or no angle at all."""
    if not -180.0 <= sun_zenith_deg <= 180.0:
        raise ConfigurationError(f"a zenith angle of {sun_zenith_deg:g} deg of the Sun cannot be")
    if abs(sun_zenith_deg) >= 90.0:
        raise ConfigurationError(
            f"the Sun is {abs(sun_zenith_deg) - 90.0:.2f} deg below the horizon: there is nothing "
            "to reflect"
        )


def require_reflection(sun: FloatArray, target: FloatArray) -> None:
    """Refuse (ConfigurationError) a Sun within 0.1 deg of opposite the target: no mirror joins
    them, the light would graze along it."""
    apart = float(angle_deg(sun, target))
    if apart > 179.9:
        raise ConfigurationError(
            f"Sun and target stand opposite each other ({apart:.2f} deg apart): the light would "
            "graze along the mirror, and no normal joins them"
        )


def _length(vector: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.sum(vector * vector, axis=-1)))


class Target(msgspec.Struct, frozen=True):
    """The target vector as the controller keeps it: seen from the hub, the crossing of the axes.

    ``distance`` is in any unit of length, the same as the mirror's offsets.

    Raises
    ------
    ConfigurationError
        A direction or distance that cannot be.
    """

    azimuth_deg: float
    zenith_deg: float
    distance: float

    def __post_init__(self) -> None:
        require_between("target azimuth", self.azimuth_deg, -360.0, 360.0, " deg")
        if not 0.0 <= self.zenith_deg <= 180.0:
            raise ConfigurationError(
                f"target zenith angle {self.zenith_deg:g} deg is not between 0 (straight up) and "
                "180 (straight down)"
            )
        require_positive("the distance of the target", self.distance)

    def direction_enu(self) -> FloatArray:
        """Unit vector from the hub, (3,)."""
        return direction_enu(self.azimuth_deg, self.zenith_deg)

    def vector_enu(self) -> FloatArray:
        """The target as seen from the hub, (3,), in its unit of length."""
        return self.distance * self.direction_enu()


@dataclass(frozen=True, slots=True)
class Targeting:
    """The direction of the target, and how well the observations agree about it.

    ``residual_deg`` (n,): angle between where each observation puts the target and the mean;
    ``rms_deg`` their root mean square per axis (n - 1 observations' worth), ``sigma_deg`` that of
    the mean; both ``None`` from a single observation, which contradicts nothing.
    """

    azimuth_deg: float
    zenith_deg: float
    residual_deg: tuple[float, ...]
    rms_deg: float | None
    sigma_deg: float | None


def targeting(
    sun_azimuth_deg: FloatArray,
    sun_zenith_deg: FloatArray,
    normal_azimuth_deg: FloatArray,
    normal_zenith_deg: FloatArray,
) -> Targeting:
    """The target's direction from observations of the beam on it; arrays (n,).

    Least squares: the unit vector with the smallest sum of squared distances to the reflected
    directions is their mean, brought to length one. The distance is not in the angles: measure it.

    Raises
    ------
    ConfigurationError
        No observation; one with the Sun below the horizon or behind the mirror; observations so
        far apart that they cannot be of one target.
    """
    suns_azimuth, suns_zenith, normals_azimuth, normals_zenith = (
        np.atleast_1d(np.asarray(a, dtype=np.float64))
        for a in (sun_azimuth_deg, sun_zenith_deg, normal_azimuth_deg, normal_zenith_deg)
    )
    if not len(suns_azimuth):
        raise ConfigurationError("targeting needs at least one observation")
    for sun_zenith in suns_zenith:
        require_above_horizon(float(sun_zenith))
    suns = direction_enu(suns_azimuth, suns_zenith)
    normals = direction_enu(normals_azimuth, normals_zenith)
    facing = np.sum(suns * normals, axis=-1)
    if (facing <= 0.0).any():
        worst = int(np.argmin(facing))
        raise ConfigurationError(
            f"observation {worst + 1}: the Sun is behind the mirror "
            f"({float(angle_deg(suns[worst], normals[worst])):.2f} deg from its normal)"
        )
    targets = reflected(suns, normals)
    mean = targets.mean(axis=0)
    if float(np.linalg.norm(mean)) < 0.5:
        raise ConfigurationError(
            "these observations put the target in opposite directions; they are not of one target"
        )
    mean = unit(mean)
    residuals = angle_deg(targets, mean)
    n = len(residuals)
    azimuth, zenith = horizontal_deg(mean)
    # Two components to each observation, two unknowns in all.
    rms = math.sqrt(float(np.sum(residuals**2)) / (2.0 * (n - 1))) if n > 1 else None
    return Targeting(
        float(azimuth),
        float(zenith),
        tuple(residuals.tolist()),
        rms,
        None if rms is None else rms / math.sqrt(n),
    )


def translation_deg(shift: float, distance: float) -> float:
    """By how much a translation across the line of sight turns it: 3 ft at 800 ft is 0.215 deg."""
    require_positive("the distance", distance)
    return math.atan2(shift, distance) / RAD_PER_DEG
