"""Fit, forecast, plan and verdict of the session, on a thread of its own: the newest wins."""

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from solarcal.errors import SolarcalError
from solarcal.station.news import FitReady

if TYPE_CHECKING:
    from solarcal.model.plan import Plan
    from solarcal.station.plan_options import PlanOptions
    from solarcal.station.state import SessionView


class Fitter:
    """One thread, one waiting place.

    Parameters
    ----------
    post : where ``FitReady`` goes; must be safe to call from another thread.
    """

    def __init__(self, post: Callable[[FitReady], object]) -> None:
        self._post = post
        self._wanted: Callable[[], FitReady] | None = None
        self._last: FitReady | None = None
        self._change = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="fit", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def fit(
        self,
        generation: int,
        session: "SessionView",
        at_utc_s: float | None = None,
        plan_options: "PlanOptions | None" = None,
    ) -> None:
        """Fit, judge and plan from ``at_utc_s``; a session still waiting is forgotten."""
        with self._change:
            self._wanted = lambda: fit_message(
                generation, session, at_utc_s, plan_options, self._plan_of(session)
            )
            self._change.notify()

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

    def _plan_of(self, session: "SessionView") -> "Plan | None":
        """The plan last shown of this session."""
        last = self._last
        if last is None or last.judgement is None:
            return None
        return last.judgement.plan if last.session.header == session.header else None


def fit_message(
    generation: int,
    session: "SessionView",
    at_utc_s: float | None = None,
    plan_options: "PlanOptions | None" = None,
    before: "Plan | None" = None,
) -> FitReady:
    """Fit and judgement of a session as the message that carries them.

    The plan is compared with the one shown before.

    A session that can be fitted but not judged keeps its fit; ``reason`` says why.
    """
    from solarcal.station.fitting import solve
    from solarcal.station.plan_options import DEFAULT_OPTIONS, analyse_with_options

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
