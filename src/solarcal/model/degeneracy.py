"""Which of the six numbers the points cannot tell apart, and which point would."""

from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from solarcal.model.finding import Finding
from solarcal.model.least_squares import inverse
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.parameter_checks import correlation_text
from solarcal.model.terms import labels
from solarcal.model.year_grid import SunGrid, sun_grid
from solarcal.sun.position import sun_known
from solarcal.timescale import SECONDS_PER_DAY, clock_utc, format_utc
from solarcal.units import FloatArray

TOLD_APART = 0.9
"""|r| above which two numbers cannot be separated."""

_MOST_SAID = 2
_DAYS_AHEAD = tuple(range(15, 346, 15))
_POINTS_OF_A_DAY = 5
_LOOSE = 1e-6
"""Of the prior's precision: enough to invert what the points leave open."""


def degeneracies(solution: MechanismSolution) -> tuple[Finding, ...]:
    """Findings on the pairs of numbers that stand or fall together, the worst first.

    The cure is looked for among the half hours of the last point's day, then among later days.
    Points without times or beyond the years of the Sun models, or fewer than three, name the
    degeneracy only.
    """
    unit = solution.prior.sigma_array()
    slopes = solution.slopes * unit
    normal = np.einsum("n,nai,naj->ij", solution.point_weights, slopes, slopes)
    r = _correlations(normal)
    pairs: list[tuple[int, int]] = []
    for pair in sorted(combinations(range(len(r)), 2), key=lambda pair: -abs(float(r[pair]))):
        alone = all(set(pair).isdisjoint(other) for other in pairs)
        if abs(float(r[pair])) > TOLD_APART and alone:
            pairs.append(pair)
    chances = _Chances(solution)
    return tuple(_said(chances, normal, r, pair) for pair in pairs[:_MOST_SAID])


def _correlations(normal: FloatArray) -> FloatArray:
    """Of normal matrices (..., k, k)."""
    covariance = inverse(normal + _LOOSE * np.eye(normal.shape[-1]))
    sigma = np.sqrt(np.einsum("...ii->...i", covariance))
    correlations: FloatArray = covariance / (sigma[..., :, np.newaxis] * sigma[..., np.newaxis, :])
    return correlations


def _said(chances: "_Chances", normal: FloatArray, r: FloatArray, pair: tuple[int, int]) -> Finding:
    solution = chances.solution
    names = labels((solution.model_terms[i] for i in pair), solution.geometry.name)
    value = float(r[pair])
    shown = correlation_text(value)
    sentence = f"{names[0]} and {names[1]} can hardly be separated with these points (r = {shown})"
    cure = _cure(chances, normal, pair)
    return Finding(
        kind="degeneracy",
        subject=f"{solution.terms[pair[0]]},{solution.terms[pair[1]]}",
        sentence=f"{sentence}; {cure}" if cure else sentence,
        certainty="not_determinable",
        number=value,
        unit="correlation",
    )


def _cure(chances: "_Chances", normal: FloatArray, pair: tuple[int, int]) -> str:
    times = chances.solution.points.utc_s
    if times is None or not sun_known(times, year_ahead=True).all() or len(times) < 3:
        return ""
    weight = float(np.median(chances.solution.point_weights))

    def cured(added: FloatArray) -> NDArray[np.bool_]:
        r = _correlations(normal + weight * added)[:, pair[0], pair[1]]
        return np.abs(r) <= TOLD_APART

    grid, information = chances.slots
    today = grid.day == 0
    good = grid.utc_s[today][cured(information[today])].tolist()
    if good:
        taken = times[times >= chances.midnight_s]
        before = [t for t in good if t < taken.min()]
        after = [t for t in good if t > taken.max()]
        if before and len(before) >= len(after):
            return f"a point before {clock_utc(max(before) + 1.0)} would"
        if after:
            return f"a point after {clock_utc(min(after) - 1.0)} would"
        return f"a point at {clock_utc(good[len(good) // 2])} would"
    starts_s, together = chances.later
    later = np.flatnonzero(cured(together))
    if later.size:
        return f"points around {format_utc(float(starts_s[later[0]]), 0)[:10]} would"
    return "no single day's points would; the effect on the predicted pointing is small"


class _Chances:
    """What points on the last point's day and on later days would tell; each computed once."""

    def __init__(self, solution: MechanismSolution) -> None:
        self.solution = solution

    @cached_property
    def midnight_s(self) -> float:
        """Mean solar midnight that begins the last point's day."""
        times = self.solution.points.utc_s
        assert times is not None
        first_s = self.solution.context.first_midnight_utc_s
        since_s = float(times.max()) - first_s
        return float(first_s + SECONDS_PER_DAY * np.floor(since_s / SECONDS_PER_DAY))

    @cached_property
    def slots(self) -> tuple[SunGrid, FloatArray]:
        """Half hours of that day and of later ones; what a point at each tells (s, 6, 6)."""
        days = np.array((0, *_DAYS_AHEAD))
        grid = sun_grid(self.solution.context, self.midnight_s + SECONDS_PER_DAY * days)
        at = grid.linearised(self.solution.posterior.mean)
        rows = np.transpose(at.sky_slopes, (2, 1, 0)) * self.solution.prior.sigma_array()
        return grid, np.einsum("nai,naj->nij", rows, rows)

    @cached_property
    def later(self) -> tuple[FloatArray, FloatArray]:
        """Midnights (d,) of later days, and what some points spread over each tell (d, 6, 6)."""
        grid, information = self.slots
        long_enough, together = [], []
        for index in range(1, len(grid.days_utc_s)):
            of_day = np.flatnonzero(grid.day == index)
            if len(of_day) >= _POINTS_OF_A_DAY:
                spread = np.linspace(0, len(of_day) - 1, _POINTS_OF_A_DAY).round().astype(int)
                long_enough.append(index)
                together.append(information[of_day[spread]].sum(axis=0))
        return grid.days_utc_s[long_enough], np.array(together).reshape(-1, 6, 6)
