"""Azimuth and elevation of a rotator as the native axes of an ``azel`` mount, and back.

AX1 = 180 - azimuth (from South, positive East), AX2 = 90 - elevation: exact, for both are angles
about the vertical and from it. What is left to choose is the turn: AX1 lies on the branch around
its centre, the rotator's azimuth on whatever turn it has (0 to 360, -180 to 540, ...).
"""

from solarcal.errors import ConfigurationError
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.unit.rotator import Direction
from solarcal.units import wrap_deg

TURNS = (0, 1, -1, 2, -2)
"""In the order they are tried: azimuths of the plain turn first."""

_TOUCHING_DEG = 1e-6

Pair = tuple[float, float]


class AzElAxes:
    """The axes of one rotator.

    Parameters
    ----------
    geometry : the mount's; only ``azel`` is one.
    ax1_centre_deg : centre of the branch of axis 1.
    azimuth, elevation : how far the rotator turns, as it reads.

    Raises
    ------
    ConfigurationError
        Another geometry, or a rotator that reaches no part of the branch.
    """

    def __init__(
        self, geometry: str, ax1_centre_deg: float, azimuth: AxisLimits, elevation: AxisLimits
    ) -> None:
        if geometry != "azel":
            raise ConfigurationError(
                f"a rotator turns in azimuth and elevation: a {geometry} mount cannot be driven by "
                "it; describe the mount as azel"
            )
        self._centre_deg = ax1_centre_deg
        self._azimuth = azimuth
        self._elevation = elevation
        self.limits = Limits(self._reach1(), self._reach2())
        """Read-outs the rotator can be sent to."""

    def reading_deg(self, direction: Direction) -> Pair:
        """AX1 on the branch and AX2 of where the rotator says it stands."""
        azimuth, elevation = direction
        return float(wrap_deg(180.0 - azimuth, self._centre_deg)), 90.0 - elevation

    def direction_deg(self, ax1_deg: float, ax2_deg: float) -> Direction:
        """Azimuth and elevation that belong to read-outs within ``limits``; always the same turn
        for the same AX1."""
        low, high = self._azimuth.low_deg, self._azimuth.high_deg
        azimuth = 180.0 - ax1_deg
        for turn in TURNS:
            on_turn = azimuth + 360.0 * turn
            if low - _TOUCHING_DEG <= on_turn <= high + _TOUCHING_DEG:
                azimuth = on_turn
                break
        elevation = 90.0 - ax2_deg
        return (
            min(max(azimuth, low), high),
            min(max(elevation, self._elevation.low_deg), self._elevation.high_deg),
        )

    def _reach1(self) -> AxisLimits:
        """The longest stretch of the branch that has no gap."""
        low, high = self._centre_deg - 180.0, self._centre_deg + 180.0
        pieces: list[Pair] = []
        for turn in TURNS:
            begins = max(low, 180.0 - self._azimuth.high_deg + 360.0 * turn)
            ends = min(high, 180.0 - self._azimuth.low_deg + 360.0 * turn)
            if begins < ends:
                pieces.append((begins, ends))
        joined: list[Pair] = []
        for begins, ends in sorted(pieces):
            if joined and begins <= joined[-1][1] + _TOUCHING_DEG:
                joined[-1] = (joined[-1][0], max(joined[-1][1], ends))
            else:
                joined.append((begins, ends))
        if not joined:
            raise ConfigurationError(
                f"the rotator's azimuths {self._azimuth.low_deg:g} to {self._azimuth.high_deg:g} "
                "deg are no part of a turn"
            )
        return AxisLimits(*max(joined, key=lambda piece: piece[1] - piece[0]))

    def _reach2(self) -> AxisLimits:
        """Not past the zenith: there AX1 would turn over."""
        low = max(0.0, 90.0 - self._elevation.high_deg)
        high = min(180.0, 90.0 - self._elevation.low_deg)
        if not low < high:
            raise ConfigurationError(
                f"the rotator's elevations {self._elevation.low_deg:g} to "
                f"{self._elevation.high_deg:g} deg leave axis 2 no range"
            )
        return AxisLimits(low, high)
