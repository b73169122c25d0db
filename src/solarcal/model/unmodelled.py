"""What a day cannot exclude: clock, collimation, axes not square, sag and air beside P1..P6.

A mount may have a little of each, and the controller's six numbers hold none of it. The points
say something about the amounts, mostly little; what they leave open widens the posterior, and with
it every band and the probability a calibration is done at. The coefficients stay those of the fit.

With the mechanism given the amounts nu, the points say theta ~ N(mu - G B nu, S), G = S A' W, where
A and B are the slopes of the points with respect to mechanism and amounts; the amounts themselves
have the information B' W B - B' W A S A' W B. Collimation and squareness are heavy-tailed: mostly
small, now and then ten times as large, which makes a mixture of three.
"""

import numpy as np

from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.prior import MechanismPosterior
from solarcal.model.sky_context import SkyContext
from solarcal.model.year_grid import SunGrid
from solarcal.mount.mechanism import Mechanism
from solarcal.stopping_rule import Unmodelled
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray, wrap_deg

NAMES = ("collimation", "squareness", "sag", "air", "clock")
CROSS_AXIS = slice(6, 8)
"""Collimation and squareness among the columns of a widened posterior."""
_BENT = ("collimation_deg", "nonperpendicularity_deg", "sag_deg")
_SUN_DEG_PER_S = 360.0 / SECONDS_PER_DAY
_LEAST_WEIGHT = 1e-5


def components(unmodelled: Unmodelled) -> list[tuple[float, FloatArray]]:
    """(chance, sigmas (5,)) in the order of ``NAMES``."""
    small = np.array(
        (
            unmodelled.cross_axis_deg,
            unmodelled.cross_axis_deg,
            unmodelled.sag_deg,
            unmodelled.air,
            unmodelled.clock_s,
        )
    )
    chances = unmodelled.large_chances
    parts = [(1.0 - sum(chances), small)]
    for index, chance in enumerate(chances):
        large = small.copy()
        large[index] = unmodelled.large_cross_axis_deg
        parts.append((chance, large))
    return [(chance, sigmas) for chance, sigmas in parts if chance > 0.0]


def sky_columns(
    values: FloatArray, context: SkyContext, ax1_deg: FloatArray, ax2_deg: FloatArray
) -> FloatArray:
    """Sky errors per unit of each amount at true directions, (5, 2, n); the clock's as measured."""
    at = Mechanism.linearised(values, context.geometry, ax1_deg, ax2_deg, _BENT)
    columns = np.zeros((len(NAMES), 2, len(ax1_deg)))
    columns[: len(_BENT)] = at.sky_slopes
    columns[3] = np.stack(context.lifted(ax1_deg, ax2_deg)(1.0)) - np.stack((ax1_deg, ax2_deg))
    columns[3, 0] = wrap_deg(columns[3, 0])
    columns[3] *= at.sky
    if context.heliostat is None:
        columns[4] = _clock_column(context, ax1_deg, ax2_deg)
    return columns


def year_columns(values: FloatArray, grid: SunGrid) -> FloatArray:
    """The same over a grid, (5, 2, g): the clock is right by then."""
    columns = sky_columns(values, grid.context, grid.sun.true1_deg, grid.sun.true2_deg)
    columns[4] = 0.0
    return columns


def _clock_column(context: SkyContext, ax1_deg: FloatArray, ax2_deg: FloatArray) -> FloatArray:
    """Of a clock one second ahead: the ideal angles are those of a second later, (2, n)."""
    geometry = context.geometry
    one, two = np.radians(ax1_deg), np.radians(ax2_deg)
    sine = np.sin(two)
    s = np.stack((sine * np.cos(one), sine * np.sin(one), np.cos(two)))
    latitude = np.radians(geometry.latitude_deg)
    pole = geometry.basis() @ np.array((0.0, np.cos(latitude), np.sin(latitude)))
    moved = -np.cross(pole, s, axisb=0).T * _SUN_DEG_PER_S
    cross = (s[0] * moved[1] - s[1] * moved[0]) / sine
    return np.stack((-cross, moved[2] / sine))


def widened(solution: MechanismSolution, unmodelled: Unmodelled) -> MechanismPosterior:
    """Posterior of P1..P6 and the five amounts (q, 11) for a ``robust`` fit."""
    posterior, context = solution.posterior, solution.context
    assert posterior.point_weights is not None
    seen = solution.seen
    columns = sky_columns(posterior.mean, context, seen.ax1_deg, seen.ax2_deg)
    n = solution.n_points
    A = solution.slopes.reshape(2 * n, 6)
    B = np.transpose(columns, (2, 1, 0)).reshape(2 * n, len(NAMES))
    sine = Mechanism.of(posterior.mean).sin_ax2(seen.ax2_deg, np.zeros(n))
    left = np.column_stack((solution.residual1_deg * sine, solution.residual2_deg)).reshape(-1)
    # One noise scale after the other: memory grows as the points, not as points by scales.
    BWA, BWB, pull = (
        np.stack(of)
        for of in zip(
            *(
                _pulls(solution, A, B, left - A @ (mean - posterior.mean), weights)
                for mean, weights in zip(posterior.means, posterior.point_weights, strict=True)
            ),
            strict=True,
        )
    )
    followed = posterior.covariances @ np.swapaxes(BWA, -1, -2)
    information = _without_negative(BWB - BWA @ followed)
    parts = [
        _with_amounts(posterior, followed, information, pull, chance, sigmas)
        for chance, sigmas in components(unmodelled)
    ]
    logs = np.concatenate([part[0] for part in parts])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    kept = weights > _LEAST_WEIGHT
    return MechanismPosterior(
        weights=weights[kept] / weights[kept].sum(),
        means=np.concatenate([part[1] for part in parts])[kept],
        covariances=np.concatenate([part[2] for part in parts])[kept],
        noise_deg=np.tile(posterior.noise_deg, len(parts))[kept],
    )


def _pulls(
    solution: MechanismSolution,
    A: FloatArray,
    B: FloatArray,
    residuals: FloatArray,
    point_weights: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """B' W A (m, 6), B' W B (m, m) and B' W r (m,) for weights (n,) of the points.

    Where something moved between sessions A and B are without what its shifts explain; r is at the
    fitted shifts, where W r says the same with and without them.
    """
    BW = B.T * np.repeat(point_weights, 2)
    if solution.shift_slopes is not None:
        A, B = (solution.beside_shifts(of, point_weights) for of in (A, B))
    return BW @ A, BW @ B, BW @ residuals


def _without_negative(information: FloatArray) -> FloatArray:
    """Where rounding left less than nothing (weights beyond what float64 resolves), nothing."""
    values, vectors = np.linalg.eigh(0.5 * (information + np.swapaxes(information, -1, -2)))
    if (values >= 0.0).all():
        return information
    scaled = vectors * np.maximum(values, 0.0)[:, np.newaxis, :]
    least: FloatArray = scaled @ np.swapaxes(vectors, -1, -2)
    return least


def _with_amounts(
    posterior: MechanismPosterior,
    followed: FloatArray,
    information: FloatArray,
    pull: FloatArray,
    chance: float,
    sigmas: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log weights (q,), means (q, 11) and covariances (q, 11, 11) for one width of the amounts.

    ``followed`` (q, 6, m) is by how much P1..P6 of the fit follow a unit of each amount.
    """
    scaled = information * np.outer(sigmas, sigmas) + np.eye(len(sigmas))
    variance = np.linalg.inv(scaled) * np.outer(sigmas, sigmas)
    amounts = np.einsum("qmn,qn->qm", variance, pull)
    evidence = 0.5 * np.einsum("qm,qm->q", pull, amounts) - 0.5 * np.linalg.slogdet(scaled)[1]
    across = followed @ variance
    means = np.concatenate(
        (posterior.means - np.einsum("qkm,qm->qk", followed, amounts), amounts), axis=1
    )
    upper = np.concatenate(
        (posterior.covariances + across @ np.swapaxes(followed, -1, -2), -across), axis=2
    )
    lower = np.concatenate((-np.swapaxes(across, -1, -2), variance), axis=2)
    logs = np.log(posterior.weights + 1e-300) + np.log(chance) + evidence
    return logs, means, np.concatenate((upper, lower), axis=1)
