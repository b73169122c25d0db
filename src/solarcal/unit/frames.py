"""Frames of the wire protocol, without any line: bytes in, frozen frames out, and back.

One frame is one line of ASCII with a CRC-32 (``docs/protocol.md``). Both ends use this module: the
station's driver and the emulated unit.
"""

import re
from enum import IntEnum
from zlib import crc32

import msgspec

from solarcal.errors import ProtocolError

MAX_FRAME_CHARS = 250
"""Longest frame without its line end. A longer line is noise, whatever it holds."""

SEQUENCE_NUMBERS = 0x10000
"""Sequence numbers run from 0000 to FFFF and wrap."""

# No field holds a space, '*', '<' or '>': a frame therefore has exactly one '*', nine characters
# before its end, and no damage can move it without the checksum noticing.
_TOKEN = r"[!-)+-;=?-~]+"
_REQUEST = re.compile(rf">([0-9A-F]{{4}}) ({_TOKEN}(?: {_TOKEN})*)")
_RESULT = re.compile(rf"<([0-9A-F]{{4}}) OK((?: {_TOKEN})*)")
_REFUSAL = re.compile(rf"<([0-9A-F]{{4}}|----) NO ([1-9][0-9]?) ({_TOKEN}(?: {_TOKEN})*)")
_CHECKSUM = re.compile(rb"[0-9A-F]{8}")


class Code(IntEnum):
    """Refusal numbers of the wire protocol.

    The sequence number of a ``DAMAGED`` frame's refusal is ``----``.
    """

    DAMAGED = 10
    UNKNOWN = 11
    SEQUENCE_REUSED = 12
    BAD_ARGUMENT = 13
    LOCKED = 20
    BEYOND_LIMIT = 21
    BUSY = 22
    MOVING = 23
    NOT_REFERENCED = 24
    SUN_DOWN = 25
    STOPPED = 26
    NOT_ANNOUNCED = 30


class Refusal(Exception):
    """Raised within an emulated unit: a request it does not carry out; nothing has changed."""

    def __init__(self, code: Code, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text


class MalformedFrame(ProtocolError):
    """The checksum is right and the content is no frame: not noise, but another protocol."""


class Request(msgspec.Struct, frozen=True):
    """What the station asks: ``>SSSS VERB [argument ...]``."""

    seq: int
    verb: str
    arguments: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Verb and arguments as they stand on the line."""
        return " ".join((self.verb, *self.arguments))


class Reply(msgspec.Struct, frozen=True):
    """What the unit answers: a result with its ``fields``, or a refusal with its code and text.

    ``seq`` is None where the unit could not read the number of the request (refusal 10).
    """

    seq: int | None
    fields: tuple[str, ...] = ()
    code: int | None = None
    text: str = ""

    @property
    def refused(self) -> bool:
        return self.code is not None


def encode_request(request: Request) -> bytes:
    """The request as one line with CR LF.

    Raises
    ------
    ProtocolError
        It cannot be written as a frame: too long, or a character the protocol does not allow.
    """
    body = f">{request.seq:04X} {request.text}"
    # A space within an argument would make it two.
    if not _REQUEST.fullmatch(body) or body.count(" ") != 1 + len(request.arguments):
        raise ProtocolError(f"{request.text!r} cannot be written as a request")
    return _sealed(body)


def encode_reply(reply: Reply) -> bytes:
    """The reply as one line with CR LF; raises ProtocolError as ``encode_request`` does."""
    seq = "----" if reply.seq is None else f"{reply.seq:04X}"
    if reply.code is None:
        body = " ".join((f"<{seq} OK", *reply.fields))
        if not _RESULT.fullmatch(body) or body.count(" ") != 1 + len(reply.fields):
            raise ProtocolError(f"fields {reply.fields!r} cannot be written as a reply")
    else:
        body = f"<{seq} NO {reply.code} {reply.text}"
        if not _REFUSAL.fullmatch(body):
            raise ProtocolError(f"refusal {reply.code} {reply.text!r} cannot be written as a reply")
    return _sealed(body)


def decode_request(line: bytes) -> Request:
    """Read one line, with or without its line end.

    Raises
    ------
    ProtocolError
        The line is damaged; ``MalformedFrame`` where it is undamaged and no request.
    """
    body = _unsealed(line)
    match = _REQUEST.fullmatch(body)
    if match is None:
        raise MalformedFrame(f"not a request: {body!r}")
    verb, *arguments = match[2].split(" ")
    return Request(int(match[1], 16), verb, tuple(arguments))


def decode_reply(line: bytes) -> Reply:
    """Read one line, with or without its line end; raises as ``decode_request``."""
    body = _unsealed(line)
    if match := _RESULT.fullmatch(body):
        return Reply(int(match[1], 16), tuple(match[2].split()))
    if match := _REFUSAL.fullmatch(body):
        seq = None if match[1] == "----" else int(match[1], 16)
        return Reply(seq, (), int(match[2]), match[3])
    raise MalformedFrame(f"not a reply: {body!r}")


def _sealed(body: str) -> bytes:
    frame = body.encode("ascii")
    frame += b"*%08X" % crc32(frame)
    if len(frame) > MAX_FRAME_CHARS:
        raise ProtocolError(f"a frame of {len(frame)} characters is longer than {MAX_FRAME_CHARS}")
    return frame + b"\r\n"


def _unsealed(line: bytes) -> str:
    """The frame without its checksum, which must be right."""
    frame = line.removesuffix(b"\n").removesuffix(b"\r")
    if len(frame) > MAX_FRAME_CHARS:
        raise ProtocolError(f"a line longer than {MAX_FRAME_CHARS} characters is no frame")
    body, star, checksum = frame[:-9], frame[-9:-8], frame[-8:]
    if star != b"*" or not _CHECKSUM.fullmatch(checksum) or crc32(body) != int(checksum, 16):
        raise ProtocolError(f"damaged frame: {frame!r}")
    # A right checksum over bytes that are not ASCII is no accident, but no frame either.
    return body.decode("ascii", errors="replace")


class LineBuffer:
    """Cuts a stream of bytes into lines and keeps no more than one longest frame of it.

    A line longer than a frame is thrown away but for its beginning, which is handed over ONCE, so
    that the receiver knows of the damage at once; no decoder accepts it.
    """

    def __init__(self) -> None:
        self._begun = bytearray()
        self._overlong = False

    def __len__(self) -> int:
        """Bytes kept of a line whose end has not come yet."""
        return len(self._begun)

    def feed(self, data: bytes) -> list[bytes]:
        """Lines completed by ``data``, without their line ends and without empty ones."""
        lines: list[bytes] = []
        *ended, rest = data.split(b"\n")
        for piece in ended:
            self._extend(piece, lines)
            line = bytes(self._begun).removesuffix(b"\r")
            if line and not self._overlong:
                lines.append(line)
            self._begun.clear()
            self._overlong = False
        self._extend(rest, lines)
        return lines

    def _extend(self, piece: bytes, lines: list[bytes]) -> None:
        if self._overlong:
            return
        room = MAX_FRAME_CHARS + 2 - len(self._begun)
        self._begun += piece[:room]
        # One character more than a frame may still be the CR of its line end.
        if len(self._begun) > MAX_FRAME_CHARS and self._begun[MAX_FRAME_CHARS:] != b"\r":
            lines.append(bytes(self._begun))
            self._begun.clear()
            self._overlong = True
