"""Both ways a machine with an offset mirror can stand, exact in three dimensions.

The normal must stand half-way between the Sun and the target as seen from the middle of the mirror,
and the middle stands where the normal puts it (``offset_mirror``). That has two roots: in front,
the light falls on the mirror's face; at the back, the machine is rotated by 180 deg and the light
would fall on the mirror's reverse. Both are looked for with a bracketing root finder.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.optics.offset_mirror import (
    MirrorOffset,
    beam_miss_enu,
    exact_direction_enu,
    require_beyond_reach,
)
from solarcal.optics.reflection import (
    Target,
    angle_deg,
    bisector,
    direction_enu,
    horizontal_deg,
    require_above_horizon,
    require_reflection,
)
from solarcal.units import RAD_PER_DEG, FloatArray


@dataclass(frozen=True, slots=True)
class Root:
    """One way the machine can stand so that the Sun's reflection passes through the target.

    ``azimuth_deg``, ``zenith_deg``: the axis of the machine's own mirror face. ``normal_*``: the
    side of the mirror towards the Sun, the same in front and the opposite at the back.
    ``from_target_deg``: normal to target, seen from the hub. ``miss``: by how far the traced ray
    passes the target, in its unit of length.
    """

    side: Literal["front", "back"]
    azimuth_deg: float
    zenith_deg: float
    normal_azimuth_deg: float
    normal_zenith_deg: float
    incidence_deg: float
    from_target_deg: float
    miss: float


def exact_roots(
    sun_azimuth_deg: float, sun_zenith_deg: float, target: Target, offset: MirrorOffset
) -> tuple[Root, Root | None]:
    """Front and back root, by bracketing in azimuth and, for each azimuth, in zenith angle.

    The front one is the one to use; the back one is ``None`` where the offsets leave none.

    Raises
    ------
    ConfigurationError
        The Sun is below the horizon or opposite the target, the target is nearer than the mirror,
        or no front root exists.
    """
    require_above_horizon(sun_zenith_deg)
    require_beyond_reach(target, offset)
    sun = direction_enu(sun_azimuth_deg, sun_zenith_deg)
    require_reflection(sun, target.direction_enu())
    front = _root(sun, target, offset, 1.0)
    if front is None:
        raise ConfigurationError(
            "no position of this machine reflects the Sun to the target: near the zenith its "
            "offsets carry the mirror past every solution"
        )
    return front, _root(sun, target, offset, -1.0)


def _root(sun: FloatArray, target: Target, offset: MirrorOffset, face: float) -> Root | None:
    from scipy.optimize import brentq  # noqa: PLC0415

    def wanted(azimuth_deg: float, zenith_deg: float) -> FloatArray:
        """Where the face should look, were the mirror's middle where these angles put it."""
        centre = offset.centre_enu(azimuth_deg, zenith_deg)
        return face * bisector(sun, exact_direction_enu(target, centre))

    def tilt_deg(azimuth_deg: float) -> float:
        """The zenith angle that fits this azimuth; 0 and 180 always bracket it."""

        def excess(zenith_deg: float) -> float:
            return float(horizontal_deg(wanted(azimuth_deg, zenith_deg))[1]) - zenith_deg

        return float(brentq(excess, 0.0, 180.0, xtol=1e-13, rtol=1e-14))

    def aside(azimuth_deg: float) -> tuple[float, float]:
        """Across and along this azimuth, of the direction wanted there."""
        east, north, _ = wanted(azimuth_deg, tilt_deg(azimuth_deg)).tolist()
        turn = azimuth_deg * RAD_PER_DEG
        return (
            east * math.cos(turn) - north * math.sin(turn),
            east * math.sin(turn) + north * math.cos(turn),
        )

    start = float(horizontal_deg(face * bisector(sun, target.direction_enu()))[0])
    bracket = _bracket(aside, start)
    if bracket is None:
        return None
    azimuth = float(brentq(lambda a: aside(a)[0], *bracket, xtol=1e-13, rtol=1e-14))
    zenith = tilt_deg(azimuth)
    normal = face * direction_enu(azimuth, zenith)
    normal_azimuth, normal_zenith = horizontal_deg(normal)
    return Root(
        "front" if face > 0.0 else "back",
        azimuth % 360.0,
        zenith,
        float(normal_azimuth),
        float(normal_zenith),
        float(angle_deg(sun, normal)),
        float(angle_deg(target.direction_enu(), normal)),
        float(
            np.linalg.norm(beam_miss_enu(sun, normal, offset.centre_enu(azimuth, zenith), target))
        ),
    )


def _bracket(
    aside: Callable[[float], tuple[float, float]], start_deg: float
) -> tuple[float, float] | None:
    """Two azimuths about the nearest root to ``start_deg``, the wider search where that fails."""
    low, high = start_deg - 60.0, start_deg + 60.0
    if aside(low)[0] > 0.0 > aside(high)[0]:
        return low, high
    # Near the zenith the offsets can carry the azimuth anywhere: look all the way round.
    step = 2.5
    turns = sorted((k * step for k in range(-72, 72)), key=abs)
    for turn in turns:
        low, high = start_deg + turn, start_deg + turn + step
        across_low, along = aside(low)
        if across_low >= 0.0 >= aside(high)[0] and along > 0.0:
            return low, high
    return None


@dataclass(frozen=True, slots=True)
class CircleRoots:
    """Angles of INCIDENCE T of both roots; the normal stands phi - T from the target."""

    front_deg: float
    back_deg: float
    angle_deg: float

    @property
    def front_from_target_deg(self) -> float:
        return self.angle_deg - self.front_deg

    @property
    def back_from_target_deg(self) -> float:
        return self.angle_deg - self.back_deg


def circle_roots(angle_sun_target_deg: float, distance_to_radius: float) -> CircleRoots:
    """AzimPivot_R = PivotRefl_R = 0: the mirror on a circle of radius r, the target at distance d.

    d/r = |sin T / sin(2T - phi)| in the plane of the incident and the reflected ray, phi the angle
    between Sun and target (10-physics, section 6). In front T lies above phi/2, at the back below.

    Raises
    ------
    ConfigurationError
        phi not between 0 and 180, or the target on or within the mirror's circle.
    """
    from scipy.optimize import brentq  # noqa: PLC0415

    if not 0.0 < angle_sun_target_deg < 180.0:
        raise ConfigurationError(
            f"the angle between Sun and target must lie between 0 and 180 deg, not "
            f"{angle_sun_target_deg:g}"
        )
    if not 1.0 < distance_to_radius < math.inf:
        raise ConfigurationError(
            f"the target is behind the mirror: d/r must be greater than 1, not "
            f"{distance_to_radius:g}"
        )
    phi = angle_sun_target_deg * RAD_PER_DEG

    def open_by(incidence: float, radius: float) -> float:
        return distance_to_radius * math.sin(2.0 * incidence - phi) - radius * math.sin(incidence)

    front = brentq(open_by, 0.5 * phi, phi, args=(1.0,), xtol=1e-15, rtol=1e-14)
    back = brentq(open_by, 0.0, 0.5 * phi, args=(-1.0,), xtol=1e-15, rtol=1e-14)
    return CircleRoots(front / RAD_PER_DEG, back / RAD_PER_DEG, angle_sun_target_deg)


@dataclass(frozen=True, slots=True)
class Bisection:
    """One step: the middle of the bracket, and by how much its d/r differs from the wanted one."""

    low_deg: float
    high_deg: float
    incidence_deg: float
    difference: float


PUBLISHED_STOP = 1e-4
"""Difference of d/r at which the published bisection stops."""
_MOST_STEPS = 100


def published_bisection(
    angle_sun_target_deg: float, distance_to_radius: float, side: Literal["front", "back"]
) -> tuple[Bisection, ...]:
    """The published way to the roots of ``circle_roots``, step by step.

    The bracket, phi/2..phi in front and 0..phi/2 at the back, is halved until d/r of its middle is
    within 1e-4 of the wanted one. For phi 22.5 deg and d/r 5: 12.489481 after 17 steps in front,
    10.232005 after 18 at the back; the roots are 12.489466 and 10.232014. Raises as
    ``circle_roots``.
    """
    circle_roots(angle_sun_target_deg, distance_to_radius)
    phi = angle_sun_target_deg * RAD_PER_DEG
    low, high = (phi / 2.0, phi) if side == "front" else (0.0, phi / 2.0)
    steps: list[Bisection] = []
    while len(steps) < _MOST_STEPS:
        middle = 0.5 * (low + high)
        reach = abs(math.sin(middle) / math.sin(2.0 * middle - phi))
        difference = reach - distance_to_radius
        steps.append(
            Bisection(low / RAD_PER_DEG, high / RAD_PER_DEG, middle / RAD_PER_DEG, difference)
        )
        if abs(difference) < PUBLISHED_STOP:
            break
        # d/r grows without bound towards phi/2 from both sides.
        if (difference > 0.0) == (side == "front"):
            low = middle
        else:
            high = middle
    return tuple(steps)
