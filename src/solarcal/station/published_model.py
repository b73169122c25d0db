"""A fit beside what others published: TPOINT models term by term, PAINT's focal spots as beams."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solarcal.errors import FitError
from solarcal.model.fit import ITERATED, PMFIT_TERMS, chosen_terms
from solarcal.model.points import Points
from solarcal.model.solution import Solution
from solarcal.model.terms import NativeAngles, design_matrix
from solarcal.session.interchange import FillIn, is_paint, read_paint
from solarcal.session.interchange.paint import beam_residuals_mrad
from solarcal.session.interchange.tpoint_model import TpointModel, write_tpoint_model
from solarcal.units import ARCSEC_PER_DEG, RAD_PER_DEG, FloatArray, rms


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
    points: Points, names: Sequence[str], values: Sequence[float]
) -> FloatArray:
    """Distance of each point from what a model predicts, on the sky, degrees, (n,)."""
    terms = chosen_terms(names, points.geometry)
    at = NativeAngles.at(points.geometry, points.ax1_deg, points.ax2_deg)
    e1, e2 = np.einsum("k,kan->an", np.asarray(values), design_matrix(terms, at))
    cross = (points.err1_deg - e1) * np.sin(points.ax2_deg * RAD_PER_DEG)
    return np.asarray(np.hypot(cross, points.err2_deg - e2))


def compare_model(solution: Solution, model: TpointModel) -> ModelComparison:
    """The published terms beside the fitted ones, and the points' distance from its prediction.

    Raises
    ------
    FitError
        The model has a term that is not known, or none that this mount has.
    """
    sky = residuals_on_sky_deg(solution.points, model.names, model.values)
    units: dict[str, str] = {
        term.name: term.unit
        for term in (*chosen_terms(model.names, solution.geometry), *solution.model_terms)
    }
    values = zip(model.values, model.sigmas, strict=True)
    published = dict(zip(model.names, values, strict=True))
    fitted: dict[str, tuple[float, float | None]] = {
        name: (value, sigma)
        for name, value, sigma in zip(
            solution.terms, solution.values.tolist(), solution.sigma_list(), strict=True
        )
    }
    rows = tuple(
        (name, units[name], *published.get(name, (None, None)), *fitted.get(name, (None, None)))
        for name in dict.fromkeys((*published, *fitted))
    )
    return ModelComparison(
        caption=model.caption,
        rows=rows,
        sky_rms_deg=rms(sky),
        sky_max_deg=float(sky.max()),
        published_sky_rms_arcsec=model.sky_rms_arcsec,
    )


def fitted_terms(
    asked: str | None, method: str | None, model: TpointModel | None
) -> tuple[str, ...] | None:
    """The terms asked for, else those of the published model, else the method's own (None)."""
    if asked is not None:
        return tuple(term.strip() for term in asked.split(","))
    if model is not None:
        return model.names
    return PMFIT_TERMS if method == ITERATED else None


def write_model(solution: Solution, files: Sequence[Path], path: Path) -> None:
    """The fitted terms as a TPOINT model; its sky rms is that of the fit.

    FitError for a term that TPOINT does not have.
    """
    if foreign := [term.name for term in solution.model_terms if term.unit != "arcsec"]:
        raise FitError(
            f"a TPOINT model cannot hold {', '.join(foreign)}; fit TPOINT terms, for example "
            "--terms IA,IE,AN,AW,CA"
        )
    write_tpoint_model(
        TpointModel(
            caption=", ".join(file.name for file in files),
            method="T",
            observations=solution.n_points,
            sky_rms_arcsec=solution.sky_rms_deg * ARCSEC_PER_DEG,
            names=solution.terms,
            values=tuple(solution.values.tolist()),
            sigmas=tuple(solution.sigma_list()),
        ),
        path,
    )


@dataclass(frozen=True, slots=True)
class BeamResiduals:
    """``before_mrad``: with the drawing's mechanism; ``after_mrad``: with the fitted one, (n,)."""

    before_mrad: FloatArray
    after_mrad: FloatArray

    def as_json(self) -> dict[str, Any]:
        return {
            "rms_before_mrad": rms(self.before_mrad),
            "rms_mrad": rms(self.after_mrad),
            "max_mrad": float(self.after_mrad.max()),
        }

    def sentence(self) -> str:
        return (
            f"beam beside the spot, as seen from the mirror: rms {rms(self.after_mrad):.3f} mrad, "
            f"largest {self.after_mrad.max():.3f} (before the fit rms {rms(self.before_mrad):.3f})"
        )


def beam_residuals(
    files: Sequence[Path], fill_in: FillIn, solution: Solution
) -> BeamResiduals | None:
    """Of a fit of PAINT records alone; None for any other files."""
    if not all(is_paint(path) for path in files):
        return None
    shots = read_paint(files, fill_in).shots()
    if solution.n_points != len(shots.sun_enu):
        return None
    before = (
        shots.readings_deg[0] - shots.ideal_deg[0],
        shots.readings_deg[1] - shots.ideal_deg[1],
    )
    return BeamResiduals(
        beam_residuals_mrad(shots, *before),
        beam_residuals_mrad(shots, solution.residual1_deg, solution.residual2_deg),
    )
