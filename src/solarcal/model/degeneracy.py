"""Which of the six numbers the points cannot tell apart, and which point would."""

from collections.abc import Callable
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from solarcal.model.exact_errors import errors_and_slopes, own_sine
from solarcal.model.finding import Finding
from solarcal.model.known_physics import SkyContext, sun_directions
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.year_grid import LOWEST_FORECAST_DEG
from solarcal.timescale import SECONDS_PER_DAY, format_utc
from solarcal.units import FloatArray

TOLD_APART = 0.9
"""|r| above which two numbers cannot be told apart."""

_MOST_SAID = 2
_SLOT_S = 1800.0
_DAYS_AHEAD = tuple(range(15, 346, 15))
_POINTS_OF_A_DAY = 5
_LOOSE = 1e-6
"""Of the prior's precision: enough to invert what the points leave open."""


def clock_utc(utc_s: float) -> str:
    return f"{format_utc(utc_s, 0)[11:16]} UTC"


def degeneracies(
    solution: MechanismSolution, clock: Callable[[float], str] = clock_utc
) -> tuple[Finding, ...]:
    """Findings on the pairs of numbers that stand or fall together, the worst first.

    The cure is looked for among the half hours of the last point's day, then among later days.
    Points without times, or fewer than three, name the degeneracy only.
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
    return tuple(_said(solution, normal, r, pair, clock) for pair in pairs[:_MOST_SAID])


def _correlations(normal: FloatArray) -> FloatArray:
    covariance = np.linalg.inv(normal + _LOOSE * np.eye(len(normal)))
    sigma = np.sqrt(np.diag(covariance))
    correlations: FloatArray = covariance / np.outer(sigma, sigma)
    return correlations


def _said(
    solution: MechanismSolution,
    normal: FloatArray,
    r: FloatArray,
    pair: tuple[int, int],
    clock: Callable[[float], str],
) -> Finding:
    names = [solution.model_terms[i].label(solution.geometry.name) for i in pair]
    value = float(r[pair])
    shown = f"{value:+.2f}" if abs(value) < 0.995 else f"{np.clip(value, -0.9999, 0.9999):+.4f}"
    sentence = f"{names[0]} and {names[1]} cannot be told apart from these points, r = {shown}"
    cure = _cure(solution, normal, pair, clock)
    return Finding(
        kind="degeneracy",
        subject=f"{solution.terms[pair[0]]},{solution.terms[pair[1]]}",
        sentence=f"{sentence}; {cure}" if cure else sentence,
        certainty="cannot_be_told",
        number=value,
        unit="correlation",
    )


def _cure(
    solution: MechanismSolution,
    normal: FloatArray,
    pair: tuple[int, int],
    clock: Callable[[float], str],
) -> str:
    times = solution.points.utc_s
    if times is None or not np.isfinite(times).all() or len(times) < 3:
        return ""
    weight = float(np.median(solution.point_weights))

    def cured(added: FloatArray) -> bool:
        return bool(abs(_correlations(normal + weight * added)[pair]) <= TOLD_APART)

    context = solution.context
    last_s = float(times.max())
    midnight_s = context.first_midnight_utc_s + SECONDS_PER_DAY * np.floor(
        (last_s - context.first_midnight_utc_s) / SECONDS_PER_DAY
    )
    slots, information = _informations(solution, context, midnight_s)
    good = [float(t) for t, one in zip(slots, information, strict=True) if cured(one)]
    if good:
        today = times[times >= midnight_s]
        before = [t for t in good if t < today.min()]
        after = [t for t in good if t > today.max()]
        if before and len(before) >= len(after):
            return f"a point before {clock(max(before) + 1.0)} would"
        if after:
            return f"a point after {clock(min(after) - 1.0)} would"
        return f"a point at {clock(good[len(good) // 2])} would"
    for days in _DAYS_AHEAD:
        start_s = midnight_s + days * SECONDS_PER_DAY
        slots, information = _informations(solution, context, start_s)
        if len(slots) < _POINTS_OF_A_DAY:
            continue
        spread = np.linspace(0, len(slots) - 1, _POINTS_OF_A_DAY).round().astype(int)
        if cured(information[spread].sum(axis=0)):
            return f"points around {format_utc(start_s, 0)[:10]} would"
    return "no single day's points would; the predicted pointing hardly suffers from it"


def _informations(
    solution: MechanismSolution, context: SkyContext, midnight_s: float
) -> tuple[FloatArray, FloatArray]:
    """Half hours (s,) of a day with the Sun high enough, and what a point there tells (s, 6, 6)."""
    slots = midnight_s + _SLOT_S * np.arange(SECONDS_PER_DAY / _SLOT_S)
    sun = sun_directions(context, slots)
    seen: NDArray[np.bool_] = sun.elevation_deg > LOWEST_FORECAST_DEG
    if context.limits is not None:
        seen &= context.limits.distance_deg(sun.ideal1_deg, sun.ideal2_deg) >= 0.0
    values = solution.posterior.mean
    true1, true2 = sun.true1_deg[seen], sun.true2_deg[seen]
    errors, slopes = errors_and_slopes(values, solution.geometry, true1, true2)
    slopes[:, 0] *= own_sine(values, true2, errors[1])
    rows = np.transpose(slopes, (2, 1, 0)) * solution.prior.sigma_array()
    return slots[seen], np.einsum("nai,naj->nij", rows, rows)
