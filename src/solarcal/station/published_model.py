"""TPOINT model files beside a fit: which terms to fit, comparison, writing."""

from collections.abc import Sequence
from pathlib import Path

from solarcal.errors import FitError
from solarcal.model.comparison import ModelComparison, compare_model
from solarcal.model.iterated_fit import ITERATED, PMFIT_TERMS
from solarcal.model.solution import Solution
from solarcal.session.interchange.tpoint_model import (
    TpointModel,
    read_tpoint_model,
    write_tpoint_model,
)
from solarcal.units import ARCSEC_PER_DEG


def published(path: Path) -> TpointModel:
    """A model file, read."""
    return read_tpoint_model(path)


def fitted_terms(
    asked: str | None, method: str | None, model: TpointModel | None
) -> tuple[str, ...] | None:
    """The terms asked for, else those of the published model, else the method's own (None)."""
    if asked is not None:
        return tuple(term.strip() for term in asked.split(","))
    if model is not None:
        return model.names
    return PMFIT_TERMS if method == ITERATED else None


def compared(solution: Solution, model: TpointModel) -> ModelComparison:
    """The model beside the fit."""
    return compare_model(
        solution, model.caption, model.names, model.values, model.sigmas, model.sky_rms_arcsec
    )


def write_model(solution: Solution, files: Sequence[Path], path: Path) -> None:
    """The fitted terms as a TPOINT model; its sky rms is that of the fit.

    Raises
    ------
    FitError
        A term that TPOINT does not have.
    """
    if foreign := [term.name for term in solution.model_terms if term.unit != "arcsec"]:
        raise FitError(
            f"a TPOINT model cannot hold {', '.join(foreign)}; fit TPOINT terms, for example "
            "--terms IA,IE,AN,AW,CA"
        )
    sigmas = [None] * len(solution.terms) if solution.sigmas is None else solution.sigmas.tolist()
    write_tpoint_model(
        TpointModel(
            caption=", ".join(file.name for file in files),
            method="T",
            observations=solution.n_points,
            sky_rms_arcsec=solution.sky_rms_deg * ARCSEC_PER_DEG,
            names=solution.terms,
            values=tuple(solution.values.tolist()),
            sigmas=tuple(sigmas),
        ),
        path,
    )
