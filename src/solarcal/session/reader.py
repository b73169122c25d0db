"""A session file read, whether or not a program is still writing it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solarcal.errors import SessionFileError
from solarcal.input_files import read_bytes
from solarcal.session.lines import parse_session
from solarcal.session.records import Closed, Header, PointRecord, Record, SunOffset, Void
from solarcal.units import wrap_deg

_SAME_DEG = 1e-4
"""Numbers rounded to 1e-5 deg or to the read-out's digits, of which one follows from the others."""


UNCLOSED = "was not closed: the session goes on, or its end is missing"


@dataclass(frozen=True, slots=True)
class Session:
    """A session as its file tells it. ``records`` are all of them, without the header."""

    path: str
    header: Header
    records: tuple[Record, ...]
    warnings: tuple[str, ...] = ()


def read_session(path: str | Path) -> Session:
    """Read a session file. What is wrong with it and can be lived with is in ``warnings``: a torn
    line, an end that is missing, a record that contradicts itself.

    Raises
    ------
    SessionFileError
        Missing, unreadable, a bad line (named), or a format of the future.
    """
    content = read_bytes(path, error=SessionFileError)
    return session_of(content, str(path))


def session_of(content: bytes, name: str) -> Session:
    """The session a file's bytes hold; ``name`` is what messages call the file.

    Raises
    ------
    SessionFileError
        A bad line (named), or a format of the future.
    """
    text = parse_session(content, name)
    warnings = [*text.warnings, *contradictions(text.header, text.records, name)]
    if not any(isinstance(record, Closed) for record in text.records):
        warnings.append(f"{name} {UNCLOSED}")
    return Session(name, text.header, tuple(text.records), tuple(warnings))


def contradictions(header: Header, records: Sequence[Record], name: str) -> Iterator[str]:
    """Records in which a number does not agree with the others it can be had from."""
    offsets = {r.instant: r for r in records if isinstance(r, SunOffset)}
    found = [record for record in records if isinstance(record, PointRecord)]
    parts = [
        (record.seq, axis, *numbers)
        for record in found
        if record.reading_deg and record.ideal_deg and record.error_deg
        for axis, numbers in enumerate(
            zip(record.reading_deg, record.ideal_deg, record.error_deg, strict=True), start=1
        )
    ]
    if parts and not header.unit.typed:
        _, _, reading, ideal, error = np.array(parts).T
        for at in np.flatnonzero(np.abs(wrap_deg(reading - ideal - error)) > _SAME_DEG).tolist():
            seq, axis, *numbers = parts[at]
            yield (
                f"{name}: point {seq}: reading {numbers[0]:.5f} - ideal {numbers[1]:.5f} of "
                f"axis {axis} is not the recorded error {numbers[2]:.5f} deg"
            )
    for record in found:
        offset = offsets.get(record.read_utc or "")
        if record.basis == "sun_offset" and offset is not None:
            for what in ("ideal_deg", "reading_deg", "counts", "offsets"):
                if getattr(record, what) != getattr(offset, what):
                    yield (
                        f"{name}: point {record.seq}: its {what} are not those of the Set Sun "
                        f"Offset it was taken on, record {offset.seq}"
                    )


def live_records(source: Session | tuple[Record, ...] | list[Record]) -> tuple[Record, ...]:
    """The records that no void strikes, in order. A struck void strikes nothing itself."""
    records = source.records if isinstance(source, Session) else source
    struck: set[int] = set()
    # A void strikes what came before it, so that backwards every void is judged in time.
    for record in reversed(records):
        if isinstance(record, Void) and record.seq not in struck:
            struck.add(record.voids)
    return tuple(record for record in records if record.seq not in struck)


def points(source: Session | tuple[Record, ...] | list[Record]) -> tuple[PointRecord, ...]:
    """The live data points, whatever their status."""
    return tuple(r for r in live_records(source) if isinstance(r, PointRecord))


def refuse_void(header: Header, records: tuple[Record, ...] | list[Record], seq: int) -> None:
    """Say no to a void that would strike nothing.

    Raises
    ------
    SessionFileError
        ``seq`` is the header's, no record's, or one that is void already.
    """
    if seq == header.seq:
        raise SessionFileError(f"record {seq} is the header, which cannot be voided")
    if all(record.seq != seq for record in records):
        last = records[-1].seq if records else header.seq
        raise SessionFileError(f"there is no record {seq} in this session (the last is {last})")
    if all(record.seq != seq for record in live_records(records)):
        by = [r.seq for r in live_records(records) if isinstance(r, Void) and r.voids == seq]
        raise SessionFileError(
            f"record {seq} is void already; to restore it, void record {by[0]} instead"
        )
