"""The second reader: of a session file only its header and its live, accepted points, fast.

It is for those who read thousands of files and want nothing but what a fit is made of. It looks at
the checksum of every line, decodes only the header, points and voids, and expects each sequence
number in its place. Of a file it cannot take at its word (an old format, a wrong checksum, a torn
line, a session that is still open) it says so, and the first reader (``view.read_session``)
decides. So both give the same points of every file the first one accepts.
"""

from pathlib import Path

import msgspec

from solarcal.decimals import Pair
from solarcal.errors import ConfigurationError, SessionFileError
from solarcal.input_files import read_bytes
from solarcal.session.lines import damaged_lines, decode_record
from solarcal.session.points import PointTable, table_of_points
from solarcal.session.records import FORMAT_VERSION, Header, PointStatus

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


class _Void(msgspec.Struct, tag="void", frozen=True):
    seq: int
    utc: str
    voids: int


_decoder = msgspec.json.Decoder(_Point | _Void)


class NeedsFirstReader(Exception):
    """This file is for ``view.read_session``: it will read it, or say what is wrong."""


def read_points_only(path: str | Path) -> tuple[Header, PointTable]:
    """Header and live accepted points of a session file.

    Raises
    ------
    SessionFileError
        The file is missing or cannot be opened.
    NeedsFirstReader
        It is no plain session file; ``read_session`` knows what to say of it.
    """
    content = read_bytes(path, error=SessionFileError)
    try:
        return _points_of(content, str(path))
    except (ValueError, RecursionError, ConfigurationError) as error:
        raise NeedsFirstReader(str(error)) from None


def _points_of(content: bytes, source: str) -> tuple[Header, PointTable]:
    head, _, rest = content.partition(b"\n")
    header = decode_record(head)
    if not isinstance(header, Header) or header.format != FORMAT_VERSION:
        raise NeedsFirstReader("no plain session header")
    lines = content.split(b"\n")
    if lines.pop() or any(damaged_lines(lines)):
        raise NeedsFirstReader("a line that is torn or was changed")
    if b'\n{"type":"closed"' not in content:
        raise NeedsFirstReader("not closed: the first reader says so")
    if b'"torn"' in rest or b"\\u" in rest:
        # An escaped type name would escape this reader.
        raise NeedsFirstReader("torn or escaped lines")
    points: list[_Point] = []
    voids: list[_Void] = []
    for seq, line in enumerate(lines[1:], start=header.seq + 1):
        if _WANTED[0] not in line and _WANTED[1] not in line:
            continue
        record = _decoder.decode(line)
        if record.seq != seq:
            raise NeedsFirstReader("sequence numbers that do not follow")
        if isinstance(record, _Point):
            points.append(record)
        elif record.voids < record.seq:
            voids.append(record)
        else:
            raise NeedsFirstReader("a void of what comes after it")
    struck: set[int] = set()
    for void in reversed(voids):
        if void.seq not in struck:
            struck.add(void.voids)
    live = [p for p in points if p.status == "accepted" and p.seq not in struck]
    if any(p.ideal_deg is None or p.error_deg is None for p in live):
        raise NeedsFirstReader("an accepted point without angles")
    return header, table_of_points(header, live, source)
