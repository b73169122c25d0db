"""What only an emulator can be asked, its time first (``docs/protocol.md``, Emulator only: ``X``).

Time is whole microseconds that pass only when they are let.
"""

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Protocol

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.unit import fields, values
from solarcal.unit.frames import Code, Refusal
from solarcal.unit.tracker import EmulatedSky, Spot, Truth
from solarcal.unit.verbs import expect


class VirtualTime(ABC):
    """Virtual seconds since the start.

    Parameters
    ----------
    speed : virtual seconds a real second. 0: time moves only by ``advance``.
    monotonic : real seconds from any beginning; the operating system's by default.

    Everything happens at an instant of its own, so that it makes no difference how time was cut
    into pieces or who looked on the way. Methods may be called from several threads.
    """

    def __init__(self, speed: float = 0.0, monotonic: Callable[[], float] | None = None) -> None:
        if not 0.0 <= speed <= MAX_SPEED:
            raise ConfigurationError(f"speed {speed:g} must lie between 0 and a million")
        self.turn = threading.RLock()
        """Held while the world must not move on."""
        self._now_us = 0
        self._speed = speed
        self._monotonic = monotonic or time.monotonic
        self._caught_up_s = self._monotonic()

    @abstractmethod
    def settle(self) -> None:
        """Let everything happen that is due by now, in the order of its instants."""

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
            self.settle()

    def catch_up(self) -> None:
        """Let the virtual time pass that real time owes; nothing at speed 0."""
        if not self._speed:
            return
        with self.turn:
            real_s = self._monotonic()
            owed_s, self._caught_up_s = real_s - self._caught_up_s, real_s
            self.advance(owed_s * self._speed)


MAX_SPEED = 1e6


class Surroundings(Protocol):
    """The emulation around a controller. Times in seconds, axes 1 and 2."""

    def now_s(self) -> float: ...

    def times_utc_s(self) -> tuple[float, float]: ...

    def speed(self) -> float: ...

    def set_speed(self, speed: float) -> None: ...

    def advance(self, seconds: float) -> None: ...

    def settle(self) -> None: ...

    def spot(self) -> Spot: ...

    def sky(self) -> EmulatedSky: ...

    def truth(self) -> Truth: ...

    def lose_counts(self, axis: int, counts: int) -> None: ...

    def freeze(self, axis: int) -> None: ...

    def thaw(self) -> None: ...

    def reboot(self) -> None: ...

    def talk(self, fault: str) -> None: ...


def without_arguments(answer: Callable[[], list[str]]) -> Callable[[list[str]], list[str]]:
    """What carries out a request that takes no arguments, and refuses any."""

    def carry_out(arguments: list[str]) -> list[str]:
        expect(arguments, "")
        return answer()

    return carry_out


class EmulatorRequests:
    """Carries out ``X`` requests on the surroundings."""

    def __init__(self, surroundings: Surroundings) -> None:
        self._around = around = surroundings
        self._words: dict[str, Callable[[list[str]], list[str]]] = {
            "TIME": without_arguments(self._time),
            "SPEED": self._speed,
            "ADVANCE": self._advance,
            "SPOT": without_arguments(lambda: fields.SPOT.write(around.spot())),
            "SKY": without_arguments(lambda: fields.SKY.write(around.sky())),
            "TRUTH": without_arguments(lambda: fields.TRUTH.write(around.truth())),
            "FAULT": self._fault,
        }

    def carry_out(self, arguments: list[str]) -> list[str]:
        """The reply's fields; raises Refusal or ProtocolError."""
        word = self._words.get(arguments[0]) if arguments else None
        if word is None:
            raise Refusal(Code.UNKNOWN, f"unknown request; X takes {' '.join(self._words)}")
        return word(arguments[1:])

    def _time(self) -> list[str]:
        return fields.TIMES_AND_SPEED.write((self._around.times_utc_s(), self._around.speed()))

    def _speed(self, arguments: list[str]) -> list[str]:
        self._around.set_speed(fields.SPEED.read(arguments))
        return fields.SPEED.write(self._around.speed())

    def _advance(self, arguments: list[str]) -> list[str]:
        self._around.advance(fields.ADVANCE.read(arguments))
        return fields.TIMES.write(self._around.times_utc_s())

    def _fault(self, arguments: list[str]) -> list[str]:
        (name,) = expect(arguments, "name")
        if name in ("mute", "garbage"):
            self._around.talk(name)
        elif name == "none":
            self._around.talk("")
            self._around.thaw()
        elif name in ("freeze1", "freeze2"):
            self._around.freeze(int(name[-1]))
        elif name == "reboot":
            self._around.reboot()
        elif name.startswith(("miss1:", "miss2:")):
            self._around.lose_counts(int(name[4]), values.whole_number(name[6:], "counts"))
        else:
            raise ProtocolError(
                "faults are mute garbage none freeze1 freeze2 reboot miss1:counts miss2:counts"
            )
        return [name]
