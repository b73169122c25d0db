"""The climb of ``noise_mixture``: expectation-maximisation of many starts in many sessions at once.

A start says of each point how likely it is a blunder, and of which scale the noise is. Each turn
solves weighted least squares for the six parameters and weighs the points anew by what they leave.

References
----------
Dempster, Laird and Rubin (1977), J. R. Stat. Soc. B 39, 1: expectation-maximisation.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solarcal.model.least_squares import ROUNDING
from solarcal.units import FloatArray

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

BLUNDER_CHANCE = 0.02
BLUNDER_DEG = 0.7
SETTLED = 1e-3
ENOUGH_FOR_SCALE = 1000
"""Points of which as many, evenly chosen, say how noisy all are; blunders among so many cannot hide
one another."""

PARAMETERS = 6
_COLUMN_STARTS = (0, 7, 13, 18, 22, 25)
"""Columns of the lower half of a normal matrix, each with its element of the pull below it."""
_ROWS = np.array([row for column in range(PARAMETERS) for row in range(column, PARAMETERS + 1)])
_COLUMNS = np.array([column for column in range(PARAMETERS) for _ in range(column, PARAMETERS + 1)])


@dataclass(frozen=True, eq=False, slots=True)
class Linearised:
    """s sessions of n points, each about its own place in the space of the six parameters.

    ``residuals`` (s, 2, n) sky degrees; ``slopes`` (s, 2, n, 6) and ``offset`` (s, 6), prior mean
    less the place, in units of the prior; ``widths``: (factor, chance) of its sigmas; ``sigma_deg``
    (s, n): noise of each point at scale one; ``log_scale_mean``, ``log_scale_sd`` (s,): the prior
    of ln s; ``precision``: of the prior, below one where it shall hardly count.
    """

    residuals: FloatArray
    slopes: FloatArray
    offset: FloatArray
    widths: tuple[tuple[float, float], ...]
    sigma_deg: FloatArray
    log_scale_mean: FloatArray
    log_scale_sd: FloatArray
    precision: float = 1.0

    def __len__(self) -> int:
        return len(self.residuals)

    def take(self, chosen: Indices | Mask) -> "Linearised":
        """These sessions."""
        columns = ("residuals", "slopes", "offset", "sigma_deg", "log_scale_mean", "log_scale_sd")
        return replace(self, **{name: getattr(self, name)[chosen] for name in columns})

    def every(self, step: int) -> "Linearised":
        """Every so manieth of the points."""
        return replace(
            self,
            residuals=self.residuals[:, :, ::step],
            slopes=self.slopes[:, :, ::step],
            sigma_deg=self.sigma_deg[:, ::step],
        )


@dataclass(frozen=True, eq=False, slots=True)
class Climbed:
    """Where each start came to: steps (6, s, r), points (n, s, r), scores (s, r)."""

    steps: FloatArray
    point_weights: FloatArray
    blunder: FloatArray
    scores: FloatArray


def climb(
    at: Linearised, log_scales: FloatArray, widths: FloatArray, blunder: FloatArray, iterations: int
) -> Climbed:
    """Expectation-maximisation of r starts (n, s, r) in each session.

    ``log_scales`` (s, r), ``widths`` (r,).
    """
    n, s, r = blunder.shape
    found = Climbed(
        np.empty((PARAMETERS, s, r)), np.empty((n, s, r)), np.empty((n, s, r)), np.empty((s, r))
    )
    precision = at.precision / widths**2
    log_odds = np.log1p(-BLUNDER_CHANCE) - np.log(BLUNDER_CHANCE)
    moments, model = _moments(at), _model(at)
    offset = at.offset.T[:, :, np.newaxis]
    good = np.exp(2.0 * log_scales) * (at.sigma_deg.T**2)[:, :, np.newaxis]
    bad = good + BLUNDER_DEG**2
    inverse = 1.0 / good
    doubt = inverse - 1.0 / bad
    odds = log_odds - np.log(good) + np.log(bad)
    active = np.arange(s)
    for turn in range(iterations):
        weights = blunder * doubt
        np.subtract(inverse, weights, out=weights)
        steps, determinant = _maximised(moments, weights, precision, offset)
        left = np.empty((2 * n, *steps.shape[1:]))
        np.matmul(model, steps.transpose(1, 0, 2), out=left.transpose(1, 0, 2))
        left *= left
        distance = left[:n]
        distance += left[n:]
        distance *= 0.5
        before, blunder = blunder, distance * doubt
        np.subtract(odds, blunder, out=blunder)
        # A point that cannot be a blunder: exp is infinite and the probability zero, as it should.
        with np.errstate(over="ignore"):
            np.exp(blunder, out=blunder)
        blunder += 1.0
        np.reciprocal(blunder, out=blunder)
        last = turn == iterations - 1
        if turn < 2 and not last:
            continue
        change = np.subtract(blunder, before, out=left[n:])
        np.abs(change, out=change)
        settled = change.max(axis=0).max(axis=1) < SETTLED
        if last:
            settled[:] = True
        if not settled.any():
            continue
        here = active[settled]
        found.steps[:, here] = steps[:PARAMETERS, settled]
        found.point_weights[:, here] = weights[:, settled]
        found.blunder[:, here] = blunder[:, settled]
        like_good = np.log1p(-BLUNDER_CHANCE) + np.log(inverse[:, settled])
        like_good -= distance[:, settled] * inverse[:, settled]
        like_bad = like_good - odds[:, settled] + distance[:, settled] * doubt[:, settled]
        likelihood = np.logaddexp(like_good, like_bad)
        away = steps[:PARAMETERS, settled] - offset[:, settled]
        off_scale = log_scales[settled] - at.log_scale_mean[here, np.newaxis]
        found.scores[here] = (
            likelihood.sum(axis=0)
            - 0.5 * np.sum(away**2, axis=0) * precision
            - 0.5 * np.log(determinant[settled])
            - PARAMETERS * np.log(widths)
            - 0.5 * (off_scale / at.log_scale_sd[here, np.newaxis]) ** 2
        )
        if settled.all():
            break
        on = ~settled
        active, log_scales = active[on], log_scales[on]
        moments, model, offset = moments[on], model[on], offset[:, on]
        inverse, doubt, odds = inverse[:, on], doubt[:, on], odds[:, on]
        blunder = blunder[:, on]
    return found


def _moments(at: Linearised) -> FloatArray:
    """(s, 27, n): each point's share of the normal matrix, by columns, and of the pull."""
    s, _, n, _ = at.slopes.shape
    rows = np.concatenate((at.slopes, at.residuals[..., np.newaxis]), axis=3)
    if n <= ENOUGH_FOR_SCALE:
        gathered: FloatArray = np.einsum("sanp,sanp->spn", rows[..., _ROWS], rows[..., _COLUMNS])
        return gathered
    # Of very many points each row alone: memory grows as the points.
    moments = np.empty((s, len(_ROWS), n))
    for at_row, (row, column) in enumerate(zip(_ROWS, _COLUMNS, strict=True)):
        moments[:, at_row] = np.einsum("san,san->sn", rows[..., row], rows[..., column])
    return moments


def _model(at: Linearised) -> FloatArray:
    """(s, 2 n, 6 + 1): times (steps, 1) it is what the steps leave, with the sign turned."""
    s, _, n, k = at.slopes.shape
    flat = at.slopes.reshape(s, 2 * n, k)
    return np.concatenate((flat, -at.residuals.reshape(s, 2 * n, 1)), axis=2)


def _maximised(
    moments: FloatArray, weights: FloatArray, precision: FloatArray, offset: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Steps (6 + 1, s, r) that solve the normal equations, a one below them; determinants (s, r).

    L D L.T by hand: LAPACK takes a microsecond for each 6 by 6 matrix, this a fraction of it.
    """
    normal = np.empty((len(_ROWS), *weights.shape[1:]))
    np.matmul(moments, weights.transpose(1, 0, 2), out=normal.transpose(1, 0, 2))
    columns = [normal[start : start + PARAMETERS + 1 - j] for j, start in enumerate(_COLUMN_STARTS)]
    diagonal = normal[list(_COLUMN_STARTS)]
    diagonal += precision
    # As alone: free directions would otherwise be lost in rounding.
    diagonal += ROUNDING * diagonal.sum(axis=0)
    for j, column in enumerate(columns):
        column[0] = diagonal[j]
        column[-1] += offset[j] * precision
    # Below the pivots stays L D, which back substitution needs.
    work = np.empty((PARAMETERS, *weights.shape[1:]))
    for j, column in enumerate(columns[:-1]):
        factors = column[1:-1] / column[0]
        for m in range(j + 1, PARAMETERS):
            change = work[: PARAMETERS + 1 - m]
            np.multiply(factors[m - j - 1], column[m - j :], out=change)
            columns[m] -= change
    steps = np.empty((PARAMETERS + 1, *weights.shape[1:]))
    steps[PARAMETERS] = 1.0
    determinant = columns[0][0].copy()
    for column in columns[1:]:
        determinant *= column[0]
    for j in range(PARAMETERS - 1, -1, -1):
        column = columns[j]
        known = np.einsum("isr,isr->sr", column[1:-1], steps[j + 1 : PARAMETERS])
        np.subtract(column[-1], known, out=known)
        np.divide(known, column[0], out=steps[j])
    return steps, determinant
