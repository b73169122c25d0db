"""How far the points bear out the fit: each left out in turn, their order, and the last ones."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from solarcal.model.least_squares import inverse, solution_of
from solarcal.model.mechanism_solution import OUTLIER_PROBABILITY, MechanismSolution
from solarcal.mount.mechanism import Mechanism
from solarcal.units import FloatArray, rms

LAST_POINTS = 2
ORDER_LEVEL = 0.01
"""How often a whole day of clean points, looked at after every point, may seem out of order."""
FEWEST_TO_STOP = 4
FEWEST_FOR_ORDER = 7
NEGLIGIBLE_SHARE = 0.05
"""Residuals below this part of the tolerance are no misfit, whatever their order."""
TOO_LARGE_FACTOR = 30.0
"""Sigmas so many times as large as the scatter are another quantity, or in another unit."""
INSIDE = 1e-12
"""How far from the poles of a cumulant's slope its root is looked for, as a part of them."""
MOST_FOR_EIGENVALUES = 100
"""Of more points the spectrum is computed from its moments: time and memory grow as the points."""


def order_limit(n: int) -> float:
    """The probability below which the order of n residuals speaks against the fit.

    The limits of all numbers of points from seven on add up to ``ORDER_LEVEL``: so the whole day
    raises no more false alarms than that, however often it is looked at.
    """
    return ORDER_LEVEL * (FEWEST_FOR_ORDER - 1) / (n * (n - 1))


@dataclass(frozen=True, eq=False, slots=True)
class CrossChecks:
    """Numbers a verdict rests on; blunders are left aside in all of them.

    Attributes
    ----------
    left_out_deg : (n,), sky error of each point predicted from all the others.
    left_out_rms_deg : over both axes (on sky, hypot); None with a single point.
    order_probability : how often residuals of pure chance would follow each other as these do, or
        more; None with fewer than seven points.
    order_limit : below this it is no chance: ``order_limit`` of the number of points.
    residual_rms_deg : of the points that are not blunders, on sky.
    last_moved_deg : by how much the last two points moved the prediction for the year, rms on sky;
        None when there is nothing before them.
    """

    left_out_deg: FloatArray
    left_out_rms_deg: float | None
    order_probability: float | None
    order_limit: float
    residual_rms_deg: float
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
    covariance = inverse(normal)
    sky = _sky_residuals(solution)

    # Residual of a left-out point: (1 - h)^-1 r, h its own share in its prediction.
    share = np.einsum("n,nai,ij,nbj->nab", weights, rows, covariance, rows)
    predicted = np.linalg.solve(np.eye(2) - share + 1e-12 * np.eye(2), sky[..., np.newaxis])
    left_out = np.hypot(predicted[:, 0, 0], predicted[:, 1, 0])
    order = solution.points.in_time
    used = np.flatnonzero(good) if order is None else order[good[order]]
    return CrossChecks(
        left_out_deg=left_out,
        left_out_rms_deg=rms(left_out[good]) if good.sum() > 1 else None,
        order_probability=_order_probability(rows, weights, covariance, sky, used),
        order_limit=order_limit(max(len(used), FEWEST_FOR_ORDER)),
        residual_rms_deg=rms(np.hypot(*sky[good].T)) if good.any() else 0.0,
        last_moved_deg=_last_moved(solution, rows, weights, normal, sky, used, unit),
    )


def _sky_residuals(solution: MechanismSolution) -> FloatArray:
    """(n, 2), measured minus fitted."""
    ax2 = solution.points.ax2_deg
    sine = Mechanism.of(solution.posterior.mean).sin_ax2(ax2, np.zeros_like(ax2))
    return np.column_stack((solution.residual1_deg * sine, solution.residual2_deg))


def _order_probability(
    rows: FloatArray,
    weights: FloatArray,
    covariance: FloatArray,
    sky: FloatArray,
    used: np.ndarray[tuple[int], np.dtype[np.intp]],
) -> float | None:
    """Of the lag-one correlation of the residuals, for noise sent through the same fit.

    Residuals of few points are correlated by the fit itself, so tables for free series mislead.

    References
    ----------
    Lugannani and Rice (1980), Adv. Appl. Prob. 12, 475: the tail of a sum from its cumulants.
    Durbin and Watson (1950), Biometrika 37, 409: a serial correlation as a ratio of quadratic
    forms in the noise.
    """
    n = len(used)
    if n < FEWEST_FOR_ORDER:
        return None
    root = np.repeat(np.sqrt(weights[used]), 2)
    design = rows[used].reshape(2 * n, 6) * root[:, np.newaxis]
    left = sky[used].reshape(-1) * root
    square = float(left @ left)
    if square == 0.0:
        return None
    seen = float(left @ _beside(left)) / square
    spectrum = _spectrum if n <= MOST_FOR_EIGENVALUES else _spectrum_of_many
    return chance_above_zero(spectrum(design, covariance, seen))


def _beside(values: FloatArray) -> FloatArray:
    """Half the sum of the neighbours in time, each axis with itself: rows alternate. (2n, ...)"""
    sums = np.zeros_like(values)
    sums[2:] += values[:-2]
    sums[:-2] += values[2:]
    return 0.5 * sums


def _spectrum(design: FloatArray, covariance: FloatArray, seen: float) -> FloatArray:
    """Eigenvalues of the statistic's quadratic form in the noise, (2n,)."""
    one = np.eye(len(design))
    keep = one - design @ covariance @ design.T
    form = keep @ (_beside(one) - seen * one) @ keep
    return np.asarray(np.linalg.eigvalsh(form), dtype=np.float64)


def _spectrum_of_many(design: FloatArray, covariance: FloatArray, seen: float) -> FloatArray:
    """The same where points are many, without a matrix of points by points.

    The eigenvalues of the neighbour matrix alone are known; the fit of six parameters shifts and
    stretches them hardly: so that the trace of the form and of its square come out exactly.

    References
    ----------
    Durbin and Watson (1950), Biometrika 37, 409: the eigenvalues cos(pi k / (n + 1)).
    """
    n = len(design) // 2
    free = np.repeat(np.cos(np.pi * np.arange(1, n + 1) / (n + 1)), 2) - seen
    taken = 2.0 * covariance - covariance @ (design.T @ design) @ covariance
    moved = _beside(design) - seen * design
    once = taken @ (design.T @ moved)
    trace = float(free.sum() - np.trace(once))
    squares = float(free @ free - 2.0 * np.trace(taken @ (moved.T @ moved)) + np.sum(once * once.T))
    mean = trace / len(free)
    spread = math.sqrt(max(squares / len(free) - mean**2, 0.0) / float(np.var(free)))
    spectrum: FloatArray = mean + spread * (free - free.mean())
    return spectrum


def chance_above_zero(weights: FloatArray) -> float:
    """Probability that sum w_i z_i^2 of standard normals z is above zero (saddle point)."""
    largest = float(np.abs(weights).max())
    scaled = weights / largest if largest > 0.0 else weights
    low_w, high_w = float(scaled.min()), float(scaled.max())
    if high_w <= 1e-12 or low_w >= -1e-12:
        return 0.0 if high_w <= 1e-12 else 1.0

    def slope(s: float) -> float:
        return float(np.sum(scaled / (1.0 - 2.0 * s * scaled)))

    # Its slope runs from minus to plus infinity between the two poles.
    low, high = 0.5 / low_w, 0.5 / high_w
    s = float(brentq(slope, low * (1.0 - INSIDE), high * (1.0 - INSIDE), xtol=1e-15))
    spread = 1.0 - 2.0 * s * scaled
    curved = float(2.0 * np.sum((scaled / spread) ** 2))
    w = math.copysign(math.sqrt(max(float(np.sum(np.log(spread))), 0.0)), s)
    u = s * math.sqrt(curved)
    if abs(w) < 1e-3:
        third = float(8.0 * np.sum(scaled**3))
        spread0 = float(2.0 * np.sum(scaled**2))
        skew: float = third / (6.0 * math.sqrt(2.0 * math.pi) * spread0**1.5)
        return 0.5 - skew
    density = math.exp(-0.5 * w * w) / math.sqrt(2.0 * math.pi)
    tail = 0.5 * math.erfc(w / math.sqrt(2.0)) + density * (1.0 / u - 1.0 / w)
    return min(max(tail, 0.0), 1.0)


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
    moved = solution_of(without + 1e-9 * np.eye(6), -pull) * unit
    change = np.einsum("k,kag->ag", moved, solution.year.sky_slopes)
    return rms(np.hypot(change[0], change[1]))


def sigmas_too_large(solution: MechanismSolution, checks: CrossChecks) -> str:
    """A sentence where the points' sigmas are many times their scatter; else nothing."""
    sigma, scatter = solution.points.sigma_deg, checks.residual_rms_deg / 2.0**0.5
    if sigma is None or solution.n_points <= FEWEST_TO_STOP or scatter <= 0.0:
        return ""
    expected = float((sigma**2).mean() ** 0.5)
    if expected < TOO_LARGE_FACTOR * scatter:
        return ""
    return (
        f"the points' sigmas ({expected:.2g} deg) are {expected / scatter:.0f} times as large as "
        f"their scatter ({scatter:.2g} deg), so the prior counts for more than it should: correct "
        "sigma_deg"
    )


def out_of_order(checks: CrossChecks, tolerance_deg: float) -> bool:
    """Whether the residuals follow each other in time, and are large enough to matter."""
    return (
        checks.order_probability is not None
        and checks.order_probability < checks.order_limit
        and checks.residual_rms_deg > NEGLIGIBLE_SHARE * tolerance_deg
    )
