"""``noise_mixture`` for many sessions of n points at once: the same equations, side by side.

A single fit spends its time on calling numpy for a few dozen numbers. Here every array has the
sessions in it: (n, s, r) for n points, s sessions and r starts, so that a call does thousands of
numbers and each start still climbs as it would alone. Sessions leave the batch when they settle,
at the very turn at which they would have stopped alone.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from solarcal.model import noise_mixture as alone
from solarcal.units import FloatArray

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

_K = 6
_COLUMN_STARTS = (0, 7, 13, 18, 22, 25)
"""Columns of the lower half of a normal matrix, each with its element of the pull below it."""
_ROWS = np.array([row for column in range(_K) for row in range(column, _K + 1)])
_COLUMNS = np.array([column for column in range(_K) for _ in range(column, _K + 1)])


@dataclass(frozen=True, eq=False, slots=True)
class ManyLinearised:
    """s sessions of n points, each about its own place; see ``noise_mixture.Linearised``.

    ``residuals`` (s, 2, n) sky degrees; ``slopes`` (s, 2, n, 6) and ``offset`` (s, 6) in units of
    the prior, whose precision is one; ``sigma_deg`` (s, n); ``log_scale_mean``, ``log_scale_sd``
    (s,).
    """

    residuals: FloatArray
    slopes: FloatArray
    offset: FloatArray
    widths: tuple[tuple[float, float], ...]
    sigma_deg: FloatArray
    log_scale_mean: FloatArray
    log_scale_sd: FloatArray

    def __len__(self) -> int:
        return len(self.residuals)

    def take(self, chosen: Indices | Mask) -> "ManyLinearised":
        return ManyLinearised(
            self.residuals[chosen],
            self.slopes[chosen],
            self.offset[chosen],
            self.widths,
            self.sigma_deg[chosen],
            self.log_scale_mean[chosen],
            self.log_scale_sd[chosen],
        )


@dataclass(frozen=True, eq=False, slots=True)
class ManyMixtures:
    """Posteriors at q pairs of noise scale and prior width: weights (s, q), steps (s, q, 6)."""

    weights: FloatArray
    log_scales: FloatArray
    widths: FloatArray
    steps: FloatArray
    point_weights: FloatArray
    blunder: FloatArray

    @property
    def mean_step(self) -> FloatArray:
        mean: FloatArray = np.einsum("sq,sqk->sk", self.weights, self.steps)
        return mean

    def columns(self) -> tuple[FloatArray, ...]:
        return (
            self.weights,
            self.log_scales,
            self.widths,
            self.steps,
            self.point_weights,
            self.blunder,
        )

    def take(self, chosen: Indices | Mask) -> "ManyMixtures":
        return ManyMixtures(*(column[chosen] for column in self.columns()))

    def replaced(self, chosen: Indices | Mask, by: "ManyMixtures") -> "ManyMixtures":
        """With these sessions' answers exchanged."""
        columns = tuple(column.copy() for column in self.columns())
        for column, new in zip(columns, by.columns(), strict=True):
            column[chosen] = new
        return ManyMixtures(*columns)


def solve_mixtures(at: ManyLinearised, before: ManyMixtures | None = None) -> ManyMixtures:
    """``noise_mixture.solve_mixture`` of every session."""
    n = at.residuals.shape[2]
    if before is None:
        start = _search_blunders(at) if n > 2 else np.zeros((len(at), n))
        nodes = alone.COARSE_NODES + at.log_scale_mean[:, np.newaxis]
        before = _at_scales(at, nodes, start)
        narrowest = alone.COARSE_STEP / 2.0
    else:
        narrowest = alone.LEAST_LOG_SD
    mean = np.einsum("sq,sq->s", before.weights, before.log_scales)
    away = before.log_scales - mean[:, np.newaxis]
    spread = np.sqrt(np.einsum("sq,sq->s", before.weights, away**2))
    sharpest = 1.0 / np.sqrt(4.0 * n + 2.0 / at.log_scale_sd**2)
    spread = np.maximum(np.maximum(spread, np.minimum(sharpest, narrowest)), alone.LEAST_LOG_SD)
    best = before.blunder[np.arange(len(at)), np.argmax(before.weights, axis=1)]
    nodes = mean[:, np.newaxis] + spread[:, np.newaxis] * alone.FINE_NODES
    return _at_scales(at, nodes, best)


def _search_blunders(at: ManyLinearised) -> FloatArray:
    """The most plausible start of each session, (s, n)."""
    s, n = len(at), at.residuals.shape[2]
    rows = _start_rows(at)
    r = rows.shape[2]
    best, best_score = np.zeros((s, n)), np.full(s, -np.inf)
    for shift in alone.SEARCH_SCALES:
        log_scales = np.broadcast_to((at.log_scale_mean + shift)[:, np.newaxis], (s, r))
        climbed = _climb(at, log_scales, np.ones(r), rows, alone.SEARCH_ITERATIONS)
        top = np.argmax(climbed.scores, axis=1)
        score = climbed.scores[np.arange(s), top]
        better = score > best_score
        best[better] = climbed.blunder[:, np.arange(s), top].T[better]
        best_score[better] = score[better]
    return best


def _start_rows(at: ManyLinearised) -> FloatArray:
    """No point, each suspect, each pair of them taken for a blunder: (n, s, r)."""
    s, n = len(at), at.residuals.shape[2]
    if n <= alone.MOST_SUSPECTS + 4:
        suspects = np.broadcast_to(np.arange(n), (s, n))
    else:
        suspects = _suspects(at)
    m = suspects.shape[1]
    chosen: list[tuple[int, ...]] = [(), *((i,) for i in range(m))]
    if n > 3:
        chosen += combinations(range(m), 2)
    rows = np.zeros((n, s, len(chosen)))
    for start, places in enumerate(chosen):
        for place in places:
            rows[suspects[:, place], np.arange(s), start] = 1.0
    return rows


def _suspects(at: ManyLinearised) -> Indices:
    """``noise_mixture._suspects`` of every session, (s, MOST_SUSPECTS) in rising order."""
    scale = np.exp(at.log_scale_mean + alone.COARSE_STEP)[:, np.newaxis]
    weights = 1.0 / (scale * at.sigma_deg) ** 2
    slopes = at.slopes.transpose(0, 2, 1, 3)
    weighted = slopes * weights[..., np.newaxis, np.newaxis]
    normal = np.einsum("snai,snaj->sij", weighted, slopes) + np.eye(_K)
    pull = np.einsum("snai,san->si", weighted, at.residuals) + at.offset
    normal += alone.ROUNDING * np.einsum("sii->s", normal)[:, np.newaxis, np.newaxis] * np.eye(_K)
    inverse = np.linalg.inv(normal)
    left = at.residuals.transpose(0, 2, 1) - np.einsum("snai,sij,sj->sna", slopes, inverse, pull)
    leverage = (weighted @ inverse[:, np.newaxis]) @ slopes.swapaxes(2, 3)
    others = np.eye(2) * (1.0 + alone.ROUNDING) - leverage
    predicted = np.linalg.solve(others, left[..., np.newaxis])[..., 0]
    distance = weights * np.einsum("sna,sna->sn", left, predicted)
    farthest = np.argsort(distance, axis=1)[:, ::-1][:, : alone.MOST_SUSPECTS]
    return np.sort(farthest, axis=1)


def _at_scales(at: ManyLinearised, scales: FloatArray, start: FloatArray) -> ManyMixtures:
    """``noise_mixture._at_scales`` at scales (s, m) from starts (s, n)."""
    doubted = start.max(axis=1) > 0.01
    if doubted.all() or not doubted.any():
        return _at_scales_alike(at, scales, start, bool(doubted.any()))
    n, q = start.shape[1], scales.shape[1] * len(at.widths)
    s = len(at)
    whole = ManyMixtures(
        weights=np.empty((s, q)),
        log_scales=np.empty((s, q)),
        widths=np.empty((s, q)),
        steps=np.empty((s, q, _K)),
        point_weights=np.empty((s, q, n)),
        blunder=np.empty((s, q, n)),
    )
    for group, doubt in ((doubted, True), (~doubted, False)):
        found = _at_scales_alike(at.take(group), scales[group], start[group], doubt)
        whole = whole.replaced(group, found)
    return whole


def _at_scales_alike(
    at: ManyLinearised, scales: FloatArray, start: FloatArray, doubted: bool
) -> ManyMixtures:
    (s, n), w = start.shape, len(at.widths)
    q = scales.shape[1] * w
    log_scales = np.tile(scales, w)
    widths = np.repeat([factor for factor, _ in at.widths], scales.shape[1])
    log_chances = np.repeat(np.log([chance for _, chance in at.widths]), scales.shape[1])
    starts = np.zeros((n, s, 2 * q if doubted else q))
    row_scales, row_widths = log_scales, widths
    if doubted:
        starts[:, :, :q] = start.T[:, :, np.newaxis]
        row_scales, row_widths = np.tile(log_scales, 2), np.tile(widths, 2)
    climbed = _climb(at, row_scales, row_widths, starts, alone.ITERATIONS)
    better = np.broadcast_to(np.arange(q), (s, q))
    if doubted:
        better = np.where(climbed.scores[:, :q] >= climbed.scores[:, q:], better, better + q)
    session = np.arange(s)[:, np.newaxis]
    evidence = climbed.scores[session, better] + log_chances
    weights = np.exp(evidence - evidence.max(axis=1, keepdims=True))
    return ManyMixtures(
        weights=weights / weights.sum(axis=1, keepdims=True),
        log_scales=log_scales,
        widths=np.broadcast_to(widths, (s, q)),
        steps=np.moveaxis(climbed.steps[:, session, better], 0, 2),
        point_weights=np.moveaxis(climbed.point_weights[:, session, better], 0, 2),
        blunder=np.moveaxis(climbed.blunder[:, session, better], 0, 2),
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Climbed:
    """Where each start came to: steps (6, s, r), points (n, s, r), scores (s, r)."""

    steps: FloatArray
    point_weights: FloatArray
    blunder: FloatArray
    scores: FloatArray


def _climb(
    at: ManyLinearised,
    log_scales: FloatArray,
    widths: FloatArray,
    blunder: FloatArray,
    iterations: int,
) -> _Climbed:
    """Expectation-maximisation of r starts (n, s, r) in each session.

    ``log_scales`` (s, r), ``widths`` (r,). The equations are those of ``noise_mixture._climb``.
    """
    n, s, r = blunder.shape
    found = _Climbed(
        np.empty((_K, s, r)), np.empty((n, s, r)), np.empty((n, s, r)), np.empty((s, r))
    )
    precision = 1.0 / widths**2
    log_odds = np.log1p(-alone.BLUNDER_CHANCE) - np.log(alone.BLUNDER_CHANCE)
    moments, model = _moments(at), _model(at)
    offset = at.offset.T[:, :, np.newaxis]
    good = np.exp(2.0 * log_scales) * (at.sigma_deg.T**2)[:, :, np.newaxis]
    bad = good + alone.BLUNDER_DEG**2
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
        settled = change.max(axis=0).max(axis=1) < alone.SETTLED
        if last:
            settled[:] = True
        if not settled.any():
            continue
        here = active[settled]
        found.steps[:, here] = steps[:_K, settled]
        found.point_weights[:, here] = weights[:, settled]
        found.blunder[:, here] = blunder[:, settled]
        like_good = np.log1p(-alone.BLUNDER_CHANCE) + np.log(inverse[:, settled])
        like_good -= distance[:, settled] * inverse[:, settled]
        like_bad = like_good - odds[:, settled] + distance[:, settled] * doubt[:, settled]
        likelihood = np.logaddexp(like_good, like_bad)
        away = steps[:_K, settled] - offset[:, settled]
        off_scale = log_scales[settled] - at.log_scale_mean[here, np.newaxis]
        found.scores[here] = (
            likelihood.sum(axis=0)
            - 0.5 * np.sum(away**2, axis=0) * precision
            - 0.5 * np.log(determinant[settled])
            - _K * np.log(widths)
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


def _moments(at: ManyLinearised) -> FloatArray:
    """(s, 27, n): each point's share of the normal matrix, by columns, and of the pull."""
    rows = np.concatenate((at.slopes, at.residuals[..., np.newaxis]), axis=3)
    moments: FloatArray = np.einsum("sanp,sanp->spn", rows[..., _ROWS], at.slopes[..., _COLUMNS])
    return moments


def _model(at: ManyLinearised) -> FloatArray:
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
    columns = [normal[start : start + _K + 1 - j] for j, start in enumerate(_COLUMN_STARTS)]
    diagonal = normal[list(_COLUMN_STARTS)]
    diagonal += precision
    # As alone: free directions would otherwise be lost in rounding.
    diagonal += alone.ROUNDING * diagonal.sum(axis=0)
    for j, column in enumerate(columns):
        column[0] = diagonal[j]
        column[-1] += offset[j] * precision
    # Below the pivots stays L D, which back substitution needs.
    work = np.empty((_K, *weights.shape[1:]))
    for j, column in enumerate(columns[:-1]):
        factors = column[1:-1] / column[0]
        for m in range(j + 1, _K):
            change = work[: _K + 1 - m]
            np.multiply(factors[m - j - 1], column[m - j :], out=change)
            columns[m] -= change
    steps = np.empty((_K + 1, *weights.shape[1:]))
    steps[_K] = 1.0
    determinant = columns[0][0].copy()
    for column in columns[1:]:
        determinant *= column[0]
    for j in range(_K - 1, -1, -1):
        column = columns[j]
        known = np.einsum("isr,isr->sr", column[1:-1], steps[j + 1 : _K])
        np.subtract(column[-1], known, out=known)
        np.divide(known, column[0], out=steps[j])
    return steps, determinant
