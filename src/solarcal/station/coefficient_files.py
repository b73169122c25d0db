"""Coefficients from a file: a document of ``solarcal fit --json``, or a session that is fitted."""

import math
from pathlib import Path

import msgspec

from solarcal.errors import InputFileError
from solarcal.input_files import read_bytes
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients
from solarcal.station.analysing import analyse_files, read_files


class _Value(msgspec.Struct):
    value: float


class _FitDocument(msgspec.Struct):
    geometry: str
    coefficients: dict[str, _Value]
    method: str = ""


class FileCoefficients(msgspec.Struct, frozen=True):
    """P1..P6, the geometry they mean something for, and where they are from, in words."""

    coefficients: Coefficients
    geometry: str
    source: str


def read_coefficients(path: Path, method: str | None = None) -> FileCoefficients:
    """The coefficients a file gives.

    Parameters
    ----------
    method : how a session is fitted; a document's fit has been made.

    Raises
    ------
    InputFileError
        Neither of the two, or a document without all six terms.
    FitError
        A session whose points allow no fit.
    """
    if path.suffix.lower() == ".jsonl":
        judged = analyse_files(read_files([path], {}), method=method)
        solution = judged.of_the_controller().solution
        return FileCoefficients(
            solution.coefficients(), judged.table.geometry, f"{solution.method} fit of {path}"
        )
    content = read_bytes(path)
    try:
        document = msgspec.json.decode(content, type=_FitDocument)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputFileError(
            f"{path} is neither a session (.jsonl) nor what `solarcal fit --json` prints: {error}"
        ) from None
    told = {name: term.value for name, term in document.coefficients.items()}
    missing = [name for name in COEFFICIENT_NAMES if not math.isfinite(told.get(name, math.nan))]
    if missing:
        raise InputFileError(
            f"{path}: {', '.join(missing)} missing; a controller needs all of P1..P6, so fit "
            "without --terms"
        )
    return FileCoefficients(
        Coefficients(*(told[name] for name in COEFFICIENT_NAMES)),
        document.geometry,
        f"{document.method} fit in {path}".strip(),
    )
