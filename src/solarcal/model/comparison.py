"""A published pointing model beside a fit: the same points, term by term."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solarcal.model.points import PointSet
from solarcal.model.solution import Solution
from solarcal.model.terms import NativeAngles, chosen_terms, design_matrix
from solarcal.units import ARCSEC_PER_DEG, RAD_PER_DEG, FloatArray


@dataclass(frozen=True, slots=True)
class ModelComparison:
    """How a published model does on these points.

    ``rows``: term, unit, published value and sigma, fitted value and sigma; None where there is
    none. ``sky_rms_deg``: of the points from the published model; ``published_sky_rms_arcsec``
    is what its file says of its own points.
    """

    caption: str
    rows: tuple[tuple[str, str, float | None, float | None, float | None, float | None], ...]
    sky_rms_deg: float
    sky_max_deg: float
    published_sky_rms_arcsec: float | None

    def as_json(self) -> dict[str, Any]:
        return {
            "caption": self.caption,
            "sky_rms_arcsec": self.sky_rms_deg * ARCSEC_PER_DEG,
            "sky_max_arcsec": self.sky_max_deg * ARCSEC_PER_DEG,
            "published_sky_rms_arcsec": self.published_sky_rms_arcsec,
            "terms": {
                name: {
                    "unit": unit,
                    "published": published,
                    "published_sigma": published_sigma,
                    "fitted": fitted,
                    "fitted_sigma": fitted_sigma,
                }
                for name, unit, published, published_sigma, fitted, fitted_sigma in self.rows
            },
        }


def residuals_on_sky_deg(
    points: PointSet, names: Sequence[str], values: Sequence[float]
) -> FloatArray:
    """Distance of each point from what a model predicts, on the sky, degrees, (n,)."""
    terms = chosen_terms(names, points.geometry)
    at = NativeAngles.at(points.geometry, points.ax1_deg, points.ax2_deg)
    e1, e2 = np.einsum("k,kan->an", np.asarray(values), design_matrix(terms, at))
    cross = (points.err1_deg - e1) * np.sin(points.ax2_deg * RAD_PER_DEG)
    return np.asarray(np.hypot(cross, points.err2_deg - e2))


def compare_model(
    solution: Solution,
    caption: str,
    names: Sequence[str],
    values: Sequence[float],
    sigmas: Sequence[float | None],
    published_sky_rms_arcsec: float | None,
) -> ModelComparison:
    """The published terms beside the fitted ones, and the points' distance from its prediction.

    Raises
    ------
    FitError
        The model has a term that is not known, or none that this mount has.
    """
    sky = residuals_on_sky_deg(solution.points, names, values)
    units: dict[str, str] = {
        term.name: term.unit
        for term in (*chosen_terms(names, solution.geometry), *solution.model_terms)
    }
    published = {
        name: (value, sigma) for name, value, sigma in zip(names, values, sigmas, strict=True)
    }
    own_sigmas = [None] * len(solution.terms) if solution.sigmas is None else solution.sigmas
    fitted: dict[str, tuple[float, float | None]] = {
        name: (float(value), None if sigma is None else float(sigma))
        for name, value, sigma in zip(solution.terms, solution.values, own_sigmas, strict=True)
    }
    rows = tuple(
        (name, units[name], *published.get(name, (None, None)), *fitted.get(name, (None, None)))
        for name in dict.fromkeys((*published, *fitted))
    )
    return ModelComparison(
        caption=caption,
        rows=rows,
        sky_rms_deg=float(np.sqrt(np.mean(sky**2))),
        sky_max_deg=float(sky.max()),
        published_sky_rms_arcsec=published_sky_rms_arcsec,
    )
