"""A rotator: a machine that turns to a given direction and reports where it is, no more.

It knows no Sun, no offsets, no coefficients and no limits of the sky: the station is its controller
(``station.software_controller``). Directions are azimuth from North through East and elevation
above the horizon, degrees, as the rotator reads them: on its own turn of azimuth, uncorrected.
"""

import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable

import msgspec

from solarcal.mount.geometry import AxisLimits
from solarcal.unit.conversation import refuse_if_turned_away
from solarcal.unit.link import Link
from solarcal.unit.stop_guard import StopGuard

Direction = tuple[float, float]

READ_OUT_DEG = 0.01
"""The last digit of most read-outs."""

LINES_REMEMBERED = 100


class RotatorIdentity(msgspec.Struct, frozen=True):
    """Who answers, and how far it can turn."""

    model: str
    version: str
    azimuth: AxisLimits
    elevation: AxisLimits
    read_out_deg: float = READ_OUT_DEG
    """The last digit of its read-outs."""


class Rotator(ABC):
    """A driver of a rotator's text line. Methods may be called from several threads.

    They raise ``LinkError``, ``ProtocolError`` or ``UnitRefused``.

    Parameters
    ----------
    link_factory : opens the line; called by every ``open``.
    where : what messages call it, port or address; in sessions its serial number, where it has no
        name.
    """

    def __init__(self, link_factory: Callable[[], Link], where: str) -> None:
        self.where = where
        self._link_factory = link_factory
        self._link: Link | None = None
        self._turn = threading.RLock()
        self._guard = StopGuard()
        self._recent: deque[str] = deque(maxlen=LINES_REMEMBERED)

    @abstractmethod
    def open(self) -> RotatorIdentity:
        """Open the line and learn who is there; again after a lost link."""

    @abstractmethod
    def close(self) -> None: ...

    @abstractmethod
    def position_deg(self) -> Direction:
        """Where it stands: azimuth, elevation."""

    def stops(self) -> int:
        """How often ``stop`` or ``park`` was called: what ``go_to`` wants to know."""
        return self._guard.stops

    @abstractmethod
    def go_to(self, azimuth_deg: float, elevation_deg: float, stops: int) -> None:
        """Set out for a direction, and return.

        ``stops``: what ``stops`` gave when this was decided. ProcedureRefused: it was stopped
        since, and nothing that waited may move it after a STOP.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop now, past any request that is waiting. One that cannot stop is sent to where it
        stands."""

    @abstractmethod
    def park(self) -> None:
        """Go to its own parking position, past any request that is waiting."""

    def _received(self, line: bytes) -> None:
        """Remember a line; LinkError where a server has another station already."""
        self._recent.append("< " + line.decode("ascii", "backslashreplace"))
        refuse_if_turned_away(line, self.where)

    def recent_traffic(self) -> tuple[str, ...]:
        """The last lines both ways, oldest first."""
        return tuple(self._recent.copy())
