"""Linear regression with a prior, an unknown noise scale, and points that may be blunders.

Every point (both its axes at once, on sky) is either good, with normal noise of an unknown scale
s, or with a small probability a blunder, thrown about by BLUNDER_DEG. For each s on a grid the most
likely parameters come from expectation-maximisation, that is least squares with weights; Laplace's
approximation gives the evidence for that s. The answer is the mixture over s: wide where few points
cannot say how noisy they are, and untouched by a point that cannot be true.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from solarcal.units import FloatArray

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


@dataclass(frozen=True, eq=False, slots=True)
class Linearised:
    """n points about one place in the space of k parameters.

    ``residuals`` (n, 2) sky degrees; ``slopes`` (n, 2, k); ``offset`` (k,): prior mean less the
    place, ``precision`` (k,): of the prior; ``widths``: (factor, chance) of its sigmas;
    ``sigma_deg`` (n,): noise of each point at scale one; ``log_scale_mean``, ``log_scale_sd``: the
    prior of ln s.
    """

    residuals: FloatArray
    slopes: FloatArray
    offset: FloatArray
    precision: FloatArray
    widths: tuple[tuple[float, float], ...]
    sigma_deg: FloatArray
    log_scale_mean: float
    log_scale_sd: float

    def every(self, step: int) -> "Linearised":
        """Every so manieth of the points."""
        return replace(
            self,
            residuals=self.residuals[::step],
            slopes=self.slopes[::step],
            sigma_deg=self.sigma_deg[::step],
        )


@dataclass(frozen=True, eq=False, slots=True)
class ScaleMixture:
    """Posterior at q pairs of noise scale and prior width.

    ``weights``, ``log_scales``, ``widths`` (q,); ``steps`` (q, k) from the place of linearisation;
    ``point_weights`` (q, n); ``blunder`` (q, n) probabilities.
    """

    weights: FloatArray
    log_scales: FloatArray
    widths: FloatArray
    steps: FloatArray
    point_weights: FloatArray
    blunder: FloatArray

    @property
    def mean_step(self) -> FloatArray:
        mean: FloatArray = self.weights @ self.steps
        return mean


def solve_mixture(at: Linearised, before: ScaleMixture | None = None) -> ScaleMixture:
    """Posterior over a grid of noise scales, refined where its weight lies.

    ``before``, the answer at a place nearby, saves looking for blunders and for the scale again.
    """
    n = len(at.residuals)
    narrowest = COARSE_STEP / 2.0 if before is None else LEAST_LOG_SD
    if before is None:
        some = at if n <= ENOUGH_FOR_SCALE else at.every(-(-n // ENOUGH_FOR_SCALE))
        start = _search_blunders(some) if n > 2 else np.zeros((1, n))
        before = _at_scales(some, COARSE_NODES + at.log_scale_mean, start)
    mean = float(before.weights @ before.log_scales)
    spread = float(np.sqrt(before.weights @ (before.log_scales - mean) ** 2))
    # A coarse grid cannot tell a width below its own step: 2n - k data leave about this one.
    sharpest = 1.0 / np.sqrt(4.0 * n + 2.0 / at.log_scale_sd**2)
    spread = max(spread, min(sharpest, narrowest), LEAST_LOG_SD)
    best = before.blunder[int(np.argmax(before.weights))][np.newaxis]
    if best.shape[1] < n:
        best = np.zeros((1, n))
    return _at_scales(at, mean + spread * FINE_NODES, best)


def _search_blunders(at: Linearised) -> FloatArray:
    """The most plausible start: no point, each suspect, each pair of them a blunder. (1, n)"""
    n = len(at.residuals)
    suspects = range(n) if n <= MOST_SUSPECTS + 4 else _suspects(at)
    rows: list[tuple[int, ...]] = [(), *((i,) for i in suspects)]
    if n > 3:
        rows += list(combinations(suspects, 2))
    starts = np.zeros((len(rows), n))
    for row, chosen in zip(starts, rows, strict=True):
        row[list(chosen)] = 1.0
    best, best_score = starts[:1], -np.inf
    moments = _moments(at)
    for shift in SEARCH_SCALES:
        log_scales = np.full(len(rows), at.log_scale_mean + shift)
        ones = np.ones(len(rows))
        _, _, blunder, scores = _climb(at, moments, log_scales, ones, starts, SEARCH_ITERATIONS)
        top = int(np.argmax(scores))
        if scores[top] > best_score:
            best, best_score = blunder[top : top + 1], scores[top]
    return best


def _suspects(at: Linearised) -> list[int]:
    """The points that lie farthest from what the others predict, in their own noise.

    One fit of all points; the residual of a left-out point follows from its leverage, so that the
    search grows as the number of points (Cook and Weisberg 1982, Residuals and Influence, 2.2).
    """
    scale = np.exp(at.log_scale_mean + COARSE_STEP)
    weights = 1.0 / (scale * at.sigma_deg) ** 2
    normal = np.einsum("n,nai,naj->ij", weights, at.slopes, at.slopes) + np.diag(at.precision)
    pull = np.einsum("n,nai,na->i", weights, at.slopes, at.residuals) + at.precision * at.offset
    inverse = np.linalg.inv(normal + ROUNDING * np.trace(normal) * np.eye(len(normal)))
    left = at.residuals - at.slopes @ (inverse @ pull)
    leverage = np.einsum("n,nai,ij,nbj->nab", weights, at.slopes, inverse, at.slopes, optimize=True)
    others = np.eye(2) * (1.0 + ROUNDING) - leverage
    predicted = np.linalg.solve(others, left[..., np.newaxis])[..., 0]
    distance = weights * np.einsum("na,na->n", left, predicted)
    return sorted(np.argsort(distance)[::-1][:MOST_SUSPECTS].tolist())


def _at_scales(at: Linearised, scales: FloatArray, start: FloatArray) -> ScaleMixture:
    """Climb from these blunder probabilities (1, n), and from none, at every scale and width."""
    n, w = len(at.residuals), len(at.widths)
    q = len(scales) * w
    log_scales = np.tile(scales, w)
    widths = np.repeat([factor for factor, _ in at.widths], len(scales))
    log_chances = np.repeat(np.log([chance for _, chance in at.widths]), len(scales))
    # Among many points blunders cannot hide one another: what they are is found from no start.
    both = 2 if n <= ENOUGH_FOR_SCALE and start.max() > 0.01 else 1
    moments = _moments(at)
    # Of very many points the scales are climbed a few at a time: memory grows as the points.
    together = max(1, MOST_NUMBERS // (both * n))
    parts = []
    for first in range(0, q, together):
        part = slice(first, first + together)
        here = len(log_scales[part])
        starts = np.zeros((both * here, n))
        starts[: (both - 1) * here] = start
        climbed = _climb(
            at, moments, np.tile(log_scales[part], both), np.tile(widths[part], both), starts,
            ITERATIONS,
        )  # fmt: skip
        scores = climbed[3]
        better = np.arange(here)
        if both == 2:
            better = np.where(scores[:here] >= scores[here:], better, better + here)
        parts.append([of[better] for of in climbed])
    steps, point_weights, blunder, scores = (np.concatenate(of) for of in zip(*parts, strict=True))
    evidence = scores + log_chances
    weights = np.exp(evidence - evidence.max())
    return ScaleMixture(
        weights=weights / weights.sum(),
        log_scales=log_scales,
        widths=widths,
        steps=steps,
        point_weights=point_weights,
        blunder=blunder,
    )


def _moments(at: Linearised) -> tuple[FloatArray, FloatArray]:
    """Of each point: products of every two slopes, each pair once (n, k (k + 1) / 2), and of slopes
    and residuals (n, k)."""
    first, second = np.triu_indices(at.slopes.shape[-1])
    squares = np.empty((len(first), len(at.slopes)))
    slopes1, slopes2 = at.slopes[:, 0].T, at.slopes[:, 1].T
    for row, i, j in zip(squares, first, second, strict=True):
        np.multiply(slopes1[i], slopes1[j], out=row)
        row += slopes2[i] * slopes2[j]
    return squares.T, np.einsum("nai,na->ni", at.slopes, at.residuals)


def _climb(
    at: Linearised,
    moments: tuple[FloatArray, FloatArray],
    log_scales: FloatArray,
    widths: FloatArray,
    blunder: FloatArray,
    iterations: int,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Expectation-maximisation of b starts at once.

    Returns steps (b, k), point weights (b, n), blunder probabilities (b, n), log evidence (b,).
    """
    n, _, k = at.slopes.shape
    flat = at.slopes.reshape(2 * n, k)
    measured = at.residuals.reshape(-1)
    squares, pulls = moments
    first, second = np.triu_indices(k)
    precision = at.precision / widths[:, np.newaxis] ** 2
    prior = precision[:, :, np.newaxis] * np.eye(k)
    prior_pull = precision * at.offset

    good = np.exp(2.0 * log_scales)[:, np.newaxis] * at.sigma_deg**2
    bad = good + BLUNDER_DEG**2
    log_good = np.log1p(-BLUNDER_CHANCE) - np.log(good)
    log_bad = np.log(BLUNDER_CHANCE) - np.log(bad)

    for turn in range(iterations):
        weights = (1.0 - blunder) / good + blunder / bad
        normal = prior.copy()
        normal[:, first, second] += weights @ squares
        normal[:, second, first] = normal[:, first, second]
        # Without a prior to speak of, free directions would be lost in rounding.
        normal += ROUNDING * np.einsum("bii->b", normal)[:, np.newaxis, np.newaxis] * np.eye(k)
        steps = np.linalg.solve(normal, (weights @ pulls + prior_pull)[..., np.newaxis])[..., 0]
        left = (measured - steps @ flat.T).reshape(-1, n, 2)
        distance = np.einsum("bna,bna->bn", left, left)
        like_good = log_good - 0.5 * distance / good
        like_bad = log_bad - 0.5 * distance / bad
        before = blunder
        if n <= ENOUGH_FOR_SCALE:
            blunder = np.exp(like_bad - np.logaddexp(like_good, like_bad))
        else:
            # Equal, and some times as fast; what is beyond all doubt overflows to certainty.
            with np.errstate(over="ignore"):
                blunder = 1.0 / (1.0 + np.exp(like_good - like_bad))
        if turn > 1 and np.abs(blunder - before).max() < SETTLED:
            break

    # The curvature that belongs to the last steps; the blunders have moved by nothing since.
    away = steps - at.offset
    score = (
        np.logaddexp(like_good, like_bad).sum(axis=1)
        - 0.5 * np.sum(away**2 * precision, axis=1)
        - 0.5 * np.linalg.slogdet(normal)[1]
        - k * np.log(widths)
        - 0.5 * ((log_scales - at.log_scale_mean) / at.log_scale_sd) ** 2
    )
    return np.asarray(steps), weights, blunder, np.asarray(score)
