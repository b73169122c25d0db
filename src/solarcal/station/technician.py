"""The automatic technician: performs the whole manual procedure by what can be seen.

It knows no truth. It looks at the sunspot, jogs until the spot is centred, comes from the proper
side, waits for an update, answers the three questions by what it observed, and stores a point only
if the counts make sense.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from solarcal.decimals import counted
from solarcal.errors import LinkError, ProcedureRefused, UnitRefused
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.session.records import CheckRecord, PointRecord, UploadRecord
from solarcal.station import centring
from solarcal.station.point_judgement import counts_doubt
from solarcal.station.procedure import Station
from solarcal.station.question_evidence import found_words
from solarcal.station.uploading import propose_upload, refuse_doubtful
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.unit.frames import Code
from solarcal.unit.tracker import Mode, Spot

T = TypeVar("T")

MAX_TRIES = 3
SETTLE_S = 60.0
"""After a reference check the axes drive back to the Sun before there is a spot to look at."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """How many points, and how far apart. ``every_min`` None spreads them over the daylight."""

    points: int = 12
    every_min: float | None = None
    checks: int = 2
    check_every_min: float = 30.0


class AutomaticTechnician:
    """Calibrates through a ``Station`` with an eye on the sunspot device.

    Parameters
    ----------
    station : connected, its session open.
    look : what the sunspot device shows now.
    eye_sigma_deg : the technician's own estimate of reading the spot, one sigma per axis on sky.
    force : why to upload although something speaks against it; recorded.
    say : called with a sentence at every step worth telling.
    reopen : connects a lost line again, or raises; without it a lost line ends the calibration.
    """

    def __init__(
        self,
        station: Station,
        look: Callable[[], Spot],
        schedule: Schedule,
        *,
        method: str = DEFAULT_METHOD,
        eye_sigma_deg: float = 0.02,
        force: str | None = None,
        say: Callable[[str], None] = lambda sentence: None,
        reopen: Callable[[LinkError], object] | None = None,
    ) -> None:
        self._reopen = reopen
        self.station = station
        self.schedule = schedule
        self.method = method
        self.refused = ""
        self._given_up = 0
        self._force = force
        self.sight = centring.SunCentring(station, look, eye_sigma_deg=eye_sigma_deg, say=say)
        self._say = say

    # -- the day -----------------------------------------------------------------------------

    def calibrate(self) -> UploadRecord | None:
        """The whole procedure: prepare, points, upload, check points.

        None where the upload is refused; ``refused`` says why.

        Raises
        ------
        LinkError
            The line was lost; the session says so and keeps everything up to then.
        ProcedureRefused
            Too few points could be taken to compute coefficients, an axis does not move, or no spot
            is to be seen.
        """
        self.prepare()
        self.take_points()
        upload = self._uploaded or self._persist(self.upload)
        if upload is not None:
            self.take_checks()
        return upload

    def prepare(self) -> None:
        """Clock and reference check; then the calibration is begun, unless it was before."""
        station = self.station
        if station.tracker.capabilities.has_clock:
            self._persist(self._set_clock)
        self._persist(self._check_reference)
        if not centring.sun_up(station):
            self._say("the Sun is down; waiting for the morning")
            self._persist(partial(centring.wait_for_sun, station))
            self._persist(self._track)
        self._persist(partial(centring.wait_for_sun, station))
        if station.session.initialised is None:
            self._persist(self._initialise)

    def _set_clock(self) -> None:
        clock = self.station.set_unit_clock()
        self._say(f"unit clock set: {clock.before_s:+z.3f} s before, {clock.after_s:+z.3f} s after")

    def _initialise(self) -> None:
        station = self.station
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
        """Points on schedule, over as many days as it takes (at most five).

        Those a session had before it was taken up again count.
        """
        station = self.station
        if self._uploaded is not None:
            return
        every_min = self.schedule.every_min or centring.spread_min(station, self.schedule.points)
        interval_s = 60.0 * every_min
        taken, slot_utc_s = len(station.session.accepted), station.clock.utc_s()
        start_utc_s = slot_utc_s
        recheck_after = self.schedule.points // 2
        while taken < self.schedule.points:
            self._persist(partial(centring.wait_until, station, slot_utc_s))
            if not centring.sun_usable(station):
                self._say("the Sun is too low or beyond the limits; waiting for the next morning")
                self._persist(partial(centring.wait_for_sun, station))
                slot_utc_s = station.clock.utc_s()
                if slot_utc_s - start_utc_s > 5 * SECONDS_PER_DAY:
                    break
            if self._persist(self.take_point) is not None:
                taken += 1
                if taken == recheck_after:
                    self._persist(self._check_reference)
            if self.sight.unseen >= centring.MOST_UNSEEN:
                raise ProcedureRefused(
                    f"only {counted(taken, 'point')} accepted; given up: at {self.sight.unseen} "
                    f"slots in a row {centring.NO_SPOT}"
                )
            slot_utc_s += interval_s
            while slot_utc_s < station.clock.utc_s():
                slot_utc_s += interval_s
        self._persist(self._check_reference)

    def take_point(self, *, check: bool = False) -> PointRecord | CheckRecord | None:
        """One point, tried again when it looks wrong; ``None`` when the slot had to be given up."""
        for attempt in range(MAX_TRIES):
            try:
                self._refer_after_restart()
                if not self.sight.centre():
                    self._given_up += 1
                    self._say("the slot is given up")
                    self._track()
                    return None
                self.station.set_sun_offset()
                liked = self.sight.watch()
                record = self._ask_and_gather(liked, check=check)
                if record is None:
                    continue
                doubt = counts_doubt(self.station.session, record, self.method)
                if doubt and attempt < MAX_TRIES - 1:
                    self.station.store(False, doubt)
                    self._say(f"rejected: {doubt}")
                    self._check_reference()
                    continue
            except UnitRefused as refusal:
                # The unit lost its power on the way: it will say so to every step until referenced.
                if refusal.code != Code.NOT_REFERENCED:
                    raise
                self._say(str(refusal))
                if self.station.state.attempt is not None:
                    self.station.abort_attempt(str(refusal))
                continue
            stored = self.station.store(True)
            self.station.record_newest_fit(self.method)
            return stored
        return None

    def upload(self) -> UploadRecord | None:
        """Upload what is better than what is in force and fits, or is forced; None: refused."""
        station = self.station
        held = station.tracker.stored()
        proposal = propose_upload(
            station.session, held.coefficients, self.method, offsets=held.offsets
        )
        if proposal is None:
            raise ProcedureRefused(
                f"only {counted(len(station.session.accepted), 'point')} accepted; at least three "
                f"are needed to compute coefficients worth uploading{self._without_spot()}"
            )
        try:
            forced = refuse_doubtful(proposal, self._force)
        except ProcedureRefused as refusal:
            self.refused = str(refusal)
            self._say(self.refused)
            return None
        record = station.upload(proposal.rounded, method=self.method, forced=forced)
        self._say(
            "coefficients uploaded and read back " + ("equal" if record.verified else "DIFFERENT")
        )
        self._track()
        return record

    def _without_spot(self) -> str:
        if not self._given_up:
            return ""
        return f"; at {counted(self._given_up, 'slot')} {centring.NO_SPOT}"

    def take_checks(self) -> None:
        station = self.station
        upload = self._uploaded
        taken = 0 if upload is None else len(station.session.checks_after(upload))
        for index in range(taken, self.schedule.checks):
            if index:
                wait_s = 60.0 * self.schedule.check_every_min
                self._persist(partial(centring.wait_until, station, station.clock.utc_s() + wait_s))
            if not centring.sun_usable(station):
                self._say("the Sun is too low for a check point; waiting for the next morning")
                self._persist(partial(centring.wait_for_sun, station))
            self._persist(partial(self.take_point, check=True))
            self._persist(self._track)

    @property
    def _uploaded(self) -> UploadRecord | None:
        """The upload of a session that is taken up behind it."""
        uploads = self.station.session.uploads
        if not uploads or uploads[-1].rollback or not uploads[-1].verified:
            return None
        return uploads[-1]

    # -- a line that is lost -----------------------------------------------------------------

    def _persist(self, step: Callable[[], T]) -> T:
        """Do a step; after a lost line, connect to the same unit again and do it anew.

        Raises
        ------
        LinkError
            The line stayed away for as long as ``reopen`` gives it.
        ProcedureRefused
            Another unit answers.
        """
        while True:
            try:
                return step()
            except LinkError as error:
                self.station.link_lost(error)
                if self._reopen is None:
                    raise
                self._say(str(error))
                self._reopen(error)
                self._say("the line is open again, the same unit answers; the step is repeated")
                self._settle()

    def _settle(self) -> None:
        """What a technician does first: let a reference check end, then track."""
        try:
            if (status := self.station.poll()).mode is Mode.REF:
                self._check_reference()
            elif status.referenced and centring.sun_up(self.station):
                self.station.track()
        except LinkError as error:
            # The step itself meets it again.
            self._say(str(error))

    # -- the steps ---------------------------------------------------------------------------

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

    def _check_reference(self) -> None:
        if self.station.poll().mode is Mode.REF:
            self._say("the unit is in a reference check already; its end is waited for")
        for _ in range(MAX_TRIES):
            record = self.station.ref_check()
            self._say(f"reference check {record.number}: {found_words(record)}")
            if record.complete and (not centring.sun_up(self.station) or self._tracks()):
                return
            self._say("the reference check does not count; once more")
        raise ProcedureRefused(
            f"{MAX_TRIES} reference checks were broken off; look at the unit's power and switches"
        )

    def _track(self) -> None:
        """Let the unit track; one that has restarted needs a reference check before."""
        if not self._tracks():
            self._refer_after_restart()

    def _tracks(self) -> bool:
        try:
            self.station.track()
        except UnitRefused as refusal:
            if refusal.code != Code.NOT_REFERENCED:
                raise
            return False
        return True

    def _refer_after_restart(self) -> None:
        """A unit that has restarted knows neither where its axes are nor its offsets."""
        if not self.station.poll().referenced:
            self._say("the unit has lost its reference (did it restart?): a reference check first")
            self._check_reference()
            self.station.clock.wait(SETTLE_S)
