"""``robust`` for thousands of sessions at once: the mechanism, without what a year of Sun is for.

The same steps as ``methods.fit_mechanism``, each taken for all sessions that still need it. What
comes out is the mechanism and how well it is known; the six numbers to UPLOAD need the year of
each site and are the business of ``methods.fit``.
"""

from dataclasses import dataclass, fields

import numpy as np

from solarcal.model import methods as alone
from solarcal.model.mixture_climb import Indices, Linearised
from solarcal.model.noise_mixture import (
    GIVEN_NOISE_LOG_SD,
    NOISE_LOG_SD,
    TYPICAL_NOISE_DEG,
    ScaleMixtures,
    solve_mixtures,
)
from solarcal.model.prior import Prior
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.units import FloatArray, wrap_deg

MOST_STEPS = 30
PLACE_SETTLED = 1e-7
"""In units of the prior: the step after so small a one would be lost in rounding."""
LEAN_TRUSTED_DEG = 10.0
"""A lean step no linearisation is believed beyond."""
_ANY_MOUNT = MountGeometry("azel", 0.0)
"""Without sag a mechanism sees all mounts alike: native angles, on a branch that is theirs."""
_WIDTHS = Prior().widths
_AT_ONCE, _OF_POINTS = 160, 12
"""So many sessions of so many points a batch: its arrays stay in the processor's cache."""


def at_once(n: int) -> int:
    """How many sessions of n points are best fitted in one call."""
    return max(1, _AT_ONCE * _OF_POINTS // max(n, _OF_POINTS))


@dataclass(frozen=True, eq=False, slots=True)
class ManyPoints:
    """n points of each of s sessions, from where the Sun really stood; degrees.

    ``ax1_deg`` on the branch, ``ax2_deg``, ``err1_deg``, ``err2_deg`` (s, n) as in ``TruePoints``;
    ``sigma_deg`` (s, n), NaN throughout a session that gives none;
    ``prior_mean``, ``prior_sigma`` (s, 6).
    """

    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    sigma_deg: FloatArray
    prior_mean: FloatArray
    prior_sigma: FloatArray

    def __len__(self) -> int:
        return len(self.ax1_deg)

    def take(self, chosen: Indices | slice) -> "ManyPoints":
        return ManyPoints(*(getattr(self, one.name)[chosen] for one in fields(self)))


@dataclass(frozen=True, eq=False, slots=True)
class ManyMechanisms:
    """What ``robust`` says of s sessions.

    ``mean`` (s, 6), ``covariance`` (s, 6, 6): P1..P6 of the exact mechanism; ``noise_deg`` (s,) of
    one point on sky, per axis (the median); ``residual1_deg``, ``residual2_deg`` (s, n) axis
    degrees; ``blunder`` (s, n) probabilities.
    """

    mean: FloatArray
    covariance: FloatArray
    noise_deg: FloatArray
    residual1_deg: FloatArray
    residual2_deg: FloatArray
    blunder: FloatArray


def fit_many(points: ManyPoints) -> ManyMechanisms:
    """Fit sessions of the same number of points, at least one; best ``at_once`` of them a call.

    Agrees with ``methods.fit(method="robust")`` but for rounding.
    """
    s, n = points.ax1_deg.shape
    even = np.full((s, n), alone.FIRST_NOISE_DEG**-2.0)
    values = _nearest(points, points.prior_mean, even, np.ones(s))
    at, left, sky = _linearised(points, values)
    mixture = solve_mixtures(at)
    for turn in range(alone.MOST_STEPS):
        mean_step = mixture.mean_step
        active = np.flatnonzero(np.abs(mean_step).max(axis=1) >= alone.SETTLED)
        if not active.size:
            break
        here = points.take(active)
        if turn == 0:
            found = mixture.take(active)
            weighted = found.mean_of_points(found.point_weights)
            pull = np.einsum("sq,sq->s", found.weights, found.widths**-2.0)
            values[active] = _nearest(here, values[active], weighted, pull)
        else:
            values[active] += mean_step[active] * here.prior_sigma
        moved, left[active], sky[active] = _linearised(here, values[active])
        mixture = mixture.replaced(active, solve_mixtures(moved, mixture.take(active)))
        at.residuals[active], at.slopes[active] = moved.residuals, moved.slopes
        at.offset[active] = moved.offset
    return _concluded(points, at, mixture, values, left, sky)


def _nearest(
    points: ManyPoints, start: FloatArray, weights: FloatArray, pull: FloatArray
) -> FloatArray:
    """Least squares of weighted points (s, n) and priors of precision ``pull`` (s,), from (s, 6).

    Gauss and Newton's steps to where scipy's least squares ends in ``fit_mechanism``.
    """
    values = start.copy()
    active: Indices = np.arange(len(points))
    _, _, sky = _linearised(points, start)
    for _ in range(MOST_STEPS):
        here = points.take(active)
        at, _, _ = _linearised(here, values[active], sky[active])
        s, _, n, k = at.slopes.shape
        rows = at.slopes.reshape(s, 2 * n, k)
        turned = rows.swapaxes(1, 2) * np.tile(weights[active], 2)[:, np.newaxis]
        precision = pull[active][:, np.newaxis]
        wanted = (turned @ at.residuals.reshape(s, 2 * n, 1))[..., 0] + at.offset * precision
        normal = turned @ rows + precision[..., np.newaxis] * np.eye(k)
        step: FloatArray = np.asarray(
            np.linalg.solve(normal, wanted[..., np.newaxis])[..., 0], dtype=np.float64
        )
        values[active] += _trusted(step, here.prior_sigma)
        active = active[np.abs(step).max(axis=1) >= PLACE_SETTLED]
        if not active.size:
            break
    return values


def _linearised(
    points: ManyPoints, values: FloatArray, sky: FloatArray | None = None
) -> tuple[Linearised, FloatArray, FloatArray]:
    """Each session about its place (s, 6); what is left (s, 2, n) and axis to sky (s, 2, n).

    ``sky`` another axis to sky than the place's own.
    """
    there = Mechanism.linearised(values, _ANY_MOUNT, points.ax1_deg, points.ax2_deg)
    errors = there.errors.swapaxes(0, 1)
    sky = there.sky.swapaxes(0, 1).copy() if sky is None else sky
    left = np.stack((points.err1_deg, points.err2_deg), axis=1) - errors
    left[:, 0] = wrap_deg(left[:, 0])
    unit = points.prior_sigma
    given = np.isfinite(points.sigma_deg.sum(axis=1))
    at = Linearised(
        residuals=left * sky,
        slopes=np.ascontiguousarray(there.slopes.transpose(2, 1, 3, 0))
        * sky[..., np.newaxis]
        * unit[:, np.newaxis, np.newaxis, :],
        offset=(points.prior_mean - values) / unit,
        widths=_WIDTHS,
        sigma_deg=np.where(given[:, np.newaxis], points.sigma_deg, 1.0),
        log_scale_mean=np.where(given, 0.0, np.log(TYPICAL_NOISE_DEG)),
        log_scale_sd=np.where(given, GIVEN_NOISE_LOG_SD, NOISE_LOG_SD),
    )
    return at, left, sky


def _trusted(step: FloatArray, unit: FloatArray) -> FloatArray:
    full = step * unit
    lean = np.hypot(full[:, 0], full[:, 2])
    held: FloatArray = LEAN_TRUSTED_DEG / np.maximum(lean, LEAN_TRUSTED_DEG)
    return full * held[:, np.newaxis]


def _concluded(
    points: ManyPoints,
    at: Linearised,
    mixture: ScaleMixtures,
    values: FloatArray,
    left: FloatArray,
    sky: FloatArray,
) -> ManyMechanisms:
    unit, weights = points.prior_sigma, mixture.weights
    step = mixture.mean_step
    left = left - np.einsum("sank,sk->san", at.slopes, step) / sky
    squares = np.einsum("sani,sanj->snij", at.slopes, at.slopes)
    s, n, k = squares.shape[:3]
    normal = (mixture.point_weights @ squares.reshape(s, n, k * k)).reshape(s, -1, k, k)
    normal += np.eye(k) / (mixture.widths**2)[..., np.newaxis, np.newaxis]
    inner: FloatArray = np.einsum("sq,sqij->sij", weights, np.linalg.inv(normal))
    away = mixture.steps - step[:, np.newaxis]
    inner += np.einsum("sq,sqi,sqj->sij", weights, away, away)
    noise = np.exp(mixture.log_scales) * np.sqrt(np.mean(at.sigma_deg**2, axis=1))[:, np.newaxis]
    return ManyMechanisms(
        mean=values + step * unit,
        covariance=inner * unit[:, :, np.newaxis] * unit[:, np.newaxis, :],
        noise_deg=_medians(noise, weights),
        residual1_deg=left[:, 0],
        residual2_deg=left[:, 1],
        blunder=mixture.mean_of_points(mixture.blunder),
    )


def _medians(noise_deg: FloatArray, weights: FloatArray) -> FloatArray:
    """Half of each session's weight lies below, (s,); see ``MechanismPosterior``."""
    order = np.argsort(noise_deg, axis=1)
    reached = np.cumsum(np.take_along_axis(weights, order, 1), axis=1)
    logs = np.log(np.take_along_axis(noise_deg, order, 1))
    pairs = zip(reached, logs, strict=True)
    return np.exp([np.interp(0.5, below, log) for below, log in pairs])
