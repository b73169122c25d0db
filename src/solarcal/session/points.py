"""Points as a table: what sessions, CSV and TPOINT files have in common.

Angles are degrees in the mount's native frame, AX1 on the branch; ``err = reading - ideal``.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solarcal.decimals import Pair
from solarcal.errors import InputFileError
from solarcal.optics.offset_mirror import Heliostat, format_mirror, format_target
from solarcal.session.records import Header, PointStatus
from solarcal.site import Site, longitude_apart_deg
from solarcal.timescale import parse_many_utc
from solarcal.units import FloatArray

Column: TypeAlias = FloatArray | tuple[Any, ...] | None

IDEALS = ("apparent", "airless", "solartrak")
STATUSES = ("accepted", "aborted", "rejected")

SITE_TOLERANCE_DEG = 0.01

NUMBERS = {"sigma_deg": (1e-9, 90.0)}
"""Numbers a point may have beside its angles, and between which limits.

Each is a field of the record, a column of the table, of a points CSV and of the points a fit takes;
a column without a number for every accepted point is None.
"""


class PointLabel(int):
    """The number of a point among several files: a sentence names its file with it."""

    source: str

    def __new__(cls, number: int, source: str) -> "PointLabel":
        label = super().__new__(cls, number)
        label.source = source
        return label

    def __reduce__(self) -> tuple[type["PointLabel"], tuple[int, str]]:
        return PointLabel, (int(self), self.source)

    def __str__(self) -> str:
        return f"{int(self)} of {self.source}"


# No slots: cached properties live in the instance's dictionary.
@dataclass(frozen=True, eq=False)
class PointTable:
    """Points of one unit. All columns have n rows, one per point or attempt.

    Attributes
    ----------
    geometry, unit : native frame; name of the unit ("" unknown).
    latitude_deg, longitude_deg : ``None`` where the file does not say.
    ideal : what the ideal angles are: ``apparent`` (no known physics is missing), ``airless``
        (refraction is) or ``solartrak`` (refraction and the ephemeris difference are).
    utc_s : NaN where the instant is not known, or says nothing about the angles: on the Moon.
    ax1_deg, ax2_deg, err1_deg, err2_deg : NaN only in rows that are not accepted.
    sigma_deg : on sky, per axis; given for every accepted row or ``None``.
    status : ``accepted``, ``aborted`` or ``rejected``. Only accepted rows are fitted.
    approach : sense of the last motion of each axis: +1, -1, 0 unknown.
    labels : line numbers of the file, or sequence numbers of the session.
    sources : the file of each row; a label is unique within its source.
    warnings : what the reader found to report.
    heliostat : target and mirror, where all angles are those of a mirror's normal.
    stamp_utc_s : when each row was taken, to be shown, where ``utc_s`` must not hold it.
    light : ``sun`` where the points are on the Sun or the Moon even without an instant.
    """

    geometry: str
    latitude_deg: float | None
    longitude_deg: float | None
    elevation_m: float
    unit: str
    ax1_centre_deg: float
    ideal: str
    utc_s: FloatArray
    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    status: tuple[str, ...]
    approach: tuple[tuple[int, int], ...]
    note: tuple[str, ...]
    labels: tuple[int, ...]
    sources: tuple[str, ...]
    sigma_deg: FloatArray | None = None
    warnings: tuple[str, ...] = ()
    heliostat: Heliostat | None = None
    stamp_utc_s: FloatArray | None = None
    light: str = ""

    def __len__(self) -> int:
        return len(self.labels)

    @cached_property
    def site(self) -> Site | None:
        """Where the unit stands, if the file says so."""
        if self.latitude_deg is None or self.longitude_deg is None:
            return None
        return Site(self.latitude_deg, self.longitude_deg, self.elevation_m)

    def count(self, status: str) -> int:
        """How many rows have this status."""
        return self.status.count(status)

    def rows(self, indices: Sequence[int] | NDArray[np.intp]) -> "PointTable":
        """The table of these rows only, in this order."""
        chosen = np.asarray(indices, dtype=np.intp)
        order = chosen.tolist()

        def of(column: Column) -> Any:
            if column is None:
                return None
            if isinstance(column, tuple):
                return tuple(column[i] for i in order)
            return column[chosen]

        return replace(self, **{name: of(getattr(self, name)) for name in COLUMNS})

    def accepted(self) -> "PointTable":
        """The rows that are fitted."""
        if self.count("accepted") == len(self.status):
            return self
        return self.rows([i for i, status in enumerate(self.status) if status == "accepted"])


COLUMNS = (
    "utc_s", "ax1_deg", "ax2_deg", "err1_deg", "err2_deg", *NUMBERS, "status", "approach", "note",
    "labels", "sources", "stamp_utc_s",
)  # fmt: skip
"""What a ``PointTable`` has one of for each row."""


def given_numbers(column: FloatArray, accepted: NDArray[np.bool_]) -> FloatArray | None:
    """One of the ``NUMBERS``, or None where an accepted row has none."""
    return None if np.isnan(column[accepted]).any() or np.isnan(column).all() else column


class _Attempt(Protocol):
    """What a record must have to be a row: a point's, a check point's, or that of a reader that
    looks at nothing else. Without an approach or a number of ``NUMBERS`` there is none known."""

    @property
    def seq(self) -> int: ...
    @property
    def utc(self) -> str: ...
    @property
    def read_utc(self) -> str | None: ...
    @property
    def status(self) -> PointStatus: ...
    @property
    def reason(self) -> str: ...
    @property
    def ideal_deg(self) -> Pair | None: ...
    @property
    def error_deg(self) -> Pair | None: ...


def table_of_points(
    header: Header, found: Sequence[_Attempt], source: str = "", warnings: tuple[str, ...] = ()
) -> PointTable:
    """The points of a session; labels are sequence numbers.

    ``utc_s`` is when the point's angles were read; attempts without angles have NaN.
    """
    accepted = np.array([p.status == "accepted" for p in found], dtype=bool)
    ideal = np.array([_pair(p.ideal_deg) for p in found]).reshape(-1, 2)
    error = np.array([_pair(p.error_deg) for p in found]).reshape(-1, 2)
    # The time of an import says nothing about when its points were taken, nor does that of an
    # attempt without angles.
    imported = header.unit.imported
    stamps = np.array(
        parse_many_utc(
            [p.read_utc or (None if imported or p.ideal_deg is None else p.utc) for p in found]
        ),
        dtype=np.float64,
    )
    numbers: dict[str, Any] = {
        name: given_numbers(
            np.array([getattr(p, name, None) for p in found], dtype=np.float64), accepted
        )
        for name in NUMBERS
    }
    return PointTable(
        geometry=header.geometry,
        latitude_deg=None if "latitude" in header.unknown else header.site.latitude_deg,
        longitude_deg=None if "longitude" in header.unknown else header.site.longitude_deg,
        elevation_m=header.site.elevation_m,
        unit=unit_name(header),
        ax1_centre_deg=header.ax1_centre_deg,
        ideal=ideal_kind(header),
        # What compares instants and angles would compare the Moon's with the Sun's.
        utc_s=np.full(len(found), np.nan) if header.target == "moon" else stamps,
        ax1_deg=ideal[:, 0],
        ax2_deg=ideal[:, 1],
        err1_deg=error[:, 0],
        err2_deg=error[:, 1],
        status=tuple(p.status for p in found),
        approach=tuple(getattr(p, "approach", None) or (0, 0) for p in found),
        note=tuple(p.reason for p in found),
        labels=tuple(p.seq for p in found),
        sources=(source,) * len(found),
        warnings=warnings,
        heliostat=header.unit.heliostat,
        stamp_utc_s=stamps if header.target == "moon" else None,
        **numbers,
    )


def unit_name(header: Header) -> str:
    """The unit as points files name it: model and serial number."""
    if header.unit.imported:
        return header.unit.serial
    return f"{header.unit.model} {header.unit.serial}".strip()


def merge_tables(tables: Sequence[PointTable]) -> PointTable:
    """Several files of one unit as one table, in the order given.

    Rows stay traceable by (source, label). Sigmas are kept only where every table has them.

    Raises
    ------
    InputFileError
        Tables that are not of one unit: see ``require_one_unit``.
    """
    require_one_unit(tables)
    first = tables[0]
    if len(tables) == 1:
        return first
    warnings = [text for t in tables for text in t.warnings]
    columns: dict[str, Any] = {}
    for name in COLUMNS:
        given = [column for t in tables if (column := getattr(t, name)) is not None]
        if len(given) < len(tables):
            columns[name] = None
            if name in NUMBERS and given:
                warnings.append(f"only some of the files give {name}: it was not used")
        elif isinstance(given[0], tuple):
            columns[name] = tuple(cell for column in given for cell in column)
        else:
            columns[name] = np.concatenate(given)
    columns["stamp_utc_s"] = np.concatenate(
        [t.utc_s if t.stamp_utc_s is None else t.stamp_utc_s for t in tables]
    )
    return replace(
        first,
        latitude_deg=next((t.latitude_deg for t in tables if t.latitude_deg is not None), None),
        longitude_deg=next((t.longitude_deg for t in tables if t.longitude_deg is not None), None),
        warnings=tuple(warnings),
        **columns,
    )


def labelled_by_file(tables: Sequence[PointTable]) -> tuple[PointTable, ...]:
    """The tables of several files with labels that name theirs; one alone as it is."""
    if len(tables) < 2:
        return tuple(tables)
    return tuple(
        replace(table, labels=tuple(map(PointLabel, table.labels, table.sources)))
        for table in tables
    )


def require_one_unit(tables: Sequence[PointTable]) -> None:
    """Refuse what cannot be merged.

    Raises
    ------
    InputFileError
        No table; a file given twice; or another unit, site, geometry, branch or kind of ideal
        angles in one of them.
    """
    if not tables:
        raise InputFileError("no points file was given")
    seen: set[str] = set()
    for table in tables:
        here = set(table.sources)
        if twice := seen & here:
            raise InputFileError(f"{min(twice)} was given twice; each point counts once")
        seen |= here
        _require_same_unit(tables[0], table)


def _require_same_unit(first: PointTable, other: PointTable) -> None:
    def name(table: PointTable) -> str:
        return table.sources[0] if table.sources else "an empty file"

    for what, a, b in (
        ("unit", first.unit or "unnamed", other.unit or "unnamed"),
        ("geometry", first.geometry, other.geometry),
        ("AX1 branch centre", first.ax1_centre_deg, other.ax1_centre_deg),
        ("kind of ideal angles", first.ideal, other.ideal),
        ("heliostat's target", _aim(first.heliostat), _aim(other.heliostat)),
    ):
        if a != b:
            raise InputFileError(
                f"{name(other)} is of another {what} than {name(first)} ({b}, not {a}); only "
                "files of one unit are merged"
            )
    for what, here, there in (
        ("latitude", first.latitude_deg, other.latitude_deg),
        ("longitude", first.longitude_deg, other.longitude_deg),
    ):
        if here is None or there is None:
            continue
        # Latitudes are never so far apart that it matters.
        if abs(longitude_apart_deg(here, there)) > SITE_TOLERANCE_DEG:
            raise InputFileError(
                f"{name(other)} is of another {what} than {name(first)} ({there:g}, not "
                f"{here:g} deg); only files of one unit in one place are merged"
            )


def _aim(heliostat: Heliostat | None) -> str:
    """Target and mirror as the wire and the points files write them."""
    if heliostat is None:
        return "none"
    mirror = format_mirror(heliostat.reduced_offset)
    return f"target {format_target(heliostat.target)}, mirror {mirror}"


def ideal_kind(header: Header) -> str:
    """What the ideal angles of a session are: one of `IDEALS`."""
    if header.refraction != "none" or header.target == "moon":
        return "apparent"
    # Before the word of an import: an emulated world may have the controller's own Sun.
    if header.true_sun == header.sun_model:
        return "airless" if header.weather.pressure_hpa else "apparent"
    if header.sun_model in IDEALS:
        return header.sun_model
    return "solartrak" if header.sun_model.startswith("solartrak") else "airless"


def _pair(pair: tuple[float, float] | None) -> tuple[float, float]:
    return (np.nan, np.nan) if pair is None else pair
