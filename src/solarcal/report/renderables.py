"""What a certificate is made of, whatever it is written as.

Every text in here is as measured or typed; a writer escapes it for its own format.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Facts:
    """Names and values, one pair a line."""

    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Cells under headings. ``align`` is ``<`` or ``>`` for each column."""

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str


@dataclass(frozen=True, slots=True)
class Sentences:
    """Remarks, one bullet each."""

    sentences: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Figure:
    """A picture twice: as text of fixed width, and as the inside of an SVG of this size.

    ``svg`` is markup already escaped; ``caption`` is plain text.
    """

    caption: str
    text: str
    svg: str
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Signatures:
    """Lines to sign on: who, each with name, date and signature."""

    roles: tuple[str, ...]


Block = Facts | Table | Sentences | Figure | Signatures


@dataclass(frozen=True, slots=True)
class Section:
    """Blocks under a title."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True)
class Certificate:
    """The whole of it. ``status`` is the one line a reader in a hurry takes home."""

    title: str
    subject: str
    status: str
    sections: tuple[Section, ...]


def printable(text: str) -> str:
    """A text without control characters: they are no XML, and a terminal would obey them."""
    return "".join(
        char if char.isprintable() else " " if char.isspace() else "\N{REPLACEMENT CHARACTER}"
        for char in text
    )
