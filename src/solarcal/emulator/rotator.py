"""An emulated rotator behind rotctld: the same hidden world, with a machine that knows nothing.

No Sun, no clock, no switches, no P and O: absolute encoders, two motors, a range, and the part of
rotctld's extended protocol that Hamlib's own answers in the same words. A motion goes on when the
connection is gone, as it does there.
"""

from collections.abc import Callable

from solarcal.emulator.controller import Controller
from solarcal.emulator.emulation import almanac, told_truth
from solarcal.emulator.motor import Motor
from solarcal.emulator.scenario import Scenario
from solarcal.emulator.true_error import TrueError
from solarcal.emulator.virtual_time import VirtualTime
from solarcal.emulator.world import World
from solarcal.errors import ConfigurationError
from solarcal.mount.drive import Drive, reading_deg, register
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.limits import AxisLimits
from solarcal.unit.frames import LineBuffer
from solarcal.unit.tracker import EmulatedSky, Spot, Truth

MODEL = 9001
"""No model of Hamlib's."""

INVALID, CANNOT = -1, -11


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


class EmulatedRotator:
    """An ``azel`` scenario's world with a rotator in the place of the controller.

    Parameters
    ----------
    start_utc_s, seed, noise_deg, speed, monotonic : as of ``Emulator``.

    Raises
    ------
    ConfigurationError
        The scenario's mount does not turn in azimuth and elevation.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        start_utc_s: float | None = None,
        seed: int = 0,
        noise_deg: float | None = None,
        speed: float = 0.0,
        monotonic: Callable[[], float] | None = None,
    ) -> None:
        if noise_deg is not None:
            scenario = scenario.with_settings([f"truth.noise_deg={noise_deg!r}"])
        unit, truth, site = scenario.unit, scenario.truth, scenario.site.place()
        if unit.geometry != "azel" or unit.target is not None:
            raise ConfigurationError(
                "a rotator turns in azimuth and elevation and follows the Sun itself: choose an "
                "azel scenario without a target"
            )
        self.scenario = scenario
        self.noise_deg = truth.noise_deg
        references = (unit.reference1_deg, unit.reference2_deg)
        drives = unit.drives()
        self.world = World(
            truth,
            site,
            unit.mount(site),
            truth.drives(*drives),
            references,
            scenario.start_utc_s() if start_utc_s is None else start_utc_s,
            seed,
        )
        motor1, motor2 = self.world.motors
        self._axes = (
            _Axis(motor1, drives[0], references[0]),
            _Axis(motor2, drives[1], references[1]),
        )
        low1, high1 = unit.limits1_deg
        low2, high2 = unit.limits2_deg
        self.azimuth = AxisLimits(180.0 - high1, 180.0 - low1)
        self.elevation = AxisLimits(90.0 - high2, 90.0 - low2)
        self.time = VirtualTime(self.settle, speed, monotonic)
        self._input = LineBuffer()
        self.silent = False
        """A fault: it hears, and answers nothing."""
        # Drives nothing: only its formula is asked where P and O would put the axes.
        self._yardstick = Controller(
            unit, site, 0.0, (motor1, motor2), lambda now_s: now_s, self.world.laptop_utc_s(0.0)
        )
        self._true_error = TrueError(self.world, self._yardstick)

    # --- the line -----------------------------------------------------------------------------

    def handle_input(self, data: bytes) -> list[bytes]:
        """Lines of the replies, each with its line end."""
        with self.time.turn:
            self.catch_up()
            lines = [reply for line in self._input.feed(data) for reply in self._answer(line)]
            return [] if self.silent else [line.encode("ascii") + b"\n" for line in lines]

    def catch_up(self) -> None:
        """Let the time pass that real time owes."""
        self.time.catch_up()

    def link_lost(self) -> None:
        """Half a line is forgotten; what moves goes on."""
        self._input = LineBuffer()

    def _answer(self, line: bytes) -> list[str]:
        text = line.decode("ascii", errors="replace")
        name, *arguments = text.removeprefix("+\\").split()
        if not text.startswith("+\\") or name not in self._WORDS:
            # rotctld says nothing to what it does not know.
            return []
        now_s = self.time.now_s()
        answer = self._WORDS[name](self, arguments, now_s)
        body = answer if isinstance(answer, list) else []
        result = 0 if isinstance(answer, list) else answer
        return [f"{name}: {' '.join(arguments)}".rstrip(), *body, f"RPRT {result}"]

    def _get_pos(self, arguments: list[str], now_s: float) -> list[str]:
        del arguments
        azimuth, elevation = self.stands_deg(now_s)
        return [f"Azimuth: {azimuth:.2f}", f"Elevation: {elevation:.2f}"]

    def _set_pos(self, arguments: list[str], now_s: float) -> list[str] | int:
        try:
            azimuth, elevation = (float(text) for text in arguments)
        except ValueError:
            return INVALID
        reach = min(self.azimuth.distance_deg(azimuth), self.elevation.distance_deg(elevation))
        if not reach >= 0.0:
            return INVALID
        self._axes[0].go_to(180.0 - azimuth, now_s)
        self._axes[1].go_to(90.0 - elevation, now_s)
        return []

    def _stop(self, arguments: list[str], now_s: float) -> list[str]:
        del arguments
        for axis in self._axes:
            axis.stop(now_s)
        return []

    def _park(self, arguments: list[str], now_s: float) -> list[str]:
        del arguments
        unit = self.scenario.unit
        self._axes[0].go_to(unit.stow1_deg, now_s)
        self._axes[1].go_to(unit.stow2_deg, now_s)
        return []

    def _state(self, arguments: list[str], now_s: float) -> list[str]:
        del arguments, now_s
        return [
            "rotctld Protocol Ver: 1",
            f"Rotor Model: {MODEL}",
            f"Minimum Azimuth: {self.azimuth.low_deg:f}",
            f"Maximum Azimuth: {self.azimuth.high_deg:f}",
            f"Minimum Elevation: {self.elevation.low_deg:f}",
            f"Maximum Elevation: {self.elevation.high_deg:f}",
            "South Zero: 0",
            "rot_type=AzEl",
            "done",
        ]

    def _caps(self, arguments: list[str], now_s: float) -> list[str]:
        del arguments, now_s
        return [
            f"Caps dump for model:\t{MODEL}",
            "Model name:\t\tRotator",
            "Mfg name:\t\tEmulated",
            "Backend version:\t1.0",
            "Rot type:\t\tAz-El",
        ]

    _WORDS = {  # noqa: RUF012
        "get_pos": _get_pos,
        "set_pos": _set_pos,
        "stop": _stop,
        "park": _park,
        "dump_state": _state,
        "dump_caps": _caps,
    }

    # --- the world ----------------------------------------------------------------------------

    def settle(self) -> None:
        """Let everything happen that is due by now."""
        now_s = self.time.now_s()
        while (next_s := self.world.next_event_s()) <= now_s:
            self.world.happen(next_s)

    def stands_deg(self, now_s: float) -> tuple[float, float]:
        """Azimuth and elevation as its encoders read them."""
        axis1, axis2 = self._axes
        return 180.0 - axis1.reading_deg(now_s), 90.0 - axis2.reading_deg(now_s)

    def spot(self) -> Spot:
        """One look at the sunspot device."""
        with self.time.turn:
            self.catch_up()
            return Spot(*self.world.spot(self.time.now_s()))

    def sky(self) -> EmulatedSky:
        return almanac(self.world)

    def truth(self, coefficients: Coefficients, offsets: Offsets) -> Truth:
        """The mechanism's P1..P6, and the true error of whoever commands with this P and O."""
        with self.time.turn:
            now_s = self.time.now_s()
            model = self._yardstick.model
            model.remember(coefficients, offsets)
            model.set_clock(self.world.laptop_utc_s(now_s), now_s)
            return told_truth(self.world, self._true_error, now_s)
