"""Errors a user can meet. Each message says what happened, where, and what to do.

The command line prints the message without a traceback and leaves with ``exit_code``.
"""

from typing import ClassVar

from solarcal.plain_text import one_line


class SolarcalError(Exception):
    """Base of everything solarcal raises on purpose."""

    exit_code: ClassVar[int] = 2

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
