"""Points from and to other programs' files: what a file is, and its points as a session of ours.

The bytes at its beginning say what a file is.
"""

import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Unpack, cast

import numpy as np

from solarcal import __version__
from solarcal.errors import ConfigurationError, InputFileError, SessionFileError
from solarcal.input_files import STANDARD_INPUT, read_beginning
from solarcal.mount.drive import RotaryDrive
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.session.interchange.altaz import read_pmfit
from solarcal.session.interchange.csv_head import SEPARATOR_LINE, UnitFillIn, instant_text
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.session.interchange.paint import PaintFiles, paint_files, paint_table
from solarcal.session.interchange.solar_offsets import Offsets, read_solar_offsets
from solarcal.session.interchange.tpoint import read_tpoint, write_tpoint
from solarcal.session.journal import Journal
from solarcal.session.points import NUMBERS, PointTable
from solarcal.session.records import (
    IMPORTED_MODEL,
    Answers,
    Closed,
    Header,
    PointRecord,
    Record,
    UnitRecord,
)
from solarcal.session.view import SessionView, read_session, view_session
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.stopping_rule import DEFAULT_UNMODELLED
from solarcal.timescale import format_utc
from solarcal.units import FloatArray

_LOOKED_AT = 65536
_CSV_NAMES = {"utc", "ax1_deg", "ax2_deg"}
_OFFSET_NAMES = {"timestamp", "azimuth", "elevation", "offset_az", "offset_el"}


@dataclass(frozen=True, slots=True)
class Format:
    """A kind of file: what it is called, its endings, and what to do with one met elsewhere."""

    name: str
    endings: tuple[str, ...]
    advice: str


SESSION = Format("session", (".jsonl",), "name it .jsonl")
POINTS_CSV = Format("points CSV", (".csv",), "name it .csv")
TPOINT = Format("TPOINT pointing file", (".dat",), "name it .dat")
PMFIT = Format("PMFIT file", (".dat",), "name it .dat")
TPOINT_MODEL = Format(
    "TPOINT model", (".mod",), "give the observations to fit and the model to --compare"
)
OFFSETS = Format("solaris-pointing offsets file", (".tsv", ".txt"), "name it .tsv")
PAINT_CALIBRATION = Format("PAINT calibration record", (".json",), "name it .json")
PAINT_HELIOSTAT = Format(
    "PAINT heliostat properties file",
    (),
    "give the calibration records to fit and it to --heliostat",
)
PAINT_TOWER = Format(
    "PAINT tower measurements file", (), "give the calibration records to fit and it to --tower"
)

POINT_FORMATS = (SESSION, POINTS_CSV, TPOINT, PMFIT, OFFSETS, PAINT_CALIBRATION)


def point_format(path: str | Path) -> Format:
    """The format in which to read points from a file: known by its ending, checked by its text.

    Standard input has no ending: its text decides. A file whose text is of no known kind is left
    to the reader of its ending, which names the line at fault.

    Raises
    ------
    InputFileError
        The file is missing, cannot be read, or is in a known format but not the one asked for.
    ConfigurationError
        The ending is none that points are read from.
    """
    ending = Path(path).suffix.lower()
    nameless = str(path) == STANDARD_INPUT
    asked = [known for known in POINT_FORMATS if nameless or ending in known.endings]
    found = recognised(read_beginning(path, _LOOKED_AT).decode("utf-8-sig", errors="replace"))
    if found in asked:
        return found
    if found is not None:
        raise InputFileError(f"{path}: this looks like a {found.name}; {found.advice}")
    if nameless:
        raise InputFileError(
            "standard input is in no format that points are read from (docs/formats.md)"
        )
    if not asked:
        endings = sorted({ending for known in POINT_FORMATS for ending in known.endings})
        raise ConfigurationError(
            f"{path}: points are read from files ending in {', '.join(endings)} "
            "(docs/formats.md describes them)"
        )
    return asked[0]


def recognised(text: str) -> Format | None:
    """The format whose first lines these are; None for no known one."""
    lines = [bare for line in text.splitlines() if (bare := line.strip())]
    if not lines:
        return None
    if lines[0].startswith("{"):
        return _json_kind(text, lines[0])
    separator = ","
    if named := SEPARATOR_LINE.fullmatch(text.splitlines()[0].strip('"')):
        separator, lines = named[1], lines[1:]
    header = next((line for line in lines if not line.strip('"').startswith("#")), "")
    if {cell.strip(' "').lower() for cell in header.split(separator)} >= _CSV_NAMES:
        return POINTS_CSV
    if {cell.strip().lower() for cell in header.split("\t")} >= _OFFSET_NAMES:
        return OFFSETS
    plain = [line for line in lines if not line.startswith(("!", "#", ";"))]
    if any(line.startswith(":") for line in plain[:6]):
        return TPOINT
    if len(plain) >= 3 and plain[1].upper() in ("A", "E") and _is_number(plain[2]):
        return PMFIT
    if len(plain) >= 2 and _starts_a_model(plain[1].split()):
        return TPOINT_MODEL
    return None


def _json_kind(text: str, first_line: str) -> Format | None:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        # A session is one document a line; a torn or damaged one still shows its first.
        return SESSION if '"type"' in first_line and '"header"' in first_line else None
    if not isinstance(document, dict):
        return None
    if document.get("type") == "header":
        return SESSION
    if "focal_spot" in document or "motor_position" in document:
        return PAINT_CALIBRATION
    if "kinematic_properties" in document:
        return PAINT_HELIOSTAT
    return PAINT_TOWER if "power_plant_properties" in document else None


def _starts_a_model(cells: list[str]) -> bool:
    """Method, number of observations, sky rms, refraction constants."""
    return len(cells) >= 3 and cells[0].isalpha() and all(map(_is_number, cells[1:]))


def _is_number(text: str) -> bool:
    try:
        return text.isascii() and float(text) == float(text)
    except ValueError:
        return False


_NOT_OF_A_UNIT = ("offsets", "heliostat", "tower", "spot")


class FillIn(UnitFillIn, total=False):
    """``UnitFillIn``, what the numbers of an offsets file are, and what PAINT records need."""

    offsets: Offsets | None
    heliostat: str | Path | None
    tower: str | Path | None
    spot: str | None


def read_table(path: str | Path, **fill_in: Unpack[FillIn]) -> PointTable:
    """Points of a file in any of the formats of ``docs/formats.md``, recognised by its text.

    ``fill_in`` completes files of other programs where they are silent.

    Raises
    ------
    ConfigurationError
        An ending that points are not read from.
    InputFileError
        The file is missing, cannot be read, or is in another format than its ending says.
    """
    found = point_format(path)
    if found == SESSION:
        return read_session(path).table
    if found == PAINT_CALIBRATION:
        return paint_table(read_paint([path], fill_in), unit=fill_in.get("unit"))
    unit = {key: value for key, value in fill_in.items() if key not in _NOT_OF_A_UNIT}
    if found == OFFSETS:
        return read_solar_offsets(path, offsets=fill_in.get("offsets"), **cast(UnitFillIn, unit))
    readers: dict[Format, Callable[..., PointTable]]
    readers = {POINTS_CSV: read_points_csv, PMFIT: read_pmfit}
    return readers.get(found, read_tpoint)(path, **cast(UnitFillIn, unit))


def read_paint(paths: Sequence[str | Path], fill_in: FillIn) -> PaintFiles:
    """PAINT records of one heliostat with the files that belong to them."""
    return paint_files(
        paths,
        heliostat=fill_in.get("heliostat"),
        tower=fill_in.get("tower"),
        spot=fill_in.get("spot"),
    )


def is_paint(path: str | Path) -> bool:
    """Whether a file is a PAINT calibration record."""
    may_be = str(path) == STANDARD_INPUT or Path(path).suffix.lower() == ".json"
    return may_be and point_format(path) == PAINT_CALIBRATION


def write_table(table: PointTable, path: str | Path) -> None:
    """Write a points ``.csv`` or TPOINT ``.dat`` file, by its ending; replaces an older one.

    Raises
    ------
    ConfigurationError
        Another ending, a table the format cannot hold, or the file cannot be written.
    """
    ending = Path(path).suffix.lower()
    if ending == ".csv":
        write_points_csv(table, path)
    elif ending == ".dat":
        write_tpoint(table, path)
    else:
        raise ConfigurationError(f"{path}: points are written as .csv or .dat (TPOINT) files")


def session_from_table(table: PointTable, path: str | Path, *, utc_s: float) -> SessionView:
    """Write a new session file that holds the table's points, in order.

    Its table gives the same numbers back; labels become sequence numbers.
    ``utc_s`` is now: when the import was made. Drives, limits and reference positions are unknown,
    so the unit's record holds a unit gear ratio and the whole branch.

    Raises
    ------
    ConfigurationError
        An instant the file could not hold (beyond the year 9999).
    SessionFileError
        The file exists or cannot be written.
    """
    header = imported_header(table, utc_s)
    points = imported_points(table, header)
    end = Closed(seq=header.seq + len(points) + 1, utc=header.utc, reason="imported")
    records: tuple[Record, ...] = (*points, end)
    with Journal.create(path, header) as journal:
        try:
            journal.append_all(records)
        except SessionFileError:
            # Half an import must not pass for a session; nobody was told of the file yet.
            with suppress(OSError):
                Path(path).unlink()
            raise
    return view_session(header, records, str(path))


def imported_header(table: PointTable, utc_s: float) -> Header:
    """The header of an imported session; its unit model is ``imported``."""
    site = Site(table.latitude_deg or 0.0, table.longitude_deg or 0.0, table.elevation_m)
    given = {"latitude": table.latitude_deg, "longitude": table.longitude_deg}
    centre = table.ax1_centre_deg
    unit = UnitRecord(
        model=IMPORTED_MODEL,
        serial=table.unit,
        firmware="",
        zone_west_h=0.0,
        drive1=RotaryDrive(counts_per_deg=1.0),
        drive2=RotaryDrive(counts_per_deg=1.0),
        limits=Limits(
            axis1=AxisLimits(low_deg=centre - 180.0, high_deg=centre + 180.0),
            axis2=AxisLimits(low_deg=0.0, high_deg=180.0),
        ),
        update_range_deg=0.0,
        reference1_deg=0.0,
        reference2_deg=0.0,
        tilt_decimals=4,
        scale_decimals=6,
        site=site,
        heliostat=table.heliostat,
    )
    return Header(
        utc=format_utc(utc_s),
        software=f"solarcal {__version__}",
        unit=unit,
        site=site,
        geometry=table.geometry,
        ax1_centre_deg=centre,
        sun_model=table.ideal,
        # As a fit of the file takes it that this session is made of.
        weather=Weather(standard_pressure_hpa(site.elevation_m)),
        unmodelled=DEFAULT_UNMODELLED,
        unknown=tuple(name for name, value in given.items() if value is None),
    )


def imported_points(table: PointTable, header: Header) -> list[PointRecord]:
    """One record per row. Which questions were asked is not known: the answers are null."""
    numbers: dict[str, FloatArray] = {
        name: column for name in NUMBERS if (column := getattr(table, name)) is not None
    }
    columns = zip(
        table.utc_s.tolist(),
        table.ax1_deg.tolist(),
        table.ax2_deg.tolist(),
        table.err1_deg.tolist(),
        table.err2_deg.tolist(),
        table.status,
        table.approach,
        table.note,
        strict=True,
    )
    records = []
    for at, row in enumerate(columns):
        utc_s, ax1, ax2, err1, err2, status, approach, note = row
        own: dict[str, Any] = {
            name: float(column[at]) for name, column in numbers.items() if not np.isnan(column[at])
        }
        records.append(
            PointRecord(
                seq=header.seq + 1 + at,
                utc=header.utc,
                status=status,
                answers=Answers(),
                reason=note,
                read_utc=None if np.isnan(utc_s) else _instant(utc_s),
                ideal_deg=None if np.isnan(ax1 + ax2) else (ax1, ax2),
                error_deg=None if np.isnan(err1 + err2) else (err1, err2),
                approach=None if approach == (0, 0) else approach,
                **own,
            )
        )
    return records


def _instant(utc_s: float) -> str:
    try:
        return instant_text(utc_s)
    except (ValueError, OverflowError, OSError):
        raise ConfigurationError(f"{utc_s!r} s since 1970 is no instant a file can hold") from None
