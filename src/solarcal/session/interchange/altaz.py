"""What files of alt-azimuth telescopes share: numbers, layouts of a row, native angles.

A row gives azimuth and elevation of the true place, then of the encoders, azimuth from North
through East. In native angles AX1 = 180 - A and AX2 = 90 - E; errors are encoder minus true.

PMFIT pointing data (``.dat``) is no more than that, what the fitting program of the SPK pointing
kernel reads:

    caption
    A                            mount: A altazimuth (E, equatorial, is not read)
    -30.240667                   latitude, decimal degrees
    az el az_enc el_enc [...]    degrees, azimuth from North through East: observed place, demands

No comments and no END line; a fifth number of a row is passed over.
"""

import re
import warnings
from collections.abc import Collection, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Unpack

import numpy as np

from solarcal.decimals import counted
from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import read_text
from solarcal.session.interchange.csv_head import UnitFillIn, complete_head
from solarcal.session.points import PointTable
from solarcal.units import FloatArray, wrap_deg

Row = tuple[float, float, float, float]

DECIMAL, SPACED, COLONS = "decimal degrees", "degrees minutes seconds", "degrees:minutes:seconds"

# Bounded, so that no line can ask for a number of a million digits.
_NUMBER = re.compile(r"[+-]?(?=\.?[0-9])[0-9]{0,30}(\.[0-9]{0,400})?([eE][+-]?[0-9]{1,2})?")
_SIXTIETHS, _LAST = r"[0-5]?[0-9]", r"[0-5]?[0-9](?:\.[0-9]{0,400})?"
_SPACED = re.compile(" ".join([rf"[+-]?[0-9]{{1,3}} {_SIXTIETHS} {_LAST}"] * 4))
_WHOLE_COLONS = re.compile(" ".join([rf"[+-]?[0-9]{{1,3}}:{_SIXTIETHS}:{_LAST}"] * 4))
_TWO_COLUMNS = re.compile(" ".join([rf"[+-]?[0-9]{{1,3}} {_LAST}"] * 4))
_COLONS = re.compile(r"[+-]?[0-9]{1,3}:[0-9]{1,2}(:[0-9]{1,2}(\.[0-9]{0,20})?)?")
_FURTHEST_APART_DEG = 10.0
_MANY_DIGITS = re.compile("[0-9]{31}")
_PLAIN = b"0123456789+-. "
"""What decimal numbers without an exponent are written with."""
_FEWEST_TO_JUDGE = 3
# Azimuth, elevation, and both of the encoders, degrees.
_LEAST, _MOST = (-360.0, -90.0, -360.0, -270.0), (720.0, 90.0, 720.0, 270.0)


def plain_numbers(cells: Sequence[str]) -> list[float]:
    """The leading cells that are plain decimal numbers."""
    return [float(cell) for cell in takewhile(_NUMBER.fullmatch, cells)]


def all_numbers(cells: Sequence[str], where: str) -> list[float]:
    """The cells of a row; InputFileError names the first that is no plain decimal number."""
    values = plain_numbers(cells)
    if len(values) < len(cells):
        raise InputFileError(
            f"{where}: {cells[len(values)][:20]!r} (number {len(values) + 1} of the line) "
            "is not a number"
        )
    return values


def require_possible(row: Sequence[float], where: str, encoders: str = "encoders") -> None:
    """Refuse four angles that cannot be an observation, degrees."""
    if not possible(row):
        raise InputFileError(
            f"{where}: azimuths must lie within -360..720 and elevations within -90..90 deg "
            f"({encoders} -270..270)"
        )


def possible(row: Sequence[float]) -> bool:
    """Whether four angles can be an observation, degrees."""
    within = zip(_LEAST, row, _MOST, strict=False)
    return all(least <= angle <= most for least, angle, most in within)


def layout_of(cells: Sequence[str]) -> str | None:
    """How the angles of a row are written; None where no layout is certain.

    Twelve columns whose degrees and minutes are whole and whose minutes and seconds lie below 60
    are degrees, minutes, seconds. Eight columns of whole degrees and minutes could be that or
    decimal degrees with further numbers behind: no layout is certain.
    """
    if not cells:
        return None
    if any(":" in cell for cell in cells[:4]):
        return COLONS
    # A first cell with a point is a decimal degree: nothing else has to be looked at.
    if "." in cells[0] or len(cells) < 8:
        return DECIMAL
    if len(cells) >= 12 and _SPACED.fullmatch(" ".join(cells[:12])):
        return SPACED
    if _TWO_COLUMNS.fullmatch(" ".join(cells[:8])):
        return None
    # Twelve columns of degrees minutes seconds with a slip in one of them are no decimal degrees.
    if len(cells) >= 12 and all(cells[at].lstrip("+-").isdigit() for at in (0, 1, 3, 4)):
        return None
    return DECIMAL


def many_rows(
    texts: Sequence[str], layout: str, columns: Collection[int] = range(4, 8)
) -> FloatArray | None:
    """The angles of many rows of one layout at once, (n, 4) degrees: those of each row alone.

    ``columns``: how many decimal degrees a row may have, all rows as many. None where a row is not
    certainly as it should be: each is then to be read alone.
    """
    rows_text = [" ".join(text.split()) for text in texts]
    joined, width = " ".join(rows_text), 12
    if layout == DECIMAL:
        widths = {row.count(" ") + 1 for row in rows_text}
        width = min(widths, default=0)
        unsure = len(widths) > 1 or width not in columns or _MANY_DIGITS.search(joined)
        if unsure or not joined.isascii() or joined.encode().translate(None, _PLAIN):
            return None
    else:
        pattern = _SPACED if layout == SPACED else _WHOLE_COLONS
        if not all(map(pattern.fullmatch, rows_text)):
            return None
        joined = joined.replace(":", " ")
    try:
        with warnings.catch_warnings():
            # How older versions of numpy say that a cell is no number.
            warnings.simplefilter("error", DeprecationWarning)
            values = np.fromstring(joined, sep=" ")
    except (ValueError, DeprecationWarning):
        return None
    # Two numbers in one cell are one too many.
    if values.size != len(texts) * width:
        return None
    values = values.reshape(-1, width)
    if layout == DECIMAL:
        rows = values[:, :4]
    else:
        degrees, minutes, seconds = values[:, 0::3], values[:, 1::3], values[:, 2::3]
        # The sign of -0 is that of its text.
        rows = np.copysign(np.abs(degrees) + minutes / 60.0 + seconds / 3600.0, degrees)
        around = np.abs(rows[:, 0] - rows[:, 2]) % 360.0
        apart = np.maximum(np.minimum(around, 360.0 - around), np.abs(rows[:, 1] - rows[:, 3]))
        if apart.max() > _FURTHEST_APART_DEG:
            return None
    within = (np.array(_LEAST) <= rows) & (rows <= np.array(_MOST))
    return np.asarray(rows) if within.all() else None


def sexagesimal_row(cells: Sequence[str], layout: str, where: str) -> Row:
    """The four angles of a sexagesimal row, degrees; the sign is that of the degrees' text.

    Raises
    ------
    InputFileError
        A cell of another form, minutes or seconds from 60 on, or encoders so far from the true
        place that the columns must mean something else.
    """
    text = " ".join(cells[:4])
    if layout == COLONS and not _WHOLE_COLONS.fullmatch(text):
        angles = _colon_angles(cells[:4], where)
    else:
        if layout == COLONS:
            cells = text.replace(":", " ").split()
        values = list(map(float, cells[:12]))
        angles = [
            -size if cells[at].startswith("-") else size
            for at in range(0, 12, 3)
            for size in (abs(values[at]) + values[at + 1] / 60.0 + values[at + 2] / 3600.0,)
        ]
    row = (angles[0], angles[1], angles[2], angles[3])
    around = abs(row[0] - row[2]) % 360.0
    apart = max(min(around, 360.0 - around), abs(row[1] - row[3]))
    if apart > _FURTHEST_APART_DEG:
        raise InputFileError(
            f"{where}: read as {layout} the encoders are {apart:.0f} deg from the true place; "
            "the columns must be azimuth, elevation, encoder azimuth, encoder elevation, each as "
            "degrees minutes seconds (other sexagesimal layouts are not read; convert to "
            "decimal degrees)"
        )
    return row


def refuse_radians(rows: Sequence[Row] | FloatArray, path: str) -> None:
    """Refuse rows that can only be radians: azimuths within a turn, no elevation above pi/2."""
    if len(rows) < _FEWEST_TO_JUDGE:
        return
    angles = np.array(rows)
    azimuth, elevation = angles[:, 0], angles[:, 1]
    if (
        np.all(np.abs(angles[:, (0, 2)]) <= 2.0 * np.pi + 0.1)
        and np.all(np.abs(angles[:, (1, 3)]) <= np.pi / 2.0 + 0.1)
        and np.ptp(azimuth) > 0.2
        and np.ptp(elevation) > 0.05
    ):
        raise InputFileError(
            f"{path}: all elevations lie below {np.max(elevation):.2f} and all azimuths below "
            f"{np.max(azimuth):.2f}: this looks like radians; convert the angles to degrees"
        )


def altaz_table(
    path: str | Path,
    rows: Sequence[Row] | FloatArray,
    masked: Sequence[bool],
    lines: Sequence[int],
    *,
    keys: dict[str, str | float],
    fill_in: UnitFillIn,
    format_name: str,
    warnings: Sequence[str] = (),
) -> PointTable:
    """The points table of alt-azimuth rows. Masked rows have the status ``rejected``.

    The branch is centred on 0, south of the equator on 180. ``fill_in`` fills what ``keys`` of
    the file leave out.

    Raises
    ------
    ConfigurationError
        Another geometry than azel is asked for.
    """
    if fill_in.get("geometry") not in (None, "azel"):
        raise ConfigurationError(
            f"{path}: {format_name} files are of geometry azel, not {fill_in['geometry']}"
        )
    head = complete_head({"geometry": "azel", **keys}, path, fill_in)
    n = len(lines)
    columns: FloatArray = np.array(rows, dtype=np.float64).reshape(n, 4).T
    azimuth, elevation, azimuth_encoder, elevation_encoder = columns
    return PointTable(
        **head.of_unit(),
        utc_s=np.full(n, np.nan),
        ax1_deg=wrap_deg(180.0 - azimuth, head.ax1_centre_deg),
        ax2_deg=90.0 - elevation,
        err1_deg=wrap_deg(azimuth - azimuth_encoder),
        err2_deg=elevation - elevation_encoder,
        status=tuple("rejected" if mask else "accepted" for mask in masked),
        approach=((0, 0),) * n,
        note=("",) * n,
        labels=tuple(lines),
        sources=(str(path),) * n,
        warnings=(*warnings, *head.warnings),
    )


def _colon_angles(cells: Sequence[str], where: str) -> list[float]:
    """Four angles written d:m:s or d:m, degrees."""
    angles = []
    for number, cell in enumerate(cells, start=1):
        if not _COLONS.fullmatch(cell):
            raise InputFileError(
                f"{where}: {cell[:20]!r} (number {number} of the line) is not "
                "degrees:minutes:seconds"
            )
        degrees, *smaller = cell.split(":")
        sixtieths = [float(text) for text in smaller]
        if any(value >= 60.0 for value in sixtieths):
            raise InputFileError(f"{where}: minutes or seconds are not below 60")
        size = abs(float(degrees)) + sum(
            value / 60.0**place for place, value in enumerate(sixtieths, start=1)
        )
        angles.append(-size if degrees.startswith("-") else size)
    if len(angles) < 4:
        raise InputFileError(
            f"{where}: {len(angles)} angles where an observation has four "
            "(azimuth, elevation, and both encoders)"
        )
    return angles


_COLUMNS = (4, 5)


def read_pmfit(path: str | Path, **fill_in: Unpack[UnitFillIn]) -> PointTable:
    """Read a PMFIT file of an altazimuth mount; ``fill_in`` fills what it does not hold.

    Raises
    ------
    InputFileError
        An equatorial mount, a latitude or a row that is none (named by line), radians.
    ConfigurationError
        The geometry is given and not ``azel``.
    """
    lines = [
        (number, line.strip())
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip()
    ]
    if len(lines) < 3:
        raise InputFileError(
            f"{path}: a PMFIT file has a caption, the mount (A), the latitude, and observations"
        )
    (at_mount, mount), (at_latitude, latitude) = lines[1:3]
    if mount.upper() != "A":
        raise InputFileError(
            f"{path}:{at_mount}: mount {mount[:20]!r}: only altazimuth PMFIT files (A) are read"
        )
    numbers = plain_numbers(latitude.split())
    if len(numbers) != 1 or len(latitude.split()) != 1 or abs(numbers[0]) > 90.0:
        raise InputFileError(
            f"{path}:{at_latitude}: {latitude[:30]!r} is not a latitude in decimal degrees"
        )
    rows: Sequence[Row] | FloatArray | None
    rows = many_rows([line for _, line in lines[3:]], DECIMAL, _COLUMNS)
    if rows is None:
        rows = [_row(line, f"{path}:{number}") for number, line in lines[3:]]
    refuse_radians(rows, str(path))
    return altaz_table(
        path,
        rows,
        [False] * len(rows),
        [number for number, _ in lines[3:]],
        keys={"lat_deg": numbers[0]},
        fill_in=fill_in,
        format_name="PMFIT altazimuth",
    )


def _row(line: str, where: str) -> Row:
    values = all_numbers(line.split(), where)
    if len(values) not in _COLUMNS:
        raise InputFileError(
            f"{where}: {counted(len(values), 'number')} where an observation has four or five "
            "(azimuth, elevation, both demands, degrees)"
        )
    require_possible(values, where, "demands")
    return (values[0], values[1], values[2], values[3])
