"""Errors a user can meet, and the text of others made harmless.

Each message says what happened, where, and what to do. The command line prints it without a
traceback and leaves with ``exit_code``.

A session file, a profile, a points file or a file's name may hold escape sequences that clear the
screen, change its title or turn words around. Every reader of such text, and
every error message, passes it through ``harmless``.
"""

import re
from typing import Any, ClassVar

# C0 but tab and line feed, delete, C1, marks and overrides of the writing direction, lone
# surrogates (a file name that is no UTF-8), a byte order mark.
_OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufeff]"
)


def harmless(text: str) -> str:
    """The text with every character a terminal would obey written out, like ``\\x1b``.

    Tabs and line feeds stay.
    """
    return _OBEYED.sub(_written_out, text)


def one_line(text: str) -> str:
    """The same with every run of white space a single space."""
    return harmless(" ".join(text.split()))


def harmless_tree(value: Any) -> Any:
    """A document of mappings, lists and plain values with all its texts harmless, keys too."""
    if isinstance(value, str):
        return harmless(value)
    if isinstance(value, dict):
        return {harmless_tree(key): harmless_tree(item) for key, item in value.items()}
    if isinstance(value, list):
        return [harmless_tree(item) for item in value]
    return value


def _written_out(found: "re.Match[str]") -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


class SolarcalError(Exception):
    """Base of everything solarcal raises on purpose."""

    exit_code: ClassVar[int] = 2
    action: str | None = None
    """The workstation's action that is to come first, if any: a screen adds its keys."""

    def __str__(self) -> str:
        # Messages quote what came from files, lines and keyboards.
        return one_line(super().__str__())


class ConfigurationError(SolarcalError):
    """A site, profile, scenario, option or number that cannot be used."""


class InputFileError(SolarcalError):
    """A points, TPOINT or session file that cannot be read; names file, line and column."""


class SessionFileError(InputFileError):
    """A session journal that is damaged, locked, or cannot be written."""


class FitError(SolarcalError):
    """Points from which no answer can be computed: too few, not finite, at a pole."""


class LinkError(SolarcalError):
    """The line to the unit: cannot be opened, lost, or silent."""

    exit_code = 3


class ProtocolError(LinkError):
    """The unit answered, but not in the protocol: damaged, unexpected, another version."""


class UnitRefused(SolarcalError):
    """The unit answered NO. ``code`` is the protocol's number for the reason."""

    exit_code = 1

    def __init__(self, code: int, text: str, request: str) -> None:
        super().__init__(f"the unit refused {request}: {text} (code {code})")
        self.code = code
        self.text = text


class ProcedureRefused(SolarcalError):
    """The calibration procedure does not allow this step now; says why and what to do first."""

    exit_code = 1

    def __init__(self, sentence: str, action: str | None = None) -> None:
        super().__init__(sentence)
        self.action = action
