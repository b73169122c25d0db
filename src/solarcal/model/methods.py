"""Entry point of fitting: ``linear``, ``robust`` (the default) or ``exact``."""

from collections.abc import Iterable
from typing import Literal, get_args

import numpy as np

from solarcal.errors import FitError
from solarcal.model.exact_fit import ExactFit, fit_mechanism
from solarcal.model.fit import ITERATED, fit_iterated, fit_linear
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.points import Points
from solarcal.model.prior import MechanismPosterior, Prior
from solarcal.model.sky_context import (
    LOWEST_ELEVATION_DEG,
    SkyContext,
    TruePoints,
    true_points,
)
from solarcal.model.solution import Solution
from solarcal.model.terms import CONTROLLER_TERMS, TERMS
from solarcal.model.year_grid import (
    coefficients_jacobian,
    controller_coefficients,
    year_grid,
)

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
    points
        ``robust`` and ``exact`` answer from one point on, ``linear`` from three. A point given
        more than once counts once.
    context
        Site, limits, and what the ideal angles leave out. None: nothing, and the whole sky.
    method
        ``linear``: the named terms by plain least squares. ``robust``: the exact mechanism with a
        prior and doubt about single points. ``exact``: the same without prior. ``iterated``: the
        named TPOINT terms at the encoder places, as SPK's PMFIT.
    prior
        Of the mechanism; not for ``linear``.
    terms
        For ``linear`` and ``iterated``.

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
    return _fit_free(used, seen).posterior


def _fit_free(used: Points, seen: TruePoints) -> ExactFit:
    return fit_mechanism(seen, used.geometry, used.sigma_deg, DEFAULT_PRIOR, use_prior=False)


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
