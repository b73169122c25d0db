"""Files read and written whole; of others regular ones only, and none larger than has a use.

A pipe would be waited for, a device or a growing file would never end: both are refused before a
byte is read. Only ``-`` is waited for: standard input, whatever that is.
"""

import os
import stat
import sys
import threading
import tomllib
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from solarcal.errors import (
    ConfigurationError,
    InputFileError,
    SolarcalError,
    harmless,
    harmless_tree,
)

LARGEST_RECORD_BYTES = 32_000_000
"""Of a session or points file: ten thousand points with everything about them are a third."""

LARGEST_SETTINGS_BYTES = 1_000_000
"""Of a profile, a scenario, settings, a field book: a hundred times what one has."""

STANDARD_INPUT = "-"


def read_bytes(
    path: str | Path,
    largest: int = LARGEST_RECORD_BYTES,
    error: type[SolarcalError] = InputFileError,
) -> bytes:
    """The content of a regular file.

    Raises
    ------
    SolarcalError
        Of the class ``error``: not there, not readable, not a regular file, or larger than
        ``largest`` bytes.
    """
    content = read_beginning(path, largest + 1, error)
    if len(content) > largest:
        raise error(_too_large(path, largest))
    return content


def read_beginning(
    path: str | Path, most: int, error: type[SolarcalError] = InputFileError
) -> bytes:
    """The first bytes of a regular file or of standard input, ``most`` at most.

    Raises
    ------
    SolarcalError
        Of the class ``error``: not there, not readable, not a regular file.
    """
    try:
        if str(path) == STANDARD_INPUT:
            return _standard_input()[:most]
        refuse_irregular(path, error)
        # A pipe without a writer must not be waited for, nor a terminal become ours.
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
        descriptor = os.open(path, flags | getattr(os, "O_BINARY", 0))
        with os.fdopen(descriptor, "rb") as file:
            # What was looked at may have been replaced since.
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise error(f"{path} cannot be read: it is not a regular file")
            return file.read(most)
    except FileNotFoundError:
        raise error(f"{path} is missing: no such file") from None
    except (OSError, ValueError) as failure:
        raise error(f"{path} cannot be read: {reason_of(failure)}") from None


@cache
def _standard_input() -> bytes:
    """Read once, for whoever looks at its beginning first."""
    return sys.stdin.buffer.read(LARGEST_RECORD_BYTES + 1)


def read_utf8(path: str | Path) -> str:
    """The same as text.

    Raises
    ------
    InputFileError
        As for the bytes; or it is not UTF-8 text.
    """
    try:
        return read_bytes(path, LARGEST_SETTINGS_BYTES).decode("utf-8")
    except UnicodeDecodeError:
        raise InputFileError(f"{path} cannot be read: it is not UTF-8 text") from None


def refuse_irregular(path: str | Path, error: type[SolarcalError] = InputFileError) -> None:
    """Refuse what is there and is not a regular file; what is not there is left to the caller.

    Raises
    ------
    SolarcalError
        Of the class ``error``: a folder, a pipe, a device.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return
    if stat.S_ISDIR(mode):
        raise error(f"{path} cannot be read: it is a folder")
    if not stat.S_ISREG(mode):
        raise error(f"{path} cannot be read: it is a pipe or a device, not a regular file")


def refuse_large(path: str | Path, error: type[SolarcalError] = InputFileError) -> None:
    """Refuse a session file that is larger than is read of one.

    Raises
    ------
    SolarcalError
        Of the class ``error``.
    """
    refuse_irregular(path, error)
    if os.path.exists(path) and os.stat(path).st_size > LARGEST_RECORD_BYTES:
        raise error(_too_large(path, LARGEST_RECORD_BYTES))


def _too_large(path: str | Path, largest: int) -> str:
    return (
        f"{path} cannot be read: it is larger than {largest / 1e6:g} MB, the most that is read of "
        "such a file"
    )


def reason_of(failure: OSError | ValueError) -> str:
    """Why, in the system's own words."""
    return getattr(failure, "strerror", None) or str(failure)


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


def write_whole(path: str | Path, content: str | bytes, *, make_folder: bool = False) -> None:
    """Put the content in place in one step: after a power cut there is the old file or the new.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    try:
        path = Path(path)
        if make_folder:
            path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f".{path.name}.{os.getpid()}-{threading.get_ident()}.part")
        try:
            with unfinished.open("wb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(path)
        except BaseException:
            with suppress(OSError):
                unfinished.unlink()
            raise
    except (OSError, ValueError) as error:
        raise ConfigurationError(f"{path} cannot be written: {reason_of(error)}") from error


def parse_toml(text: str) -> dict[str, Any]:
    """A TOML document.

    Raises
    ------
    ValueError
        Not TOML, a number too long to read, or nested too deeply; says where it can.
    """
    try:
        document: dict[str, Any] = harmless_tree(tomllib.loads(text))
    except RecursionError:
        raise ValueError("nested too deeply") from None
    return document
