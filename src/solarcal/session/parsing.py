"""A session file from its bytes: all of it with what is torn or contradicts itself, or its points.

Who reads thousands of files wants nothing but what a fit is made of: ``read_points_only`` looks at
the checksum of every line, decodes only the header, points and voids, and expects each sequence
number in its place. Of a file it cannot take at its word (an old format, a wrong checksum, a torn
line, a session that is still open) it says so, and the whole reader (``view.read_session``)
decides. So both give the same points of every file the whole reader accepts.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from solarcal.decimals import Pair
from solarcal.errors import ConfigurationError, SessionFileError, one_line
from solarcal.input_files import read_bytes
from solarcal.session.lines import (
    MISSING,
    TORN_START,
    check_stamps,
    damaged_lines,
    decode_record,
    nearly_sealed,
    opened,
    records_of,
)
from solarcal.session.points import PointTable, table_of_points
from solarcal.session.records import FORMAT_VERSION, Header, PointStatus, Record, Void

_HEADER_START = b'{"type":"header"'

# What a power cut leaves where a block of the file was never written.
_UNWRITTEN = b"\0\0"

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"


class _Torn(msgspec.Struct, frozen=True, tag="torn"):
    bytes: int


_torn_decoder = msgspec.json.Decoder(_Torn)


@dataclass(slots=True)
class SessionText:
    """A whole session file, understood. ``records`` are without the header.

    ``torn_start`` is the offset of an unfinished last line not yet declared, ``ended`` whether the
    file ends with a newline, ``size`` its length in bytes.
    """

    header: Header
    records: list[Record]
    warnings: list[str]
    size: int
    ended: bool
    torn_start: int | None


def parse_session(content: bytes, name: str) -> SessionText:
    """Read a session file's bytes; ``name`` is what messages call the file.

    Raises
    ------
    SessionFileError
        A bad line (named), no header, a format of the future.
    """
    reading = _Reading(name, content)
    # An editor's byte order mark is no part of the header.
    lines = content.removeprefix(_BYTE_ORDER_MARK).split(b"\n")
    reading.offset = len(content) - len(content.removeprefix(_BYTE_ORDER_MARK))
    for line, damage, record in zip(lines, damaged_lines(lines), records_of(lines), strict=True):
        reading.take(line, damage, record)
    return reading.finish()


@dataclass(slots=True)
class _Reading:
    """State of one pass over a file. ``records``, ``offsets`` and ``lines`` run in parallel."""

    name: str
    content: bytes
    number: int = 0
    offset: int = 0
    header: Header | None = None
    header_end: int = 0
    records: list[Record] = field(default_factory=list)
    offsets: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    # Whether the header has no checksum: format 1.
    unsealed: bool = False
    # First line that is no JSON, not declared torn so far: its number, offset and complaint.
    bad: tuple[int, int, str] | None = None

    def take(self, line: bytes, damage: str | None, record: Record | ValueError) -> None:
        """The next line, what is wrong with its checksum, and its record or why it has none."""
        self.number += 1
        start = self.offset
        self.offset += len(line) + 1
        if not line.strip():
            return
        if _UNWRITTEN in line:
            damage = MISSING
        if damage not in (None, MISSING):
            raise self._error(self.number, str(damage))
        if self.header is None:
            self.header = self._read_header(line, record)
            self.header_end = self.offset
            if damage == MISSING and self._checksums_due:
                raise self._error(self.number, MISSING)
            self.unsealed = damage == MISSING
            return
        if damage == MISSING and self._checksums_due:
            self._take_unsealed(line, start)
            return
        if line.startswith(TORN_START) and self._declare_torn(line, start):
            return
        if self.bad is not None:
            if not TORN_START.startswith(line) and not line.startswith(TORN_START):
                raise self._error(self.bad[0], self.bad[2])
            return
        if isinstance(record, ValueError):
            if isinstance(record, msgspec.ValidationError) or _is_json(line):
                raise self._error(self.number, str(record))
            self.bad = (self.number, start, f"not a JSON object ({one_line(str(record))})")
            return
        if isinstance(record, Header):
            raise self._error(self.number, "a second header")
        self.records.append(record)
        self.offsets.append(start)
        self.lines.append(self.number)

    @property
    def _checksums_due(self) -> bool:
        return self.header is not None and self.header.format >= 2

    def _take_unsealed(self, line: bytes, start: int) -> None:
        """A line that should end in a checksum and does not: cut, or changed."""
        if nearly_sealed(line) or _is_json(line):
            raise self._error(self.number, MISSING)
        if self.bad is None:
            self.bad = (self.number, start, MISSING)
        elif not TORN_START.startswith(line) and not line.startswith(TORN_START):
            raise self._error(self.bad[0], self.bad[2])

    def finish(self) -> SessionText:
        if self.header is None:
            raise SessionFileError(f"{self.name} is empty: no session was begun in it")
        try:
            check_stamps(self.records)
        except ConfigurationError:
            self._refuse_stamp()
        self._check_sequence()
        if self.unsealed:
            self.warnings.insert(
                0,
                f"{self.name} is of format {self.header.format}, without checksums: a changed "
                "byte in it can go unnoticed",
            )
        if self.bad is not None:
            self.warnings.append(
                f"{self.name}:{self.bad[0]}: the last line is torn and was ignored "
                "(the power or the disk failed while it was written)"
            )
        return SessionText(
            header=self.header,
            records=self.records,
            warnings=self.warnings,
            size=len(self.content),
            ended=self.content.endswith(b"\n"),
            torn_start=None if self.bad is None else self.bad[1],
        )

    def _declare_torn(self, line: bytes, start: int) -> bool:
        try:
            torn_start = start - _torn_decoder.decode(opened(line)).bytes
        except ValueError:
            return False
        fits = self.header_end <= torn_start < start and self.content[torn_start - 1] == 0x0A
        if not fits or (self.bad is not None and torn_start > self.bad[1]):
            raise self._error(self.number, "declares torn bytes that are not a line's")
        # A line that was written whole but whose sync failed was never acknowledged either.
        while self.offsets and self.offsets[-1] >= torn_start:
            del self.offsets[-1], self.records[-1], self.lines[-1]
        self.bad = None
        torn_line = self.content.count(b"\n", 0, torn_start) + 1
        self.warnings.append(f"{self.name}:{torn_line}: a line torn while written was ignored")
        return True

    def _read_header(self, line: bytes, record: Record | ValueError) -> Header:
        try:
            raw: Any = msgspec.json.decode(line)
        except (ValueError, RecursionError):
            if nearly_sealed(line):
                raise self._error(self.number, MISSING) from None
            if line[: len(_HEADER_START)] == _HEADER_START[: len(line)]:
                raise self._error(
                    self.number, "no complete session header; nothing was recorded in this file"
                ) from None
            raw = None
        if not isinstance(raw, dict) or raw.get("type") != "header":
            raise self._error(self.number, "not a session file: its first line is no header")
        version = raw.get("format")
        if isinstance(version, int) and version > FORMAT_VERSION:
            raise SessionFileError(
                f"{self.name} was written by a newer solarcal (format {version}; this one reads "
                f"{FORMAT_VERSION}): update solarcal to read it"
            )
        if not isinstance(version, int) or version < 1:
            raise self._error(self.number, f"{version!r} is no session format")
        if isinstance(record, ValueError):
            raise self._error(self.number, str(record))
        if not isinstance(record, Header):
            raise self._error(self.number, "not a session header")
        try:
            check_stamps([record])
        except ConfigurationError as error:
            raise self._error(self.number, str(error)) from None
        return record

    def _check_sequence(self) -> None:
        assert self.header is not None
        last = self.header.seq
        seen = set()
        for record, number in zip(self.records, self.lines, strict=True):
            if record.seq <= last or (self._checksums_due and record.seq != last + 1):
                what = "lines mixed or repeated" if record.seq <= last else "lines are missing"
                raise self._error(number, f"sequence number {record.seq} after {last}: {what}")
            if isinstance(record, Void) and record.voids not in seen:
                raise self._error(number, f"voids {record.voids}, which is no earlier record")
            last = record.seq
            seen.add(last)

    def _refuse_stamp(self) -> None:
        """Name the line of the first instant that is none."""
        for record, number in zip(self.records, self.lines, strict=True):
            try:
                check_stamps([record])
            except ConfigurationError as error:
                raise self._error(number, str(error)) from None

    def _error(self, number: int, complaint: str) -> SessionFileError:
        return SessionFileError(f"{self.name}:{number}: {one_line(complaint)}")


def _is_json(line: bytes) -> bool:
    try:
        msgspec.json.decode(line)
    except (ValueError, RecursionError):
        return False
    return True


_WANTED = (b'"point"', b'"void"')


class _Point(msgspec.Struct, tag="point", frozen=True):
    seq: int
    utc: str
    status: PointStatus
    ideal_deg: Pair | None = None
    error_deg: Pair | None = None
    sigma_deg: float | None = None
    read_utc: str | None = None
    reason: str = ""
    approach: tuple[int, int] | None = None


_points_decoder = msgspec.json.Decoder(_Point | Void)


class NeedsWholeReader(Exception):
    """This file is for ``view.read_session``: it will read it, or say what is wrong."""


def read_points_only(path: str | Path) -> tuple[Header, PointTable]:
    """Header and live accepted points of a session file.

    Raises
    ------
    SessionFileError
        The file is missing or cannot be opened.
    NeedsWholeReader
        It is no plain session file; ``read_session`` knows what to say of it.
    """
    content = read_bytes(path, error=SessionFileError)
    try:
        return _points_of(content, str(path))
    except (ValueError, RecursionError, ConfigurationError) as error:
        raise NeedsWholeReader(str(error)) from None


def _points_of(content: bytes, source: str) -> tuple[Header, PointTable]:
    head, _, rest = content.partition(b"\n")
    header = decode_record(head)
    if not isinstance(header, Header) or header.format != FORMAT_VERSION:
        raise NeedsWholeReader("no plain session header")
    lines = content.split(b"\n")
    if lines.pop() or any(damaged_lines(lines)):
        raise NeedsWholeReader("a line that is torn or was changed")
    if b'\n{"type":"closed"' not in content:
        raise NeedsWholeReader("not closed: the whole reader says so")
    if b'"torn"' in rest or b"\\u" in rest:
        # An escaped type name would escape this reader.
        raise NeedsWholeReader("torn or escaped lines")
    points: list[_Point] = []
    voids: list[Void] = []
    for seq, line in enumerate(lines[1:], start=header.seq + 1):
        if _WANTED[0] not in line and _WANTED[1] not in line:
            continue
        record = _points_decoder.decode(line)
        if record.seq != seq:
            raise NeedsWholeReader("sequence numbers that do not follow")
        if isinstance(record, _Point):
            points.append(record)
        elif record.voids < record.seq:
            voids.append(record)
        else:
            raise NeedsWholeReader("a void of what comes after it")
    struck: set[int] = set()
    for void in reversed(voids):
        if void.seq not in struck:
            struck.add(void.voids)
    if struck - {point.seq for point in points} - {void.seq for void in voids}:
        raise NeedsWholeReader("a struck record that a point may be taken on")
    live = [p for p in points if p.status == "accepted" and p.seq not in struck]
    if any(p.ideal_deg is None or p.error_deg is None for p in live):
        raise NeedsWholeReader("an accepted point without angles")
    return header, table_of_points(header, live, source)
