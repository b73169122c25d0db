"""Fit, forecast, plan and verdict of a running session, on a thread of its own: the newest wins.

What the technician wants of the day's plan, and when the day is planned anew.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from solarcal.errors import SolarcalError
from solarcal.model.analysis import Analysis
from solarcal.model.plan import Plan
from solarcal.model.schedule import GAP_S
from solarcal.session.view import SessionView
from solarcal.station.analysing import analyse_session
from solarcal.station.fitting import solve
from solarcal.station.news import FitReady
from solarcal.station.state import StationState
from solarcal.timescale import parse_utc

MISSED_S = 600.0
"""So long after the planned time of the next point the rest of the day is planned anew."""

PLAN_AGE_S = 3600.0
"""And at least every hour: a Sun that went down yesterday is up again."""

HALF_HOUR_S = 1800.0
MOST_POINTS = 40


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """All open at first.

    Attributes
    ----------
    until_utc_s : the technician must leave then.
    points : of the whole calibration, those taken already among them.
    struck : beginnings (POSIX UTC seconds) of the half hours in which no point can be taken.
    """

    until_utc_s: float | None = None
    points: int | None = None
    struck: frozenset[float] = frozenset()

    def strike(self, begin_utc_s: float) -> "PlanOptions":
        """That half hour excluded, or restored."""
        return replace(self, struck=self.struck ^ {begin_utc_s})

    def leave_at(self, utc_s: float) -> "PlanOptions":
        """Leave then; the same time again lifts it."""
        return replace(self, until_utc_s=None if self.until_utc_s == utc_s else utc_s)

    def points_more(self, by: int, taken: int, planned: int) -> "PlanOptions":
        """One point more or less than requested, or than what is taken and planned."""
        now = taken + planned if self.points is None else self.points
        return replace(self, points=min(max(now + by, taken), MOST_POINTS))

    def points_left(self, taken: int) -> int | None:
        return None if self.points is None else max(0, self.points - taken)

    def intervals(self) -> tuple[tuple[float, float], ...]:
        """(from, to) of the struck half hours, seconds; the first second belongs to the one before,
        as in the table, where a half hour's row is that of a stop at its end."""
        return tuple((begin + 1.0, begin + HALF_HOUR_S) for begin in sorted(self.struck))


DEFAULT_OPTIONS = PlanOptions()


def analyse_with_options(
    session: SessionView, plan_options: PlanOptions = DEFAULT_OPTIONS, at_utc_s: float | None = None
) -> Analysis | None:
    """The analysis of a session, planned from ``at_utc_s`` (else from the newest point).

    A time to leave that has passed means: now.
    """
    until_utc_s = plan_options.until_utc_s
    if until_utc_s is not None and at_utc_s is not None:
        until_utc_s = max(until_utc_s, at_utc_s)
    return analyse_session(
        session,
        at_utc_s=at_utc_s,
        until_utc_s=until_utc_s,
        points_left=plan_options.points_left(len(session.accepted)),
        struck=plan_options.intervals(),
    )


class Fitter:
    """One thread, one waiting place.

    ``post``: where ``FitReady`` goes; must be safe to call from another thread.
    """

    def __init__(self, post: Callable[[FitReady], object]) -> None:
        self._post = post
        self._wanted: Callable[[], FitReady] | None = None
        self._last: FitReady | None = None
        self._fitted: object = None
        self._planned_utc_s: float | None = None
        self._change = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="fit", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def fit(
        self,
        generation: int,
        session: SessionView,
        at_utc_s: float | None = None,
        plan_options: PlanOptions | None = None,
    ) -> None:
        """Fit, judge and plan from ``at_utc_s``; a session still waiting is forgotten."""
        with self._change:
            self._wanted = lambda: fit_message(
                generation, session, at_utc_s, plan_options, self._plan_of(session)
            )
            self._change.notify()

    def fit_if_needed(self, state: StationState, plan_options: PlanOptions | None = None) -> None:
        """Fit and plan where points, evidence or options changed, or time overtook the plan.

        A status comes every second, an analysis takes a fifth of one.
        """
        session = state.session
        if session is None:
            return
        wanted = (session.header, session.points, session.newest_evidence, plan_options)
        if wanted != self._fitted or self._overtaken(state.live.laptop_utc_s):
            self._fitted = wanted
            self._planned_utc_s = planning_utc_s(session, state.live.laptop_utc_s)
            self.fit(state.generation, session, self._planned_utc_s, plan_options)

    def _overtaken(self, now_utc_s: float | None) -> bool:
        last = self._last
        plan = last.judgement.plan if last is not None and last.judgement is not None else None
        if now_utc_s is None or plan is None or plan.at_utc_s != self._planned_utc_s:
            # Nothing to overtake, or a newer one is on its way.
            return False
        planned = plan.recommended.times_utc_s
        missed = bool(planned) and now_utc_s > planned[0] + MISSED_S
        return missed or now_utc_s > plan.at_utc_s + PLAN_AGE_S

    def close(self) -> None:
        with self._change:
            self._closing = True
            self._change.notify()

    def _run(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._closing or self._wanted is not None)
                if self._closing or self._wanted is None:
                    return
                wanted, self._wanted = self._wanted, None
            message = wanted()
            self._last = message
            self._post(message)

    def _plan_of(self, session: SessionView) -> Plan | None:
        """The plan last shown of this session."""
        last = self._last
        if last is None or last.judgement is None:
            return None
        return last.judgement.plan if last.session.header == session.header else None


def fit_message(
    generation: int,
    session: SessionView,
    at_utc_s: float | None = None,
    plan_options: PlanOptions | None = None,
    before: Plan | None = None,
) -> FitReady:
    """Fit and judgement of a session as the message that carries them.

    The plan is compared with the one shown before.

    A session that can be fitted but not judged keeps its fit; ``reason`` says why.
    """
    try:
        analysis = analyse_with_options(session, plan_options or DEFAULT_OPTIONS, at_utc_s)
    except (SolarcalError, ValueError, ArithmeticError) as error:
        # Arithmetic on strange points may fail in its own words; the thread must live on.
        try:
            solution = solve(session)
        except SolarcalError as refused:
            return FitReady(generation, session, None, reason=str(refused))
        return FitReady(generation, session, solution, reason=f"no forecast: {error}")
    if analysis is None:
        return FitReady(generation, session, None)
    if analysis.plan is not None:
        analysis = replace(analysis, plan=analysis.plan.compared_with(before))
    return FitReady(generation, session, analysis.solution, analysis)


def planning_utc_s(session: SessionView, laptop_utc_s: float | None) -> float | None:
    """The moment to plan from: the laptop's, but not so soon after the newest point that no one
    could take another."""
    if not session.accepted:
        return laptop_utc_s
    soonest_utc_s = parse_utc(session.accepted[-1].utc) + GAP_S
    return soonest_utc_s if laptop_utc_s is None else max(laptop_utc_s, soonest_utc_s)
