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

from dataclasses import dataclass, fields
from itertools import combinations

import numpy as np

from solarcal.model.least_squares import ROUNDING
from solarcal.model.mixture_climb import (
    ENOUGH_FOR_SCALE,
    PARAMETERS,
    Climbed,
    Indices,
    Linearised,
    Mask,
    climb,
)
from solarcal.units import FloatArray

TYPICAL_NOISE_DEG = 0.03
"""A spot read by eye."""
NOISE_LOG_SD = 0.7
"""Natural logarithm: two thirds of all technicians within a factor of two."""
GIVEN_NOISE_LOG_SD = 0.5
"""The same where the points carry sigmas, which are then taken to be off by a common factor."""

COARSE_STEP = 0.4
COARSE_NODES: FloatArray = COARSE_STEP * np.arange(-5.0, 9.0)
FINE_NODES: FloatArray = np.linspace(-2.6, 2.6, 9)
LEAST_LOG_SD = 0.05
ITERATIONS = 12
SEARCH_ITERATIONS = 6
SEARCH_SCALES = (0.0, 2 * COARSE_STEP)
MOST_SUSPECTS = 8
MOST_NUMBERS = 300_000
"""Of one array of starts by points, as the processor keeps at hand; beyond it the starts take
turns."""


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
        climbed = climb(at, log_scales, np.ones(r), rows, SEARCH_ITERATIONS)
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
    normal = np.einsum("snai,snaj->sij", weighted, slopes) + at.precision * np.eye(PARAMETERS)
    pull = np.einsum("snai,san->si", weighted, at.residuals) + at.precision * at.offset
    normal += ROUNDING * np.einsum("sii->s", normal)[:, np.newaxis, np.newaxis] * np.eye(PARAMETERS)
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
    whole = ScaleMixtures(pairs, pairs, pairs, np.empty((s, q, PARAMETERS)), points, points)
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
    climbed = Climbed(
        *(np.concatenate([getattr(p, one.name) for p in parts], axis=-1) for one in fields(Climbed))
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
) -> Climbed:
    """At each scale (s, r) the better of two climbs; of one where no point is doubted."""
    (s, n), r = start.shape, len(widths)
    starts = np.zeros((n, s, 2 * r if doubted else r))
    if not doubted:
        return climb(at, log_scales, widths, starts, ITERATIONS)
    starts[:, :, :r] = start.T[:, :, np.newaxis]
    found = climb(at, np.tile(log_scales, 2), np.tile(widths, 2), starts, ITERATIONS)
    first = np.arange(r)
    better = np.where(found.scores[:, :r] >= found.scores[:, r:], first, first + r)
    session = np.arange(s)[:, np.newaxis]
    return Climbed(
        found.steps[:, session, better],
        found.point_weights[:, session, better],
        found.blunder[:, session, better],
        found.scores[session, better],
    )
