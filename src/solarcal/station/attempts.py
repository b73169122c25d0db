"""Data points and check points, one attempt at a time: questions, gathering, store or not."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import msgspec

from solarcal.errors import LinkError, ProcedureRefused
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.model.solution import Solution
from solarcal.mount.formula import Offsets
from solarcal.session.records import CheckRecord, FitRecord, Override, PointRecord
from solarcal.station import guards
from solarcal.station.core import StationCore
from solarcal.station.fitting import solve
from solarcal.station.gathering import check_candidate, demand_plausible, gather, point_candidate
from solarcal.station.state import PENDING, Activity, Attempt, Pending

Progress = Callable[[float], None]

NOT_INITIALISED = "initialise the data file first, once per calibration"
NO_ATTEMPT = Pending("no point is being taken", "begin one first", "take_point")

_NOT_DUE = {
    Activity.QUESTIONS: "there is no question to answer",
    Activity.READY: "there is no point to gather",
    Activity.RESULT: "there is no point to store or reject",
}


class PointSteps(StationCore):
    """The steps from the first question to a stored point."""

    def begin_point(self, *, check: bool = False, override_reason: str | None = None) -> Attempt:
        """Start an attempt: the guards first, then the first question is open."""
        what = "a check point" if check else "a data point"
        self._demand_idle(what)
        session = self.session
        if session.header.target != "sun":
            raise ProcedureRefused(
                "this session holds points on the Moon; connect again without it for the Sun"
            )
        if session.initialised is None and not check:
            raise ProcedureRefused(NOT_INITIALISED, "initialise")
        if check and not session.uploads:
            raise ProcedureRefused("check points come after an upload; there has been none yet")
        if check and not self.compare_in_force():
            raise ProcedureRefused(
                "the unit does not hold what was uploaded: a check point would prove nothing; "
                "upload again"
            )
        status = self.poll()
        with self._overruled(override_reason):
            guards.demand_clear_of_limits(session.header, status, what)
            guards.demand_sun_high_enough(self.sun_elevation_deg(), what)
        attempt = Attempt(check=check)
        self._become(activity=Activity.QUESTIONS, attempt=attempt)
        return attempt

    def answer(self, yes: bool) -> Attempt:
        """Answer the open question. The first NO ends the attempt: kept as aborted, not used."""
        attempt = self._attempt(Activity.QUESTIONS)
        question = attempt.question
        attempt = attempt.answered(yes)
        if not yes:
            self.abort_attempt(f"answered NO to: {question}", attempt.answers)
            return attempt
        done = attempt.question is None
        self._become(attempt=attempt, activity=Activity.READY if done else Activity.QUESTIONS)
        return attempt

    def gather_point(self, progress: Progress | None = None) -> PointRecord | CheckRecord:
        """A few seconds of readings; the result is shown and waits for ``store``."""
        attempt = self._attempt(Activity.READY)
        self._become(activity=Activity.GATHERING)
        candidate: PointRecord | CheckRecord
        try:
            gathered = gather(self, progress)
            if attempt.check:
                candidate = check_candidate(self.session, gathered, attempt.answers)
            else:
                candidate = point_candidate(self.session, gathered, attempt.answers, self._in_force)
            demand_plausible(self.session, candidate)
        except LinkError as error:
            self.link_lost(error)
            raise
        except ProcedureRefused as refusal:
            self.abort_attempt(str(refusal))
            raise
        self._become(activity=Activity.RESULT, attempt=replace(attempt, candidate=candidate))
        return candidate

    def store(self, yes: bool, reason: str = "") -> PointRecord | CheckRecord:
        """Store the gathered point, or keep it as rejected."""
        attempt = self._attempt(Activity.RESULT)
        candidate = attempt.candidate
        if candidate is None:
            raise ProcedureRefused("nothing has been gathered")
        if isinstance(candidate, CheckRecord) and yes:
            # The check's Set Sun Offset must not stay in force: what was uploaded is P with O = 0.
            # Before the record: a line lost here leaves a check to be taken again, not one stored.
            self.tracker.write_coefficients(self._in_force, Offsets())
        status = "accepted" if yes else "rejected"
        stored: PointRecord | CheckRecord = self._record(
            partial(
                msgspec.structs.replace, candidate, status=status, reason=reason or candidate.reason
            )
        )
        self._become(activity=Activity.IDLE, attempt=None)
        return stored

    def store_reading(self, candidate: PointRecord) -> PointRecord:
        """Store a point taken on the Moon, which the unit's own steps cannot take.

        Raises
        ------
        ProcedureRefused
            The session is not initialised or one of points on the Sun, or no axis can have such an
            error.
        """
        self._demand_idle("a data point")
        session = self.session
        if session.initialised is None or session.header.target != "moon":
            raise ProcedureRefused("points on the Moon need a session of their own, initialised")
        demand_plausible(session, candidate)
        return self._record(partial(msgspec.structs.replace, candidate))

    def _attempt(self, expected: Activity) -> Attempt:
        attempt = self._state.attempt
        if attempt is None or self._state.activity is not expected:
            pending = PENDING.get(self._state.activity, NO_ATTEMPT)
            raise ProcedureRefused(
                f"{_NOT_DUE[expected]}: {pending.sentence}; {pending.first}", pending.action
            )
        return attempt

    def record_newest_fit(self, method: str = DEFAULT_METHOD) -> None:
        """Keep what the fit says now, where there are points enough for one."""
        solution = solve(self.session, method)
        if solution is not None:
            self.record_fit(solution)

    def record_fit(self, solution: Solution) -> FitRecord:
        """Keep what the fit said after a point, for the history of the coefficients."""
        return self._record(
            partial(
                FitRecord,
                method=solution.method,
                points=solution.n_points,
                coefficients=solution.coefficients(),
                sigmas=solution.sigma_coefficients(),
                sky_rms_deg=solution.sky_rms_deg,
                message=solution.message,
            )
        )

    @contextmanager
    def _overruled(self, reason: str | None) -> Iterator[None]:
        """A guard that refuses within is overruled where a reason is given; it is recorded."""
        try:
            yield
        except guards.GuardRefused as refusal:
            if reason is None:
                raise
            if not reason.strip():
                raise ProcedureRefused(
                    "an override needs a reason; it is written to the session file"
                ) from None
            self._record(partial(Override, guard=str(refusal), reason=reason))
