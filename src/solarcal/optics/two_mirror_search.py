"""Spiral search: where to look, in order, when the spot is not on the diode."""

import math
from collections.abc import Iterator

from solarcal.errors import ConfigurationError
from solarcal.optics.two_mirror import direction_components
from solarcal.units import RAD_PER_DEG

ARM_SPACING = 1.3
"""Between two arms, in radii of the field: a spot between them is seen from both."""

LOOK_SPACING = 1.0
"""Between two looks along an arm, in radii of the field."""


def spiral_deg(field_radius_deg: float, limit_deg: float) -> Iterator[tuple[float, float]]:
    """Offsets (x, y) on the sky, from the centre outwards along an Archimedean spiral.

    Any direction within ``limit_deg`` lies within ``field_radius_deg`` of one of them.

    Raises
    ------
    ConfigurationError
        A field or limit that is not above zero.
    """
    if not (field_radius_deg > 0.0 and limit_deg > 0.0):
        raise ConfigurationError("a spiral search needs a field and a limit above zero")
    return _spiral(field_radius_deg, limit_deg)


def _spiral(field_radius_deg: float, limit_deg: float) -> Iterator[tuple[float, float]]:
    growth = ARM_SPACING * field_radius_deg / (2.0 * math.pi)
    turn = 0.0
    # The last arm passes outside the limit by half a spacing, so that the edge is covered.
    while growth * turn <= limit_deg + 0.5 * ARM_SPACING * field_radius_deg:
        radius = growth * turn
        yield radius * math.cos(turn), radius * math.sin(turn)
        turn += LOOK_SPACING * field_radius_deg / math.hypot(radius, growth)


def beside(t1_deg: float, t2_deg: float, x_deg: float, y_deg: float) -> tuple[float, float, float]:
    """The unit vector x_deg farther from the axis and y_deg across from the direction (t1, t2).

    On the tangent plane: near the primary axis a spiral in the axis angles themselves would
    collapse.
    """
    px, py, pz = direction_components(t1_deg, t2_deg)
    t1, t2 = t1_deg * RAD_PER_DEG, t2_deg * RAD_PER_DEG
    c1, s1, c2, s2 = math.cos(t1), math.sin(t1), math.cos(t2), math.sin(t2)
    away = math.hypot(x_deg, y_deg)
    if away == 0.0:
        return px, py, pz
    c, s = math.cos(away * RAD_PER_DEG), math.sin(away * RAD_PER_DEG) / away
    x, y = s * x_deg, s * y_deg
    return (
        c * px + x * c2 * c1 - y * s1,
        c * py + x * c2 * s1 + y * c1,
        c * pz - x * s2,
    )
