"""What a report is made of, whatever it is written as, and the plain text of it.

A table is put together once, as blocks; here they become lines for a terminal, in `markup` pages.
Every text in a block is as measured or typed; a writer escapes it for its own format.
"""

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

LINE_WIDTH = 80
REMARK_INDENT = 6
BLANK = "-"
"""What stands where there is no number."""


@dataclass(frozen=True, slots=True)
class Prose:
    """Paragraphs, each from the left edge; an empty one is a gap."""

    paragraphs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Facts:
    """Names and values, one pair a line."""

    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Cells under headings. ``align`` is ``<`` or ``>`` for each column.

    ``groups`` says of each row under which lines it stands (a file, a date): those that differ
    from the row before are written above it. ``remarks`` has a sentence or "" for each row.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str
    groups: tuple[tuple[str, ...], ...] = ()
    remarks: tuple[str, ...] = ()

    def parts(self) -> Iterator[tuple[tuple[str, ...], tuple[str, ...], str]]:
        """Of each row: the group lines that begin above it, its cells, its remark."""
        before: tuple[str, ...] = ()
        for index, row in enumerate(self.rows):
            here = self.groups[index] if self.groups else ()
            new = next((i for i, name in enumerate(here) if before[i : i + 1] != (name,)), None)
            above = () if new is None else tuple(name for name in here[new:] if name)
            yield above, row, self.remarks[index] if self.remarks else ""
            before = here


@dataclass(frozen=True, slots=True)
class Sentences:
    """Remarks, one bullet each."""

    sentences: tuple[str, ...]


FIGURE_SIZE = (640, 300)


@dataclass(frozen=True, slots=True)
class Figure:
    """A picture twice: as text of fixed width, and as the inside of an SVG of ``FIGURE_SIZE``.

    ``svg`` is markup already escaped; ``caption`` is plain text.
    """

    caption: str
    text: str
    svg: str


@dataclass(frozen=True, slots=True)
class Signatures:
    """Lines to sign on: who, each with name, date and signature."""

    roles: tuple[str, ...]


Block = Prose | Facts | Table | Sentences | Figure | Signatures
Blocks = tuple[Block, ...]


@dataclass(frozen=True, slots=True)
class Section:
    """Blocks under a title."""

    title: str
    blocks: Blocks


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


# -- numbers and columns -------------------------------------------------------------------------


def number(value: float | None, decimals: int, signed: bool = False) -> str:
    """A number for a table, without a negative zero; ``BLANK`` where there is none."""
    if value is None or value != value:
        return BLANK
    return f"{value:+z.{decimals}f}" if signed else f"{value:z.{decimals}f}"


def clock_text(hours: float) -> str:
    """Hours of the day as HH:MM."""
    minutes = round(hours * 60.0) % 1440
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def columns(headings: Sequence[str], rows: Iterable[Sequence[str]], align: str) -> list[str]:
    """Lines of a table: headings, a rule, rows. ``align`` is ``<`` or ``>`` for each column."""
    body = [list(row) for row in rows]
    widths = [
        max(len(heading), *(len(row[i]) for row in body)) if body else len(heading)
        for i, heading in enumerate(headings)
    ]

    def line(cells: Sequence[str]) -> str:
        return "  ".join(
            f"{cell:{side}{width}}" for cell, side, width in zip(cells, align, widths, strict=True)
        ).rstrip()

    return [line(headings), "  ".join("-" * width for width in widths), *map(line, body)]


def wrapped(
    text: str, indent: int = 0, hang: int | None = None, width: int = LINE_WIDTH
) -> list[str]:
    """A sentence broken at ``width``, following lines indented by ``hang``."""
    return textwrap.wrap(
        text,
        width,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent if hang is None else hang),
    )


# -- plain text ----------------------------------------------------------------------------------


def text_of(*blocks: Block) -> str:
    """Blocks below one another as a terminal shows them."""
    return "\n".join(lines_of(*blocks))


def lines_of(*blocks: Block, width: int = LINE_WIDTH) -> list[str]:
    """The same as lines of at most so many columns, but for tables whose cells need more."""
    return [line for block in blocks for line in _lines(block, width)]


def section_text(title: str, *blocks: Block) -> str:
    """A title, underlined, and what stands below it."""
    return f"{title}\n{'-' * len(title)}\n{text_of(*blocks)}"


def plain_text(certificate: Certificate) -> str:
    """A certificate as a text file."""
    rule = "=" * LINE_WIDTH
    lines = [
        rule,
        printable(certificate.title).upper(),
        *wrapped(printable(certificate.subject)),
        *wrapped(printable(certificate.status)),
        rule,
    ]
    for section in certificate.sections:
        blocks = "\n\n".join(text_of(block) for block in section.blocks)
        title = printable(section.title)
        lines += ["", title, "-" * len(title), blocks]
    return "\n".join(lines) + "\n"


def _lines(block: Block, width: int) -> list[str]:
    match block:
        case Prose():
            return [
                line
                for text in block.paragraphs
                for line in wrapped(printable(text), width=width) or [""]
            ]
        case Facts():
            names = [printable(name) for name, _ in block.rows]
            column = max(map(len, names), default=0) + 2
            lines = []
            for name, (_, value) in zip(names, block.rows, strict=True):
                lines += wrapped(f"{name:<{column}}{printable(value)}", hang=column, width=width)
            return lines
        case Table():
            return _table_lines(block, width)
        case Sentences():
            return [
                line
                for sentence in block.sentences
                for line in wrapped(f"- {printable(sentence)}", hang=2, width=width)
            ]
        case Figure():
            return [printable(block.caption), *block.text.split("\n")]
        case Signatures():
            to_sign = (
                "Name ____________________  Date ______________  Signature ____________________"
            )
            return [
                line for role in block.roles for line in ("", printable(role), to_sign)
            ][1:]  # fmt: skip


def _table_lines(table: Table, width: int) -> list[str]:
    """Headings, a rule, rows; groups above their rows, remarks, broken at ``width``, below."""
    rows = [[printable(cell) for cell in row] for row in table.rows]
    head, rule, *body = columns([printable(text) for text in table.headings], rows, table.align)
    lines = [head, rule]
    for line, (above, _, remark) in zip(body, table.parts(), strict=True):
        lines += [*map(printable, above), line]
        if remark:
            lines += wrapped(printable(remark), indent=REMARK_INDENT, width=width)
    return lines
