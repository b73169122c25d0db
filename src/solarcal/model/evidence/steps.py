"""A step in the residuals: from one point on both axes read otherwise."""

import numpy as np

from solarcal.model.f_tests import ZEROS, ColumnFit, Rows
from solarcal.model.finding import Finding
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.residual_tests import NATURAL_ODDS
from solarcal.model.terms import occurs
from solarcal.units import FloatArray

SHORTEST_RUN = 3
"""Fewer points than this after a step are bad points."""
STEP_LEVEL = 0.001
NIGHT_S = 6.0 * 3600.0
MOVED_ODDS = 100.0
"""By so much a move is likelier in the hours between two visits than between two points of one."""
RIVAL = 10.0
"""A division whose p is within this factor is as good."""


def steps(solution: MechanismSolution, rows: Rows, tolerance_deg: float) -> tuple[Finding, ...]:
    """A change of both zeros between two runs of points in time: a reference or a clamp moved.

    Each division into two runs of three points or more is an F-test of two columns beside the six
    numbers, corrected for the number of divisions; a single smooth cause that explains more (in an
    amount that does not occur: much more) is preferred, and of divisions that explain nearly as
    much the one at a night.
    """
    points, n = solution.points, len(solution.points)
    order = points.in_time
    if order is None or n < 2 * SHORTEST_RUN + 1:
        return ()
    base = ColumnFit(rows.six, rows.residuals)
    place = np.empty(n, dtype=np.intp)
    place[order] = np.arange(n)
    tried: list[tuple[float, int, FloatArray]] = []
    for first in range(SHORTEST_RUN, n - SHORTEST_RUN + 1):
        later = np.repeat(place >= first, 2)[:, np.newaxis]
        p, amount = base.columns(rows.six[:, list(ZEROS)] * later)
        tried.append((p, first, amount))
    if not tried:
        return ()
    times_s = np.zeros(n) if points.utc_s is None else points.utc_s[order]
    nights = np.flatnonzero(np.diff(times_s) > NIGHT_S) + 1
    p, first, amount = min(tried, key=lambda one: one[0] / (MOVED_ODDS if one[1] in nights else 1))
    rivals = [at for other, at, _ in sorted(tried, key=lambda one: one[0]) if other < RIVAL * p]
    p *= len(tried)
    each = zip(rows.causes, *base.each(rows.columns(rows.causes)), strict=True)
    smooth = min(
        chance * (1.0 if occurs(name, value, sigma) else NATURAL_ODDS)
        for name, value, sigma, chance in each
    )
    sine = float(np.mean(np.sin(np.radians(points.ax2_deg))))
    size = float(np.hypot(amount[0] * sine, amount[1]))
    if p > STEP_LEVEL or p > smooth or size < 0.5 * tolerance_deg:
        return ()
    before, after = (points.labels[order[i]] for i in (first - 1, first))
    also = [f"{points.labels[order[at - 1]]} and {points.labels[order[at]]}" for at in rivals]
    also = [pair for pair in also if pair != f"{before} and {after}"]
    where = f"between points {before} and {after}"
    if also:
        where += f" ({also[0]} would explain nearly as much)"
    moved = (
        "the tower, a reference, a clamp or the pointing device moved between the visits: keep the "
        "later run"
        if first in nights
        else "a reference, a clamp or the pointing device moved: do a reference check, and keep "
        "one of the two runs"
    )
    runs = (order[:first], order[first:])
    shorter = tuple(points.labels[i] for i in min(runs, key=len))
    return (
        Finding(
            kind="step",
            subject=f"points {before} and {after}",
            sentence=f"a step {where}: from there on axis 1 reads {amount[0]:+z.3f} deg and axis 2 "
            f"{amount[1]:+z.3f} deg otherwise (p = {p:.1g}); {moved}",
            number=size,
            labels=shorter,
        ),
    )
