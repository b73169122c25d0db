"""Points from and to other programs' files."""

from pathlib import Path
from typing import TypedDict, Unpack

from solarcal.errors import ConfigurationError
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.session.interchange.tpoint import read_tpoint, write_tpoint
from solarcal.session.points import PointTable, table_from_session
from solarcal.session.reader import read_session


class FillIn(TypedDict, total=False):
    """What the command line knows and a file may lack."""

    geometry: str | None
    latitude_deg: float | None
    longitude_deg: float | None
    elevation_m: float | None
    unit: str | None


def read_table(path: str | Path, **fill_in: Unpack[FillIn]) -> PointTable:
    """Points of a session ``.jsonl``, points ``.csv`` or TPOINT ``.dat`` file, by its ending.

    ``fill_in`` completes CSV and TPOINT files where they are silent.

    Raises
    ------
    ConfigurationError
        Another ending.
    InputFileError
        The file cannot be read.
    """
    ending = Path(path).suffix.lower()
    if ending == ".jsonl":
        return table_from_session(read_session(path))
    if ending == ".csv":
        return read_points_csv(path, **fill_in)
    if ending == ".dat":
        return read_tpoint(path, **fill_in)
    raise ConfigurationError(
        f"{path}: points are read from .jsonl (session), .csv and .dat (TPOINT) files"
    )


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
