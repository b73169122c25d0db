"""A line of a session file: a record to bytes, bytes to a record, and the checksum they end with.

A line is one JSON object and a newline; its last field is the CRC-32C of the bytes before that
field. Nothing is ever rewritten, so an unfinished line (power cut, full disk) stays in the file for
good. Whoever appends next closes it with a newline and a ``{"type":"torn","bytes":K}`` line: the K
bytes before that line are not a record.

Format 1 is the same without checksums, and its sequence numbers may leave gaps.

The checksum's polynomial is that of iSCSI (RFC 3720, appendix B.4), reflected; its check value, of
the ASCII digits "123456789", is E3069283. Every change of up to 32 neighbouring bits is found, and
every odd number of changed bits.

A CRC is linear: that of a text is the exclusive or of what each byte contributes at its distance
from the end. With these contributions in one table the lines of a whole file are summed at once.
"""

import re
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, get_args

import msgspec
import numpy as np
import numpy.typing as npt

from solarcal.errors import ConfigurationError, SessionFileError, harmless_tree
from solarcal.session.records import CheckRecord, KnownRecord, PointRecord, Record, UnknownRecord
from solarcal.timescale import parse_many_utc

TORN_START = b'{"type":"torn","bytes":'
_CHECKSUM_LENGTH = len(b',"crc32c":"01234567"}')
_CHECKSUM_START = b',"crc32c":"'
_CHECKSUM = re.compile(rb',"crc32c":"([0-9a-f]{8})"\}')
_KNOWN_TYPES = {kind.__struct_config__.tag for kind in get_args(KnownRecord)}

MISSING = "cut or changed: no checksum at the end of the line"

# Escapes of JSON, and the first bytes of what UTF-8 has to say to a terminal.
_SUSPICIOUS = re.compile(
    rb"\\[ubfr]|\xc2[\x80-\x9f]|\xd8\x9c|\xe2\x80[\x80-\xbf]|\xe2\x81|\x7f|\xef\xbb\xbf"
)

_POLYNOMIAL = 0x82F63B78

_REACH = 2048
"""Bytes before the end that the table holds; longer lines are summed in parts."""

_AT_ONCE = 128
"""Lines summed together: the indices of their bytes stay within a few megabytes."""

Words = npt.NDArray[np.uint32]

_encoder = msgspec.json.Encoder()
_decoder = msgspec.json.Decoder(KnownRecord)


def encode_record(record: Record) -> bytes:
    """The record as one line, newline included.

    Raises
    ------
    SessionFileError
        The record would not read back as itself (a number that is not finite, broken text).
    """
    return sealed(_json_of(record))


def encode_records(records: Sequence[Record]) -> bytes:
    """The lines of ``encode_record``, one after the other; raises as it does."""
    bodies = [_body(_json_of(record)) for record in records]
    # Summed together: most of a line's time is its checksum's otherwise.
    return b"".join(map(_with_checksum, bodies, checksums(bodies)))


def _json_of(record: Record) -> bytes:
    try:
        if isinstance(record, UnknownRecord):
            own = {"type": record.type, "seq": record.seq, "utc": record.utc}
            line = _encoder.encode({**own, **record.fields})
        else:
            line = _encoder.encode(record)
        same = decode_record(line) == record
    except (ValueError, TypeError) as error:
        raise SessionFileError(f"this record cannot be written: {error}") from error
    if not same:
        raise SessionFileError("this record cannot be written: it would not read back unchanged")
    return line


def decode_record(line: bytes) -> Record:
    """One line to its record; its checksum is not looked at (``damaged_lines`` does that).

    Raises
    ------
    ValueError
        Not JSON, or not a record; the message says what is wrong.
    """
    try:
        record = _understood(line)
        check_stamps([record])
    except RecursionError:
        raise ValueError("nested too deeply") from None
    except ConfigurationError as error:
        raise msgspec.ValidationError(str(error)) from None
    return record


def torn_marker(torn_bytes: int) -> bytes:
    """The line that declares the ``torn_bytes`` bytes before it to be no record."""
    return sealed(TORN_START + str(torn_bytes).encode() + b"}")


def sealed(line: bytes) -> bytes:
    """A JSON object as a line of the file: with its checksum, whatever it had, and a newline."""
    body = _body(line)
    return _with_checksum(body, crc32c(body))


def _body(line: bytes) -> bytes:
    """What the checksum is of: all of the object but its end."""
    return opened(line.rstrip())[:-1]


def _with_checksum(body: bytes, checksum: int) -> bytes:
    return body + _CHECKSUM_START + b'%08x"}\n' % checksum


def opened(line: bytes) -> bytes:
    """The JSON object without its checksum; a line that has none as it is."""
    line = line.rstrip(b"\r\n")
    if _CHECKSUM.match(line, len(line) - _CHECKSUM_LENGTH):
        return line[:-_CHECKSUM_LENGTH] + b"}"
    return line


def damaged_lines(lines: Sequence[bytes]) -> Iterator[str | None]:
    """For each line what is wrong with its checksum: nothing, not what it says, or ``missing``."""
    plain = [line.removesuffix(b"\r") for line in lines]
    sums = checksums([line[:-_CHECKSUM_LENGTH] for line in plain])
    for line, found in zip(plain, sums, strict=True):
        own = _CHECKSUM.match(line, max(0, len(line) - _CHECKSUM_LENGTH))
        if own is None:
            yield MISSING
        elif int(own[1], 16) != found:
            yield f"the line was changed: its checksum is {own[1].decode()}, not {found:08x}"
        else:
            yield None


def nearly_sealed(line: bytes) -> bool:
    """Whether a line without a checksum ends in a damaged one: no cut line ends like that."""
    tail = line[-_CHECKSUM_LENGTH:]
    whole = _CHECKSUM_START + tail[len(_CHECKSUM_START) : -2] + b'"}'
    return len(tail) == len(whole) and sum(a != b for a, b in zip(tail, whole, strict=True)) < 2


def records_of(lines: Sequence[bytes]) -> Iterator[Record | ValueError]:
    """For each line its record with texts harmless to a terminal, or why it is none.

    Neither checksums nor times are looked at.
    """
    for line in lines:
        try:
            yield _understood(_harmless(line))
        except RecursionError:
            yield ValueError("nested too deeply")
        except ConfigurationError as error:
            yield ValueError(str(error))
        except ValueError as error:
            yield error


def _understood(line: bytes) -> Record:
    """A line's record; its times are not looked at."""
    record = _decode(opened(line))
    if isinstance(record, PointRecord) and record.status == "accepted":
        for name in ("ideal_deg", "error_deg"):
            if getattr(record, name) is None:
                raise msgspec.ValidationError(f"an accepted point without {name}")
    return record


def _harmless(line: bytes) -> bytes:
    """The line with its texts harmless to a terminal; nearly always the line itself."""
    if not _SUSPICIOUS.search(line):
        return line
    return msgspec.json.encode(harmless_tree(msgspec.json.decode(line)))


def _decode(line: bytes) -> Record:
    try:
        record: KnownRecord = _decoder.decode(line)
    except msgspec.ValidationError:
        raw: Any = msgspec.json.decode(line)
        kind = raw.pop("type", None) if isinstance(raw, dict) else None
        if not isinstance(kind, str) or kind in _KNOWN_TYPES:
            raise
    else:
        return record
    seq, utc = raw.pop("seq", None), raw.pop("utc", None)
    if type(seq) is not int or not isinstance(utc, str):
        raise msgspec.ValidationError(f"a {kind!r} record without a proper seq or utc")
    return UnknownRecord(seq=seq, utc=utc, type=kind, fields=raw)


def check_stamps(records: Sequence[Record]) -> None:
    """Refuse the first time that is no instant, of these records or of their read-outs."""
    read = (r.read_utc for r in records if isinstance(r, PointRecord | CheckRecord))
    parse_many_utc([*(r.utc for r in records), *(utc for utc in read if utc is not None)])


def crc32c(content: bytes) -> int:
    """The CRC-32C of some bytes."""
    return next(checksums((content,)))


def checksums(lines: Sequence[bytes]) -> Iterator[int]:
    """The CRC-32C of each of the lines, in order."""
    for first in range(0, len(lines), _AT_ONCE):
        yield from _sum(lines[first : first + _AT_ONCE])


def _sum(lines: Sequence[bytes]) -> Iterator[int]:
    table = _contributions()
    short = [line for line in lines if 4 <= len(line) <= _REACH]
    found = iter(())
    if short:
        octets = np.frombuffer(b"".join(short), dtype=np.uint8).copy()
        lengths = np.array([len(line) for line in short])
        ends = np.cumsum(lengths)
        starts = ends - lengths
        # The register begins with all ones, which is the same as four inverted first bytes.
        octets[starts[:, np.newaxis] + np.arange(4)] ^= 0xFF
        places = np.repeat(ends - 1, lengths) - np.arange(len(octets))
        places <<= 8
        places |= octets
        sums = np.bitwise_xor.reduceat(table.take(places), starts)
        found = iter(np.invert(sums).tolist())
    for line in lines:
        yield next(found) if 4 <= len(line) <= _REACH else _one_sum(line)


def _one_sum(line: bytes) -> int:
    """Of a line that is very long or very short: in parts, each taking up the register."""
    table = _contributions()
    register = 0xFFFFFFFF
    while line:
        part, line = line[:_REACH], line[_REACH:]
        octets = np.frombuffer(part, dtype=np.uint8).copy()
        taken = np.frombuffer(register.to_bytes(4, "little"), dtype=np.uint8)[: len(octets)]
        octets[: len(taken)] ^= taken
        places = (np.arange(len(octets) - 1, -1, -1) << 8) | octets
        # A part shorter than the register leaves the rest of it, moved down.
        left = register >> 8 * len(octets)
        register = int(np.bitwise_xor.reduce(table.take(places))) ^ left
    return register ^ 0xFFFFFFFF


@cache
def _contributions() -> Words:
    """What byte value b adds that has k bytes behind it: at 256 k + b."""
    one = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        one = np.where(one & 1, (one >> 1) ^ np.uint32(_POLYNOMIAL), one >> 1).astype(np.uint32)
    table = np.empty((_REACH, 256), dtype=np.uint32)
    table[0] = one
    for row in range(1, _REACH):
        before = table[row - 1]
        table[row] = (before >> 8) ^ one[before & 0xFF]
    return table.ravel()
