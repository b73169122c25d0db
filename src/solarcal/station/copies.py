"""Points that several files hold: a copy, an earlier state, an export. Each counts once."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from solarcal.model.finding import points_named
from solarcal.session.points import PointTable, table_of_points
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView

Loaded = tuple[PointTable, SessionView | None]

SAME_S = 1.0
"""A unit takes no two points within a second; a file may round its times by as much."""
SAME_DEG = 1e-3
"""To so much a file that a person wrote may round angles."""
SAME_UNDATED_DEG = 1e-4
"""The same where no time tells two points of one direction apart."""


def counted_once(loaded: Sequence[Loaded]) -> list[Loaded]:
    """Files of one unit, each point in one of them only, and warnings of what they lost.

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
    copies: dict[tuple[int, int, bool], list[int]] = {}
    for late, early, row in _copies(tables, owners, len(withheld)):
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
    for at, gone in lost.items():
        table, session = left[at]
        own = table.rows([row for row in range(len(table)) if row not in gone])
        left[at] = (own, session)
        if not own.count("accepted") and len(left) > 1:
            del left[at]
    files = [left[at] for at in sorted(left)]
    table, session = files[0]
    files[0] = (replace(table, warnings=(*table.warnings, *said)), session)
    return files


def _name(file: Loaded) -> str:
    table, session = file
    return table.sources[0] if session is None else session.path


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
) -> Iterator[tuple[int, int, int]]:
    """Accepted rows that stand in an earlier table of another file too: this table, the other, the
    row. The first ``withheld`` tables lose none."""
    places = [
        (at, row)
        for at, table in enumerate(tables)
        for row, status in enumerate(table.status)
        if status == "accepted"
    ]
    used = [table.accepted() for table in tables]
    utc_s = np.concatenate([table.utc_s for table in used])
    names = ("ax1_deg", "ax2_deg", "err1_deg", "err2_deg")
    angles = np.column_stack(
        [np.concatenate([getattr(table, name) for table in used]) for name in names]
    )
    order = np.argsort(angles[:, 0], kind="stable")
    along = angles[order, 0]
    first = np.searchsorted(along, along - SAME_DEG)
    last = np.searchsorted(along, along + SAME_DEG, side="right")
    for index in np.flatnonzero(last - first > 1).tolist():
        here = int(order[index])
        # Rows of earlier tables come first.
        near = np.sort(order[first[index] : last[index]])
        near = near[near < here]
        apart = np.abs(angles[near] - angles[here]).max(axis=1, initial=0.0)
        between_s = np.abs(utc_s[near] - utc_s[here])
        same = (between_s <= SAME_S) & (apart <= SAME_DEG)
        same |= np.isnan(between_s) & (apart <= SAME_UNDATED_DEG)
        at, row = places[here]
        for other in near[same].tolist():
            if at >= withheld and owners[places[other][0]] != owners[at]:
                yield at, places[other][0], row
                break
