"""What keeps a unit going between commands: somebody looks, again and again, what is due."""

import threading
import weakref
from collections.abc import Callable
from typing import Protocol

from solarcal.clock import SystemClock

PACE_S = 0.25
"""How often is looked, real seconds."""


class Acting(Protocol):
    """Whoever has something due from time to time."""

    def act(self) -> None:
        """Do what is due; nothing where nothing is."""
        ...


class Pace(Protocol):
    """Has ``act`` called when something is due."""

    def begin(self, unit: Acting) -> None: ...

    def end(self) -> None: ...


class ThreadPace:
    """A thread that looks, several times a second, whether something is due.

    Parameters
    ----------
    speed : laptop seconds a real second; 0 while time is moved by somebody who calls ``act``.
    """

    def __init__(self, speed: Callable[[], float] = lambda: 1.0) -> None:
        self._speed = speed
        self._clock: SystemClock | None = None

    def begin(self, unit: Acting) -> None:
        self.end()
        clock = self._clock = SystemClock()
        # Held weakly: a unit that nobody uses any more is not kept going.
        threading.Thread(
            target=self._run, args=(weakref.ref(unit), clock), name="pace of the unit", daemon=True
        ).start()

    def end(self) -> None:
        # Not joined: it may be waiting for the turn of whoever ends it, and finds nothing to do.
        clock, self._clock = self._clock, None
        if clock is not None:
            clock.wake()

    def _run(self, held: "weakref.ref[Acting]", clock: SystemClock) -> None:
        while self._clock is clock:
            speed = self._speed()
            unit = held()
            if unit is None:
                return
            if speed > 0.0 and self._clock is clock:
                unit.act()
            del unit
            clock.wait(PACE_S if speed <= 1.0 else max(PACE_S / speed, 0.01))
