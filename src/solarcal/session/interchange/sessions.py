"""Imported points as a session file of their own."""

from pathlib import Path
from typing import Any

import numpy as np

from solarcal import __version__
from solarcal.errors import ConfigurationError, SessionFileError
from solarcal.mount.drive import RotaryDrive
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.session.interchange.csv_head import instant_text
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
from solarcal.session.view import SessionView, view_session
from solarcal.site import Site
from solarcal.timescale import format_utc
from solarcal.units import FloatArray


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
            Path(path).unlink(missing_ok=True)
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
