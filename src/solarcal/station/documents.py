"""The JSON documents of the contracts, built from values; the same for live, replay and files."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from solarcal.model.analysis import Analysis
from solarcal.model.finding import Finding
from solarcal.model.solution import Solution
from solarcal.session.points import PointTable
from solarcal.session.records import UnitRecord, UploadRecord
from solarcal.station.uploading import UploadOffer


def fit_document(
    files: Sequence[str | Path],
    table: PointTable,
    solution: Solution,
    judgement: Analysis | None = None,
    *,
    findings: Sequence[Finding] | None = None,
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """The contract's ``solarcal fit --json`` document.

    ``findings`` is every finding whole, ``evidence`` the sentences of the direct ones.

    ``judgement`` is of the same points; without one (terms a controller does not have) forecast
    and verdict are null, and its findings are to be given. ``mechanism`` is null for ``linear``,
    ``prior`` for every method without one.
    """
    if findings is None:
        findings = () if judgement is None else judgement.findings
    fitted = solution.as_json()
    return {
        "files": _names(files),
        "geometry": fitted.pop("geometry"),
        "method": fitted.pop("method"),
        "points": {
            "total": len(table),
            "used": solution.n_points,
            "aborted": table.count("aborted"),
            "rejected": table.count("rejected"),
            "outliers": fitted.pop("outliers", []),
        },
        "mechanism": fitted.pop("mechanism", None),
        "prior": fitted.pop("prior", None),
        **fitted,
        "evidence": [finding.sentence for finding in findings if finding.direct],
        "findings": [finding.as_json() for finding in findings],
        "warnings": list(warnings),
        "forecast": None if judgement is None else judgement.forecast.as_json(),
        "verdict": None if judgement is None else judgement.verdict.as_json(),
    }


def forecast_document(
    files: Sequence[str | Path], judgement: Analysis, tolerance_deg: float
) -> dict[str, Any]:
    """``solarcal forecast --json``: the year's figures, the map, and the verdict they lead to."""
    return {
        **_heading(files, judgement),
        "tolerance_deg": tolerance_deg,
        "done_probability": judgement.forecast.rule.probability,
        "forecast": judgement.forecast.as_json(),
        "map": judgement.forecast.map_json(),
        "verdict": judgement.verdict.as_json(),
    }


def plan_document(files: Sequence[str | Path], judgement: Analysis) -> dict[str, Any]:
    """``solarcal plan --json``: each remaining half hour, the schedule advised, the verdict."""
    assert judgement.plan is not None
    return {
        **_heading(files, judgement),
        **judgement.plan.as_json(),
        "verdict": judgement.verdict.as_json(),
    }


def upload_document(file: str | Path, unit: UnitRecord, record: UploadRecord) -> dict[str, Any]:
    """What was written into which unit, what it held before, and whether it reads back equal."""
    return {
        "file": Path(file).name,
        "unit": {"model": unit.model, "serial": unit.serial},
        **msgspec.to_builtins(record),
    }


def offer_document(offer: UploadOffer) -> dict[str, Any]:
    """What was fitted, what the unit's resolution makes of the year, and the verdict."""
    return {
        "fitted": msgspec.to_builtins(offer.fitted),
        "forecast": {
            "fitted": offer.judgement.forecast.as_json(),
            "rounded": offer.kept.as_json(),
            "in_force": None if offer.held is None else offer.held.as_json(),
        },
        "probability_better": offer.better,
        "verdict": offer.judgement.verdict.as_json(),
    }


def _heading(files: Sequence[str | Path], judgement: Analysis) -> dict[str, Any]:
    return {
        "files": _names(files),
        "geometry": judgement.solution.geometry.name,
        "method": judgement.solution.method,
        "prior": judgement.solution.as_json().get("prior"),
        "points_used": judgement.solution.n_points,
    }


def _names(files: Sequence[str | Path]) -> list[str]:
    return [Path(file).name for file in files]
