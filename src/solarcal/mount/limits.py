"""How far the axes may go."""

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.units import Angles


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

    def nearer(self, reading_deg: float) -> str:
        """Which limit is the nearer one, in words: ``high limit 150.0 deg``."""
        if reading_deg - self.low_deg < self.high_deg - reading_deg:
            return f"low limit {self.low_deg:.1f} deg"
        return f"high limit {self.high_deg:.1f} deg"


class Limits(msgspec.Struct, frozen=True):
    """Software limits of both axes."""

    axis1: AxisLimits
    axis2: AxisLimits

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
                    f"axis {number}: {reading_deg:.3f} is beyond "
                    f"{limits.low_deg:g}..{limits.high_deg:g}"
                )
        return ""

    def nearest(self, reading1_deg: float, reading2_deg: float) -> str:
        """Which limit of which axis is the nearest, in words: ``axis 1 high limit 150.0 deg``."""
        if self.axis1.distance_deg(reading1_deg) <= self.axis2.distance_deg(reading2_deg):
            return f"axis 1 {self.axis1.nearer(reading1_deg)}"
        return f"axis 2 {self.axis2.nearer(reading2_deg)}"
