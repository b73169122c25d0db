"""CRC-32C (Castagnoli) of the lines of a session file.

The polynomial of iSCSI (RFC 3720, appendix B.4), reflected; its check value, of the ASCII digits
"123456789", is E3069283. Every change of up to 32 neighbouring bits is found, and every odd number
of changed bits.

A CRC is linear: that of a text is the exclusive or of what each byte contributes at its distance
from the end. With these contributions in one table the lines of a whole file are summed at once.
"""

from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
import numpy.typing as npt

_POLYNOMIAL = 0x82F63B78

_REACH = 2048
"""Bytes before the end that the table holds; longer lines are summed in parts."""

_AT_ONCE = 1 << 18
"""Bytes of lines summed together: their indices stay within a few megabytes."""

Words = npt.NDArray[np.uint32]


def crc32c(content: bytes) -> int:
    """The CRC-32C of some bytes."""
    return next(checksums((content,)))


def checksums(lines: Sequence[bytes]) -> Iterator[int]:
    """The CRC-32C of each of the lines, in order."""
    batch: list[bytes] = []
    size = 0
    for line in lines:
        if size + len(line) > _AT_ONCE and batch:
            yield from _sum(batch)
            batch, size = [], 0
        batch.append(line)
        size += len(line)
    yield from _sum(batch)


def _sum(lines: list[bytes]) -> Iterator[int]:
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
