"""TPOINT pointing data of an alt-azimuth mount (``.dat``), in and out.

    caption
    : ALTAZ
    -30 14 40.2                  latitude: d m s, or decimal degrees [date, weather, height ...]
    az el az_enc el_enc [...]    azimuth from North through East: true place, encoders; decimal
                                 degrees, d m s in twelve columns, or d:m:s
    END

In native angles AX1 = 180 - A and AX2 = 90 - E; the errors are encoder minus true. What is read
beyond that (comments, masked observations, solarcal's own keys) is in ``docs/session-file.md``.
"""

import re
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Unpack

import numpy as np

from solarcal.decimals import counted
from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import read_text, write_whole
from solarcal.session.interchange.altaz import (
    DECIMAL,
    Row,
    all_numbers,
    altaz_table,
    layout_of,
    many_rows,
    plain_numbers,
    possible,
    refuse_radians,
    require_possible,
    sexagesimal_row,
)
from solarcal.session.interchange.csv_head import UnitFillIn, head_lines, take_key
from solarcal.session.points import PointTable
from solarcal.units import FloatArray

_COMMENT = ("!", "#", ";")
_COMMENT_FOLLOWS = re.compile("[!#;]")
_MASK = "*"
_FIGURES = frozenset("0123456789+-.")
# Where a latitude line goes on (date, temperature, pressure), the height is the sixth number
# after the latitude.
_HEIGHT_AFTER = 5
_EARLIEST_YEAR = 1900.0
_DECIMALS = 10


def read_tpoint(path: str | Path, **fill_in: Unpack[UnitFillIn]) -> PointTable:
    """Read an ALTAZ pointing file. Masked observations have the status ``rejected``.

    ``fill_in`` fills what is missing.

    Raises
    ------
    InputFileError
        A short line, a bad number, a layout of columns that is not certain (all named by line),
        radians, or another mount than ALTAZ.
    ConfigurationError
        The geometry is given and not ``azel``.
    """
    reading = _Reading(str(path))
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        if reading.take(number, line.strip()):
            break
    angles = reading.finish()
    return altaz_table(
        path,
        angles,
        reading.masked,
        reading.lines,
        keys=reading.keys,
        fill_in=fill_in,
        format_name="TPOINT ALTAZ",
        warnings=reading.warnings,
    )


def write_tpoint(table: PointTable, path: str | Path) -> None:
    """Write an ALTAZ pointing file, ten decimals of a degree.

    Rows that are not accepted are written masked; attempts without angles are left out. Times,
    sigmas and notes have no place in the format.

    Raises
    ------
    ConfigurationError
        Another geometry than azel, no latitude, or the file cannot be written.
    """
    if table.geometry != "azel":
        raise ConfigurationError(
            f"TPOINT files are written for azel only, not for {table.geometry}; export to .csv"
        )
    if table.latitude_deg is None:
        raise ConfigurationError("a TPOINT file needs the latitude, which is not known; add --lat")
    own = [line for line in head_lines(table) if not line.startswith(("geometry=", "lat_deg="))]
    lines = [
        f"{' '.join(table.unit.split()) or 'Sun tracker'}: points from solarcal",
        *(f"! {line}" for line in own),
        ": ALTAZ",
        _latitude_text(table.latitude_deg),
    ]
    true_azimuth = 180.0 - table.ax1_deg
    true_elevation = 90.0 - table.ax2_deg
    columns = (
        _azimuth_texts(true_azimuth),
        _elevation_texts(true_elevation),
        _azimuth_texts(true_azimuth - table.err1_deg),
        _elevation_texts(true_elevation - table.err2_deg),
    )
    for status, *cells in zip(table.status, *columns, strict=True):
        if "" not in cells:
            lines.append(" ".join(cells) if status == "accepted" else "! " + " ".join(cells))
    write_whole(path, "\n".join([*lines, "END", ""]))


@dataclass(slots=True)
class _Reading:
    """State of one pass over a file: caption, then the latitude line, then observations."""

    path: str
    caption: str | None = None
    options: list[str] = field(default_factory=list)
    keys: dict[str, str | float] = field(default_factory=dict)
    alone: dict[int, Row] = field(default_factory=dict)
    """Observations read one by one, by their place among all."""
    waiting: list[tuple[int, str]] = field(default_factory=list)
    """Line and text of the others: read together in the end."""
    layout: str | None = None
    masked: list[bool] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    ended: bool = False

    def take(self, number: int, line: str) -> bool:
        """One line, blanks stripped. True when it is the END."""
        if self.layout is not None and line[:1] in _FIGURES and not _COMMENT_FOLLOWS.search(line):
            self._keep(number, line, masked=False)
            return False
        where = f"{self.path}:{number}"
        if line.startswith(_COMMENT):
            self._comment(number, line.lstrip("!#; \t"))
            return False
        if self.caption is None:
            if not line:
                return False
            self.caption = "" if line.startswith(":") else line
            if self.caption:
                cells = line.split()
                if len(cells) >= 3 and len(plain_numbers(cells)) == len(cells):
                    raise InputFileError(f"{where}: a TPOINT file begins with its caption line")
                return False
        line = _COMMENT_FOLLOWS.split(line, maxsplit=1)[0].strip()
        if not line:
            return False
        if line.startswith(":"):
            self.options.extend(line[1:].upper().split())
        elif line.upper() == "END":
            self.ended = True
            return True
        elif "lat_deg" not in self.keys:
            self._latitude(line.split(), where)
        else:
            masked, text = line.startswith(_MASK), line.lstrip("* \t")
            self._keep(number, text if self.layout else self._observation(number, text), masked)
        return False

    def finish(self) -> FloatArray:
        """All observations, (n, 4) degrees, once everything has been taken."""
        if self.caption is None:
            raise InputFileError(f"{self.path} is empty: no TPOINT caption in it")
        if "ALTAZ" not in self.options:
            raise InputFileError(
                f"{self.path} has no ': ALTAZ' line: only TPOINT files of alt-azimuth mounts "
                "are read"
            )
        if "lat_deg" not in self.keys:
            raise InputFileError(f"{self.path} has no latitude line (degrees minutes seconds)")
        angles = self._angles()
        refuse_radians(angles, self.path)
        if any(self.masked):
            used = len(self.masked) - sum(self.masked)
            self.warnings.append(
                f"{self.path}: {used} observations used, {sum(self.masked)} masked"
            )
        if not self.ended:
            self.warnings.append(f"{self.path} has no END line: it may have been cut short")
        return angles

    def _angles(self) -> FloatArray:
        angles = np.empty((len(self.lines), 4))
        together = np.full(len(angles), True)
        for place, row in self.alone.items():
            angles[place], together[place] = row, False
        if self.waiting and self.layout:
            many = many_rows([text for _, text in self.waiting], self.layout)
            angles[together] = (
                [self._observation(number, text) for number, text in self.waiting]
                if many is None
                else many
            )
        return angles

    def _comment(self, number: int, text: str) -> None:
        """A remark, a key of solarcal's, or an observation that was commented out."""
        cells = _COMMENT_FOLLOWS.split(text, maxsplit=1)[0].split()
        row = self._masked_row(cells) if "lat_deg" in self.keys else None
        if row is not None:
            self._keep(number, row, masked=True)
        elif self.caption is None or not self.lines:
            key = text.partition("=")[0].strip()
            if key in ("unit", "lon_deg", "elevation_m", "ax1_centre_deg", "target", "mirror"):
                take_key(self.keys, text, f"{self.path}:{number}")

    def _masked_row(self, cells: list[str]) -> Row | None:
        """The observation in a comment, None where it is none."""
        layout = layout_of(cells)
        if layout == DECIMAL:
            values = plain_numbers(cells)
            if len(values) < max(4, len(cells)) or not possible(values):
                return None
            return (values[0], values[1], values[2], values[3])
        if layout is None or layout != self.layout:
            return None
        try:
            row = sexagesimal_row(cells, layout, "")
        except InputFileError:
            return None
        return row if possible(row) else None

    def _latitude(self, cells: list[str], where: str) -> None:
        values = plain_numbers(cells)
        if len(values) < len(cells):
            raise InputFileError(
                f"{where}: {cells[len(values)][:20]!r} is not a number; the latitude comes here "
                "(degrees minutes seconds, or decimal degrees)"
            )
        # A decimal latitude stands alone or before a date, whose year no minute can be.
        if len(values) == 1 or ("." in cells[0] and values[1] >= _EARLIEST_YEAR):
            size, after = abs(Fraction(cells[0])), 1
        elif len(values) < 3 or "." in cells[0]:
            raise InputFileError(
                f"{where}: the latitude needs degrees, minutes and seconds, or decimal degrees "
                "alone"
            )
        else:
            degrees, minutes, seconds = (Fraction(cell) for cell in cells[:3])
            if not (0 <= minutes < 60 and 0 <= seconds < 60):
                raise InputFileError(
                    f"{where}: minutes or seconds of the latitude are not below 60"
                )
            size, after = abs(degrees) + minutes / 60 + seconds / 3600, 3
        if size > 90:
            raise InputFileError(f"{where}: a latitude of {float(size):g} deg is beyond the pole")
        # The sign stands in the text: -0 30 00 is south.
        self.keys["lat_deg"] = float(-size if cells[0].startswith("-") else size)
        if len(values) > after + _HEIGHT_AFTER:
            self.keys.setdefault("elevation_m", values[after + _HEIGHT_AFTER])

    def _observation(self, number: int, text: str) -> Row:
        where, cells = f"{self.path}:{number}", text.split()
        layout = layout_of(cells)
        if layout is None:
            raise InputFileError(
                f"{where}: columns of whole degrees and minutes are not read, because they could "
                "be decimal degrees; write decimal degrees, or degrees minutes seconds in twelve "
                "columns, minutes and seconds below 60"
            )
        if self.layout is None:
            self.layout = layout
        elif layout != self.layout:
            raise InputFileError(
                f"{where}: this observation is in {layout}, those above in {self.layout}; "
                "write all in one way"
            )
        row = (
            self._decimal_row(cells, where)
            if layout == DECIMAL
            else sexagesimal_row(cells, layout, where)
        )
        require_possible(row, where)
        return row

    def _decimal_row(self, cells: list[str], where: str) -> Row:
        values = all_numbers(cells, where)
        if len(values) < 4:
            raise InputFileError(
                f"{where}: {counted(len(values), 'number')} where an observation has four "
                "(azimuth, elevation, and both encoders, degrees)"
            )
        return (values[0], values[1], values[2], values[3])

    def _keep(self, number: int, row: Row | str, masked: bool) -> None:
        if isinstance(row, str):
            self.waiting.append((number, row))
        else:
            self.alone[len(self.lines)] = row
        self.masked.append(masked)
        self.lines.append(number)


def _latitude_text(latitude_deg: float) -> str:
    """Degrees, minutes and seconds, exact: a decimal degree is a finite decimal of a second."""
    size = abs(Fraction(repr(latitude_deg)))
    degrees, rest = divmod(size, 1)
    minutes, rest = divmod(rest * 60, 1)
    seconds = rest * 60
    digits = 0
    while seconds * 10**digits % 1:
        digits += 1
    text = f"{int(seconds * 10**digits):0{digits + 1}d}"
    shown = f"{text[:-digits]}.{text[-digits:]}" if digits else text
    return f"{'-' if latitude_deg < 0 else '+'}{int(degrees):02d} {int(minutes):02d} {shown}"


def _azimuth_texts(azimuth_deg: FloatArray) -> list[str]:
    # Rounded before the turn is taken off, so that no 360.0000000000 is written.
    turned = np.mod(np.round(azimuth_deg, _DECIMALS), 360.0).tolist()
    return ["" if np.isnan(a) else f"{a:0{_DECIMALS + 4}.{_DECIMALS}f}" for a in turned]


def _elevation_texts(elevation_deg: FloatArray) -> list[str]:
    return ["" if np.isnan(e) else f"{e:.{_DECIMALS}f}" for e in elevation_deg.tolist()]
