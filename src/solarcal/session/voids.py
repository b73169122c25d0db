"""Records that are struck out: which count, and which can be struck."""

from collections.abc import Sequence

from solarcal.errors import SessionFileError
from solarcal.session.records import (
    CheckRecord,
    Header,
    InForce,
    PointRecord,
    Record,
    Restarted,
    SunOffset,
    UploadBegun,
    UploadRecord,
    Void,
)

_OBSERVED = (InForce, Restarted, UploadBegun, UploadRecord)
"""What the unit was seen to hold or to do: no person took or typed it."""

TAKEN_BACK = "Set Sun Offset taken back"
"""How the reason of a void begins with which the unit was given the O of before again."""


def live_records(records: Sequence[Record]) -> tuple[Record, ...]:
    """The records that no void strikes, in order. A struck void strikes nothing itself."""
    struck: set[int] = set()
    # A void strikes what came before it, so that backwards every void is judged in time.
    for record in reversed(records):
        if isinstance(record, Void) and record.seq not in struck:
            struck.add(record.voids)
    return tuple(record for record in records if record.seq not in struck)


def offsets_struck(records: Sequence[Record], live: Sequence[Record]) -> dict[int, int]:
    """Accepted points and checks taken on a Set Sun Offset that is struck out, and its record."""
    if len(live) == len(records):
        return {}
    offsets = {r.instant: r.seq for r in records if isinstance(r, SunOffset)}
    for record in live:
        if isinstance(record, SunOffset):
            offsets.pop(record.instant, None)
    return {
        r.seq: offsets[r.read_utc]
        for r in live
        if isinstance(r, PointRecord | CheckRecord)
        and r.status == "accepted"
        and getattr(r, "basis", "sun_offset") == "sun_offset"
        and r.read_utc in offsets
    }


def refuse_void(header: Header, records: Sequence[Record], seq: int) -> None:
    """Say no to a void that would strike nothing, or what the unit was seen to hold or to do.

    Raises
    ------
    SessionFileError
        ``seq`` is the header's, no record's, one that is void already, or of a kind that no person
        took or typed.
    """
    if seq == header.seq:
        raise SessionFileError(f"record {seq} is the header, which cannot be voided")
    if all(record.seq != seq for record in records):
        last = records[-1].seq if records else header.seq
        raise SessionFileError(f"there is no record {seq} in this session (the last is {last})")
    for record in records:
        if record.seq == seq and isinstance(record, _OBSERVED):
            raise SessionFileError(
                f"record {seq} says what the unit was seen to hold or to do: it cannot be voided; "
                "a note can explain it"
            )
    live = live_records(records)
    if all(record.seq != seq for record in live):
        by = [r.seq for r in live if isinstance(r, Void) and r.voids == seq]
        raise SessionFileError(
            f"record {seq} is void already; to restore it, void record {by[0]} instead"
        )
