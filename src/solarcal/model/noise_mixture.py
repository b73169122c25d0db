"""Linear regression with a prior, an unknown noise scale, and points that may be blunders.

Every point (both its axes at once, on sky) is either good, with normal noise of an unknown scale
s, or with a small probability a blunder, thrown about by BLUNDER_DEG. For each s on a grid the most
likely parameters come from expectation-maximisation, that is least squares with weights; Laplace's
approximation gives the evidence for that s. The answer is the mixture over s: wide where few points
cannot say how noisy they are, and untouched by a point that cannot be true.

It is written for s sessions of n points side by side, one of them or thousands. Every array has the
sessions in it: (n, s, r) for n points, s sessions and r starts, so that a call does thousands of
numbers and each start still climbs as it would alone. Sessions leave the batch when they settle.

References
----------
Dempster, Laird and Rubin (1977), J. R. Stat. Soc. B 39, 1: expectation-maximisation. Cook and
Weisberg (1982), Residuals and Influence in Regression, 2.2: points left out by their leverage.
"""

from dataclasses import dataclass, fields, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from solarcal.units import FloatArray

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

TYPICAL_NOISE_DEG = 0.03
"""A spot read by eye."""
NOISE_LOG_SD = 0.7
"""Natural logarithm: two thirds of all technicians within a factor of two."""
GIVEN_NOISE_LOG_SD = 0.5
"""The same where the points carry sigmas, which are then taken to be off by a common factor."""
BLUNDER_CHANCE = 0.02
BLUNDER_DEG = 0.7

COARSE_STEP = 0.4
COARSE_NODES: FloatArray = COARSE_STEP * np.arange(-5.0, 9.0)
FINE_NODES: FloatArray = np.linspace(-2.6, 2.6, 9)
LEAST_LOG_SD = 0.05
ITERATIONS = 12
SEARCH_ITERATIONS = 6
SEARCH_SCALES = (0.0, 2 * COARSE_STEP)
SETTLED = 1e-3
ROUNDING = 1e-14
MOST_SUSPECTS = 8
ENOUGH_FOR_SCALE = 1000
"""Points of which as many, evenly chosen, say how noisy all are; blunders among so many cannot hide
one another."""
MOST_NUMBERS = 300_000
"""Of one array of starts by points, as the processor keeps at hand; beyond it the starts take
turns."""

_K = 6
_COLUMN_STARTS = (0, 7, 13, 18, 22, 25)
"""Columns of the lower half of a normal matrix, each with its element of the pull below it."""
_ROWS = np.array([row for column in range(_K) for row in range(column, _K + 1)])
_COLUMNS = np.array([column for column in range(_K) for _ in range(column, _K + 1)])


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
class ScaleMixtures:
    """Posterior of each session at q pairs of noise scale and prior width.

    ``weights``, ``log_scales``, ``widths`` (s, q); ``steps`` (s, q, 6) from the place of
    linearisation; ``point_weights`` (s, q, n); ``blunder`` (s, q, n) probabilities.
    """

    weights: FloatArray
    log_scales: FloatArray
    widths: FloatArray
    steps: FloatArray
    point_weights: FloatArray
    blunder: FloatArray

    @property
    def mean_step(self) -> FloatArray:
        """(s, 6)"""
        mean: FloatArray = np.einsum("sq,sqk->sk", self.weights, self.steps)
        return mean

    def mean_of_points(self, column: FloatArray) -> FloatArray:
        """Of the point weights or the blunders (s, q, n) over the mixture, (s, n)."""
        mean: FloatArray = np.einsum("sq,sqn->sn", self.weights, column)
        return mean

    def take(self, chosen: Indices | Mask) -> "ScaleMixtures":
        """Those of these sessions."""
        return ScaleMixtures(*(getattr(self, one.name)[chosen] for one in fields(self)))

    def replaced(self, chosen: Indices | Mask, by: "ScaleMixtures") -> "ScaleMixtures":
        """With these sessions' answers exchanged."""
        columns = {one.name: getattr(self, one.name).copy() for one in fields(self)}
        for name, column in columns.items():
            column[chosen] = getattr(by, name)
        return ScaleMixtures(**columns)


@dataclass(frozen=True, eq=False, slots=True)
class _Climbed:
    """Where each start came to: steps (6, s, r), points (n, s, r), scores (s, r)."""

    steps: FloatArray
    point_weights: FloatArray
    blunder: FloatArray
    scores: FloatArray


def solve_mixtures(at: Linearised, before: ScaleMixtures | None = None) -> ScaleMixtures:
    """Posterior over a grid of noise scales, refined where its weight lies.

    ``before``, the answer at a place nearby, saves looking for blunders and for the scale again.
    """
    s, _, n, _ = at.slopes.shape
    narrowest = COARSE_STEP / 2.0 if before is None else LEAST_LOG_SD
    if before is None:
        some = at if n <= ENOUGH_FOR_SCALE else at.every(-(-n // ENOUGH_FOR_SCALE))
        nodes = COARSE_NODES + at.log_scale_mean[:, np.newaxis]
        before = _at_scales(some, nodes, _search_blunders(some))
    mean = np.einsum("sq,sq->s", before.weights, before.log_scales)
    away = before.log_scales - mean[:, np.newaxis]
    spread = np.sqrt(np.einsum("sq,sq->s", before.weights, away**2))
    # A coarse grid cannot tell a width below its own step: 2n - k data leave about this one.
    sharpest = 1.0 / np.sqrt(4.0 * n + 2.0 / at.log_scale_sd**2)
    spread = np.maximum(np.maximum(spread, np.minimum(sharpest, narrowest)), LEAST_LOG_SD)
    best = before.blunder[np.arange(s), np.argmax(before.weights, axis=1)]
    if best.shape[1] < n:
        best = np.zeros((s, n))
    nodes = mean[:, np.newaxis] + spread[:, np.newaxis] * FINE_NODES
    return _at_scales(at, nodes, best)


def _search_blunders(at: Linearised) -> FloatArray:
    """The most plausible start of each session, (s, n)."""
    s, n = len(at), at.residuals.shape[2]
    if n < 3:
        return np.zeros((s, n))
    rows = _start_rows(at)
    r = rows.shape[2]
    best, best_score = np.zeros((s, n)), np.full(s, -np.inf)
    for shift in SEARCH_SCALES:
        log_scales = np.broadcast_to((at.log_scale_mean + shift)[:, np.newaxis], (s, r))
        climbed = _climb(at, log_scales, np.ones(r), rows, SEARCH_ITERATIONS)
        top = np.argmax(climbed.scores, axis=1)
        score = climbed.scores[np.arange(s), top]
        better = score > best_score
        best[better] = climbed.blunder[:, np.arange(s), top].T[better]
        best_score[better] = score[better]
    return best


def _start_rows(at: Linearised) -> FloatArray:
    """No point, each suspect, each pair of them taken for a blunder: (n, s, r)."""
    s, n = len(at), at.residuals.shape[2]
    if n <= MOST_SUSPECTS + 4:
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


def _suspects(at: Linearised) -> Indices:
    """The points of each session that lie farthest from what the others predict, in their own
    noise: (s, MOST_SUSPECTS), rising.

    One fit of all points; the residual of a left-out point follows from its leverage, so that the
    search grows as the number of points.
    """
    scale = np.exp(at.log_scale_mean + COARSE_STEP)[:, np.newaxis]
    weights = 1.0 / (scale * at.sigma_deg) ** 2
    slopes = at.slopes.transpose(0, 2, 1, 3)
    weighted = slopes * weights[..., np.newaxis, np.newaxis]
    normal = np.einsum("snai,snaj->sij", weighted, slopes) + at.precision * np.eye(_K)
    pull = np.einsum("snai,san->si", weighted, at.residuals) + at.precision * at.offset
    normal += ROUNDING * np.einsum("sii->s", normal)[:, np.newaxis, np.newaxis] * np.eye(_K)
    inverse = np.linalg.inv(normal)
    left = at.residuals.transpose(0, 2, 1) - np.einsum("snai,sij,sj->sna", slopes, inverse, pull)
    leverage = (weighted @ inverse[:, np.newaxis]) @ slopes.swapaxes(2, 3)
    others = np.eye(2) * (1.0 + ROUNDING) - leverage
    predicted = np.linalg.solve(others, left[..., np.newaxis])[..., 0]
    distance = weights * np.einsum("sna,sna->sn", left, predicted)
    farthest = np.argsort(distance, axis=1)[:, ::-1][:, :MOST_SUSPECTS]
    return np.sort(farthest, axis=1)


def _at_scales(at: Linearised, scales: FloatArray, start: FloatArray) -> ScaleMixtures:
    """Climb from these blunder probabilities (s, n), and from none, at every scale (s, m) and
    width."""
    s, n = start.shape
    # Among many points blunders cannot hide one another: what they are is found from no start.
    doubted = (start.max(axis=1) > 0.01) & (n <= ENOUGH_FOR_SCALE)
    if doubted.all() or not doubted.any():
        return _at_scales_alike(at, scales, start, bool(doubted.any()))
    q = scales.shape[1] * len(at.widths)
    points = np.empty((s, q, n))
    pairs = np.empty((s, q))
    whole = ScaleMixtures(pairs, pairs, pairs, np.empty((s, q, _K)), points, points)
    for group, doubt in ((doubted, True), (~doubted, False)):
        found = _at_scales_alike(at.take(group), scales[group], start[group], doubt)
        whole = whole.replaced(group, found)
    return whole


def _at_scales_alike(
    at: Linearised, scales: FloatArray, start: FloatArray, doubted: bool
) -> ScaleMixtures:
    (s, n), w = start.shape, len(at.widths)
    log_scales = np.tile(scales, w)
    widths = np.repeat([factor for factor, _ in at.widths], scales.shape[1])
    log_chances = np.repeat(np.log([chance for _, chance in at.widths]), scales.shape[1])
    # Of very many points the scales are climbed a few at a time: memory grows as the points.
    together = max(1, MOST_NUMBERS // ((1 + doubted) * s * n))
    parts = [
        _from_start_and_none(at, log_scales[:, part], widths[part], start, doubted)
        for part in (slice(low, low + together) for low in range(0, len(widths), together))
    ]
    climbed = _Climbed(
        *(
            np.concatenate([getattr(p, one.name) for p in parts], axis=-1)
            for one in fields(_Climbed)
        )
    )
    evidence = climbed.scores + log_chances
    weights = np.exp(evidence - evidence.max(axis=1, keepdims=True))
    return ScaleMixtures(
        weights=weights / weights.sum(axis=1, keepdims=True),
        log_scales=log_scales,
        widths=np.broadcast_to(widths, log_scales.shape),
        steps=np.moveaxis(climbed.steps, 0, 2),
        point_weights=np.moveaxis(climbed.point_weights, 0, 2),
        blunder=np.moveaxis(climbed.blunder, 0, 2),
    )


def _from_start_and_none(
    at: Linearised, log_scales: FloatArray, widths: FloatArray, start: FloatArray, doubted: bool
) -> _Climbed:
    """At each scale (s, r) the better of two climbs; of one where nobody is doubted."""
    (s, n), r = start.shape, len(widths)
    starts = np.zeros((n, s, 2 * r if doubted else r))
    if not doubted:
        return _climb(at, log_scales, widths, starts, ITERATIONS)
    starts[:, :, :r] = start.T[:, :, np.newaxis]
    found = _climb(at, np.tile(log_scales, 2), np.tile(widths, 2), starts, ITERATIONS)
    first = np.arange(r)
    better = np.where(found.scores[:, :r] >= found.scores[:, r:], first, first + r)
    session = np.arange(s)[:, np.newaxis]
    return _Climbed(
        found.steps[:, session, better],
        found.point_weights[:, session, better],
        found.blunder[:, session, better],
        found.scores[session, better],
    )


def _climb(
    at: Linearised,
    log_scales: FloatArray,
    widths: FloatArray,
    blunder: FloatArray,
    iterations: int,
) -> _Climbed:
    """Expectation-maximisation of r starts (n, s, r) in each session.

    ``log_scales`` (s, r), ``widths`` (r,).
    """
    n, s, r = blunder.shape
    found = _Climbed(
        np.empty((_K, s, r)), np.empty((n, s, r)), np.empty((n, s, r)), np.empty((s, r))
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
        found.steps[:, here] = steps[:_K, settled]
        found.point_weights[:, here] = weights[:, settled]
        found.blunder[:, here] = blunder[:, settled]
        like_good = np.log1p(-BLUNDER_CHANCE) + np.log(inverse[:, settled])
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
    columns = [normal[start : start + _K + 1 - j] for j, start in enumerate(_COLUMN_STARTS)]
    diagonal = normal[list(_COLUMN_STARTS)]
    diagonal += precision
    # As alone: free directions would otherwise be lost in rounding.
    diagonal += ROUNDING * diagonal.sum(axis=0)
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
