"""How far the points bear out the fit: each left out in turn, their order, and the last ones."""

from dataclasses import dataclass

import numpy as np

from solarcal.model.exact_errors import errors_and_slopes, own_sine
from solarcal.model.mechanism_solution import OUTLIER_PROBABILITY, MechanismSolution
from solarcal.model.year_grid import year_grid
from solarcal.units import FloatArray

LAST_POINTS = 2
_DRAWS = 400
_SEED = 7
_FEWEST_FOR_ORDER = 6


@dataclass(frozen=True, eq=False, slots=True)
class CrossChecks:
    """Numbers a verdict rests on; blunders are left aside in all of them.

    Attributes
    ----------
    left_out_deg : (n,)
        Sky error of each point predicted from all the others.
    left_out_rms_deg : float or None
        Over both axes (on sky, hypot); None with a single point.
    order_probability : float or None
        How often residuals of pure chance would follow each other as these do, or more; None with
        fewer than six points.
    last_moved_deg : float or None
        By how much the last two points moved the prediction for the year, rms on sky; None when
        there is nothing before them.
    """

    left_out_deg: FloatArray
    left_out_rms_deg: float | None
    order_probability: float | None
    last_moved_deg: float | None


def cross_check(solution: MechanismSolution) -> CrossChecks:
    """All of it linearised about the fit, which costs a millisecond instead of n fits."""
    good = solution.blunder_probability <= OUTLIER_PROBABILITY
    unit = solution.prior.sigma_array()
    precision = 1.0 if solution.method == "robust" else 1e-6
    rows = solution.slopes * unit
    weights = solution.point_weights
    pulls = np.einsum("n,nai,naj->nij", weights, rows, rows)
    normal = pulls.sum(axis=0) + precision * np.eye(6)
    covariance = np.linalg.inv(normal)
    sky = _sky_residuals(solution)

    # Residual of a left-out point: (1 - h)^-1 r, h its own share in its prediction.
    share = np.einsum("n,nai,ij,nbj->nab", weights, rows, covariance, rows)
    predicted = np.linalg.solve(np.eye(2) - share + 1e-12 * np.eye(2), sky[..., np.newaxis])
    left_out = np.hypot(predicted[:, 0, 0], predicted[:, 1, 0])
    order = _in_time(solution)
    used = order[good[order]]
    return CrossChecks(
        left_out_deg=left_out,
        left_out_rms_deg=_rms(left_out[good]) if good.sum() > 1 else None,
        order_probability=_order_probability(rows, weights, covariance, sky, used),
        last_moved_deg=_last_moved(solution, rows, weights, normal, sky, used, unit),
    )


def _sky_residuals(solution: MechanismSolution) -> FloatArray:
    """(n, 2), measured minus fitted."""
    ax2 = solution.points.ax2_deg
    sine = own_sine(solution.posterior.mean, ax2, np.zeros_like(ax2))
    return np.column_stack((solution.residual1_deg * sine, solution.residual2_deg))


def _in_time(solution: MechanismSolution) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    times = solution.points.utc_s
    n = len(solution.points)
    if times is None or not np.isfinite(times).all():
        return np.arange(n)
    return np.argsort(times, kind="stable")


def _order_probability(
    rows: FloatArray,
    weights: FloatArray,
    covariance: FloatArray,
    sky: FloatArray,
    used: np.ndarray[tuple[int], np.dtype[np.intp]],
) -> float | None:
    """Of the lag-one correlation of the residuals, against noise sent through the same fit.

    Residuals of few points are correlated by the fit itself, so tables for free series mislead.
    """
    n = len(used)
    if n < _FEWEST_FOR_ORDER:
        return None
    root = np.repeat(np.sqrt(weights[used]), 2)
    design = rows[used].reshape(2 * n, 6) * root[:, np.newaxis]
    keep = np.eye(2 * n) - design @ covariance @ design.T
    draws = keep @ np.random.default_rng(_SEED).standard_normal((2 * n, _DRAWS))
    seen = _lag_one((sky[used].reshape(-1) * root)[:, np.newaxis])[0]
    return float((1 + np.count_nonzero(_lag_one(draws) >= seen)) / (_DRAWS + 1))


def _lag_one(residuals: FloatArray) -> FloatArray:
    """Lag-one correlation of each column, both axes together; rows alternate between axes."""
    products = np.sum(residuals[2:] * residuals[:-2], axis=0)
    squares = np.sum(residuals**2, axis=0)
    correlation: FloatArray = products / np.maximum(squares, 1e-300)
    return correlation


def _last_moved(
    solution: MechanismSolution,
    rows: FloatArray,
    weights: FloatArray,
    normal: FloatArray,
    sky: FloatArray,
    used: np.ndarray[tuple[int], np.dtype[np.intp]],
    unit: FloatArray,
) -> float | None:
    if len(used) <= LAST_POINTS:
        return None
    last = used[-LAST_POINTS:]
    without = normal - np.einsum("n,nai,naj->ij", weights[last], rows[last], rows[last])
    pull = np.einsum("n,nai,na->i", weights[last], rows[last], sky[last])
    # At the solution all pulls cancel, so leaving these out moves it by minus their own.
    moved = np.linalg.solve(without + 1e-9 * np.eye(6), -pull) * unit
    grid = year_grid(solution.context)
    values = solution.posterior.mean
    errors, slopes = errors_and_slopes(
        values, grid.geometry, grid.sun.true1_deg, grid.sun.true2_deg
    )
    change = np.einsum("k,kag->ag", moved, slopes)
    change[0] *= own_sine(values, grid.sun.true2_deg, errors[1])
    return _rms(np.hypot(change[0], change[1]))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
