"""A mirror whose surface does not pass through the crossing of the axes.

Seen from the hub (on the azimuth axis, at the height of the elevation axis) the middle of the
mirror stands at

    c = AzimPivot_R a_h + R_el(S) (PivotRefl_R, PivotRefl_Z)        (10-physics, section 6)

with a_h the horizontal direction of the mirror's azimuth, and R_el tilting by its zenith angle S:
lying flat (S = 0) PivotRefl_R is horizontal, along a_h, and PivotRefl_Z points up, along the
normal. So the reflected ray starts elsewhere than at the hub, and the target is seen from there in
another direction; that direction sets the normal, and the normal sets c.

The controller corrects the target's direction to first order and repeats. The exact answer in
three dimensions is the normal that stands half-way between the Sun and the target as seen from the
middle of the mirror; ``mirror_roots`` finds it, and its twin at the back, by bracketing.

``Heliostat`` is the machine as its controller describes it; ``controller_normal_deg`` is what the
controller computes, ``true_normal_deg`` what the geometry demands, each for floats or arrays.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from solarcal.errors import ConfigurationError
from solarcal.optics.reflection import (
    Target,
    angle_deg,
    bisector,
    direction_enu,
    horizontal_deg,
    reflected,
    unit,
)
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

STILL_DEG = 1e-9
"""The normal is repeated until it moves less than this."""

MOST_STEPS = 200
GRAZING = 0.05
"""Cosine of the incidence below which nothing worth the name is reflected, nor iterated for."""


class MirrorOffset(msgspec.Struct, frozen=True):
    """The three lengths, in the unit of the target's distance; all zero: no offset."""

    AzimPivot_R: float = 0.0
    PivotRefl_R: float = 0.0
    PivotRefl_Z: float = 0.0

    def __post_init__(self) -> None:
        for name in ("AzimPivot_R", "PivotRefl_R", "PivotRefl_Z"):
            if not math.isfinite(getattr(self, name)):
                raise ConfigurationError(f"the mirror offset {name} must be a number")

    def __bool__(self) -> bool:
        return self != MirrorOffset()

    @property
    def reach(self) -> float:
        """The farthest the middle of the mirror can stand from the hub."""
        return abs(self.AzimPivot_R) + math.hypot(self.PivotRefl_R, self.PivotRefl_Z)

    def scaled(self, factor: float) -> "MirrorOffset":
        """The lengths times a factor: 1/distance gives the reduced offsets the controller keeps."""
        return MirrorOffset(
            self.AzimPivot_R * factor, self.PivotRefl_R * factor, self.PivotRefl_Z * factor
        )

    def centre_enu(self, azimuth_deg: ArrayLike, zenith_deg: ArrayLike) -> FloatArray:
        """c (..., 3) with the mirror's axis at this azimuth and zenith angle S."""
        azimuth = np.asarray(azimuth_deg, dtype=np.float64) * RAD_PER_DEG
        tilt = np.asarray(zenith_deg, dtype=np.float64) * RAD_PER_DEG
        sin, cos = np.sin(tilt), np.cos(tilt)
        flat = self.AzimPivot_R + self.PivotRefl_R * cos + self.PivotRefl_Z * sin
        up = self.PivotRefl_Z * cos - self.PivotRefl_R * sin
        return np.stack(
            np.broadcast_arrays(flat * np.sin(azimuth), flat * np.cos(azimuth), up), axis=-1
        )


def require_beyond_reach(target: Target, offset: MirrorOffset) -> None:
    """Refuse (ConfigurationError) a target nearer than the mirror itself can stand."""
    if offset.reach >= target.distance:
        raise ConfigurationError(
            f"the target is behind the mirror: its distance {target.distance:g} must be more than "
            f"the mirror's offsets reach, {offset.reach:g}"
        )


def first_order_direction_enu(target: Target, centre: FloatArray) -> FloatArray:
    """The target's direction from the mirror's middle ``centre`` (..., 3), to first order.

    Zenith and azimuth are corrected each in its own plane: zenith in the vertical plane towards
    the target, azimuth in the horizontal one, with the part of c that lies in it.
    """
    azimuth, zenith = target.azimuth_deg * RAD_PER_DEG, target.zenith_deg * RAD_PER_DEG
    east, north, up = centre[..., 0], centre[..., 1], centre[..., 2]
    towards = east * math.sin(azimuth) + north * math.cos(azimuth)
    aside = east * math.cos(azimuth) - north * math.sin(azimuth)
    # C sin(T - th) and C cos(T - th) with th = atan2(C_r, C_z), written out.
    zenith_turn = np.arctan2(
        up * math.sin(zenith) - towards * math.cos(zenith),
        target.distance - up * math.cos(zenith) - towards * math.sin(zenith),
    )
    azimuth_turn = np.arctan2(-aside, target.distance * math.sin(zenith) - towards)
    return direction_enu(
        (azimuth + azimuth_turn) / RAD_PER_DEG, (zenith + zenith_turn) / RAD_PER_DEG
    )


def exact_direction_enu(target: Target, centre: FloatArray) -> FloatArray:
    """The target's direction from the mirror's middle ``centre`` (..., 3)."""
    return unit(target.vector_enu() - centre)


Direction = Callable[[Target, FloatArray], FloatArray]


def normal_enu(
    sun: FloatArray, target: Target, offset: MirrorOffset, direction: Direction
) -> FloatArray:
    """The front normal (..., 3) for unit vectors ``sun`` (..., 3), repeated until it stands still.

    ``direction`` is ``first_order_direction_enu`` or ``exact_direction_enu``. Each repetition
    brings the normal nearer by about reach / (2 distance); where it does not settle the offsets
    are too large for the distance, or the normal passes over the zenith.

    Raises
    ------
    ConfigurationError
        It does not settle (grazing light excepted, which is of no use anyway).
    """
    normal = bisector(sun, target.direction_enu())
    if not offset:
        return normal
    for _ in range(MOST_STEPS):
        centre = offset.centre_enu(*horizontal_deg(normal))
        moved = bisector(sun, direction(target, centre))
        facing = np.sum(sun * moved, axis=-1)
        step = np.where(facing > GRAZING, angle_deg(normal, moved), 0.0)
        normal = moved
        if float(np.max(step, initial=0.0)) < STILL_DEG:
            return normal
    raise ConfigurationError(
        f"the mirror's normal does not settle: with offsets that reach {offset.reach:g} and a "
        f"target at {target.distance:g} it turns over the zenith or has no place to be"
    )


def beam_miss_enu(
    sun: FloatArray, normal: FloatArray, centre: FloatArray, target: Target
) -> FloatArray:
    """Ray trace: from the target to where the reflected ray passes it nearest, (..., 3).

    In the unit of the target's distance. A ray that leaves away from the target is not traced
    backwards: it misses by as much as its start.
    """
    ray = reflected(sun, normal)
    to_target = target.vector_enu() - centre
    along = np.maximum(np.sum(to_target * ray, axis=-1, keepdims=True), 0.0)
    return np.asarray(along * ray - to_target)


def board_shift(
    sun: FloatArray, mirror_azimuth_deg: ArrayLike, mirror_zenith_deg: ArrayLike,
    target: Target, offset: MirrorOffset,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Where the beam falls on a board at the target, square to the line from the hub.

    Returns
    -------
    (right, up) as seen from the heliostat, each (...), in the unit of the target's distance.
    """
    normal = direction_enu(mirror_azimuth_deg, mirror_zenith_deg)
    centre = offset.centre_enu(mirror_azimuth_deg, mirror_zenith_deg)
    ray = reflected(sun, normal)
    line = target.direction_enu()
    right = direction_enu(target.azimuth_deg + 90.0, 90.0)
    up = np.cross(right, line)
    away = target.distance - np.sum(centre * line, axis=-1)
    hits = centre + (away / np.maximum(np.sum(ray * line, axis=-1), 1e-6))[..., np.newaxis] * ray
    return np.sum(hits * right, axis=-1), np.sum(hits * up, axis=-1)


class Heliostat(msgspec.Struct, frozen=True):
    """Target vector and mirror offset, in one unit of length.

    Raises
    ------
    ConfigurationError
        The target is nearer than the mirror's offsets reach.
    """

    target: Target
    offset: MirrorOffset = MirrorOffset()

    def __post_init__(self) -> None:
        require_beyond_reach(self.target, self.offset)

    @property
    def reduced_offset(self) -> MirrorOffset:
        """The offsets in units of the target's distance, as the controller keeps them."""
        return self.offset.scaled(1.0 / self.target.distance)

    def controller_normal_deg(
        self, sun_azimuth_deg: Angles, sun_zenith_deg: Angles
    ) -> tuple[Angles, Angles]:
        """(azimuth, zenith angle) of the normal as the controller computes it."""
        return self._normal_deg(sun_azimuth_deg, sun_zenith_deg, first_order_direction_enu)

    def true_normal_deg(
        self, sun_azimuth_deg: Angles, sun_zenith_deg: Angles
    ) -> tuple[Angles, Angles]:
        """(azimuth, zenith angle) of the normal that really brings the beam to the target."""
        return self._normal_deg(sun_azimuth_deg, sun_zenith_deg, exact_direction_enu)

    def sun_deg(
        self, normal_azimuth_deg: ArrayLike, normal_zenith_deg: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """(azimuth, zenith angle) of the Sun whose light this normal sends to the target."""
        centre = self.offset.centre_enu(normal_azimuth_deg, normal_zenith_deg)
        normal = direction_enu(normal_azimuth_deg, normal_zenith_deg)
        return horizontal_deg(reflected(exact_direction_enu(self.target, centre), normal))

    def _normal_deg(
        self, sun_azimuth_deg: Angles, sun_zenith_deg: Angles, direction: Direction
    ) -> tuple[Angles, Angles]:
        sun = direction_enu(sun_azimuth_deg, sun_zenith_deg)
        normal = horizontal_deg(normal_enu(sun, self.target, self.offset, direction))
        azimuth, zenith = normal
        if isinstance(sun_azimuth_deg, np.ndarray):
            return azimuth, zenith
        return float(azimuth), float(zenith)


def format_target(target: Target | None) -> str:
    """``azimuth:zenith:distance`` as the wire and the points files write it; ``-`` without one."""
    if target is None:
        return "-"
    return _numbers((target.azimuth_deg, target.zenith_deg, target.distance), 5)


def parse_target(text: str) -> Target | None:
    """The reverse of ``format_target``.

    Raises
    ------
    ConfigurationError
        Another notation, or numbers that no target has.
    """
    if text.strip() == "-":
        return None
    return Target(*_three(text, "target", "AZIMUTH:ZENITH:DISTANCE, or - for none"))


def format_mirror(reduced: MirrorOffset) -> str:
    """``AzimPivot_R:PivotRefl_R:PivotRefl_Z``, reduced (in units of the target's distance)."""
    return _numbers((reduced.AzimPivot_R, reduced.PivotRefl_R, reduced.PivotRefl_Z), 9)


def parse_mirror(text: str) -> MirrorOffset:
    """The reverse of ``format_mirror``; ConfigurationError where it is another notation."""
    return MirrorOffset(*_three(text, "mirror", "AZIMPIVOT_R:PIVOTREFL_R:PIVOTREFL_Z, reduced"))


def heliostat_of(target: Target | None, reduced: MirrorOffset) -> Heliostat | None:
    """The heliostat of a target vector and reduced offsets; ``None`` without a target."""
    return None if target is None else Heliostat(target, reduced.scaled(target.distance))


def _three(text: str, what: str, notation: str) -> tuple[float, float, float]:
    try:
        first, second, third = map(float, text.split(":"))
    except ValueError:
        raise ConfigurationError(f"{what} {text!r} is not {notation}") from None
    return first, second, third


def _numbers(values: tuple[float, ...], decimals: int) -> str:
    texts = (f"{value:.{decimals}f}" for value in values)
    # No negative zero on the wire.
    return ":".join(text if text.strip("-0.") else text.removeprefix("-") for text in texts)


@dataclass(frozen=True, slots=True)
class Drift:
    """Columns (n,), one per Sun.

    ``right``, ``up``: the beam's place on a board at the target as seen from the heliostat, when
    the normal is set as though the mirror had no offset; in the unit of the target's distance.
    ``first_order_deg``: between the normal corrected to first order and the exact one.
    """

    right: FloatArray
    up: FloatArray
    first_order_deg: FloatArray
    distance: float

    @property
    def drift_max(self) -> float:
        """Farthest from the middle."""
        return float(np.hypot(self.right, self.up).max())

    @property
    def drift_max_deg(self) -> float:
        """The same as an angle at the heliostat."""
        return float(np.arctan2(self.drift_max, self.distance) / RAD_PER_DEG)


def drift_over(
    heliostat: Heliostat, sun_azimuth_deg: FloatArray, sun_zenith_deg: FloatArray
) -> Drift:
    """The drift for Suns (n,), by ray trace."""
    sun = direction_enu(sun_azimuth_deg, sun_zenith_deg)
    bare = horizontal_deg(bisector(sun, heliostat.target.direction_enu()))
    right, up = board_shift(sun, *bare, heliostat.target, heliostat.offset)
    first = heliostat.controller_normal_deg(sun_azimuth_deg, sun_zenith_deg)
    exact = heliostat.true_normal_deg(sun_azimuth_deg, sun_zenith_deg)
    return Drift(
        right,
        up,
        angle_deg(direction_enu(*first), direction_enu(*exact)),
        heliostat.target.distance,
    )
