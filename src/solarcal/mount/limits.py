"""How far the axes may go."""

import msgspec
import numpy as np

from solarcal.units import Angles


class AxisLimits(msgspec.Struct, frozen=True):
    """Software limits of one axis, degrees of absolute read-out (axis 1: on its branch)."""

    low_deg: float
    high_deg: float

    def distance_deg(self, reading_deg: Angles) -> Angles:
        """Distance to the nearer limit, negative outside; elementwise."""
        return np.minimum(reading_deg - self.low_deg, self.high_deg - reading_deg)  # type: ignore[return-value]


class Limits(msgspec.Struct, frozen=True):
    """Software limits of both axes."""

    axis1: AxisLimits
    axis2: AxisLimits

    def distance_deg(self, reading1_deg: Angles, reading2_deg: Angles) -> Angles:
        """Distance to the nearest limit of either axis, negative outside; elementwise."""
        return np.minimum(  # type: ignore[return-value]
            self.axis1.distance_deg(reading1_deg), self.axis2.distance_deg(reading2_deg)
        )
