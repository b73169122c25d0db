"""The JSON documents of the contracts, built from values; the same for live, replay and files."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from solarcal.model.fit import Solution
from solarcal.session.points import PointTable


def fit_document(
    files: Sequence[str | Path],
    table: PointTable,
    solution: Solution,
    *,
    evidence: Sequence[str] = (),
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """The contract's ``solarcal fit --json`` document."""
    fitted = solution.as_json()
    counted = {
        state: sum(status == state for status in table.status) for state in ("aborted", "rejected")
    }
    used = sum(status in ("accepted", "") for status in table.status)
    return {
        "files": [Path(file).name for file in files],
        "geometry": fitted.pop("geometry"),
        "method": fitted.pop("method"),
        "points": {
            "total": len(table.status),
            "used": used,
            **counted,
            "outliers": fitted.pop("outliers", []),
        },
        "mechanism": fitted.pop("mechanism", None),
        **fitted,
        "evidence": list(evidence),
        "warnings": list(warnings),
        "forecast": None,
        "verdict": None,
    }
