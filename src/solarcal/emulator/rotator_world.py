"""The world around an emulated rotator, as a station in the same process meets it.

The station is the controller here, so virtual time must not run past what the station would do
meanwhile: it is let pass in pieces, and the station acts between them.
"""

import math
from typing import Protocol

from solarcal.emulator.emulator_requests import MAX_SPEED
from solarcal.emulator.rotator import EmulatedRotator
from solarcal.errors import ConfigurationError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.unit.tracker import EmulatedSky, Spot, Truth

SHORTEST_PIECE_S = 0.05


class StandIn(Protocol):
    """Who commands the rotator: acts when something is due, and knows P and O."""

    def act(self) -> None: ...

    def next_act_s(self) -> float:
        """Seconds from now until something is due; infinite where nothing is."""
        ...

    def in_force(self) -> tuple[Coefficients, Offsets]: ...


class RotatorWorld:
    """``Emulation`` of a rotator: time, the eye on the spot, the truth.

    Attributes
    ----------
    stand_in : who commands; nobody until it is set.
    """

    def __init__(self, rotator: EmulatedRotator) -> None:
        self.stand_in: StandIn | None = None
        self._rotator = rotator

    def time(self) -> tuple[float, float]:
        rotator = self._rotator
        with rotator.time.turn:
            rotator.catch_up()
            now_s = rotator.time.now_s()
            return rotator.world.true_utc_s(now_s), rotator.world.laptop_utc_s(now_s)

    def speed(self) -> float:
        return self._rotator.time.speed()

    def set_speed(self, speed: float) -> float:
        if not 0.0 <= speed <= MAX_SPEED:
            raise ConfigurationError(f"virtual time cannot run {speed} times as fast")
        self._rotator.time.set_speed(speed)
        return speed

    def advance(self, seconds: float) -> tuple[float, float]:
        if not 0.0 <= seconds < math.inf:
            raise ConfigurationError(f"virtual time cannot be advanced by {seconds} s")
        left_s = seconds
        while left_s > 0.0:
            due_s = self.stand_in.next_act_s() if self.stand_in is not None else math.inf
            piece_s = min(left_s, max(due_s, SHORTEST_PIECE_S))
            self._rotator.time.advance(piece_s)
            left_s -= piece_s
            if self.stand_in is not None and piece_s >= due_s:
                self.stand_in.act()
        return self.time()

    def spot(self) -> Spot:
        return self._rotator.spot()

    def sky(self) -> EmulatedSky:
        return self._rotator.sky()

    def truth(self) -> Truth:
        nothing = (Coefficients(), Offsets())
        in_force = self.stand_in.in_force() if self.stand_in is not None else nothing
        return self._rotator.truth(*in_force)

    def fault(self, name: str) -> None:
        if name not in ("mute", "none"):
            raise ConfigurationError("faults of an emulated rotator are: mute none")
        self._rotator.silent = name == "mute"
