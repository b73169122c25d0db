"""A rotator: a machine that turns to a given direction and reports where it is, no more.

It knows no Sun, no offsets, no coefficients and no limits of the sky: the station is its controller
(``station.software_controller``). Directions are azimuth from North through East and elevation
above the horizon, degrees, as the rotator reads them: on its own turn of azimuth, uncorrected.
"""

import threading
from collections import deque
from collections.abc import Callable
from typing import Protocol

import msgspec

from solarcal.mount.geometry import AxisLimits
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


class RotatorOnALine:
    """What the drivers of a rotator's text line share.

    Parameters
    ----------
    link_factory : opens the line; called by every ``open``.
    where : what messages call it: port or address.
    """

    def __init__(self, link_factory: Callable[[], Link], where: str) -> None:
        self.where = where
        self._link_factory = link_factory
        self._link: Link | None = None
        self._turn = threading.RLock()
        self._guard = StopGuard()
        self._recent: deque[str] = deque(maxlen=LINES_REMEMBERED)

    def stops(self) -> int:
        return self._guard.stops

    def recent_traffic(self) -> tuple[str, ...]:
        return tuple(self._recent.copy())


class Rotator(Protocol):
    """Methods raise ``LinkError``, ``ProtocolError`` or ``UnitRefused``; from several threads."""

    where: str
    """What messages call it; in sessions its serial number, where it has no name."""

    def open(self) -> RotatorIdentity:
        """Open the line and learn who is there; again after a lost link."""
        ...

    def close(self) -> None: ...

    def position_deg(self) -> Direction:
        """Where it stands: azimuth, elevation."""
        ...

    def stops(self) -> int:
        """How often ``stop`` or ``park`` was called: what ``go_to`` wants to know."""
        ...

    def go_to(self, azimuth_deg: float, elevation_deg: float, stops: int) -> None:
        """Set out for a direction, and return.

        ``stops``: what ``stops`` gave when this was decided. ProcedureRefused: it was stopped
        since, and nothing that waited may move it after a STOP.
        """
        ...

    def stop(self) -> None:
        """Stop now, past any request that is waiting. One that cannot stop is sent to where it
        stands."""
        ...

    def recent_traffic(self) -> tuple[str, ...]:
        """The last lines both ways, oldest first."""
        ...

    def park(self) -> None:
        """Go to its own parking position, past any request that is waiting."""
        ...
