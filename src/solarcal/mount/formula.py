"""The controller's own correction: the first-order formula in P1..P6.

    E1 = -P1 sin(AX1)/tan(AX2) + P2 - P3 cos(AX1)/tan(AX2) - P5*AX1
    E2 =  P1 cos(AX1) - P3 sin(AX1) + P4 - P6*AX2

the first-order expansion of a rigid rotation of the mechanism by omega = (-P3, -P1, 0) about the
native x and y axes, plus zero offsets and scale errors.
"""

import msgspec

from solarcal.decimals import Six
from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import maths_for
from solarcal.units import RAD_PER_DEG, Angles

COEFFICIENT_NAMES = ("P1", "P2", "P3", "P4", "P5", "P6")
COEFFICIENT_UNITS = ("deg", "deg", "deg", "deg", "deg/deg", "deg/deg")

# Closer to a pole than this (6e-10 deg) the cotangent is rounding noise.
_POLE_RAD = 1e-11


class Coefficients(msgspec.Struct, frozen=True):
    """The six tilt-error coefficients. P1..P4 in degrees, P5 and P6 in degrees per degree."""

    P1: float = 0.0
    P2: float = 0.0
    P3: float = 0.0
    P4: float = 0.0
    P5: float = 0.0
    P6: float = 0.0

    def as_tuple(self) -> Six:
        return (self.P1, self.P2, self.P3, self.P4, self.P5, self.P6)

    def rounded(self, tilt_decimals: int, scale_decimals: int) -> "Coefficients":
        """What a controller keeps that stores so many decimals of P1..P4 and of P5, P6."""
        digits = (tilt_decimals,) * 4 + (scale_decimals,) * 2
        # Adding zero turns a negative zero into a plain one, so that a read-back compares equal.
        return Coefficients(
            *(round(p, d) + 0.0 for p, d in zip(self.as_tuple(), digits, strict=True))
        )


class Offsets(msgspec.Struct, frozen=True):
    """The two reference offsets O, degrees."""

    O1: float = 0.0
    O2: float = 0.0

    def rounded(self, decimals: int) -> "Offsets":
        """What a controller keeps that stores so many decimals; without a negative zero."""
        return Offsets(round(self.O1, decimals) + 0.0, round(self.O2, decimals) + 0.0)


def correction_deg(p: Coefficients, ax1_deg: Angles, ax2_deg: Angles) -> tuple[Angles, Angles]:
    """E1, E2 to be ADDED to the ideal axis angles, degrees; any broadcastable shapes.

    ``ax1_deg`` is the branch value.

    Raises
    ------
    ConfigurationError
        AX2 at a pole (0 or 180 deg) while P1 or P3 is not zero: E1 has no value there.
    """
    m = maths_for(ax1_deg, ax2_deg)
    e1 = p.P2 - p.P5 * ax1_deg
    e2 = p.P4 - p.P6 * ax2_deg
    if p.P1 == 0.0 and p.P3 == 0.0:
        # Nothing leans: both axes are plain functions of their own angle, at the poles too.
        return e1, e2
    ax1 = ax1_deg * RAD_PER_DEG
    ax2 = ax2_deg * RAD_PER_DEG
    sin1, cos1, sin2 = m.sin(ax1), m.cos(ax1), m.sin(ax2)
    if m.any(abs(sin2) < _POLE_RAD):
        raise ConfigurationError(
            "the correction of axis 1 has no value at AX2 = 0 or 180 deg, on the primary axis: "
            "leave such directions out"
        )
    lean1 = (p.P1 * sin1 + p.P3 * cos1) * m.cos(ax2) / sin2
    return e1 - lean1, e2 + p.P1 * cos1 - p.P3 * sin1
