"""Points from and to other programs' files."""

from pathlib import Path
from typing import TypedDict, Unpack, cast

from solarcal.errors import ConfigurationError
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.session.interchange.pmfit import read_pmfit
from solarcal.session.interchange.sniffing import (
    OFFSETS,
    PMFIT,
    POINTS_CSV,
    SESSION,
    point_format,
)
from solarcal.session.interchange.solar_offsets import read_solar_offsets
from solarcal.session.interchange.tpoint import read_tpoint, write_tpoint
from solarcal.session.points import PointTable, table_from_session
from solarcal.session.reader import read_session


class UnitFillIn(TypedDict, total=False):
    """What the command line knows of the unit and a file may lack."""

    geometry: str | None
    latitude_deg: float | None
    longitude_deg: float | None
    elevation_m: float | None
    unit: str | None
    ideal: str | None


class FillIn(UnitFillIn, total=False):
    """The same, and what the numbers of a solaris-pointing file are."""

    offsets: str | None


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
    if found == OFFSETS:
        return read_solar_offsets(path, **fill_in)
    unit = {key: value for key, value in fill_in.items() if key != "offsets"}
    reader = {POINTS_CSV: read_points_csv, PMFIT: read_pmfit}.get(found, read_tpoint)
    return reader(path, **cast(UnitFillIn, unit))


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
