"""What becomes of the beam when the mirror's offset is not corrected, or to first order only."""

from dataclasses import dataclass

import numpy as np

from solarcal.optics.aiming import Heliostat
from solarcal.optics.offset_mirror import board_shift
from solarcal.optics.reflection import angle_deg, bisector, direction_enu, horizontal_deg
from solarcal.units import RAD_PER_DEG, FloatArray


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
