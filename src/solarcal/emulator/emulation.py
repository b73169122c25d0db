"""World and controller joined: motor commands one way, encoder counts the other, time over both.

And the TRUE error: how far from the apparent Sun the controller's formula would put the collector.
Both axes are taken to stand exactly where the formula with the unit's clock puts them: no update
step, no backlash, no lost count, no reading noise.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from solarcal.emulator.controller import Controller
from solarcal.emulator.emulator_requests import VirtualTime
from solarcal.emulator.protocol_server import Faults, ProtocolServer, is_urgent
from solarcal.emulator.scenario import Scenario
from solarcal.emulator.world import World, random_stream
from solarcal.mount.formula import Coefficients
from solarcal.site import Weather
from solarcal.sun import sun_position
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S, require_supported_times
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.unit.frames import LineBuffer
from solarcal.unit.tracker import EmulatedSky, Spot, Truth, UnitIdentity
from solarcal.units import FloatArray, rms, wrap_deg

MODEL = "SOLARTRAK-EMU"
FIRMWARE = "1.0"


STEP_S = 300.0
MIN_ELEVATION_DEG = 10.0
DAYS_APART = 7
DAYS_OF_YEAR = 53
"""Every seventh day of a year."""


class _SunPath(NamedTuple):
    """Times (true UTC) with the Sun high enough, and its ideal axis angles; each (n,)."""

    utc_s: FloatArray
    ax1_deg: FloatArray
    ax2_deg: FloatArray


class TrueError:
    """True errors of one emulated tracker; the Sun's paths are computed once a day and year."""

    def __init__(self, world: World, controller: Controller) -> None:
        self._world = world
        self._controller = controller
        self._path = cache(self._computed_path)

    def day_deg(self, now_s: float) -> FloatArray:
        """Angles on sky every 5 min of the solar day about the transit nearest to ``now_s``.

        The clock drifts on as it does; before it was last set, it counts as just set.
        """
        path = self._path(self._day_begins_utc_s(now_s), 1)
        clock_s = self._controller.model.clock_error_s(
            path.utc_s - self._world.start_utc_s, self._world.start_utc_s
        )
        return self._errors_deg(path, clock_s)

    def year_deg(self, now_s: float) -> FloatArray:
        """The same over every seventh day of this calendar year, with the clock error of now.

        Where the Sun models do not hold for all of this year, of the nearest for which they do.
        """
        world = self._world
        instants_s = (FIRST_UTC_S, world.true_utc_s(now_s), LAST_UTC_S)
        first, now, last = (
            np.datetime64(math.floor(utc_s), "s").astype("datetime64[Y]") for utc_s in instants_s
        )
        year = min(max(now, first + 1), last - 1)
        new_year_s = float(year.astype("datetime64[s]").astype(int))
        mean_midnight_s = new_year_s - world.site.longitude_deg / 360.0 * SECONDS_PER_DAY
        path = self._path(round(mean_midnight_s / STEP_S) * STEP_S, DAYS_OF_YEAR)
        clock_s = self._controller.model.utc_s(now_s) - world.true_utc_s(now_s)
        return self._errors_deg(path, np.full_like(path.utc_s, clock_s))

    def _day_begins_utc_s(self, now_s: float) -> float:
        """Solar midnight before the transit nearest to now, on the 5-minute grid."""
        utc_s = self._world.true_utc_s(now_s)
        sun = sun_position("solartrak", utc_s, self._world.site)
        since_transit_h = float(wrap_deg((sun.solar_time_h - 12.0) * 15.0)) / 15.0
        midnight_s = utc_s - since_transit_h * 3600.0 - SECONDS_PER_DAY / 2.0
        return round(midnight_s / STEP_S) * STEP_S

    def _computed_path(self, begins_utc_s: float, days: int) -> _SunPath:
        of_day = np.arange(0.0, SECONDS_PER_DAY, STEP_S)
        of_year = np.arange(days) * DAYS_APART * SECONDS_PER_DAY
        times = begins_utc_s + (of_year[:, np.newaxis] + of_day).ravel()
        ax1, ax2, elevation = self._world.sky.sun_path_deg(times)
        high = elevation > MIN_ELEVATION_DEG
        return _SunPath(times[high], ax1[high], ax2[high])

    def _errors_deg(self, path: _SunPath, clock_error_s: FloatArray) -> FloatArray:
        readings, room = self._controller.model.readings_deg(path.utc_s + clock_error_s)
        within = room >= 0.0
        counts = [
            axis.drive.counts(readings[index, within]) - axis.drive.counts(axis.reference_deg)
            for index, axis in enumerate(self._controller.axes)
        ]
        looks1, looks2 = self._world.pointing_deg(counts[0], counts[1])
        return self._world.geometry.sky_separation_deg(
            path.ax1_deg[within], path.ax2_deg[within], looks1, looks2
        )


class EmulatedMachine(VirtualTime):
    """A scenario's world, and in it a machine that its line can reach.

    Parameters
    ----------
    start_utc_s : first true instant, POSIX UTC seconds; by default the scenario's.
    seed : of all that is random; every purpose has a stream of its own.
    noise_deg : the eye's, one sigma per axis on sky, in place of the scenario's.
    speed, monotonic : as of ``VirtualTime``.
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
        self.scenario = scenario
        self.noise_deg = scenario.truth.noise_deg
        start = scenario.start_utc_s() if start_utc_s is None else start_utc_s
        require_supported_times(np.array([start]))
        self.world = scenario.world(start, seed)
        self._input = LineBuffer()
        self._true_error = TrueError(self.world, self._switched_on(seed))
        super().__init__(speed, monotonic)

    @abstractmethod
    def _switched_on(self, seed: int) -> Controller:
        """Put the machine into the world; the controller by whose formula it points."""

    def times_utc_s(self) -> tuple[float, float]:
        """True UTC and the laptop's."""
        now_s = self.now_s()
        return self.world.true_utc_s(now_s), self.world.laptop_utc_s(now_s)

    def sky(self) -> EmulatedSky:
        """What is known of the world's Sun and air without looking at its truth."""
        truth = self.world.truth
        weather = truth.weather(self.world.site)
        if truth.refraction == "none":
            weather = Weather(0.0, weather.temperature_c)
        return EmulatedSky(truth.sun, weather)

    def truth_now(self) -> Truth:
        """The mechanism's P1..P6, and the true error with what its controller has in force."""
        m, now_s = self.world.mechanism, self.now_s()
        day_deg, year_deg = self._true_error.day_deg(now_s), self._true_error.year_deg(now_s)
        return Truth(
            coefficients=Coefficients(m.P1, m.P2, m.P3, m.P4, m.P5, m.P6),
            day_rms_deg=_rms(day_deg),
            day_max_deg=float(day_deg.max(initial=0.0)),
            year_rms_deg=_rms(year_deg),
        )


def _rms(errors_deg: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    return rms(errors_deg) if errors_deg.size else 0.0


class Emulator(EmulatedMachine):
    """An emulated tracker as its line sees it."""

    def _switched_on(self, seed: int) -> Controller:
        unit, site = self.scenario.unit, self.scenario.site.place()
        motor1, motor2 = self.world.motors
        self.controller = Controller(
            unit,
            unit.believed_site(site),
            self.scenario.unit_zone_west_h,
            (motor1, motor2),
            self.world.quartz_s,
            self.world.start_utc_s + self.world.truth.unit_offset_s,
        )
        self._faults = Faults(random_stream(seed, "garbage"))
        self._protocol = ProtocolServer(
            self.controller,
            self,
            UnitIdentity(MODEL, unit.serial, FIRMWARE, 1, frozenset("X")),
            self._faults,
        )
        return self.controller

    # --- the line -----------------------------------------------------------------------------

    def handle_input(self, data: bytes) -> list[bytes]:
        """Replies to a piece of the stream. STOP and STOW overtake whatever waits with them."""
        with self.turn:
            lines = self._input.feed(data)
            urgent = [index for index, line in enumerate(lines) if is_urgent(line)]
            # What waited before a STOP must not move the axes after it.
            overtaken = lines[: urgent[-1]] if urgent else []
            first = [lines[index] for index in urgent]
            late = [line for line in overtaken if not is_urgent(line)]
            rest = lines[len(overtaken) + 1 :] if urgent else lines
            self.catch_up()
            replies = [self._protocol.answer(line) for line in first]
            replies += [self._protocol.answer(line, overtaken=True) for line in late]
            replies += [self._protocol.answer(line) for line in rest]
            return [reply for some in replies for reply in some]

    def link_lost(self) -> None:
        """The station is gone: a jog ends, half a line is forgotten."""
        with self.turn:
            self.catch_up()
            self._input = LineBuffer()
            self.controller.cancel_jog(self.now_s())

    # --- time ---------------------------------------------------------------------------------

    def settle(self) -> None:
        now_s = self.now_s()
        while True:
            world_s = self.world.next_event_s()
            controller_s = self.controller.next_event_s()
            if min(world_s, controller_s) > now_s:
                return
            # Of two things at one instant the world's comes first, then axis 1 before axis 2.
            if world_s <= controller_s:
                for happening in self.world.happen(world_s):
                    if happening.stopped:
                        self.controller.motor_stopped(happening.axis, world_s)
                    else:
                        self.controller.encoder_jumped(happening.axis, world_s)
            else:
                self.controller.act(controller_s)

    # --- hidden truth -------------------------------------------------------------------------

    def spot(self) -> Spot:
        """One look at the sunspot device."""
        return Spot(*self.world.spot(self.now_s()))

    def truth(self) -> Truth:
        return self.truth_now()

    # --- faults -------------------------------------------------------------------------------

    def lose_counts(self, axis: int, counts: int) -> None:
        """From now on the register of axis 1 or 2 reads ``counts`` too high."""
        now_s = self.now_s()
        self.world.motors[axis - 1].lose(counts, now_s)
        self.controller.encoder_jumped(axis - 1, now_s)

    def freeze(self, axis: int) -> None:
        """The read-out of axis 1 or 2 stands still."""
        self.controller.axes[axis - 1].freeze(self.now_s())

    def thaw(self) -> None:
        """Both read-outs live again."""
        for axis in self.controller.axes:
            axis.thaw()

    def reboot(self) -> None:
        """The unit loses its power for a moment."""
        self.controller.reboot(self.now_s())
        self._protocol.forget()

    def talk(self, fault: str) -> None:
        """Replies leave the unit as ``mute``, ``garbage`` or (empty) as they are."""
        self._faults.kind = fault
