"""The laptop's clock when the unit is an emulator: its time is the emulator's."""

import contextlib

from solarcal.errors import LinkError
from solarcal.timescale import SystemClock
from solarcal.unit.tracker import Emulation

LONGEST_REAL_WAIT_S = 0.25
"""After this much real time a wait looks again: the technician may have changed the speed."""


class EmulatedClock:
    """A ``Clock`` that asks the emulator for the laptop's time and waits in its time.

    At speed 0 virtual time moves only by this clock's ``X ADVANCE``: a headless day runs as fast
    as it can be computed, and the same commands meet the same instants on every kind of line. At
    any other speed it flows on and ``wait`` really waits, so that a technician at the
    screen sees it flow.
    """

    def __init__(self, emulation: Emulation) -> None:
        self._emulation = emulation
        self._real = SystemClock()
        self._last_utc_s = 0.0

    def utc_s(self) -> float:
        # When the line is gone the session must still be told so: the last known time stands.
        with contextlib.suppress(LinkError):
            self._last_utc_s = self._emulation.time()[1]
        return self._last_utc_s

    def wait(self, seconds: float) -> None:
        """Return when that much virtual time has passed.

        Raises
        ------
        LinkError
            The emulator is gone, and its time with it.
        """
        # The wire carries milliseconds; anything finer would differ from line to line.
        left_s = round(seconds, 3)
        if left_s <= 0.0:
            return
        speed = self._emulation.speed()
        if speed == 0.0:
            self._emulation.advance(left_s)
            return
        until_utc_s = self._emulation.time()[1] + left_s
        while left_s > 0.0:
            if speed == 0.0:
                self._emulation.advance(left_s)
                return
            self._real.wait(min(left_s / speed, LONGEST_REAL_WAIT_S))
            left_s = round(until_utc_s - self._emulation.time()[1], 3)
            speed = self._emulation.speed()
