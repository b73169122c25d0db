"""Points from and to other programs' files."""

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack, cast

from solarcal.errors import ConfigurationError
from solarcal.session.interchange.csv_head import UnitFillIn
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.session.interchange.paint import PaintFiles, paint_files, paint_table
from solarcal.session.interchange.pmfit import read_pmfit
from solarcal.session.interchange.sniffing import (
    OFFSETS,
    PAINT_CALIBRATION,
    PMFIT,
    POINTS_CSV,
    SESSION,
    point_format,
)
from solarcal.session.interchange.solar_offsets import read_solar_offsets
from solarcal.session.interchange.tpoint import read_tpoint, write_tpoint
from solarcal.session.points import PointTable, table_from_session
from solarcal.session.reader import read_session

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
        return table_from_session(read_session(path))
    if found == PAINT_CALIBRATION:
        return paint_table(read_paint([path], fill_in), unit=fill_in.get("unit"))
    unit = {key: value for key, value in fill_in.items() if key not in _NOT_OF_A_UNIT}
    if found == OFFSETS:
        return read_solar_offsets(path, offsets=fill_in.get("offsets"), **cast(UnitFillIn, unit))
    reader = {POINTS_CSV: read_points_csv, PMFIT: read_pmfit}.get(found, read_tpoint)
    return reader(path, **cast(UnitFillIn, unit))


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
