"""Points that several files hold: a copy, an earlier state, an export. Each counts once."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from solarcal.model.finding import Finding, points_named
from solarcal.model.repeats import ANGLES, contradicted, repeats
from solarcal.session.points import PointLabel, PointTable, table_of_points
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView

Loaded = tuple[PointTable, SessionView | None]


def counted_once(loaded: Sequence[Loaded]) -> tuple[list[Loaded], tuple[Finding, ...]]:
    """Files of one unit, each point in one of them only, with warnings of what they lost; and
    findings on readings of one instant that contradict each other.

    A unit's session has its points before other files, then the file with more of them. A file
    without points of its own is left out, records and all, and so is a session that another one
    continues. What a unit's session rejected or struck out is no point of another file either.
    """
    left: dict[int, Loaded] = dict(enumerate(loaded))
    said: list[str] = []
    for at, file in enumerate(loaded):
        longer = next((other for other in left.values() if _continues(other, file)), None)
        if longer is not None:
            del left[at]
            said.append(f"{_name(file)} is an earlier state of {_name(longer)}: it is not used")
    ranked = sorted(left, key=lambda at: (_of_no_unit(left[at]), -left[at][0].count("accepted")))
    withheld = [(at, table) for at in ranked if len(table := _withheld(left[at]))]
    owners = [*(at for at, _ in withheld), *ranked]
    tables = [*(table for _, table in withheld), *(left[at][0] for at in ranked)]
    found = list(_copies(tables, owners, len(withheld)))
    copies: dict[tuple[int, int, bool], list[int]] = {}
    for (late, row), (early, _), _ in found:
        key = (owners[late], owners[early], early < len(withheld))
        copies.setdefault(key, []).append(row)
    lost: dict[int, set[int]] = {}
    for (at, of, struck), rows in copies.items():
        lost.setdefault(at, set()).update(rows)
        labels = tuple(left[at][0].labels[row] for row in sorted(rows))
        one = len(rows) == 1
        counts = f"{'is' if one else 'are'} in {_name(left[of])} too, and count{'s' * one} once"
        if struck:
            counts = f"{'is' if one else 'are'} not used: not accepted, or struck out, in "
            counts += _name(left[of])
        said.append(f"{points_named(labels)} of {_name(left[at])} {counts}")
    contradictions = contradicted(
        (_label(tables, late), _label(tables, early), apart_deg)
        for late, early, apart_deg in found
        if early[0] >= len(withheld)
    )
    for at, gone in lost.items():
        table, session = left[at]
        own = table.rows([row for row in range(len(table)) if row not in gone])
        left[at] = (own, session)
        if not own.count("accepted") and len(left) > 1:
            del left[at]
    files = [left[at] for at in sorted(left)]
    table, session = files[0]
    files[0] = (replace(table, warnings=(*table.warnings, *said)), session)
    return files, contradictions


def _name(file: Loaded) -> str:
    table, session = file
    return table.sources[0] if session is None else session.path


def _label(tables: Sequence[PointTable], place: tuple[int, int]) -> PointLabel:
    table = tables[place[0]]
    return PointLabel(table.labels[place[1]], table.sources[place[1]])


def _of_no_unit(file: Loaded) -> bool:
    return file[1] is None or file[1].header.unit.imported


def _withheld(file: Loaded) -> PointTable:
    """The points of a unit's session that were rejected or struck out, as if accepted."""
    table, session = file
    if session is None or _of_no_unit(file):
        return table.rows([])
    used = {point.seq for point in session.accepted}
    found = [
        msgspec.structs.replace(record, status="accepted")
        for record in session.records
        if isinstance(record, PointRecord) and record.seq not in used
        if record.ideal_deg is not None and record.error_deg is not None
    ]
    return table_of_points(session.header, found, session.path)


def _continues(longer: Loaded, shorter: Loaded) -> bool:
    """Whether a session holds another's records and more."""
    (_, full), (_, begun) = longer, shorter
    if full is None or begun is None or len(full.records) <= len(begun.records):
        return False
    return full.header == begun.header and full.records[: len(begun.records)] == begun.records


def _copies(
    tables: Sequence[PointTable], owners: Sequence[int], withheld: int
) -> Iterator[tuple[tuple[int, int], tuple[int, int], float]]:
    """Accepted rows that stand in an earlier table of another file too: table and row, those of the
    other, and their difference. The first ``withheld`` tables lose none."""
    places = [
        (at, row)
        for at, table in enumerate(tables)
        for row, status in enumerate(table.status)
        if status == "accepted"
    ]
    used = [table.accepted() for table in tables]
    utc_s, *angles = (
        np.concatenate([getattr(table, name) for table in used]) for name in ("utc_s", *ANGLES)
    )
    # Without a sigma NaN, which is no reason for a difference.
    sigmas = [table.sigma_deg for table in used]
    sigma_deg = np.concatenate(
        [np.full(len(t), np.nan) if s is None else s for t, s in zip(used, sigmas, strict=True)]
    )
    for row, first, apart_deg in repeats(utc_s, np.column_stack(angles), sigma_deg):
        here, there = places[row], places[first]
        if here[0] >= withheld and owners[here[0]] != owners[there[0]]:
            yield here, there, apart_deg
