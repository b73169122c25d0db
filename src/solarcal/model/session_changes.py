"""Did zeros or the tower's lean change between sessions? F-tests, Holm-corrected."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solarcal.model.f_tests import ColumnFit, PointsTested, f_probability, t_limit
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.points import PointSet
from solarcal.model.residual_tests import FAMILY_LEVEL, POWER_QUANTILE
from solarcal.model.sky_context import SkyContext
from solarcal.units import FloatArray

SessionIndex = NDArray[np.intp]
"""(n,): the session each point belongs to."""

ZEROS, LEAN = (1, 3), (0, 2)

_SPARE_NEEDED = 3
_UNSEEN = 1e-9


def shift_columns(six: FloatArray, session: SessionIndex, which: Sequence[int]) -> FloatArray:
    """Columns (2n, (s - 1) q): these of the six numbers, free in every session but the last."""
    rows = np.repeat(session, 2)[:, np.newaxis]
    return np.hstack([six[:, list(which)] * (rows == k) for k in range(int(session.max()))])


def what_changed(
    points: PointSet, session: SessionIndex, context: SkyContext, values: FloatArray
) -> list[tuple[int, ...]]:
    """``ZEROS``, ``LEAN``, both or none, in the order found; about these six numbers (6,).

    A single bad point that explains more is left out first: it is no move.
    """
    rows = PointsTested.of(points, context).rows(values, {})
    n = len(points)
    kept = list(range(n))
    taken: list[tuple[int, ...]] = []
    most_bad = n // 4
    while True:
        at = np.array([2 * i + axis for i in kept for axis in (0, 1)])
        columns = [rows.six, *(shift_columns(rows.six, session, which) for which in taken)]
        base = np.hstack(columns)[at]
        fit = ColumnFit(base, rows.residuals[at])
        if fit.spare < _SPARE_NEEDED:
            return taken
        tests: list[tuple[float, tuple[int, ...] | int]] = []
        for which in (ZEROS, LEAN):
            if which not in taken:
                more = shift_columns(rows.six, session, which)[at]
                tests.append((_more_probable(fit, base, more, rows.residuals[at]), which))
        if n - len(kept) < most_bad:
            chances = [fit.group((place,))[2] for place in range(len(kept))]
            tests += [(len(kept) * p, i) for p, i in zip(chances, kept, strict=True)]
        p, best = min(tests, key=lambda test: test[0], default=(1.0, -1))
        if p > FAMILY_LEVEL / (3 - len(taken)):
            return taken
        if isinstance(best, tuple):
            taken.append(best)
        else:
            kept.remove(best)


def _more_probable(
    fit: ColumnFit, base: FloatArray, more: FloatArray, residuals: FloatArray
) -> float:
    """Chance that noise alone gains as much from more columns (2n, q)."""
    wider = ColumnFit(np.hstack((base, more)), residuals)
    over = fit.spare - wider.spare
    if over == 0 or wider.spare < 1:
        return 1.0
    gained = (fit.squares - wider.squares) / over
    return f_probability(gained / max(wider.squares / wider.spare, 1e-300), over, wider.spare)


def weakest_change_deg(
    points: PointSet, session: SessionIndex, solution: MechanismSolution
) -> float:
    """The change of lean or zero, in its worst direction, that would show nine times in ten."""
    rows = PointsTested.of(points, solution.context).rows(solution.posterior.mean, {})
    worst = 0.0
    for which in (ZEROS, LEAN):
        fit = ColumnFit(rows.six, rows.residuals)
        if fit.spare < _SPARE_NEEDED:
            return float("inf")
        more = shift_columns(rows.six, session, which)
        rest = more - fit.basis @ (fit.basis.T @ more)
        least = float(np.linalg.svd(rest, compute_uv=False)[-1])
        if least <= _UNSEEN:
            return float("inf")
        factor = t_limit(FAMILY_LEVEL / 2.0, fit.spare) + POWER_QUANTILE
        worst = max(worst, factor * solution.noise_deg / least)
    return worst
