"""Bits of saved sessions flipped, and their ends cut off: never another answer in silence.

A flipped bit must be refused or reported with the number of its line; a file cut short must be
refused, or be reported as torn or not closed, and holds no record but those before the cut.
"""

import re
from collections.abc import Iterable
from pathlib import Path

from solarcal.errors import SessionFileError
from solarcal.session.view import SessionView, session_of

SAVED = tuple(sorted((Path(__file__).parent.parent / "sessions").glob("*.jsonl")))


class Unnoticed(AssertionError):
    """A damaged file gave another answer, and nothing was said."""


def try_flips(path: Path, bits: Iterable[int]) -> tuple[int, int]:
    """Flip each of these bits, one at a time; how many were refused and how many reported."""
    content = bytearray(path.read_bytes())
    name = path.name
    whole = session_of(bytes(content), name)
    refused = reported = 0
    for bit in bits:
        content[bit // 8] ^= 1 << bit % 8
        damaged = bytes(content)
        content[bit // 8] ^= 1 << bit % 8
        try:
            session = session_of(damaged, name)
        except SessionFileError as error:
            if not _names_a_line(str(error), name):
                raise Unnoticed(f"{name}: bit {bit}: no line in: {error}") from error
            refused += 1
            continue
        _expect_reported(session, whole, f"{name}: bit {bit}")
        if not any(_names_a_line(warning, name) for warning in session.warnings):
            raise Unnoticed(f"{name}: bit {bit}: no line in {session.warnings}")
        reported += 1
    return refused, reported


def try_cuts(path: Path, offsets: Iterable[int]) -> tuple[int, int]:
    """Cut the file off at each of these offsets; how many were refused and how many reported."""
    content = path.read_bytes()
    whole = session_of(content, path.name)
    refused = reported = 0
    for offset in offsets:
        try:
            session = session_of(content[:offset], path.name)
        except SessionFileError:
            refused += 1
            continue
        # The newline of the last line alone is no loss.
        if offset < len(content) - 1:
            _expect_reported(session, whole, f"{path.name}: cut at {offset}")
        reported += 1
    return refused, reported


def _expect_reported(session: SessionView, whole: SessionView, where: str) -> None:
    if not set(session.warnings) - set(whole.warnings):
        raise Unnoticed(f"{where}: nothing was said")
    if session.header != whole.header:
        raise Unnoticed(f"{where}: another header")
    if session.records != whole.records[: len(session.records)]:
        raise Unnoticed(f"{where}: another record")


def _names_a_line(text: str, name: str) -> bool:
    return re.match(rf"{re.escape(name)}:\d+: ", text) is not None
