"""The time of an emulated world: whole microseconds that pass only when they are let."""

import threading
import time
from collections.abc import Callable

from solarcal.emulator.emulator_requests import MAX_SPEED
from solarcal.errors import ConfigurationError


class VirtualTime:
    """Virtual seconds since the start.

    Parameters
    ----------
    settle : lets everything happen that is due by now, in the order of its instants.
    speed : virtual seconds a real second. 0: time moves only by ``advance``.
    monotonic : real seconds from any beginning; the operating system's by default.

    Everything happens at an instant of its own, so that it makes no difference how time was cut
    into pieces or who looked on the way. Methods may be called from several threads.
    """

    def __init__(
        self,
        settle: Callable[[], None],
        speed: float = 0.0,
        monotonic: Callable[[], float] | None = None,
    ) -> None:
        if not 0.0 <= speed <= MAX_SPEED:
            raise ConfigurationError(f"speed {speed:g} must lie between 0 and a million")
        self.turn = threading.RLock()
        """Held while the world must not move on."""
        self._settle = settle
        self._now_us = 0
        self._speed = speed
        self._monotonic = monotonic or time.monotonic
        self._caught_up_s = self._monotonic()

    def now_s(self) -> float:
        return self._now_us * 1e-6

    def speed(self) -> float:
        return self._speed

    def set_speed(self, speed: float) -> None:
        """From now on this many virtual seconds pass in a real one; 0: only by ``advance``."""
        with self.turn:
            self.catch_up()
            self._speed, self._caught_up_s = speed, self._monotonic()

    def advance(self, seconds: float) -> None:
        """Let that much virtual time pass, to the microsecond."""
        with self.turn:
            self._now_us += round(seconds * 1e6)
            self._settle()

    def catch_up(self) -> None:
        """Let the virtual time pass that real time owes; nothing at speed 0."""
        if not self._speed:
            return
        with self.turn:
            real_s = self._monotonic()
            owed_s, self._caught_up_s = real_s - self._caught_up_s, real_s
            self.advance(owed_s * self._speed)
