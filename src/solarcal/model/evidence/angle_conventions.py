"""Ideal angles counted otherwise than those of the native frames: from another zero, the other way.

Each axis is given as ``zero + sign * AX``: an azimuth from North is 180 deg - AX1 of an ``azel``
mount, an elevation 90 deg - AX2.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from solarcal.model.finding import listed
from solarcal.units import FloatArray

_WAYS = (
    tuple((sign, zero) for zero in (0, 180, 90, -90) for sign in (1, -1)),
    # AX2 is between 0 and 180 deg: from the other pole, or from the equator between them.
    ((1, 0), (-1, 90), (1, -90), (-1, 180)),
)
"""Sign and zero of axis 1 and axis 2 as they are counted elsewhere; the first is the native one."""
_MEANINGS = {
    ("azel", 0, -1, 180): "azimuth from North, positive East",
    ("azel", 0, 1, 180): "azimuth from North, positive West",
    ("azel", 0, -1, 0): "azimuth from South, positive West",
    ("azel", 1, -1, 90): "elevation",
    ("tiltroll-ew", 0, -1, 0): "tilt positive North",
    ("tiltroll-ew", 1, -1, 180): "roll from due West",
    ("tiltroll-ew", 1, -1, 90): "roll 0 at the meridian, positive East",
    ("tiltroll-ew", 1, 1, -90): "roll 0 at the meridian, positive West",
    ("tiltroll-ns", 0, -1, 0): "tilt positive West",
    ("tiltroll-ns", 1, -1, 180): "angle from South",
    ("polar", 0, -1, 0): "hour angle positive in the afternoon",
    ("polar", 1, -1, 90): "declination",
}


@dataclass(frozen=True, slots=True)
class AngleConvention:
    """How both axes are counted: sign and zero of axis 1 and of axis 2."""

    axes: tuple[tuple[int, int], ...]

    def native_deg(self, *given_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
        """AX1 and AX2 of angles given in this convention."""
        one, two = (s * (a - zero) for (s, zero), a in zip(self.axes, given_deg, strict=True))
        return one, two

    def words(self, geometry_name: str) -> str:
        """'of axis 1 are 180 deg - AX1 (azimuth from North, positive East)', of both axes."""
        said = []
        for axis, (sign, zero) in enumerate(self.axes):
            if (sign, zero) == (1, 0):
                continue
            name = f"AX{axis + 1}"
            if sign < 0:
                formula = f"{zero} deg - {name}" if zero else f"-{name}"
            else:
                formula = f"{name} {zero:+d} deg"
            meaning = _MEANINGS.get((geometry_name, axis, sign, zero))
            said.append(f"of axis {axis + 1} are {formula}" + (f" ({meaning})" if meaning else ""))
        return listed(said)


def other_conventions() -> Iterator[AngleConvention]:
    """All but the native one."""
    for axes in product(*_WAYS):
        if axes != ((1, 0), (1, 0)):
            yield AngleConvention(axes)
