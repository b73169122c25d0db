"""A session file read, whether or not a program is still writing it."""

from dataclasses import dataclass
from pathlib import Path

from solarcal.errors import SessionFileError
from solarcal.input_files import read_bytes
from solarcal.session.lines import parse_session
from solarcal.session.records import Header, PointRecord, Record, Void


@dataclass(frozen=True, slots=True)
class Session:
    """A session as its file tells it. ``records`` are all of them, without the header."""

    path: str
    header: Header
    records: tuple[Record, ...]
    warnings: tuple[str, ...] = ()


def read_session(path: str | Path) -> Session:
    """Read a session file. A torn last line is ignored and reported in ``warnings``.

    Raises
    ------
    SessionFileError
        Missing, unreadable, a bad line (named), or a format of the future.
    """
    content = read_bytes(path, error=SessionFileError)
    text = parse_session(content, str(path))
    return Session(str(path), text.header, tuple(text.records), tuple(text.warnings))


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
