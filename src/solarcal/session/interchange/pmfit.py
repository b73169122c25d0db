"""PMFIT pointing data (``.dat``): what the fitting program of the SPK pointing kernel reads.

    caption
    A                            mount: A altazimuth (E, equatorial, is not read)
    -30.240667                   latitude, decimal degrees
    az el az_enc el_enc [...]    degrees, azimuth from North through East: observed place, demands

No comments and no END line; a fifth number of a row is passed over.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

from solarcal.errors import InputFileError
from solarcal.input_files import read_text
from solarcal.session.interchange.altaz import (
    DECIMAL,
    Row,
    altaz_table,
    many_rows,
    plain_numbers,
    possible,
    refuse_radians,
)
from solarcal.session.interchange.csv_head import UnitFillIn
from solarcal.session.points import PointTable
from solarcal.units import FloatArray

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
    cells = line.split()
    values = plain_numbers(cells)
    if len(values) < len(cells):
        raise InputFileError(
            f"{where}: {cells[len(values)][:20]!r} (number {len(values) + 1} of the line) "
            "is not a number"
        )
    if len(values) not in _COLUMNS:
        raise InputFileError(
            f"{where}: {len(values)} numbers where an observation has four or five "
            "(azimuth, elevation, both demands, degrees)"
        )
    if not possible(values):
        raise InputFileError(
            f"{where}: azimuths must lie within -360..720 and elevations within -90..90 deg "
            "(demands -270..270)"
        )
    return (values[0], values[1], values[2], values[3])
