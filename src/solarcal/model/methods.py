"""Entry point of fitting: ``linear``, ``robust`` (the default) or ``exact``.

The last two fit the mechanism behind the points: exact geometry, known physics, a prior, and
possible blunders. Non-linear least squares by scipy, the prior as six pseudo-observations, inside
the robust mixture of ``noise_mixture``: the mixture at a place weighs the points, least squares of
the weighted points finds the next place, and the mixture's own mean there is the answer. All
parameters are in units of their prior sigmas, so that lean, zeros and scales weigh alike.

References
----------
Dempster, Laird and Rubin (1977), J. R. Stat. Soc. B 39, 1: expectation-maximisation, of which the
alternation is an instance.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.optimize import least_squares

from solarcal.errors import FitError
from solarcal.model.fit import ITERATED, fit_iterated, fit_linear
from solarcal.model.least_squares import LeastSquares, inverse, solve
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.mixture_climb import Linearised
from solarcal.model.noise_mixture import (
    GIVEN_NOISE_LOG_SD,
    NOISE_LOG_SD,
    TYPICAL_NOISE_DEG,
    ScaleMixtures,
    solve_mixtures,
)
from solarcal.model.points import Points
from solarcal.model.prior import PLAIN, MechanismPosterior, Prior
from solarcal.model.sky_context import LOWEST_ELEVATION_DEG, SkyContext, TruePoints, true_points
from solarcal.model.solution import Solution
from solarcal.model.terms import CONTROLLER_TERMS, TERMS
from solarcal.model.year_grid import coefficients_jacobian, controller_coefficients, year_grid
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.units import FloatArray, wrap_deg

Method = Literal["linear", "robust", "exact"]
METHODS: tuple[Method, ...] = get_args(Method)
DEFAULT_METHOD: Method = "robust"
DEFAULT_PRIOR = Prior()


def fit(
    points: Points,
    context: SkyContext | None = None,
    *,
    method: str = DEFAULT_METHOD,
    prior: Prior = DEFAULT_PRIOR,
    terms: Iterable[str] = CONTROLLER_TERMS,
) -> Solution:
    """Fit points by one of the methods.

    Parameters
    ----------
    points : ``robust`` and ``exact`` answer from one point on, ``linear`` from three. A point given
        more than once counts once.
    context : site, limits, and what the ideal angles leave out. None: nothing, and the whole sky.
    method : ``linear``: the named terms by plain least squares. ``robust``: the exact mechanism
        with a prior and doubt about single points. ``exact``: the same without prior. ``iterated``:
        the named TPOINT terms at the encoder places, as SPK's PMFIT.
    prior : of the mechanism; not for ``linear``.
    terms : for ``linear`` and ``iterated``.

    Raises
    ------
    FitError
        An unknown method, terms other than P1..P6 for ``robust`` and ``exact``, too few points.
    """
    if context is None:
        context = SkyContext.for_points(points)
    points = points.distinct()
    if method == "linear":
        return fit_linear(points, terms, limits=context.limits)
    if method == ITERATED:
        return fit_iterated(points, tuple(terms), limits=context.limits)
    if method not in METHODS:
        raise FitError(f"unknown method {method!r}; choose {', '.join(METHODS)}")
    if tuple(terms) != CONTROLLER_TERMS:
        raise FitError(f"the method {method} always has P1..P6; use --method linear with --terms")
    return fit_exact(points, context, prior=prior, use_prior=method == "robust")


def fit_exact(
    points: Points, context: SkyContext, *, prior: Prior = DEFAULT_PRIOR, use_prior: bool = True
) -> MechanismSolution:
    """``robust``, or ``exact`` without ``use_prior``; see ``fit``."""
    if not len(points):
        raise FitError("no points to fit; take at least one")
    used, seen, left_out = _high_enough(points, context)
    fitted = fit_mechanism(seen, used.geometry, used.sigma_deg, prior, use_prior=use_prior)
    posterior = fitted.posterior
    year = year_grid(context).linearised(posterior.mean)
    carried = coefficients_jacobian(year.slopes, context, prior)
    return MechanismSolution(
        method="robust" if use_prior else "exact",
        model_terms=tuple(TERMS[name] for name in CONTROLLER_TERMS),
        values=controller_coefficients(posterior.mean, context, prior, year.errors),
        covariance=carried @ posterior.covariance @ carried.T,
        sigma_source="posterior",
        residual1_deg=fitted.residuals_deg[0],
        residual2_deg=fitted.residuals_deg[1],
        points=used,
        limits=context.limits,
        least_squares=fitted.data,
        posterior=posterior,
        context=context,
        prior=prior,
        seen=seen,
        year=year,
        blunder_probability=fitted.blunder,
        slopes=fitted.slopes,
        point_weights=fitted.point_weights,
        left_out=left_out,
    )


def posterior_without_prior(points: Points, context: SkyContext) -> MechanismPosterior:
    """What the points alone say of the mechanism: by which a ``linear`` fit is judged."""
    used, seen, _ = _high_enough(points, context)
    fitted = fit_mechanism(seen, used.geometry, used.sigma_deg, DEFAULT_PRIOR, use_prior=False)
    return fitted.posterior


def _high_enough(points: Points, context: SkyContext) -> tuple[Points, TruePoints, tuple[str, ...]]:
    """Points high enough to be fitted, seen from the true Sun, and a sentence on the others."""
    seen = true_points(points, context)
    high = seen.elevation_deg >= LOWEST_ELEVATION_DEG
    if high.all():
        return points, seen, ()
    low = [points.labels[i] for i in np.flatnonzero(~high)]
    if not high.any():
        raise FitError(
            f"every point is below {LOWEST_ELEVATION_DEG:g} deg of elevation, where refraction "
            "dominates; take points higher up"
        )
    names = ", ".join(str(label) for label in low)
    sentence = (
        f"left out, because below {LOWEST_ELEVATION_DEG:g} deg of elevation: point"
        f"{'s' if len(low) > 1 else ''} {names}"
    )
    return points.subset(high), TruePoints(*(column[high] for column in seen)), (sentence,)


FREE_PRECISION = 1e-6
"""Weight of the prior in a fit 'without prior': it only chooses where the points leave a choice."""

FIRST_NOISE_DEG = 0.1
PLACE_SETTLED = 1e-10
"""Of the place, relative: where least squares ends."""
MOST_STEPS = 12
SETTLED = 2e-3
"""In units of the prior: the curvature over so small a step is below a thousandth of the noise."""


@dataclass(frozen=True, eq=False, slots=True)
class ExactFit:
    """Posterior of the mechanism and what each point has to do with it.

    ``residuals_deg`` (2, n) axis degrees, measured minus the mean mechanism's; ``blunder`` (n,)
    probability of each point; ``slopes`` (n, 2, 6) of the sky residuals; ``data`` the points' own
    information without prior.
    """

    posterior: MechanismPosterior
    residuals_deg: FloatArray
    blunder: FloatArray
    slopes: FloatArray
    point_weights: FloatArray
    data: LeastSquares


def fit_mechanism(
    points: TruePoints,
    geometry: MountGeometry,
    sigma_deg: FloatArray | None,
    prior: Prior,
    *,
    use_prior: bool = True,
) -> ExactFit:
    """Fit the exact mechanism to points seen from the true Sun.

    Parameters
    ----------
    points : at least one.
    sigma_deg : (n,), noise on sky per axis, up to a common factor; None: unknown and alike.
    prior : its sigmas are also the units of the search.
    use_prior : False: ``exact``, where the prior only chooses what the points leave open.
    """
    n = len(points.ax1_deg)
    unit, mean = prior.sigma_array(), prior.mean_array()
    precision = 1.0 if use_prior else FREE_PRECISION
    relative = (np.ones(n) if sigma_deg is None else sigma_deg)[np.newaxis]
    scale_mean = np.array([np.log(TYPICAL_NOISE_DEG) if sigma_deg is None else 0.0])
    scale_sd = np.array([NOISE_LOG_SD if sigma_deg is None else GIVEN_NOISE_LOG_SD])

    def linearised(
        values: FloatArray, sky: FloatArray | None = None
    ) -> tuple[Linearised, FloatArray, FloatArray]:
        there = Mechanism.linearised(values, geometry, points.ax1_deg, points.ax2_deg)
        left = np.stack((points.err1_deg, points.err2_deg)) - there.errors
        left[0] = wrap_deg(left[0])
        sky = there.sky if sky is None else sky
        return (
            Linearised(
                residuals=(left * sky)[np.newaxis],
                slopes=np.ascontiguousarray(
                    np.moveaxis(there.slopes * sky * unit[:, np.newaxis, np.newaxis], 0, 2)
                )[np.newaxis],
                offset=((mean - values) / unit)[np.newaxis],
                widths=prior.widths if use_prior else PLAIN,
                sigma_deg=relative,
                log_scale_mean=scale_mean,
                log_scale_sd=scale_sd,
                precision=precision,
            ),
            left,
            sky,
        )

    def nearest(weights: FloatArray, pull: float) -> FloatArray:
        """Weighted least squares of the points (n,) and the prior, of precision ``pull``, from
        where they were linearised last.

        Axis degrees count on sky as they do at the start: weights that move with the place would
        have slopes of their own.
        """
        start = values / unit
        place, found = [start], [at]
        root, prior_root = np.sqrt(np.tile(weights, 2)), np.sqrt(pull)

        def at_place(scaled: FloatArray) -> Linearised:
            if not np.array_equal(place[0], scaled):
                place[:], found[:] = [scaled.copy()], [linearised(scaled * unit, sky)[0]]
            return found[0]

        def residuals(scaled: FloatArray) -> FloatArray:
            here = at_place(scaled)
            return np.concatenate(
                (here.residuals.reshape(-1) * root, here.offset[0] * prior_root), axis=None
            )

        def slopes(scaled: FloatArray) -> FloatArray:
            rows = at_place(scaled).slopes.reshape(2 * n, 6) * root[:, np.newaxis]
            return np.concatenate((-rows, -prior_root * np.eye(6)))

        solved = least_squares(residuals, start, slopes, method="lm", xtol=PLACE_SETTLED)
        return np.asarray(solved.x * unit, dtype=np.float64)

    values = mean
    at, left, sky = linearised(values)
    values = nearest(np.full(n, FIRST_NOISE_DEG**-2.0), precision)
    at, left, sky = linearised(values)
    mixture = solve_mixtures(at)
    for turn in range(MOST_STEPS):
        if np.abs(mixture.mean_step).max() < SETTLED:
            break
        if turn == 0:
            weighted = mixture.mean_of_points(mixture.point_weights)[0]
            pull = precision * float(mixture.weights[0] @ mixture.widths[0] ** -2.0)
            values = nearest(weighted, pull)
        else:
            # The mean of the mixture is not quite where its mean weights lead: with few points the
            # noise is hardly known and the mixture wide.
            values = values + mixture.mean_step[0] * unit
        at, left, sky = linearised(values)
        mixture = solve_mixtures(at, mixture)
    return _concluded(at, mixture, values, unit, left, sky)


def _concluded(
    at: Linearised,
    mixture: ScaleMixtures,
    values: FloatArray,
    unit: FloatArray,
    left: FloatArray,
    sky: FloatArray,
) -> ExactFit:
    slopes = at.slopes[0].swapaxes(0, 1)
    # The last step is too small to be worth another linearisation.
    left = left - at.slopes[0] @ mixture.mean_step[0] / sky
    of_points = mixture.point_weights[0]
    point_weights = mixture.mean_of_points(mixture.point_weights)[0]
    if at.precision == FREE_PRECISION:
        covariances = np.stack([_free_covariance(at, w, unit) for w in of_points])
    else:
        normal = np.einsum("qn,nai,naj->qij", of_points, slopes, slopes)
        prior = np.eye(6) / (mixture.widths[0] ** 2)[:, np.newaxis, np.newaxis]
        covariances = inverse(normal + prior) * np.outer(unit, unit)
    posterior = MechanismPosterior(
        weights=mixture.weights[0],
        means=values + mixture.steps[0] * unit,
        covariances=covariances,
        noise_deg=np.exp(mixture.log_scales[0]) * np.sqrt(np.mean(at.sigma_deg**2)),
        point_weights=of_points,
    )
    return ExactFit(
        posterior=posterior,
        residuals_deg=left,
        blunder=mixture.mean_of_points(mixture.blunder)[0],
        slopes=slopes / unit,
        point_weights=point_weights,
        data=_data_only(at, point_weights, unit),
    )


def _data_only(at: Linearised, point_weights: FloatArray, unit: FloatArray) -> LeastSquares:
    root = np.sqrt(np.tile(point_weights, 2))
    rows = at.slopes.reshape(len(root), -1).T / unit[:, np.newaxis] * root
    return solve(rows, at.residuals.reshape(-1) * root, unit, float(np.linalg.norm(root)))


def _free_covariance(at: Linearised, point_weights: FloatArray, unit: FloatArray) -> FloatArray:
    """From the points alone; along what they leave open, the prior's."""
    solved = _data_only(at, point_weights, unit)
    if solved.prior_covariance is None:
        return solved.data_covariance
    return solved.data_covariance + solved.prior_covariance
