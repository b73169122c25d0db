"""The four-quadrant diode of a two-mirror tracker: its signals, traced back to axis corrections.

Quadrants lie at A(-,+) B(+,+) C(+,-) D(-,-) of (d1, d2), the components of the ray traced back from
the diode towards the Sun, so that e = +k d:

    e1 = (B + C) - (A + D),   e2 = (A + B) - (C + D)
    (xs, ys, zs) = M_tracker F (e1 - e1c, e2 - e2c, L)

is the Sun in the tracker's frame; F is the product of the fixed mirrors, e1c and e2c are the set
points and L = k. The signals are divided by their sum, so that neither haze nor the Sun's height
changes k.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from solarcal.decimals import require_positive
from solarcal.errors import ConfigurationError
from solarcal.two_mirror.mirrors import (
    IDENTITY,
    Components,
    axes_of,
    fixed_mirrors_matrix,
    ray_to_sky,
)

SUN_RADIUS_MRAD = 4.65
"""Half the Sun's apparent diameter of 9.3 mrad ('the Sun's 9 mrad')."""

Signals = tuple[float, float, float, float]
"""A, B, C, D in any unit, dark signal taken off."""


DISC_GAIN_PER_RAD = 4.0 / (math.pi * SUN_RADIUS_MRAD * 1e-3)
"""k of a sharp image of the Sun near the centre: d(e)/d(d) = 4/(pi r).

A disc moved by d across a split takes 2 r d of its area pi r^2 from one side to the other.
"""


def quadrant_errors(signals: Signals) -> tuple[float, float]:
    """(e1, e2) of the four signals, each divided by their sum: from -1 to 1.

    Raises
    ------
    ConfigurationError
        There is no light on the diode, or a signal is not a number.
    """
    a, b, c, d = signals
    light = a + b + c + d
    if not (math.isfinite(light) and light > 0.0):
        raise ConfigurationError(
            "no light on the diode: the four signals A, B, C, D must be numbers with a sum above "
            "zero"
        )
    return ((b + c) - (a + d)) / light, ((a + b) - (c + d)) / light


@dataclass(frozen=True, slots=True)
class QuadrantDiode:
    """The diode as its controller knows it.

    ``gain_per_rad`` is k (and L); ``set_point1``, ``set_point2`` are e1c, e2c; ``fixed`` the rows
    of F.
    """

    gain_per_rad: float = DISC_GAIN_PER_RAD
    set_point1: float = 0.0
    set_point2: float = 0.0
    fixed: tuple[Components, Components, Components] = IDENTITY

    def __post_init__(self) -> None:
        require_positive("the diode's gain", self.gain_per_rad)
        if max(abs(self.set_point1), abs(self.set_point2)) >= 1.0:
            raise ConfigurationError("a set point of the diode must lie between -1 and 1")

    @classmethod
    def with_fixed_mirrors(
        cls,
        normals: Sequence[ArrayLike],
        *,
        gain_per_rad: float = DISC_GAIN_PER_RAD,
        set_point1: float = 0.0,
        set_point2: float = 0.0,
    ) -> "QuadrantDiode":
        """The diode behind fixed mirrors of these normals, the tracker's side first."""
        rows = [tuple(row) for row in fixed_mirrors_matrix(normals).tolist()]
        return cls(gain_per_rad, set_point1, set_point2, (rows[0], rows[1], rows[2]))

    def ray(self, e1: float, e2: float) -> Components:
        """The ray traced back from the diode through the fixed mirrors, not of unit length."""
        d = (e1 - self.set_point1, e2 - self.set_point2, self.gain_per_rad)
        if self.fixed is IDENTITY:
            return d
        x, y, z = (row[0] * d[0] + row[1] * d[1] + row[2] * d[2] for row in self.fixed)
        return x, y, z

    def off_centre_mrad(self, e1: float, e2: float) -> float:
        """How far the spot is from the set point; too small where the diode is saturated."""
        return 1e3 * math.hypot(e1 - self.set_point1, e2 - self.set_point2) / self.gain_per_rad

    def sun_axes_deg(
        self, e1: float, e2: float, t1_deg: float, t2_deg: float
    ) -> tuple[float, float]:
        """Axis angles (t1 in (-180, 180], t2) that would centre the spot."""
        return axes_of(ray_to_sky(self.ray(e1, e2), t1_deg, t2_deg))

    def corrections_deg(
        self, e1: float, e2: float, t1_deg: float, t2_deg: float
    ) -> tuple[float, float]:
        """What to ADD to both axes to centre the spot, degrees; that of axis 1 in (-180, 180]."""
        sun1_deg, sun2_deg = self.sun_axes_deg(e1, e2, t1_deg, t2_deg)
        turn = math.remainder(sun1_deg - t1_deg, 360.0)
        return turn, sun2_deg - t2_deg


@dataclass(frozen=True, slots=True)
class FieldOfView:
    """Full angles in milliradians. ``diode_mrad`` is FOV1, ``tracker_mrad`` FOV2."""

    diode_mrad: float
    tracker_mrad: float
    sun_mrad: float

    @property
    def field_mrad(self) -> float:
        """The smaller one limits."""
        return min(self.diode_mrad, self.tracker_mrad)

    @property
    def limited_by(self) -> str:
        return "diode" if self.diode_mrad <= self.tracker_mrad else "tracker"

    @property
    def any_light_mrad(self) -> float:
        """Largest pointing error at which the Sun's centre is still in the field."""
        return 0.5 * self.field_mrad

    @property
    def whole_sun_mrad(self) -> float:
        """Largest pointing error at which the whole Sun is; negative where it never fits."""
        return 0.5 * (self.field_mrad - self.sun_mrad)


def field_of_view(
    diode_diameter_mm: float = 6.0,
    focal_length_mm: float = 200.0,
    tracker_diameter_m: float = 0.10,
    distance_m: float = 5.0,
    sun_mrad: float = 2.0 * SUN_RADIUS_MRAD,
) -> FieldOfView:
    """FOV1 = atan(D_diode/f) and FOV2 = atan(D_tracker/L).

    The defaults give 30 and 20 mrad.

    Raises
    ------
    ConfigurationError
        A length that is not greater than zero.
    """
    require_positive("the diode's diameter", diode_diameter_mm)
    require_positive("the focal length", focal_length_mm)
    require_positive("the tracker's diameter", tracker_diameter_m)
    require_positive("the distance from tracker to instrument", distance_m)
    require_positive("the Sun's diameter", sun_mrad)
    return FieldOfView(
        diode_mrad=1e3 * math.atan(diode_diameter_mm / focal_length_mm),
        tracker_mrad=1e3 * math.atan(tracker_diameter_m / distance_m),
        sun_mrad=sun_mrad,
    )
