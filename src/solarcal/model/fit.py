"""Fits of error terms, chosen by name, to points.

``fit_linear`` is what the original could do, done well: least squares of the axis errors, weighted
so that every point counts by its error ON SKY (axis 1 by sin AX2), linear in any subset of the
terms of ``model.terms`` and TPOINT's harmonics, whose names say what they are.
"""

import re
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np

from solarcal.decimals import counted
from solarcal.errors import FitError
from solarcal.model.least_squares import solve
from solarcal.model.points import Points
from solarcal.model.solution import Solution
from solarcal.model.terms import (
    CONTROLLER_TERMS,
    SAG_PRIOR_DEG,
    TERMS,
    NativeAngles,
    Row,
    Term,
    degrees_per_unit,
    design_matrix,
    tpoint,
)
from solarcal.mount.geometry import Limits, MountGeometry
from solarcal.units import RAD_PER_DEG, FloatArray

FEWEST_POINTS = 3
LARGEST_EFFECT = 1e3
"""Degrees of axis 2 that one degree of a term can cause."""


def fit_linear(
    points: Points, terms: Iterable[str] = CONTROLLER_TERMS, *, limits: Limits | None = None
) -> Solution:
    """Weighted linear least squares of the points' axis errors.

    Parameters
    ----------
    points : at least three. Their ``sigma_deg``, if given, weight them and give the covariance its
        scale; otherwise all count alike and the residuals give the scale.
    terms : names from ``TERMS``.
    limits : software limits, within which the correction has to be realistic.

    Raises
    ------
    FitError
        Too few points; an unknown or repeated term, or one this mount does not have.
    """
    model_terms = chosen_terms(terms, points.geometry)
    n = len(points)
    if n < FEWEST_POINTS:
        raise FitError(
            f"{counted(n, 'point')} to fit, at least {FEWEST_POINTS} are needed; take more points"
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


def _refuse_unbounded(design: FloatArray, points: Points, terms: tuple[Term, ...]) -> None:
    """Refuse a point where a term has no value, as TX (cot E) has none at the horizon."""
    # One unit of a term moves no axis by more than 1/sin(0.01 deg) anywhere else.
    largest = LARGEST_EFFECT * degrees_per_unit(terms)
    beyond = np.abs(design[:, 1]) > largest[:, np.newaxis]
    if beyond.any():
        term, at = np.argwhere(beyond)[0].tolist()
        raise FitError(
            f"point {points.labels[at]}: term {terms[term].name} has no value at AX2 "
            f"{points.ax2_deg[at]:g} deg; leave out the term or the point"
        )


ITERATED = "iterated"
PMFIT_TERMS = ("IA", "IE", "CA", "AN", "AW", "TF")
"""What PMFIT fits, in its order."""

_MOST_ROUNDS = 20


def fit_iterated(points: Points, terms: Sequence[str], *, limits: Limits | None = None) -> Solution:
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
        raise FitError(
            f"{counted(n, 'point')} for {counted(k, 'term')}: the iterated fit needs more points "
            "than terms"
        )
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
        step = float(solved.values @ solved.values)
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


_HARMONIC = re.compile(r"H([AESZ])([SC])([AEZ])([0-9]{0,2})(?:([SC])([AEZ])([0-9]{0,2}))?")
_RESULTS = {"A": "azimuth", "E": "elevation", "S": "left-right on the sky", "Z": "zenith distance"}


def harmonic(name: str) -> Term | None:
    """The TPOINT harmonic of this name; None where the name is no harmonic.

    ``H``, what is changed (A azimuth, E elevation, S left-right on the sky, Z zenith distance),
    then one or two factors: S sine or C cosine, of A, E or Z, times a whole number (1 if none).
    ``HASA2``: A - A_enc = HASA2 sin 2A. ``HSCA``: (A - A_enc) cos E = HSCA cos A.
    """
    parts = _HARMONIC.fullmatch(name)
    if parts is None:
        return None
    result, *rest = parts.groups()
    factors = [
        (rest[at], rest[at + 1], int(rest[at + 2] or 1)) for at in (0, 3) if rest[at] is not None
    ]
    if any(function == "S" and times == 0 for function, _, times in factors):
        return None

    def rows(at: NativeAngles) -> tuple[Row, Row]:
        value: Row = 1.0
        for function, angle, times in factors:
            # A = 180 - AX1, Z = AX2, E = 90 - AX2.
            turn = {"A": 180.0 - at.ax1_deg, "E": 90.0 - at.ax2_deg, "Z": at.ax2_deg}[angle]
            wave = np.sin if function == "S" else np.cos
            value = value * wave(times * turn * RAD_PER_DEG)
        if result == "A":
            return value, 0.0
        if result == "S":
            return value / at.sin2, 0.0
        return 0.0, value if result == "E" else -value

    wording = " ".join(
        f"{'sin' if function == 'S' else 'cos'} {times if times > 1 else ''}{angle}"
        for function, angle, times in factors
    )
    return tpoint(name, f"{_RESULTS[result]} harmonic, {wording}", SAG_PRIOR_DEG, rows)


def chosen_terms(names: Iterable[str], geometry: MountGeometry) -> tuple[Term, ...]:
    """The terms of these names, in this order.

    Raises
    ------
    FitError
        No term, an unknown or repeated one, or one that this mount does not have.
    """
    terms: list[Term] = []
    for name in names:
        term = TERMS.get(name) or harmonic(name)
        if term is None or term.rows is None:
            known = ", ".join(known for known, one in TERMS.items() if one.rows is not None)
            raise FitError(
                f"there is no error term {name!r}; known are {known} and harmonics "
                "such as HASA2 or HECE"
            )
        if term.only not in (None, geometry.name):
            raise FitError(
                f"term {name} is defined for {term.only} mounts only and this one is "
                f"{geometry.name}; use P1..P6, C, N, SAG"
            )
        terms.append(term)
    named = [term.name for term in terms]
    if len(set(named)) < len(named):
        twice = next(name for name in named if named.count(name) > 1)
        raise FitError(f"term {twice} is named twice")
    if not terms:
        raise FitError("no error term was named; give at least one, for example P1,P2,P3")
    return tuple(terms)
