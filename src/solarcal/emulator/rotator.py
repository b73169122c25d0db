"""An emulated rotator: the same hidden world, with a machine that knows nothing.

No Sun, no clock, no switches, no P and O: absolute encoders, two motors, a range, and a protocol
(``emulator.rotator_protocols``). A motion goes on when the connection is gone.

``RotatorWorld`` is the world around it as a station in the same process meets it. That station is
the controller, so virtual time must not run past what it would do meanwhile: time passes in pieces,
and the station acts between them.
"""

import math
from typing import Protocol

from solarcal.emulator.controller import Controller
from solarcal.emulator.emulation import EmulatedMachine
from solarcal.emulator.emulator_requests import MAX_SPEED
from solarcal.emulator.motor import Motor
from solarcal.emulator.rotator_protocols import RotatorProtocol, RotctldProtocol
from solarcal.errors import ConfigurationError
from solarcal.mount.drive import Drive, reading_deg, register
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits
from solarcal.unit.frames import LineBuffer
from solarcal.unit.tracker import EmulatedSky, Spot, Truth

SHORTEST_PIECE_S = 0.05


class _Axis:
    """Motor and absolute encoder of one axis, as its own nominal drive reads them."""

    def __init__(self, motor: Motor, drive: Drive, reference_deg: float) -> None:
        self._motor = motor
        self._drive = drive
        self._reference_deg = reference_deg
        # Absolute: it knows where it stands when it is switched on.
        self._zero = motor.encoder(0.0) - round(motor.position(0.0))

    def reading_deg(self, now_s: float) -> float:
        counts = self._motor.encoder(now_s) - self._zero
        return float(reading_deg(self._drive, self._reference_deg, counts))

    def go_to(self, reading_deg: float, now_s: float) -> None:
        goal = register(self._drive, self._reference_deg, reading_deg) + self._zero
        if goal != self._motor.encoder(now_s):
            self._motor.run_to(goal, now_s)
        else:
            self._motor.stop(now_s)

    def stop(self, now_s: float) -> None:
        self._motor.stop(now_s)


class EmulatedRotator(EmulatedMachine):
    """An ``azel`` scenario's world with a rotator in the place of the controller.

    Raises
    ------
    ConfigurationError
        The scenario's mount does not turn in azimuth and elevation.
    """

    def _switched_on(self, seed: int) -> Controller:
        unit, site = self.scenario.unit, self.scenario.site.place()
        if unit.geometry != "azel" or unit.target is not None:
            raise ConfigurationError(
                "a rotator turns in azimuth and elevation and follows the Sun itself: choose an "
                "azel scenario without a target"
            )
        motor1, motor2 = self.world.motors
        drive1, drive2 = unit.drives()
        self._axes = (
            _Axis(motor1, drive1, unit.reference1_deg),
            _Axis(motor2, drive2, unit.reference2_deg),
        )
        low1, high1 = unit.limits1_deg
        low2, high2 = unit.limits2_deg
        self.azimuth = AxisLimits(180.0 - high1, 180.0 - low1)
        self.elevation = AxisLimits(90.0 - high2, 90.0 - low2)
        self.protocol: RotatorProtocol = RotctldProtocol()
        """What it speaks."""
        self.silent = False
        """A fault: it receives, and answers nothing."""
        # Drives nothing: only its formula is asked where P and O would put the axes.
        self._yardstick = Controller(
            unit, site, 0.0, (motor1, motor2), lambda now_s: now_s, self.world.laptop_utc_s(0.0)
        )
        return self._yardstick

    # --- the line -----------------------------------------------------------------------------

    def handle_input(self, data: bytes) -> list[bytes]:
        """Lines of the replies, each with its line end."""
        with self.turn:
            self.catch_up()
            lines = [
                reply
                for line in self._input.feed(data)
                for reply in self.protocol.answer(self, line)
            ]
            return [] if self.silent else [line.encode("ascii") + b"\n" for line in lines]

    def link_lost(self) -> None:
        """Half a line is forgotten; what moves goes on."""
        self._input = LineBuffer()

    # --- the machine --------------------------------------------------------------------------

    def stands_deg(self) -> tuple[float, float]:
        """Azimuth and elevation as its encoders read them."""
        now_s = self.now_s()
        axis1, axis2 = self._axes
        return 180.0 - axis1.reading_deg(now_s), 90.0 - axis2.reading_deg(now_s)

    def go_to(self, azimuth_deg: float, elevation_deg: float) -> bool:
        """Set out for a direction; False where that is beyond its range."""
        reach = min(
            self.azimuth.distance_deg(azimuth_deg), self.elevation.distance_deg(elevation_deg)
        )
        if not reach >= 0.0:
            return False
        self._drive((180.0 - azimuth_deg, 90.0 - elevation_deg))
        return True

    def stop(self) -> None:
        for axis in self._axes:
            axis.stop(self.now_s())

    def park(self) -> None:
        unit = self.scenario.unit
        self._drive((unit.stow1_deg, unit.stow2_deg))

    def _drive(self, readings_deg: tuple[float, float]) -> None:
        now_s = self.now_s()
        for axis, goal_deg in zip(self._axes, readings_deg, strict=True):
            axis.go_to(goal_deg, now_s)

    # --- the world ----------------------------------------------------------------------------

    def settle(self) -> None:
        now_s = self.now_s()
        while (next_s := self.world.next_event_s()) <= now_s:
            self.world.happen(next_s)

    def spot(self) -> Spot:
        """One look at the sunspot device."""
        with self.turn:
            self.catch_up()
            return Spot(*self.world.spot(self.now_s()))

    def truth(self, coefficients: Coefficients, offsets: Offsets) -> Truth:
        """The mechanism's P1..P6, and the true error of whoever commands with this P and O."""
        with self.turn:
            now_s = self.now_s()
            model = self._yardstick.model
            model.remember(coefficients, offsets)
            model.set_clock(self.world.laptop_utc_s(now_s), now_s)
            return self.truth_now()


class StandIn(Protocol):
    """Who commands the rotator: acts when something is due, and knows P and O."""

    def act(self) -> None: ...

    def next_act_s(self) -> float:
        """Seconds from now until something is due; infinite where nothing is."""
        ...

    def in_force(self) -> tuple[Coefficients, Offsets]: ...


class RotatorWorld:
    """``Emulation`` of a rotator: time, the eye on the spot, the truth.

    ``stand_in``: who commands; ``None`` until it is set.
    """

    def __init__(self, rotator: EmulatedRotator) -> None:
        self.stand_in: StandIn | None = None
        self._rotator = rotator

    def time(self) -> tuple[float, float]:
        rotator = self._rotator
        with rotator.turn:
            rotator.catch_up()
            return rotator.times_utc_s()

    def speed(self) -> float:
        return self._rotator.speed()

    def set_speed(self, speed: float) -> float:
        if not 0.0 <= speed <= MAX_SPEED:
            raise ConfigurationError(f"virtual time cannot run {speed} times as fast")
        self._rotator.set_speed(speed)
        return speed

    def advance(self, seconds: float) -> tuple[float, float]:
        if not 0.0 <= seconds < math.inf:
            raise ConfigurationError(f"virtual time cannot be advanced by {seconds} s")
        left_s = seconds
        while left_s > 0.0:
            due_s = self.stand_in.next_act_s() if self.stand_in is not None else math.inf
            piece_s = min(left_s, max(due_s, SHORTEST_PIECE_S))
            self._rotator.advance(piece_s)
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
