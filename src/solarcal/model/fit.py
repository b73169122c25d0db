"""Fits of error terms to points.

``fit_linear`` is what the original could do, done well: least squares of the axis errors, weighted
so that every point counts by its error ON SKY (axis 1 by sin AX2), linear in any subset of the
terms of ``model.terms``.
"""

from collections.abc import Iterable
from typing import Literal

import numpy as np

from solarcal.errors import FitError
from solarcal.model.least_squares import solve
from solarcal.model.points import PointSet
from solarcal.model.solution import Solution
from solarcal.model.terms import (
    CONTROLLER_TERMS,
    NativeAngles,
    Term,
    chosen_terms,
    design_matrix,
)
from solarcal.mount.limits import Limits
from solarcal.units import FloatArray

__all__ = ["FEWEST_POINTS", "Solution", "fit_linear"]

FEWEST_POINTS = 3
LARGEST_EFFECT = 1e3
"""Degrees of axis 2 that one degree of a term can cause."""


def fit_linear(
    points: PointSet,
    terms: Iterable[str] = CONTROLLER_TERMS,
    *,
    limits: Limits | None = None,
) -> Solution:
    """Weighted linear least squares of the points' axis errors.

    Parameters
    ----------
    points
        At least three. Their ``sigma_deg``, if given, weight them and give the covariance its
        scale; otherwise all count alike and the residuals give the scale.
    terms
        Names from ``TERMS``.
    limits
        Software limits, within which the correction has to be realistic.

    Raises
    ------
    FitError
        Too few points; an unknown or repeated term, or one this mount does not have.
    """
    model_terms = chosen_terms(terms, points.geometry)
    n = len(points)
    if n < FEWEST_POINTS:
        raise FitError(
            f"{n} point{'' if n == 1 else 's'} to fit, at least {FEWEST_POINTS} are needed; "
            "take more points"
        )
    at = NativeAngles.at(points.geometry, points.ax1_deg, points.ax2_deg)
    weights = np.ones((2, n))
    weights[0] = at.sin2
    if points.sigma_deg is not None:
        weights /= points.sigma_deg
    design = design_matrix(model_terms, at)
    _refuse_unbounded(design, points, model_terms)
    measured = np.array((points.err1_deg, points.err2_deg))
    solved = solve(
        (design * weights).reshape(len(model_terms), 2 * n),
        (measured * weights).reshape(2 * n),
        np.array([term.prior_sigma for term in model_terms]),
        float(np.sqrt(np.vdot(weights, weights))),
    )
    spare = 2 * n - solved.rank
    sigma_source: Literal["given", "residuals", "none"]
    if points.sigma_deg is not None:
        sigma_source, variance = "given", 1.0
    elif spare > 0:
        squares = float(solved.weighted_residuals @ solved.weighted_residuals)
        sigma_source, variance = "residuals", squares / spare
    else:
        sigma_source, variance = "none", np.nan
    covariance = None
    if sigma_source != "none":
        covariance = variance * solved.data_covariance
        if solved.prior_covariance is not None:
            covariance = covariance + solved.prior_covariance
    residuals = solved.weighted_residuals.reshape(2, n) / weights
    return Solution(
        method="linear",
        model_terms=model_terms,
        values=solved.values,
        covariance=covariance,
        sigma_source=sigma_source,
        residual1_deg=residuals[0],
        residual2_deg=residuals[1],
        points=points,
        limits=limits,
        least_squares=solved,
    )


def _refuse_unbounded(design: FloatArray, points: PointSet, terms: tuple[Term, ...]) -> None:
    """Refuse a point where a term has no value, as TX (cot E) has none at the horizon."""
    for rows, term in zip(design, terms, strict=True):
        # One unit of a term moves no axis by more than 1/sin(0.01 deg) anywhere else.
        beyond = np.abs(rows[1]) > LARGEST_EFFECT * term.degrees_per_unit
        if beyond.any():
            at = int(np.flatnonzero(beyond)[0])
            raise FitError(
                f"point {points.labels[at]}: term {term.name} has no value at AX2 "
                f"{points.ax2_deg[at]:g} deg; leave out the term or the point"
            )
