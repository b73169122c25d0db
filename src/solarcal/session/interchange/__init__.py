"""Points from and to other programs' files; what a file is, by what stands at its beginning."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack, cast

from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import read_beginning
from solarcal.session.interchange.altaz import read_pmfit
from solarcal.session.interchange.csv_head import SEPARATOR_LINE, UnitFillIn
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.session.interchange.paint import PaintFiles, paint_files, paint_table
from solarcal.session.interchange.solar_offsets import read_solar_offsets
from solarcal.session.interchange.tpoint import read_tpoint, write_tpoint
from solarcal.session.points import PointTable
from solarcal.session.view import read_session

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

    A file whose text is of no known kind is left to the reader of its ending, which names the
    line at fault.

    Raises
    ------
    InputFileError
        The file is missing, cannot be read, or is in a known format but not the one asked for.
    ConfigurationError
        The ending is none that points are read from.
    """
    ending = Path(path).suffix.lower()
    asked = [known for known in POINT_FORMATS if ending in known.endings]
    found = recognised(read_beginning(path, _LOOKED_AT).decode("utf-8-sig", errors="replace"))
    if found in asked:
        return found
    if found is not None:
        raise InputFileError(f"{path}: this looks like a {found.name}; {found.advice}")
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
    if "kinematic_properties" in document or "heliostat_position" in document:
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

    offsets: str | None
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
    return Path(path).suffix.lower() == ".json" and point_format(path) == PAINT_CALIBRATION


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
