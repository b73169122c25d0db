"""Time is injected: whoever needs it is handed a ``Clock``.

This module and the link are the only places that ask the operating system for the time or wait.
"""

import threading
import time
from typing import Protocol


class Clock(Protocol):
    """The laptop's clock: the time it shows, and a way to wait."""

    def utc_s(self) -> float:
        """The laptop's UTC, POSIX seconds."""
        ...

    def wait(self, seconds: float) -> None:
        """Return when that much of this clock's time has passed."""
        ...


class SystemClock:
    """The operating system's clock. ``wake`` ends a wait early."""

    def __init__(self) -> None:
        self._woken = threading.Event()

    def utc_s(self) -> float:
        return time.time()

    def wait(self, seconds: float) -> None:
        self._woken.wait(seconds)

    def wake(self) -> None:
        self._woken.set()
