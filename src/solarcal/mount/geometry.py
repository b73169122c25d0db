"""The axes of each mount: how they see a direction, and how far they may go.

Every mount has a right-handed frame x, y, z fixed to Earth with z along its primary axis. For a
unit vector s in native components AX1 = atan2(s_y, s_x) and AX2 = acos(s_z): AX2 is the polar
distance from the primary axis, in [0, 180].

    geometry      x (AX1 = 0)                     y       z (primary axis)
    azel          South                           East    Up
    tiltroll-ew   Up                              South   East
    tiltroll-ns   Up                              East    North
    polar         meridian point of the equator   East    north celestial pole

AX1 lies on the continuous branch (c - 180, c + 180] around the mount's ``ax1_centre_deg`` c.
Software limits hold for the absolute read-outs.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import msgspec
import numpy as np

from solarcal.decimals import require_between
from solarcal.errors import ConfigurationError
from solarcal.units import RAD_PER_DEG, Angles, FloatArray, wrap_deg

Value: TypeAlias = Any
"""A float or a float64 array, whichever the caller of the equation came with."""

Vector: TypeAlias = tuple[Value, Value, Value]
"""Three components, each a float or an array; kept apart because (..., 3) arrays are slower."""


Rows: TypeAlias = tuple[Vector, Vector, Vector]
"""x, y, z of a native frame as East-North-Up vectors."""


def _choose(condition: bool, if_true: float, if_false: float) -> float:
    return if_true if condition else if_false


def _wrap_float_deg(angle_deg: float, centre_deg: float = 0.0) -> float:
    return float(wrap_deg(angle_deg, centre_deg))


class Maths(NamedTuple):
    """The functions the mount's equations need, under numpy's names."""

    sin: Callable[[Value], Value]
    cos: Callable[[Value], Value]
    arctan2: Callable[[Value, Value], Value]
    arccos: Callable[[Value], Value]
    hypot: Callable[[Value, Value], Value]
    sqrt: Callable[[Value], Value]
    where: Callable[[Value, Value, Value], Value]
    ceil: Callable[[Value], Value]
    wrap_deg: Callable[..., Value]
    any: Callable[[Value], bool]


_FLOATS = Maths(
    math.sin,
    math.cos,
    math.atan2,
    math.acos,
    math.hypot,
    math.sqrt,
    _choose,
    lambda value: float(np.ceil(value)),
    _wrap_float_deg,
    bool,
)
ARRAYS = Maths(
    np.sin,
    np.cos,
    np.arctan2,
    np.arccos,
    np.hypot,
    np.sqrt,
    np.where,
    np.ceil,
    wrap_deg,
    lambda condition: bool(np.any(condition)),
)


def maths_for(*values: Value) -> Maths:
    """``math`` when every value is a plain number, numpy when any is an array."""
    for value in values:
        if not isinstance(value, (float, int)):
            return ARRAYS
    return _FLOATS


def rotated(rows: tuple[Vector, Vector, Vector], vector: Vector) -> Vector:
    """Components of a vector along three directions."""
    x, y, z = vector
    a, b, c = rows
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


def unit_vector(m: Maths, ax1_rad: Value, ax2_rad: Value) -> Vector:
    """Direction of longitude ``ax1`` and polar distance ``ax2``."""
    sin2 = m.sin(ax2_rad)
    return sin2 * m.cos(ax1_rad), sin2 * m.sin(ax1_rad), m.cos(ax2_rad)


GEOMETRIES = ("azel", "tiltroll-ew", "tiltroll-ns", "polar")

_EAST: Vector = (1.0, 0.0, 0.0)
_NORTH: Vector = (0.0, 1.0, 0.0)
_SOUTH: Vector = (0.0, -1.0, 0.0)
_UP: Vector = (0.0, 0.0, 1.0)
_DEG_PER_RAD = 1.0 / RAD_PER_DEG


@lru_cache(maxsize=64)
def _rows(name: str, latitude_deg: float) -> Rows:
    """Native x, y, z as East-North-Up vectors."""
    if name == "azel":
        return _SOUTH, _EAST, _UP
    if name == "tiltroll-ew":
        return _UP, _SOUTH, _EAST
    if name == "tiltroll-ns":
        return _UP, _EAST, _NORTH
    sin_lat = math.sin(latitude_deg * RAD_PER_DEG)
    cos_lat = math.cos(latitude_deg * RAD_PER_DEG)
    return (0.0, -sin_lat, cos_lat), _EAST, (0.0, cos_lat, sin_lat)


def axes_of_horizontal_deg(
    rows: Rows, ax1_centre_deg: Value, azimuth_deg: Value, zenith_deg: Value
) -> tuple[Value, Value]:
    """(AX1 on the branch, AX2) of a direction in native frames that may differ from point to point.

    ``rows``: native x, y, z as East-North-Up vectors, their components floats or arrays like the
    angles, and like ``ax1_centre_deg``.
    """
    m = maths_for(azimuth_deg, zenith_deg)
    azimuth, zenith = azimuth_deg * RAD_PER_DEG, zenith_deg * RAD_PER_DEG
    sin_zenith = m.sin(zenith)
    enu = (sin_zenith * m.sin(azimuth), sin_zenith * m.cos(azimuth), m.cos(zenith))
    x, y, z = rotated(rows, enu)
    # atan2 instead of acos: acos loses half the digits near the primary axis. On the axis itself
    # AX1 is undetermined and given as 0 (on the branch).
    ax1 = m.wrap_deg(m.arctan2(y, x) * _DEG_PER_RAD, ax1_centre_deg)
    return ax1, m.arctan2(m.hypot(x, y), z) * _DEG_PER_RAD


def horizontal_of_axes_deg(rows: Rows, ax1_deg: Value, ax2_deg: Value) -> tuple[Value, Value]:
    """(azimuth in [0, 360), zenith angle) of axis angles; ``rows`` as in the other direction."""
    m = maths_for(ax1_deg, ax2_deg)
    native = unit_vector(m, ax1_deg * RAD_PER_DEG, ax2_deg * RAD_PER_DEG)
    # The basis is orthonormal: its transpose leads back from native to ENU components.
    column1, column2, column3 = zip(*rows, strict=True)
    east, north, up = rotated((column1, column2, column3), native)
    azimuth = m.arctan2(east, north) * _DEG_PER_RAD
    azimuth = m.where(azimuth < 0.0, azimuth + 360.0, azimuth)
    # A hair west of North plus 360 rounds up to 360.
    azimuth = m.where(azimuth >= 360.0, azimuth - 360.0, azimuth)
    return azimuth, m.arctan2(m.hypot(east, north), up) * _DEG_PER_RAD


class MountGeometry(msgspec.Struct, frozen=True):
    """The axes of one mount at one latitude, with the branch of AX1.

    Angles are degrees, scalars or arrays that broadcast together; floats in give floats out. The
    centre of the branch, where it is left out, is that of ``default_ax1_centre``.

    Raises
    ------
    ConfigurationError
        Unknown geometry, or a latitude or branch centre that cannot be.
    """

    name: str
    latitude_deg: float
    ax1_centre_deg: float = math.nan

    def __post_init__(self) -> None:
        if self.name not in GEOMETRIES:
            raise ConfigurationError(
                f"unknown geometry {self.name!r}: choose {', '.join(GEOMETRIES)}"
            )
        require_between("latitude", self.latitude_deg, -90.0, 90.0)
        if math.isnan(self.ax1_centre_deg):
            centre_deg = default_ax1_centre(self.name, self.latitude_deg)
            msgspec.structs.force_setattr(self, "ax1_centre_deg", centre_deg)
        require_between("AX1 branch centre", self.ax1_centre_deg, -360.0, 360.0, " deg")

    def basis(self) -> FloatArray:
        """Rows x, y, z of the native frame in East-North-Up components, shape (3, 3)."""
        return np.array(_rows(self.name, self.latitude_deg))

    def up_components(self) -> Vector:
        """The local vertical in native components as three floats."""
        x, y, z = _rows(self.name, self.latitude_deg)
        return x[2], y[2], z[2]

    def branch(self, ax1_deg: Angles) -> Angles:
        """AX1 brought onto (c - 180, c + 180]; a value already there is not touched."""
        return maths_for(ax1_deg).wrap_deg(ax1_deg, self.ax1_centre_deg)  # type: ignore[no-any-return]

    def axes_from_horizontal(
        self, azimuth_deg: Angles, zenith_deg: Angles
    ) -> tuple[Angles, Angles]:
        """(AX1, AX2) of a direction; azimuth from North through East, zenith angle, degrees."""
        rows = _rows(self.name, self.latitude_deg)
        return axes_of_horizontal_deg(rows, self.ax1_centre_deg, azimuth_deg, zenith_deg)

    def horizontal_from_axes(self, ax1_deg: Angles, ax2_deg: Angles) -> tuple[Angles, Angles]:
        """(azimuth in [0, 360), zenith angle) of the direction at these axis angles, degrees."""
        return horizontal_of_axes_deg(_rows(self.name, self.latitude_deg), ax1_deg, ax2_deg)

    def sky_separation_deg(
        self, first1_deg: Angles, first2_deg: Angles, second1_deg: Angles, second2_deg: Angles
    ) -> Angles:
        """Angle on the sky between two pairs of axis angles, degrees (haversine formula)."""
        m = maths_for(first1_deg, first2_deg, second1_deg, second2_deg)
        first2, second2 = first2_deg * RAD_PER_DEG, second2_deg * RAD_PER_DEG
        along = m.sin(0.5 * (second2 - first2))
        across = m.sin(0.5 * RAD_PER_DEG * (second1_deg - first1_deg))
        half = along * along + m.sin(first2) * m.sin(second2) * across * across
        # Rounding can carry antipodes beyond 1 and, at a pole of AX2 = 180, below 0.
        half = m.where(half > 1.0, 1.0, m.where(half < 0.0, 0.0, half))
        return 2.0 * _DEG_PER_RAD * m.arctan2(m.sqrt(half), m.sqrt(1.0 - half))  # type: ignore[no-any-return]


def default_ax1_centre(name: str, latitude_deg: float) -> float:
    """Branch centre that keeps the Sun's daily path whole outside the tropics, degrees.

    180 for ``azel`` south of the equator, where the Sun culminates in the North; else 0.
    """
    return 180.0 if name == "azel" and latitude_deg < 0.0 else 0.0


def crosses_branch(ax1_deg: FloatArray, ax1_centre_deg: float = 0.0) -> bool:
    """Whether a path of ideal AX1 jumps across c +- 180: one range cannot hold it.

    ``ax1_deg``: (n,) array, degrees, in order of time: the Sun's path within limits, on any branch.
    NaN parts one stretch from the next (night, beyond limits): a step over it does not count.

    Notes
    -----
    Between two samples the axis is taken to have gone the short way round, so they must be dense
    enough that it turns less than 180 deg from one to the next (a minute or two at most where the
    Sun passes close to the primary axis).
    """
    steps = np.diff(wrap_deg(np.asarray(ax1_deg, dtype=np.float64), ax1_centre_deg))
    return bool(np.any(np.abs(steps) > 180.0))


class AxisLimits(msgspec.Struct, frozen=True):
    """Software limits of one axis, degrees of absolute read-out (axis 1: on its branch)."""

    low_deg: float
    high_deg: float

    def __post_init__(self) -> None:
        if not self.low_deg < self.high_deg:
            raise ConfigurationError(
                f"limits {self.low_deg:g} to {self.high_deg:g} deg leave the axis no range: "
                "the lower one comes first"
            )

    def distance_deg(self, reading_deg: Angles) -> Angles:
        """Distance to the nearer limit, negative outside; elementwise."""
        below, above = reading_deg - self.low_deg, self.high_deg - reading_deg
        if isinstance(below, float) and isinstance(above, float):
            return min(below, above)
        return np.minimum(below, above)

    def clamped_deg(self, reading_deg: float) -> float:
        """The read-out, or the limit it lies beyond."""
        return min(max(reading_deg, self.low_deg), self.high_deg)


def from_limit(distance_deg: float, decimals: int) -> str:
    """``0.50 deg from a limit``; a negative distance is beyond it."""
    side = "beyond" if distance_deg < 0.0 else "from"
    return f"{abs(distance_deg):.{decimals}f} deg {side} a limit"


class Limits(msgspec.Struct, frozen=True):
    """Software limits of both axes."""

    axis1: AxisLimits
    axis2: AxisLimits

    def words(self) -> str:
        """Both axes' in degrees."""
        of_axes = ((1, self.axis1), (2, self.axis2))
        return ", ".join(f"axis {n} {one.low_deg:g} to {one.high_deg:g}" for n, one in of_axes)

    def distance_deg(self, reading1_deg: Angles, reading2_deg: Angles) -> Angles:
        """Distance to the nearest limit of either axis, negative outside; elementwise."""
        first, second = self.axis1.distance_deg(reading1_deg), self.axis2.distance_deg(reading2_deg)
        if isinstance(first, float) and isinstance(second, float):
            return min(first, second)
        return np.minimum(first, second)

    def beyond(self, reading1_deg: float, reading2_deg: float) -> str:
        """Which limit these read-outs are beyond, in words; empty where they are within."""
        for number, limits, reading_deg in (
            (1, self.axis1, reading1_deg),
            (2, self.axis2, reading2_deg),
        ):
            if limits.distance_deg(reading_deg) < 0.0:
                return (
                    f"axis {number}: {reading_deg:z.3f} is beyond "
                    f"{limits.low_deg:g}..{limits.high_deg:g}"
                )
        return ""
