"""Whole text files in and out, with errors in one line."""

import os
from contextlib import suppress
from pathlib import Path

from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import read_bytes, reason_of
from solarcal.plain_text import harmless


def read_text(path: str | Path) -> str:
    """The file's text (UTF-8, a byte order mark is dropped), line ends as they are.

    What a terminal would obey is written out (``plain_text``).

    Raises
    ------
    InputFileError
        It cannot be read, is not a regular file, too large, or not text.
    """
    content = read_bytes(path)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputFileError(
            f"{path}:{line}: not UTF-8 text (byte {content[error.start]:#04x}); "
            "save the file as UTF-8"
        ) from None
    # Carriage returns may be line ends.
    return "\r".join(map(harmless, text.split("\r")))


def write_text(path: str | Path, text: str) -> None:
    """Put the text in place in one step, so that no half-written file is ever met.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    try:
        path = Path(path)
        unfinished = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            unfinished.write_bytes(text.encode("utf-8"))
            unfinished.replace(path)
        except BaseException:
            with suppress(OSError):
                unfinished.unlink()
            raise
    except (OSError, ValueError) as error:
        raise ConfigurationError(f"{path} cannot be written: {reason_of(error)}") from error


def fill(given: str, path: str | Path, written: object, supplied: object) -> str | None:
    """A warning where an option contradicts what the file says; the file is believed."""
    if supplied is None or written is None or written == supplied:
        return None
    return f"{path}: its own {given} {written} was used, not the option's {supplied}"
