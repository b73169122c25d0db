"""The automatic technician: performs the whole manual procedure by what can be seen.

It knows no truth. It looks at the sunspot, jogs until the spot is centred, comes from the proper
side, waits for an update, answers the three questions by what it observed, and stores a point only
if the counts make sense.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solarcal.errors import LinkError, ProcedureRefused
from solarcal.model.fit import FEWEST_POINTS
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.drive import reading_deg, register
from solarcal.session.records import CheckRecord, PointRecord, UploadRecord
from solarcal.station.fitting import solve
from solarcal.station.procedure import Station
from solarcal.station.unit_sun import ideal_axes_deg
from solarcal.sun.day import daylight
from solarcal.timescale import format_utc
from solarcal.unit.tracker import Spot, Status
from solarcal.units import wrap_deg

FINE_MOVE_S = 2.0
"""Every jog aims at where the Sun will be this much later, and is renewed at this interval."""

BEHIND_DEG = 0.4
"""How far to go behind the Sun before coming forward: more than any backlash worth the name."""

WATCH_S = 60.0
WATCH_STEP_S = 5.0
MAX_WATCH_S = 420.0
CLOUD_WAIT_S = 300.0
MAX_CENTRING_MOVES = 12
CATCH_UP_S = 60.0
"""An axis past the Sun by less than this waits for it; by more, it goes behind."""

SUN_STANDS_DEG_PER_S = 2e-4
"""Slower than this the Sun's sense of motion in an axis means nothing."""

MAX_TRIES = 3
MIN_POINT_ELEVATION_DEG = 10.0
SUSPICIOUS_DEG = 0.25
"""Counts that disagree with the prediction by more than this (on sky, and by more than five sigmas
of the prediction) call for a reference check."""

TRUSTED_FIT_POINTS = 5


@dataclass(frozen=True, slots=True)
class Schedule:
    """How many points, and how far apart. ``every_min`` None spreads them over the daylight."""

    points: int = 12
    every_min: float | None = None
    checks: int = 2
    check_every_min: float = 30.0


def spread_every_min(points: int, daylight_left_min: float) -> float:
    """Minutes between points that use the daylight left: 20 at least, 60 at most."""
    return float(np.clip(daylight_left_min / max(points - 1, 1), 20.0, 60.0))


class AutomaticTechnician:
    """Calibrates through a ``Station`` with an eye on the sunspot device.

    Parameters
    ----------
    station : connected, its session open.
    look : what the sunspot device shows now.
    eye_sigma_deg : how well the technician believes to read the spot, one sigma per axis on sky.
    say : called with a sentence at every step worth telling.
    """

    def __init__(
        self,
        station: Station,
        look: Callable[[], Spot],
        schedule: Schedule,
        *,
        method: str = DEFAULT_METHOD,
        eye_sigma_deg: float = 0.02,
        say: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self.station = station
        self.schedule = schedule
        self.method = method
        self._look = look
        self._eye_sigma_deg = eye_sigma_deg
        self._say = say

    # -- the day -----------------------------------------------------------------------------

    def calibrate(self) -> UploadRecord:
        """The whole procedure: prepare, points, upload, check points.

        Raises
        ------
        LinkError
            The line was lost; the session says so and keeps everything up to then.
        ProcedureRefused
            Too few points could be taken to compute coefficients.
        """
        try:
            self.prepare()
            self.take_points()
            upload = self.upload()
            self.take_checks()
        except LinkError as error:
            self.station.link_lost(error)
            raise
        return upload

    def prepare(self) -> None:
        station = self.station
        clock = station.set_unit_clock()
        self._say(f"unit clock set: {clock.before_s:+.1f} s before, {clock.after_s:+.3f} s after")
        self._check_reference()
        self._wait_for_sun()
        for _ in range(48):
            try:
                station.initialise(confirmed=True)
                return
            except ProcedureRefused as refusal:
                self._say(str(refusal))
                station.clock.wait(600.0)
        raise ProcedureRefused(
            "the axes stayed too near a limit for eight hours; nothing was begun"
        )

    def take_points(self) -> None:
        """Points on schedule, over as many days as it takes (at most five)."""
        station = self.station
        interval_s = 60.0 * (self.schedule.every_min or self._spread())
        taken, slot_utc_s = 0, station.clock.utc_s()
        start_utc_s = slot_utc_s
        recheck_after = max(self.schedule.points // 2, 1)
        while taken < self.schedule.points:
            self._wait_until(slot_utc_s)
            if not self._sun_usable():
                self._say("the Sun is too low or beyond the limits; waiting for the next morning")
                self._wait_for_sun()
                slot_utc_s = station.clock.utc_s()
                if slot_utc_s - start_utc_s > 5 * 86400.0:
                    break
            if self.take_point() is not None:
                taken += 1
                if taken == recheck_after:
                    self._check_reference()
            slot_utc_s += interval_s
            while slot_utc_s < station.clock.utc_s():
                slot_utc_s += interval_s
        self._check_reference()

    def take_point(self, *, check: bool = False) -> PointRecord | CheckRecord | None:
        """One point, tried again when it looks wrong; ``None`` when the slot had to be given up."""
        for attempt in range(MAX_TRIES):
            if not self.centre():
                self._say("the slot is given up")
                self.station.track()
                return None
            self.station.set_sun_offset()
            liked = self.watch()
            record = self._ask_and_gather(liked, check=check)
            if record is None:
                continue
            doubt = self._doubt(record)
            if doubt and attempt < MAX_TRIES - 1:
                self.station.store(False, doubt)
                self._say(f"rejected: {doubt}")
                self._check_reference()
                continue
            stored = self.station.store(True)
            self._record_fit()
            return stored
        return None

    def upload(self) -> UploadRecord:
        solution = solve(self.station.session, self.method)
        accepted = len(self.station.session.accepted)
        if solution is None or accepted < FEWEST_POINTS:
            raise ProcedureRefused(
                f"only {accepted} points were accepted; three are needed at least to compute "
                "coefficients worth uploading"
            )
        record = self.station.upload(solution.coefficients(), method=self.method)
        self._say(
            "coefficients uploaded and read back " + ("equal" if record.verified else "DIFFERENT")
        )
        self.station.track()
        return record

    def take_checks(self) -> None:
        for index in range(self.schedule.checks):
            if index:
                self.station.clock.wait(60.0 * self.schedule.check_every_min)
            if not self._sun_usable():
                self._say("the Sun is too low for a check point; waiting for the next morning")
                self._wait_for_sun()
            self.take_point(check=True)
            self.station.track()

    # -- the steps ---------------------------------------------------------------------------

    def centre(self) -> bool:
        """Jog until the spot is centred, each axis coming from behind the Sun.

        An axis that is past the Sun by less than the Sun makes up in a minute is left to be
        caught up with: the jog aims at where the Sun will be then. One that is further past
        goes behind first.
        """
        station = self.station
        tolerance_deg = 3.0 * self._eye_sigma_deg + 0.003
        adjusted = False
        status = station.poll()
        # Decided once: going behind the Sun must not turn the sense it is then approached in.
        senses = [
            self._forward(rate, approach)
            for rate, approach in zip(
                self._rates_deg_per_s(status.unit_utc_s), status.approach, strict=True
            )
        ]
        for _ in range(MAX_CENTRING_MOVES):
            spot = self._look_through_clouds()
            if spot is None:
                self._say("no spot to be seen")
                return False
            status = station.poll()
            rates = self._rates_deg_per_s(status.unit_utc_s)
            if adjusted and self._on_sky(spot, status) <= tolerance_deg:
                return True
            readings = (status.reading1_deg, status.reading2_deg)
            errors = (spot.error1_deg, spot.error2_deg)
            past_s = [
                -error * sense / max(abs(rate), 1e-9) if error * sense < 0.0 else 0.0
                for error, sense, rate in zip(errors, senses, rates, strict=True)
            ]
            catching_up = [late_s for late_s in past_s if late_s <= CATCH_UP_S]
            aim_s = FINE_MOVE_S * (1.0 + np.ceil(max(catching_up, default=0.0) / FINE_MOVE_S))
            adjusted = len(catching_up) == 2
            moves = self._sun_moves_deg(status.unit_utc_s, 0.0, aim_s)
            targets = [
                reading + error + move - (0.0 if late_s <= CATCH_UP_S else sense * BEHIND_DEG)
                for reading, error, move, late_s, sense in zip(
                    readings, errors, moves, past_s, senses, strict=True
                )
            ]
            self._move(targets[0], targets[1], aim_s)
        self._say("the spot could not be centred")
        return False

    @staticmethod
    def _forward(rate_deg_per_s: float, approach: int) -> float:
        """The sense the axis has to come from: the Sun's, or the last one where it stands still."""
        if abs(rate_deg_per_s) < SUN_STANDS_DEG_PER_S:
            return -1.0 if approach < 0 else 1.0
        return -1.0 if rate_deg_per_s < 0.0 else 1.0

    def watch(self) -> bool:
        """Let it track for a minute and through one update; is the spot centred then?"""
        station = self.station
        station.track()
        station.clock.wait(WATCH_S)
        before = station.poll().update_phase
        for _ in range(int(MAX_WATCH_S / WATCH_STEP_S)):
            station.clock.wait(WATCH_STEP_S)
            phase = station.poll().update_phase
            if phase < before:
                break
            before = phase
        spot = self._look()
        status = station.poll()
        allowed = (
            0.75 * station.session.header.unit.update_range_deg + 4.0 * self._eye_sigma_deg + 0.02
        )
        return spot.visible and self._on_sky(spot, status) <= allowed

    def _ask_and_gather(self, liked: bool, *, check: bool) -> PointRecord | CheckRecord | None:
        station = self.station
        try:
            station.begin_point(check=check)
        except ProcedureRefused as refusal:
            self._say(str(refusal))
            return None
        session = station.session
        checked = bool(session.ref_checks) and session.ref_checks[-1].complete
        for yes in (checked, session.fresh_sun_offset is not None, liked):
            if not yes:
                question = station.answer(False)
                self._say(f"attempt aborted at question {question.asked}")
                return None
            station.answer(True)
        try:
            return station.gather_point()
        except ProcedureRefused as refusal:
            self._say(str(refusal))
            return None

    def _doubt(self, record: PointRecord | CheckRecord) -> str:
        """Why the counts do not make sense, or nothing."""
        session = self.station.session
        if (
            isinstance(record, CheckRecord)
            or record.ideal_deg is None
            or record.reading_deg is None
            or record.expected_counts is None
            or record.found_counts is None
            or len(session.accepted) < TRUSTED_FIT_POINTS
        ):
            return ""
        solution = solve(session, self.method)
        if solution is None:
            return ""
        unit = session.header.unit
        unsure = solution.predict_sigma_deg(*record.ideal_deg)
        weights = (np.sin(np.radians(record.ideal_deg[1])), 1.0)
        for axis in (0, 1):
            drive = (unit.drive1, unit.drive2)[axis]
            reference = (unit.reference1_deg, unit.reference2_deg)[axis]
            now, found = record.reading_deg[axis], record.found_counts[axis]
            expected = record.expected_counts[axis]
            at = register(drive, reference, now)
            off = now - float(reading_deg(drive, reference, at + round(expected) - found))
            allowed = max(SUSPICIOUS_DEG, 5.0 * float(unsure[axis]) * weights[axis])
            if abs(off) * weights[axis] > allowed:
                return (
                    f"axis {axis + 1} moved {found} counts since the last point where "
                    f"{expected:.0f} were expected ({off:+.2f} deg)"
                )
        return ""

    def _record_fit(self) -> None:
        solution = solve(self.station.session, self.method)
        if solution is not None:
            self.station.record_fit(solution)

    # -- eyes and hands ----------------------------------------------------------------------

    def _check_reference(self) -> None:
        record = self.station.ref_check()
        d1, d2 = record.difference_counts
        self._say(f"reference check {record.number}: counts found {d1:+d}, {d2:+d}")
        self.station.track()

    def _look_through_clouds(self) -> Spot | None:
        for _ in range(6):
            spot = self._look()
            if spot.visible:
                return spot
            self.station.clock.wait(CLOUD_WAIT_S)
        return None

    def _move(self, target1_deg: float, target2_deg: float, aim_s: float) -> None:
        """Jog there and stay until ``aim_s`` has passed, renewing the target until at rest."""
        passed_s = 0.0
        for _ in range(600):
            self.station.jog(target1_deg, target2_deg)
            self.station.clock.wait(FINE_MOVE_S)
            passed_s += FINE_MOVE_S
            if passed_s >= aim_s and self.station.poll().moving == (0, 0):
                return

    @staticmethod
    def _on_sky(spot: Spot, status: Status) -> float:
        return float(
            np.hypot(spot.error1_deg * np.sin(np.radians(status.ideal2_deg)), spot.error2_deg)
        )

    def _rates_deg_per_s(self, unit_utc_s: float) -> tuple[float, float]:
        """How fast the Sun moves in the axes, degrees per second, central difference."""
        half_s = 15.0
        move1, move2 = self._sun_moves_deg(unit_utc_s, -half_s, half_s)
        return move1 / (2.0 * half_s), move2 / (2.0 * half_s)

    def _sun_moves_deg(self, unit_utc_s: float, from_s: float, to_s: float) -> tuple[float, float]:
        """How far the Sun moves in the axes between two instants relative to ``unit_utc_s``."""
        geometry, header = self.station.geometry, self.station.session.header
        heliostat = header.unit.heliostat
        start = ideal_axes_deg(geometry, header.site, unit_utc_s + from_s, heliostat)
        end = ideal_axes_deg(geometry, header.site, unit_utc_s + to_s, heliostat)
        return float(wrap_deg(end[0] - start[0])), end[1] - start[1]

    # -- waiting -----------------------------------------------------------------------------

    def _wait_until(self, utc_s: float) -> None:
        self.station.clock.wait(max(0.0, round(utc_s - self.station.clock.utc_s(), 3)))

    def _sun_usable(self) -> bool:
        """High enough, and the place it would send the axes to is within the limits."""
        station = self.station
        if station.sun_elevation_deg() < MIN_POINT_ELEVATION_DEG:
            return False
        header = station.session.header
        limits = header.unit.limits
        ax1, ax2 = ideal_axes_deg(
            station.geometry, header.site, station.clock.utc_s(), header.unit.heliostat
        )
        return float(limits.distance_deg(ax1, ax2)) > 1.0

    def _wait_for_sun(self) -> None:
        """Wait, in quarter hours, until the Sun is usable; polar nights have an end too."""
        for _ in range(4 * 24 * 2):
            if self._sun_usable():
                return
            self.station.clock.wait(900.0)
        raise ProcedureRefused(
            "the Sun did not come within reach for two days; check site, date and limits "
            f"({format_utc(self.station.clock.utc_s(), 0)})"
        )

    def _spread(self) -> float:
        now = self.station.clock.utc_s()
        interval = daylight(self.station.session.header.site, now, MIN_POINT_ELEVATION_DEG)
        left_min = (interval[1] - now) / 60.0 if interval is not None else 0.0
        return spread_every_min(self.schedule.points, left_min - 10.0)
