"""Drawings on terminals and in files that are not UTF-8: the nearest character there is."""

import codecs
import io
from typing import TextIO

_NEAREST = str.maketrans("─╌│●○◆◇◈·░▒▓█°±–—", "--|*oxvX..:%#d+--")
_FRAME = range(0x2500, 0x2580)


def _nearest(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    missing = error.object[error.start : error.end].translate(_NEAREST)
    return "".join(_ascii(character) for character in missing), error.end


def _ascii(character: str) -> str:
    if character.isascii():
        return character
    # Corners and crossings of a frame.
    return "+" if ord(character) in _FRAME else "?"


def never_fail(stream: TextIO | None) -> None:
    """Let ``stream`` write "*" where its encoding has no dot, instead of ending in a traceback."""
    if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
        codecs.register_error("nearest", _nearest)
        stream.reconfigure(errors="nearest")
