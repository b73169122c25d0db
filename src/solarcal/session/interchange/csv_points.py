"""Points as CSV: ``# key=value`` lines, a header line, one row per point.

The format is in ``docs/session-file.md``. Columns are converted whole; only when that fails is the
bad cell looked for, so that a good file of 100,000 rows costs well under a second.
"""

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, Unpack

import numpy as np
from numpy.typing import NDArray

from solarcal.decimals import counted, shortened
from solarcal.errors import ConfigurationError, InputFileError, harmless
from solarcal.input_files import read_text, write_whole
from solarcal.session.interchange.csv_head import (
    UnitFillIn,
    head_lines,
    instant_text,
    read_head,
    without_separator_line,
)
from solarcal.session.points import NUMBERS, STATUSES, PointTable, given_numbers
from solarcal.timescale import parse_many_utc, parse_utc
from solarcal.units import FloatArray, wrap_deg

REQUIRED_COLUMNS = ("utc", "ax1_deg", "ax2_deg", "err1_deg", "err2_deg")
OPTIONAL_COLUMNS = (*NUMBERS, "status", "approach1", "approach2", "note")

_APPROACH = {"": 0, "0": 0, ".": 0, "1": 1, "+1": 1, "+": 1, "-1": -1, "-": -1}
# Instants a tracker can have met; anything else is a slip of the keyboard.
_EARLIEST_UTC_S, _LATEST_UTC_S = parse_utc("1900-01-01"), parse_utc("2201-01-01")

TAB = "\t"

Value = TypeVar("Value")


def read_points_csv(path: str | Path, **fill_in: Unpack[UnitFillIn]) -> PointTable:
    """Read a points CSV; ``fill_in`` fills what its ``# key=value`` lines leave out.

    Columns it does not know are ignored. AX1 is brought onto the branch.

    Raises
    ------
    InputFileError
        A bad cell, named by line and column; a missing or repeated column; no geometry.
    """
    text, separator = without_separator_line(read_text(path))
    if not text.strip():
        raise InputFileError(
            f"{path} is empty: a header line {','.join(REQUIRED_COLUMNS)} comes first"
        )
    head = read_head(text, path, fill_in)
    sheet = read_sheet(text, path, REQUIRED_COLUMNS, OPTIONAL_COLUMNS, separator)
    status = sheet.convert("status", _status_of)
    accepted = np.array([s == "accepted" for s in status], dtype=bool)
    # Attempts that were given up may have nothing to show; accepted rows must be complete.
    may_lack = ~accepted
    may_lack_utc = may_lack | (head.ideal == "apparent")
    numbers: dict[str, Any] = {}
    for name, (low, high) in NUMBERS.items():
        column = sheet.numbers(name, np.full(len(status), True), low, high)
        lacking = np.flatnonzero(np.isnan(column) & accepted)
        if len(lacking) and not np.isnan(column).all():
            raise sheet.error(int(lacking[0]), name, "is empty, but other rows have one")
        numbers[name] = given_numbers(column, accepted)
    return PointTable(
        **head.of_unit(),
        utc_s=sheet.instants("utc", may_lack_utc),
        ax1_deg=wrap_deg(sheet.numbers("ax1_deg", may_lack, -540.0, 540.0), head.ax1_centre_deg),
        ax2_deg=sheet.numbers("ax2_deg", may_lack, 0.0, 180.0),
        err1_deg=sheet.numbers("err1_deg", may_lack, -180.0, 180.0),
        err2_deg=sheet.numbers("err2_deg", may_lack, -180.0, 180.0),
        **numbers,
        status=tuple(status),
        approach=tuple(
            zip(
                sheet.convert("approach1", _approach_of),
                sheet.convert("approach2", _approach_of),
                strict=True,
            )
        ),
        note=tuple(map(harmless, sheet.column("note"))),
        labels=tuple(sheet.lines),
        sources=(str(path),) * len(status),
        warnings=head.warnings,
        light="sun",
    )


def write_points_csv(table: PointTable, path: str | Path) -> None:
    """Write a points CSV that reads back as the same numbers to the last bit.

    Instants keep microseconds. Optional columns without content are left out.

    Raises
    ------
    ConfigurationError
        The file cannot be written, or a text holds what UTF-8 cannot.
    """
    columns: dict[str, Iterable[str]] = {
        "utc": ("" if np.isnan(t) else instant_text(t) for t in table.utc_s.tolist()),
        "ax1_deg": _number_texts(table.ax1_deg),
        "ax2_deg": _number_texts(table.ax2_deg),
        "err1_deg": _number_texts(table.err1_deg),
        "err2_deg": _number_texts(table.err2_deg),
    }
    for name in NUMBERS:
        if (column := getattr(table, name)) is not None:
            columns[name] = _number_texts(column)
    columns["status"] = table.status
    if any(a != (0, 0) for a in table.approach):
        columns["approach1"] = (str(a) for a, _ in table.approach)
        columns["approach2"] = (str(a) for _, a in table.approach)
    if any(table.note):
        columns["note"] = (_quoted(note) for note in table.note)
    rows = map(",".join, zip(*columns.values(), strict=True))
    head = [*(f"# {line}" for line in head_lines(table)), ",".join(columns)]
    write_whole(path, "\n".join([*head, *rows, ""]))


@dataclass(frozen=True, slots=True)
class Sheet:
    """The cells by column name, with the line each row begins on."""

    path: str | Path
    columns: dict[str, tuple[str, ...]]
    lines: list[int]

    def column(self, name: str) -> tuple[str, ...]:
        """The cells of a column, empty where the file does not have it."""
        return self.columns.get(name) or ("",) * len(self.lines)

    def error(self, row: int, name: str, complaint: str) -> InputFileError:
        cell = self.column(name)[row]
        shown = f" {shortened(cell)}" if cell else ""
        return InputFileError(f"{self.path}:{self.lines[row]}: column {name}:{shown} {complaint}")

    def convert(self, name: str, of: Callable[[str], Value]) -> list[Value]:
        """Every cell through ``of``, whose ValueError becomes the complaint about the cell."""
        cells = self.column(name)
        try:
            # Most columns hold few different cells.
            known = {cell: of(cell) for cell in dict.fromkeys(cells)}
            return [known[cell] for cell in cells]
        except ValueError:
            for row, cell in enumerate(cells):
                try:
                    of(cell)
                except ValueError as error:
                    raise self.error(row, name, str(error)) from None
            raise

    def numbers(
        self, name: str, may_lack: NDArray[np.bool_], low: float, high: float
    ) -> FloatArray:
        """A column of finite numbers within [low, high], NaN where empty and allowed to be."""
        cells = self.column(name)
        try:
            # What float() takes and a points file should not: 1_000, other scripts' digits.
            plain = "_" not in (joined := "".join(cells)) and joined.isascii()
            values = np.array(list(map(float, cells)) if plain else [], dtype=np.float64)
        except ValueError:
            plain = False
        if not plain or not np.all((values >= low) & (values <= high)):
            values = np.array(self._slowly(name, low, high), dtype=np.float64)
        for row in np.flatnonzero(np.isnan(values) & ~may_lack)[:1]:
            raise self.error(int(row), name, "is empty")
        return values

    def _slowly(self, name: str, low: float, high: float) -> Iterable[float]:
        def number(cell: str) -> float:
            if not cell.strip():
                return np.nan
            try:
                value = np.nan if "_" in cell or not cell.isascii() else float(cell)
            except ValueError:
                value = np.nan
            if not np.isfinite(value):
                raise ValueError("is not a number")
            if not low <= value <= high:
                raise ValueError(f"is not between {low:g} and {high:g}")
            return value

        return self.convert(name, number)

    def instants(self, name: str, may_lack: NDArray[np.bool_]) -> FloatArray:
        """A column of ISO instants as POSIX seconds, NaN where empty and allowed to be."""
        cure = "correct it, or leave it empty" if may_lack.all() else "correct it"

        def instant(cell: str) -> float:
            if not cell.strip():
                return np.nan
            try:
                utc_s = parse_utc(cell)
            except ConfigurationError:
                raise ValueError("is not a date and time like 2026-06-21T15:30:00Z") from None
            if not _EARLIEST_UTC_S <= utc_s < _LATEST_UTC_S:
                raise ValueError(f"is not between 1900-01-01 and 2200-12-31; {cure}")
            return utc_s

        try:
            values = np.array(parse_many_utc(self.column(name)))
        except ConfigurationError:
            values = np.array([np.nan])
        if not np.all((values >= _EARLIEST_UTC_S) & (values < _LATEST_UTC_S)):
            values = np.array(self.convert(name, instant), dtype=np.float64)
        missing = np.isnan(values) & ~may_lack
        if missing.any():
            raise self.error(
                int(missing.argmax()),
                name,
                "is empty; only rows of ideal=apparent can do without a time",
            )
        return values


def read_sheet(
    text: str,
    path: str | Path,
    required: Sequence[str],
    optional: Sequence[str] = (),
    separator: str = ",",
) -> Sheet:
    """A header line and rows of as many cells; ``#`` rows and empty ones are passed over.

    Raises
    ------
    InputFileError
        No header line, a column missing or given twice, a row of another number of cells.
    """
    rows: list[list[str]] = []
    lines: list[int] = []
    reader = csv.reader(io.StringIO(text, newline=""), strict=True, delimiter=separator)
    last = 0
    try:
        for row in reader:
            first, last = last + 1, reader.line_num
            if row and not row[0].lstrip().startswith("#") and any(map(str.strip, row)):
                rows.append(row)
                lines.append(first)
    except csv.Error as error:
        raise InputFileError(f"{path}:{last + 1}: not readable as CSV: {error}") from None
    if not rows:
        raise InputFileError(f"{path} is empty: a header line {','.join(required)} comes first")
    names = [cell.strip().lower() for cell in rows.pop(0)]
    where = f"{path}:{lines.pop(0)}: the header line"
    if missing := [name for name in required if name not in names]:
        for name, other in (("semicolons", ";"), ("tabs", "\t"), ("commas", ",")):
            if other == separator:
                continue
            if set(required) <= {cell.strip() for cell in separator.join(names).split(other)}:
                raise InputFileError(
                    f"{where} separates its cells by {name}; save the file with "
                    f"{'tabs' if separator == TAB else 'commas'} between cells and points in "
                    "numbers"
                )
        raise InputFileError(f"{where} has no column {', '.join(missing)}")
    for name in (*required, *optional):
        if names.count(name) > 1:
            raise InputFileError(f"{where} has the column {name} twice")
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(names):
            at = names[len(row)] if len(row) < len(names) else f"number {len(names) + 1}"
            raise InputFileError(
                f"{path}:{line}: {counted(len(row), 'cell')} where the header has {len(names)} "
                f"(column {at})"
            )
    cells = list(zip(*rows, strict=True)) or [()] * len(names)
    return Sheet(path, dict(zip(names, cells, strict=True)), lines)


def _status_of(cell: str) -> str:
    status = cell.strip().lower() or "accepted"
    if status not in STATUSES:
        raise ValueError(f"is none of {', '.join(STATUSES)}")
    return status


def _approach_of(cell: str) -> int:
    try:
        return _APPROACH[cell.strip()]
    except KeyError:
        raise ValueError("is none of 1, -1, 0") from None


def _quoted(note: str) -> str:
    # Not csv.writer: with plain newlines it leaves a lone carriage return unquoted.
    return '"' + harmless(note).replace('"', '""') + '"' if note else ""


def _number_texts(values: FloatArray) -> Iterable[str]:
    return ("" if np.isnan(v) else repr(v) for v in values.tolist())
