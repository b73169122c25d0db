"""Follow the sensor: with a sun sensor in place of the technician's eye, points take themselves.

Only on explicit command. Each point goes the technician's way: onto the Sun by jogging, from
behind, Set Sun Offset, a minute and an update watched, the three questions answered by what was
seen. Every motion is bounded, and at any doubt the unit is stopped and the reason reported and
recorded: it may be unattended.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from solarcal.decimals import counted
from solarcal.errors import ProcedureRefused
from solarcal.session.records import PointRecord
from solarcal.station.attempts import NOT_INITIALISED
from solarcal.station.centring import SunCentring, wait_until
from solarcal.station.jogging import JogView, SunOffsetJog
from solarcal.station.point_judgement import judge_point
from solarcal.station.procedure import Station
from solarcal.two_mirror.control import REVERSED, GrowthWatch
from solarcal.unit.tracker import Mode, Spot

GAIN = 0.6
"""The part of an error that one correction takes away: with less than all of it, noise and the
unit's own motion do not add up."""

SETTLE_S = 3.0
LONGEST_SLEW_S = 1200.0
LOOKS = 4
LOOK_EVERY_S = 0.5
MAX_CORRECTIONS = 40
LARGEST_CORRECTION_DEG = 2.0
"""On sky, from where it began. More than this is not an offset but a mistake."""

LEAST_ELEVATION_DEG = 10.0


@dataclass(frozen=True, slots=True)
class FollowPlan:
    """How many points, and how far apart."""

    points: int = 12
    every_min: float = 30.0

    def __post_init__(self) -> None:
        if not 1 <= self.points <= 200:
            raise ProcedureRefused(f"{counted(self.points, 'point')}: give 1 to 200")
        if not 5.0 <= self.every_min <= 240.0:
            raise ProcedureRefused(
                f"a point every {self.every_min:g} minutes: give 5 to 240 minutes"
            )


@dataclass(frozen=True, slots=True)
class Followed:
    """What came of it. ``stopped``: the doubt that ended it, "" when there was none."""

    points: tuple[PointRecord, ...]
    stopped: str = ""


class SensorDoubt(ProcedureRefused):
    """Something is not as it should be; the unit is to be stopped."""


def _demand_ready(station: Station, commanded: bool) -> None:
    if not commanded:
        raise ProcedureRefused(
            "following the sensor moves the unit without a key press; it starts only on command"
        )
    session = station.session
    if session.initialised is None:
        raise ProcedureRefused(NOT_INITIALISED, "initialise")
    if not session.ref_checks or not session.ref_checks[-1].complete:
        raise ProcedureRefused("do a reference check first; without one no point would count")


class SensorFollower:
    """The sensor's eye and the jogging hand, for one station.

    Parameters
    ----------
    station : connected, session initialised, a complete reference check in it, the unit tracking.
    look : what the sensor shows now: by how much each axis must move, axis degrees.
    sensor_sigma_deg : noise of one look, one sigma per axis on the sky.
    """

    light = "Sun"

    def __init__(
        self,
        station: Station,
        look: Callable[[], Spot],
        *,
        sensor_sigma_deg: float = 0.02,
        say: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self._station = station
        self._look = look
        self._mean_sigma_deg = sensor_sigma_deg / math.sqrt(LOOKS)
        self._centred_deg = 0.005 + 2.0 * self._mean_sigma_deg
        self._say = say
        self._sight = SunCentring(station, look, eye_sigma_deg=sensor_sigma_deg, say=say)

    def follow(self, plan: FollowPlan, *, commanded: bool) -> Followed:
        """Take points by the sensor until the plan is done, the light is low, or a doubt arises.

        ``commanded``: whether the technician asked for it in so many words; nothing else starts it.

        Raises
        ------
        ProcedureRefused
            It was not asked for, or the station is not ready for points.
        LinkError
            The line was lost.
        """
        station = self._station
        _demand_ready(station, commanded)
        self.demand_ready()
        station.note(
            f"following the {self.light} by the sun sensor from here: "
            f"{counted(plan.points, 'point')}, every {plan.every_min:g} min"
        )
        taken: list[PointRecord] = []
        slot_utc_s = station.clock.utc_s()
        while len(taken) < plan.points:
            wait_until(station, slot_utc_s)
            slot_utc_s += 60.0 * plan.every_min
            if self.elevation_deg() < LEAST_ELEVATION_DEG:
                self._say(f"the {self.light} is below {LEAST_ELEVATION_DEG:g} deg: no more points")
                break
            try:
                taken.append(self.take_point())
            except ProcedureRefused as doubt:
                return Followed(tuple(taken), self.stop(str(doubt)))
        station.note(f"following the sun sensor ended with {counted(len(taken), 'point')}")
        return Followed(tuple(taken))

    def demand_ready(self) -> None:
        """Raises ``ProcedureRefused`` where the unit is not where points can begin."""
        mode = self._station.poll().mode
        if mode is not Mode.TRACK:
            raise ProcedureRefused(f"the unit is in mode {mode}; let it track first")

    def elevation_deg(self) -> float:
        """How high the light stands now."""
        return self._station.sun_elevation_deg()

    def take_point(self) -> PointRecord:
        """One point, stored.

        Raises
        ------
        SensorDoubt, ProcedureRefused
            Something speaks against it; the unit is where that was noticed.
        """
        self._await_tracking()
        jog = SunOffsetJog(self._station)
        try:
            self._centre(jog)
            jog.set_here()
        finally:
            jog.release()
        if not self._sight.watch():
            raise SensorDoubt("after a minute and an update the sensor shows it off the Sun")
        self._station.begin_point()
        # Reference check, Set Sun Offset and the watch are behind us, else we were not here.
        for _ in range(3):
            self._station.answer(True)
        candidate = self._station.gather_point()
        assert isinstance(candidate, PointRecord)  # no check point was begun
        judgement = judge_point(self._station.session, candidate)
        if judgement.suspicious:
            self._station.store(False, judgement.sentence)
            raise SensorDoubt(judgement.sentence)
        stored = self._station.store(True)
        assert isinstance(stored, PointRecord)
        return self._stored(stored)

    def _stored(self, stored: PointRecord) -> PointRecord:
        """Record what the fit says with it."""
        self._station.record_newest_fit()
        self._say(f"point {stored.seq} stored")
        return stored

    def stop(self, doubt: str) -> str:
        """Stop the unit, give up an attempt in progress, note and return why."""
        self._station.stop()
        if self._station.state.attempt is not None:
            self._station.abort_attempt(doubt)
        self._station.note(f"following the sun sensor was stopped: {doubt}")
        self._say(f"stopped: {doubt}")
        return doubt

    def _await_tracking(self) -> None:
        """Let a unit that comes from elsewhere reach its computed Sun."""
        near_deg = 2.0 * self._station.session.header.unit.update_range_deg
        for _ in range(math.ceil(LONGEST_SLEW_S / SETTLE_S)):
            status = self._station.poll()
            if status.mode is not Mode.TRACK:
                raise SensorDoubt(f"the unit went to mode {status.mode}; it was stopped")
            if max(map(abs, status.off_target_deg)) <= near_deg:
                return
            self._station.clock.wait(SETTLE_S)
        raise SensorDoubt(
            f"the axes did not reach their targets in {LONGEST_SLEW_S / 60.0:.0f} minutes"
        )

    def _centre(self, jog: SunOffsetJog) -> None:
        """Onto the light, both axes from behind, within what the sensor can tell."""
        watch = GrowthWatch()
        view = jog.look()
        began = view.status.off_ideal_deg
        for _ in range(MAX_CORRECTIONS):
            spot = self._mean_look(jog)
            view = jog.look()
            self._demand_jogging(view)
            error_deg = view.status.on_sky_deg(spot.error1_deg, spot.error2_deg)
            if watch.growing(1e3 * math.radians(error_deg)):
                raise SensorDoubt(watch.sentence())
            moved = view.status.off_ideal_deg
            moved_deg = view.status.on_sky_deg(moved[0] - began[0], moved[1] - began[1])
            if moved_deg > LARGEST_CORRECTION_DEG:
                raise SensorDoubt(
                    f"the sensor asked for {moved_deg:.2f} deg, more than "
                    f"{LARGEST_CORRECTION_DEG:g}: {REVERSED}"
                )
            if error_deg > self._centred_deg:
                jog.nudge(GAIN * spot.error1_deg, GAIN * spot.error2_deg)
                self._renew(jog, SETTLE_S)
            elif all(view.watch.from_behind):
                return
            else:
                # Behind the light and forward to the same aim: the slack is taken up.
                jog.go_behind()
                self._come_forward(jog)
                watch.forget()
        raise SensorDoubt(f"the {self.light} could not be centred in {MAX_CORRECTIONS} corrections")

    def _come_forward(self, jog: SunOffsetJog, longest_s: float = MAX_CORRECTIONS) -> None:
        for _ in range(math.ceil(longest_s)):
            view = self._renew(jog, 1.0)
            going = view.aim is not None and any(view.aim.behind)
            if not going and view.status.moving == (0, 0) and all(view.watch.from_behind):
                return
        raise SensorDoubt(
            f"the axes do not come forward from behind the {self.light}; find out what blocks them"
        )

    def _renew(self, jog: SunOffsetJog, seconds: float) -> JogView:
        """Let the axes move, the target renewed before it expires."""
        for _ in range(math.ceil(seconds)):
            self._station.clock.wait(1.0)
            view = jog.look()
            self._demand_jogging(view)
        return view

    def _mean_look(self, jog: SunOffsetJog) -> Spot:
        """The mean of a few looks; while jogging the aim keeps the spot where it is."""
        spots = []
        for number in range(LOOKS):
            if number:
                self._station.clock.wait(LOOK_EVERY_S)
                if jog.jogging:
                    jog.look()
            spot = self._look()
            if not spot.visible:
                raise SensorDoubt(
                    f"the sensor sees no {self.light}: clouds, or it was lost while centring"
                )
            if not (math.isfinite(spot.error1_deg) and math.isfinite(spot.error2_deg)):
                raise SensorDoubt("the sensor gives something that is not a number")
            spots.append(spot)
        return Spot(
            True,
            sum(spot.error1_deg for spot in spots) / LOOKS,
            sum(spot.error2_deg for spot in spots) / LOOKS,
        )

    @staticmethod
    def _demand_jogging(view: JogView) -> None:
        if view.status.mode not in (Mode.TRACK, Mode.JOG, Mode.MANUAL):
            raise SensorDoubt(f"the unit went to mode {view.status.mode}; it was stopped")
