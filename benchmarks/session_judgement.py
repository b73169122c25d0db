"""One session's robust fit, diagnosis, forecast and plan, warm: what the screen waits for.

Peer of the fit: scipy's ``least_squares`` with a soft loss on the same exact mechanism, which
gives six numbers and nothing of how well they are known. How the fit grows is measured on days
of more points than anybody takes.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from benchmarks.judgement_trackers import context_of, daylight_s, measured
from benchmarks.timing import table, timed
from solarcal.model.analysis import analyse, findings_of
from solarcal.model.evidence.direct import Evidence
from solarcal.model.forecast import forecast
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_PRIOR, fit_exact
from solarcal.model.planner import plan
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext, true_points
from solarcal.mount.mechanism import Mechanism
from solarcal.session.view import read_session
from solarcal.station.fitting import point_set, sky_context, solve_table

SESSION = Path(__file__).parents[1] / "sessions" / "azel-good-day.jsonl"
COUNTS = (12, 36, 120, 360, 1200)
LEFT_H = 7.0
LIMIT_MS = 30.0


def run() -> list[str]:
    return [*_one_session(), *_growth()]


def _one_session() -> list[str]:
    session = read_session(SESSION)
    points = session.table
    context = sky_context(points, session.header)

    def fitted() -> MechanismSolution:
        solution = solve_table(points, "robust", header=session.header)
        assert isinstance(solution, MechanismSolution)
        return solution

    evidence = Evidence(points, (session,))
    solution = fitted()
    # Planned as if most of the day were still ahead: the more half hours, the longer it takes.
    at_s = float(np.nanmax(points.utc_s)) - 3600.0 * LEFT_H

    taken = point_set(points)

    def everything() -> object:
        return analyse(taken, context, evidence, at_s)

    names = ("robust fit", "diagnosis", "forecast", f"plan, {LEFT_H:g} h left", "all and verdict")
    times = timed(
        fitted,
        lambda: findings_of(solution, context, evidence),
        lambda: forecast(solution, context),
        lambda: plan(solution.posterior, context, at_s),
        everything,
        runs=15,
    )
    return [
        f"{solution.n_points} points of {SESSION.name}, warm, ms: least (median); "
        f"asked of all: {LIMIT_MS:g}",
        *table(names, [tuple(timing.ms() for timing in times)]),
    ]


def _growth() -> list[str]:
    rows = []
    context = context_of("azel")
    first_s, last_s = daylight_s(context, 171)
    for n in COUNTS:
        times = np.linspace(first_s, last_s, n)
        tracker = Mechanism(P1=0.7, P2=-0.5, P3=0.3, P4=1.2, P5=0.001, P6=-0.0005)
        points = measured(context, tracker, times, np.random.default_rng(1))
        ours, theirs = timed(
            lambda points=points: fit_exact(points, context),  # type: ignore[misc]
            _scipy_fit(points, context),
            runs=7 if n < 360 else 3,
        )
        rows.append((f"{n}", ours.ms(), theirs.ms(), f"{theirs.least_s / ours.least_s:.1f}"))
    return [
        "robust fit of a day, ms: least (median)",
        *table(("points", "solarcal", "scipy least_squares", "ratio"), rows),
    ]


def _scipy_fit(points: Points, context: SkyContext) -> Callable[[], object]:
    seen = true_points(points, context)
    sine, unit = np.sin(np.radians(seen.ax2_deg)), DEFAULT_PRIOR.sigma_array()

    def left(scaled: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        e1, e2 = Mechanism.of(scaled * unit).errors_deg(points.geometry, seen.ax1_deg, seen.ax2_deg)
        data = np.concatenate(((seen.err1_deg - e1) * sine, seen.err2_deg - e2)) / 0.03
        return np.concatenate((data, scaled))

    return lambda: least_squares(left, np.zeros(6), loss="soft_l1")


if __name__ == "__main__":
    print("\n".join(run()))
