"""The laptop's clock when the unit is an emulator: its time is the emulator's."""

import contextlib

from solarcal.errors import LinkError
from solarcal.unit.tracker import Emulation


class EmulatedClock:
    """A ``Clock`` that asks the emulator for the laptop's time and waits by ``X ADVANCE``.

    Virtual time moves only so: a headless day runs as fast as it can be computed, and the same
    commands meet the same instants on every kind of line.
    """

    def __init__(self, emulation: Emulation) -> None:
        self._emulation = emulation
        self._last_utc_s = 0.0

    def utc_s(self) -> float:
        # When the line is gone the session must still be told so: the last known time stands.
        with contextlib.suppress(LinkError):
            self._last_utc_s = self._emulation.time()[1]
        return self._last_utc_s

    def wait(self, seconds: float) -> None:
        if seconds > 0.0:
            # The wire carries milliseconds; anything finer would differ from line to line.
            self._emulation.advance(round(seconds, 3))
