"""What a controller does with its motors, done by the station with a rotator: the modes.

Everything here is called from outside: a command of the technician, or ``act`` when
something is due (a step after the Sun, a jog that has expired, a check that has arrived).
The rotator is sent only to read-outs within the limits, and only in a mode a command has set.
"""

import threading
from dataclasses import dataclass
from typing import Final

from solarcal.decimals import Pair
from solarcal.errors import ProcedureRefused, UnitRefused
from solarcal.mount.drive import Drive, register
from solarcal.station.software_controller.controller_model import AzElAxes, SoftwareControllerModel
from solarcal.station.software_controller.motion import MotionWatch, SunSteps
from solarcal.unit.frames import Code
from solarcal.unit.rotator import READ_OUT_DEG, Rotator
from solarcal.unit.tracker import Mode, RefCheckResult

JOG_EXPIRES_S: Final = 5.0
WATCH_S: Final = 0.5
"""How often axes under way are looked at."""

LIMIT_AGAIN_S: Final = 10.0
THERE_DEG: Final = 1.0
"""A reference check that ends farther from the reference position than this did not get there."""

NEVER_S: Final = float("inf")


@dataclass(frozen=True, slots=True)
class Look:
    """One look at the rotator: when, by the stand-in's clock, and the read-outs."""

    utc_s: float
    reading_deg: Pair


class RotatorControl:
    """The modes of one rotator that is connected.

    Methods but ``stop`` and ``stow`` belong to whoever holds the turn; those two come from any
    thread at any time, and nothing decided before them moves anything after.
    """

    def __init__(
        self,
        rotator: Rotator,
        axes: AzElAxes,
        model: SoftwareControllerModel,
        read_out_deg: float = READ_OUT_DEG,
    ) -> None:
        parameters = model.parameters
        self.model = model
        self.mode = Mode.MANUAL
        self.goals_deg: Pair | None = None
        self._rotator = rotator
        self._axes = axes
        self._limits = parameters.limits
        self.steps = SunSteps(model.target_deg, parameters.limits, parameters.update_range_deg)
        self._references = (parameters.reference1_deg, parameters.reference2_deg)
        drives = (parameters.drive1, parameters.drive2)
        self.watches = tuple(
            MotionWatch(1.5 * max(_count_deg(drive, reference), read_out_deg))
            for drive, reference in zip(drives, self._references, strict=True)
        )
        self._drives = drives
        self._change = threading.Lock()
        self._halts = 0
        self._jog_expires_s = NEVER_S
        self._next_s = NEVER_S
        self._check = RefCheckResult(0, False, 0, 0)

    # -- looking -------------------------------------------------------------------------------

    def look(self) -> Look:
        """Read where it stands."""
        before_s = self.model.utc_s()
        direction = self._rotator.position_deg()
        # It belongs to the middle of its exchange.
        utc_s = 0.5 * (before_s + self.model.utc_s())
        readings = self._axes.reading_deg(direction)
        for watch, reading in zip(self.watches, readings, strict=True):
            watch.seen(utc_s, reading)
        return Look(utc_s, readings)

    def watch(self) -> Look:
        """Look; a jog or check whose axes have come to rest is over."""
        look = self.look()
        if self.at_rest:
            self._arrived(look)
        return look

    @property
    def at_rest(self) -> bool:
        return all(watch.moving == 0 for watch in self.watches)

    def counts(self, reading_deg: Pair) -> tuple[int, int]:
        """Counts from the reference position the nominal drives would show there."""
        first, second = (
            register(drive, reference, reading)
            for drive, reference, reading in zip(
                self._drives, self._references, reading_deg, strict=True
            )
        )
        return first, second

    def check_result(self) -> RefCheckResult:
        return self._check

    # -- commands ------------------------------------------------------------------------------

    def stop(self) -> None:
        self._halt(Mode.STOP)
        self._rotator.stop()

    def stow(self) -> None:
        """To the rotator's own parking position."""
        self._halt(Mode.STOW)
        try:
            self._rotator.park()
        except UnitRefused:
            self._halt(Mode.STOP)
            raise

    def manual(self) -> None:
        self._refuse_while_checking()
        halts = self._halts
        self._rotator.stop()
        self._become(Mode.MANUAL, halts)

    def track(self) -> None:
        """Follow the Sun from now on."""
        self._refuse_while_checking()
        now_s = self.model.utc_s()
        self.model.demand_sun(now_s, "MODE TRACK")
        if self.mode not in (Mode.TRACK, Mode.LIMIT):
            self.steps.forget()
            self._become(Mode.TRACK, self._halts)
        self._follow(now_s)

    def jog(self, target1_deg: float, target2_deg: float) -> None:
        """Go to read-outs; for five seconds, unless it is asked again."""
        self._refuse_while_checking()
        if self.mode is Mode.STOP:
            raise UnitRefused(Code.STOPPED, "stopped: MODE MANUAL or MODE TRACK first", "JOG")
        halts, goals = self._halts, (target1_deg, target2_deg)
        self._refuse_beyond(goals, "JOG")
        now_s = self.model.utc_s()
        under_way = self.mode is Mode.JOG and goals == self.goals_deg
        self._become(Mode.JOG, halts)
        self._jog_expires_s = now_s + JOG_EXPIRES_S
        if not under_way:
            self._send(goals, now_s)
        self._look_again(now_s)

    def start_check(self) -> None:
        """Go to the reference position, to be looked at there."""
        self._refuse_while_checking()
        if self.mode is Mode.STOP:
            raise UnitRefused(Code.STOPPED, "stopped: MODE MANUAL or MODE TRACK first", "REF START")
        halts = self._halts
        self._refuse_beyond(self._references, "REF START")
        self._become(Mode.REF, halts)
        self._check = RefCheckResult(self._check.number + 1, False, 0, 0, running=True)
        now_s = self.model.utc_s()
        self._send(self._references, now_s)
        self._look_again(now_s)

    def set_sun_offset(self) -> Look:
        """O such that the Sun belongs where the axes stand."""
        self._refuse_while_checking()
        look = self.look()
        if not self.at_rest:
            raise UnitRefused(Code.MOVING, "axis moving", "OFFSET SET")
        self.model.set_sun_offset(look.utc_s, *look.reading_deg)
        return look

    # -- of its own accord ---------------------------------------------------------------------

    def next_s(self) -> float:
        """When ``act`` has something to do, by the stand-in's clock."""
        return self._next_s

    def act(self) -> None:
        """Do what is due; nothing where nothing is."""
        now_s = self.model.utc_s()
        # A clock that was set back must not keep a jog alive, or the Sun unfollowed.
        if now_s < self._next_s <= now_s + LIMIT_AGAIN_S + 2.0 * JOG_EXPIRES_S:
            return
        mode = self.mode
        if mode in (Mode.TRACK, Mode.LIMIT):
            self._follow(now_s)
        elif mode is Mode.JOG and not 0.0 < self._jog_expires_s - now_s <= JOG_EXPIRES_S + 1.0:
            self.manual()
        elif self._next_s < NEVER_S:
            self.watch()
            self._look_again(now_s)

    def rethink(self) -> None:
        """Clock, P or O are others: where the Sun belongs is another place."""
        if self.mode in (Mode.TRACK, Mode.LIMIT):
            self._follow(self.model.utc_s())

    def let_go(self) -> bool:
        """No command is active any more; returns whether one was."""
        commanded = self.mode in (Mode.TRACK, Mode.JOG, Mode.REF)
        self._halt(Mode.MANUAL)
        return commanded

    # -- inside --------------------------------------------------------------------------------

    def _follow(self, now_s: float) -> None:
        halts = self._halts
        if not self.at_rest:
            self.look()
        within = self.steps.within(now_s) and self.model.sun_elevation_deg(now_s) >= 0.0
        if not within:
            if self.mode is Mode.TRACK:
                self._become(Mode.LIMIT, halts)
                self.steps.forget()
                self._rotator.stop()
            self._next_s = now_s + LIMIT_AGAIN_S
            return
        self._become(Mode.TRACK, halts)
        goals = self.steps.due(now_s)
        if goals is not None:
            self._send(goals, now_s)
        self._next_s = self.steps.next_s(now_s)
        if not self.at_rest:
            self._next_s = min(self._next_s, now_s + WATCH_S)

    def _arrived(self, look: Look) -> None:
        if self.mode is Mode.JOG:
            self._become(Mode.MANUAL, self._halts)
        elif self.mode is Mode.REF:
            difference1, difference2 = self.counts(look.reading_deg)
            off_deg = max(
                abs(reading - reference)
                for reading, reference in zip(look.reading_deg, self._references, strict=True)
            )
            self._check = RefCheckResult(
                self._check.number, off_deg <= THERE_DEG, difference1, difference2
            )
            self._become(Mode.MANUAL, self._halts)

    def _look_again(self, now_s: float) -> None:
        if self.mode in (Mode.JOG, Mode.REF) or not self.at_rest:
            self._next_s = now_s + WATCH_S
        elif self.mode not in (Mode.TRACK, Mode.LIMIT):
            self._next_s = NEVER_S

    def _send(self, goals: Pair, now_s: float) -> None:
        """To read-outs; not if a STOP has come since the mode was set."""
        with self._change:
            if self.mode not in (Mode.TRACK, Mode.JOG, Mode.REF):
                raise ProcedureRefused(f"not moved: the unit was put into mode {self.mode}")
            self.goals_deg = goals
            stops = self._rotator.stops()
        self._rotator.go_to(*self._axes.direction_deg(*goals), stops)
        for watch, goal in zip(self.watches, goals, strict=True):
            watch.set_out(now_s, goal)

    def _become(self, mode: Mode, halts: int) -> None:
        """Another mode, unless a STOP or STOW came since it was decided."""
        with self._change:
            if halts != self._halts:
                raise ProcedureRefused(
                    f"given up: the unit was put into mode {self.mode} meanwhile; set its mode "
                    "again before moving it"
                )
            self.mode = mode
            if mode not in (Mode.JOG, Mode.REF, Mode.TRACK):
                self._nowhere()

    def _halt(self, mode: Mode) -> None:
        with self._change:
            self._halts += 1
            if self._check.running:
                self._check = RefCheckResult(self._check.number, False, 0, 0)
            self.mode = mode
            self._nowhere()

    def _nowhere(self) -> None:
        self.goals_deg = None
        self._jog_expires_s = NEVER_S
        self.steps.forget()
        for watch in self.watches:
            watch.halt()
        # What coasts is watched until it stands.
        self._next_s = 0.0 if not self.at_rest else NEVER_S

    def _refuse_while_checking(self) -> None:
        if self.mode is Mode.REF:
            raise UnitRefused(Code.BUSY, "busy (reference check)", "a command")

    def _refuse_beyond(self, goals: Pair, request: str) -> None:
        if beyond := self._limits.beyond(*goals):
            raise UnitRefused(Code.BEYOND_LIMIT, beyond, request)


def _count_deg(drive: Drive, reference_deg: float) -> float:
    """Size of one count near the reference, degrees."""
    per_0_2_deg = drive.counts(reference_deg + 0.1) - drive.counts(reference_deg - 0.1)
    return abs(0.2 / float(per_0_2_deg))
