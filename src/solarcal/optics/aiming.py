"""A heliostat as its controller describes it: the Sun's direction to that of the mirror's normal.

Two ways, each for floats or arrays: ``controller_normal_deg`` is what the controller computes (its
target and REDUCED offsets, first order, repeated), ``true_normal_deg`` what the geometry demands.
"""

from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from solarcal.errors import ConfigurationError
from solarcal.optics.heliostat import Target
from solarcal.optics.offset_mirror import (
    Direction,
    MirrorOffset,
    board_shift,
    exact_direction_enu,
    first_order_direction_enu,
    normal_enu,
    require_beyond_reach,
)
from solarcal.optics.reflection import angle_deg, bisector, direction_enu, horizontal_deg, reflected
from solarcal.units import RAD_PER_DEG, Angles, FloatArray


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
    """The reverse of ``format_mirror``.

    Raises
    ------
    ConfigurationError
        Another notation.
    """
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
