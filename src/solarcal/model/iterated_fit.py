"""Least squares with the terms evaluated where the encoders stand, as SPK's PMFIT does it.

The model corrects the encoder place; what is left towards the true place is fitted by the terms at
the true place, and the correction is repeated with the sum until it no longer shrinks. A term
acts on the place that the terms before it have left, so the order of the terms matters in the
last digits near the zenith. One sigma of a value divides the squared residuals on the sky by n - k,
n observations and k terms, not by the 2n - k numbers of the linear fit.

References
----------
P. T. Wallace, Pmfit, in the SPK pointing kernel, 2023.
"""

from collections.abc import Sequence

import numpy as np

from solarcal.errors import FitError
from solarcal.model.least_squares import solve
from solarcal.model.points import PointSet
from solarcal.model.solution import Solution
from solarcal.model.terms import NativeAngles, chosen_terms, design_matrix
from solarcal.mount.limits import Limits
from solarcal.units import RAD_PER_DEG, FloatArray

ITERATED = "iterated"
PMFIT_TERMS = ("IA", "IE", "CA", "AN", "AW", "TF")
"""What PMFIT fits, in its order."""

_MOST_ROUNDS = 20


def fit_iterated(
    points: PointSet, terms: Sequence[str], *, limits: Limits | None = None
) -> Solution:
    """Fit the named terms, in this order, at the encoder places.

    Raises
    ------
    FitError
        Not more points than terms; an unknown or repeated term; points with sigmas of their own,
        which PMFIT does not weight by; terms that these points cannot tell apart.
    """
    model_terms = chosen_terms(terms, points.geometry)
    n, k = len(points), len(model_terms)
    if n <= k:
        raise FitError(f"{n} points for {k} terms: the iterated fit needs more points than terms")
    if any(term.unit != "arcsec" for term in model_terms):
        raise FitError(
            "the iterated fit is of TPOINT terms (IA, IE, ...); P1..P6 are fitted by the other "
            "methods"
        )
    if points.sigma_deg is not None:
        raise FitError(
            "the iterated fit counts all points alike; leave out sigma_deg or --iterated"
        )
    at_true = NativeAngles.at(points.geometry, points.ax1_deg, points.ax2_deg)
    encoder2_deg = points.ax2_deg + points.err2_deg
    at_encoder = design_matrix(
        model_terms,
        NativeAngles.at(points.geometry, points.ax1_deg + points.err1_deg, encoder2_deg),
    )
    weights = np.ones((2, n))
    weights[0] = at_true.sin2
    rows = (design_matrix(model_terms, at_true) * weights).reshape(k, 2 * n)
    measured = np.array((points.err1_deg, points.err2_deg))
    priors = np.array([term.prior_sigma for term in model_terms])
    units = np.array([term.degrees_per_unit for term in model_terms])
    values = np.zeros(k)
    last = np.inf
    for _ in range(_MOST_ROUNDS):
        left = (measured - _corrections(values, at_encoder, encoder2_deg)) * weights
        solved = solve(rows, left.reshape(2 * n), priors, float(np.sqrt(np.vdot(weights, weights))))
        if solved.rank < k:
            raise FitError(
                "these points cannot separate the terms, so that the iterated fit has no "
                "answer; leave terms out"
            )
        values = values + solved.values
        step = float(np.sum((solved.values * units) ** 2))
        if step >= last:
            break
        last = step
    residuals = measured - _corrections(values, at_encoder, encoder2_deg)
    variance = float(np.sum((residuals * weights) ** 2)) / (n - k)
    return Solution(
        method=ITERATED,
        model_terms=model_terms,
        values=values,
        covariance=variance * solved.data_covariance,
        sigma_source="residuals",
        residual1_deg=residuals[0],
        residual2_deg=residuals[1],
        points=points,
        limits=limits,
        least_squares=solved,
    )


def _corrections(
    values: FloatArray, at_encoder: FloatArray, encoder2_deg: FloatArray
) -> FloatArray:
    """E1, E2 (2, n) of the terms one after another from the encoder places, axis degrees."""
    errors = np.zeros((2, len(encoder2_deg)))
    sin_encoder = np.sin(encoder2_deg * RAD_PER_DEG)
    for value, (e1, e2) in zip(values.tolist(), at_encoder, strict=True):
        moved = np.sin((encoder2_deg - errors[1]) * RAD_PER_DEG)
        errors[0] += value * e1 * sin_encoder / moved
        errors[1] += value * e2
    return errors
