"""Plain-text columns, at most 80 characters wide: readable over any line, in any terminal."""

import textwrap
from collections.abc import Iterable, Sequence

LINE_WIDTH = 80
BLANK = "-"
"""What stands where there is no number."""


def columns(
    headings: Sequence[str], rows: Iterable[Sequence[str]], align: str, gap: str = "  "
) -> list[str]:
    """Lines of a table: headings, a rule, rows.

    Parameters
    ----------
    align : str
        ``<`` or ``>`` for each column.
    """
    body = [list(row) for row in rows]
    widths = [
        max(len(heading), *(len(row[i]) for row in body)) if body else len(heading)
        for i, heading in enumerate(headings)
    ]

    def line(cells: Sequence[str]) -> str:
        return gap.join(
            f"{cell:{side}{width}}" for cell, side, width in zip(cells, align, widths, strict=True)
        ).rstrip()

    return [line(headings), gap.join("-" * width for width in widths), *map(line, body)]


def wrapped(text: str, indent: int = 0, hang: int | None = None) -> list[str]:
    """A sentence broken at ``LINE_WIDTH``, following lines indented by ``hang``."""
    return textwrap.wrap(
        text,
        LINE_WIDTH,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent if hang is None else hang),
    )


def number(value: float | None, decimals: int, signed: bool = False) -> str:
    """A number for a table, without a negative zero; ``BLANK`` where there is none."""
    if value is None or value != value:
        return BLANK
    text = f"{value:+.{decimals}f}" if signed else f"{value:.{decimals}f}"
    return text if float(text) else text.replace("-", "+" if signed else "")


def clock_text(hours: float) -> str:
    """Hours of the day as HH:MM."""
    minutes = round(hours * 60.0) % 1440
    return f"{minutes // 60:02d}:{minutes % 60:02d}"
