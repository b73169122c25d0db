"""A screen as an SVG that fetches nothing: frames and bars are drawn, only letters need a font.

Textual's own export names a font on the internet, and a frame made of letters falls to pieces
where the reader's font has other widths.
"""

import unicodedata
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape

from rich.color import Color
from rich.segment import Segment
from rich.style import Style

CELL_WIDTH, CELL_HEIGHT = 8.4, 17.0
FONT_SIZE = 14
BASELINE = 12.8
MARGIN = 8.0
LIGHT, HEAVY = 1.0, 2.2
FULL_BLOCK = 0x2588
SHADES = {"░": 0.25, "▒": 0.5, "▓": 0.75}

_ARMS = {
    "UP": (True, False, False, False),
    "DOWN": (False, True, False, False),
    "LEFT": (False, False, True, False),
    "RIGHT": (False, False, False, True),
    "VERTICAL": (True, True, False, False),
    "HORIZONTAL": (False, False, True, True),
}
"""Up, down, left, right: which halves of its cell a word of a character's name draws."""


@dataclass(slots=True)
class _Drawing:
    """What was met so far, gathered by colour so that the file stays small."""

    backgrounds: list[str] = field(default_factory=list)
    filled: dict[tuple[str, float], list[str]] = field(default_factory=lambda: defaultdict(list))
    lines: dict[tuple[str, float], list[str]] = field(default_factory=lambda: defaultdict(list))
    words: dict[tuple[str, bool], list[str]] = field(default_factory=lambda: defaultdict(list))


def screen_svg(rows: Sequence[Iterable[Segment]], *, title: str, ink: str, paper: str) -> str:
    """The picture.

    Parameters
    ----------
    rows : the lines of the screen, each a row of styled segments.
    title : said by screen readers and shown on hover.
    ink, paper : ``#rrggbb`` where a segment has no colour of its own.
    """
    drawing = _Drawing()
    columns = 0
    for y, row in enumerate(rows):
        x = 0
        for segment in row:
            x = _segment(drawing, segment.text, segment.style, (x, y), ink, paper)
        columns = max(columns, x)
    width = columns * CELL_WIDTH + 2 * MARGIN
    height = len(rows) * CELL_HEIGHT + 2 * MARGIN
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        f'width="{width:g}" height="{height:g}" role="img">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{width:g}" height="{height:g}" rx="5" fill="{paper}"/>',
        f'<g transform="translate({MARGIN:g} {MARGIN:g})">',
        *drawing.backgrounds,
    ]
    for (colour, opacity), shapes in drawing.filled.items():
        fade = f' fill-opacity="{opacity:g}"' if opacity < 1.0 else ""
        parts.append(f'<path fill="{colour}"{fade} d="{"".join(shapes)}"/>')
    for (colour, weight), strokes in drawing.lines.items():
        parts.append(
            f'<path fill="none" stroke="{colour}" stroke-width="{weight:g}" '
            f'd="{"".join(strokes)}"/>'
        )
    parts.append(
        f'<g font-family="DejaVu Sans Mono, Menlo, Consolas, monospace" '
        f'font-size="{FONT_SIZE}" xml:space="preserve">'
    )
    for (colour, bold), texts in drawing.words.items():
        fat = ' font-weight="bold"' if bold else ""
        parts.append(f'<g fill="{colour}"{fat}>{"".join(texts)}</g>')
    return "\n".join([*parts, "</g>", "</g>", "</svg>", ""])


def _segment(
    drawing: _Drawing, text: str, style: Style | None, at: tuple[int, int], ink: str, paper: str
) -> int:
    """Take in one segment; the column after it."""
    front, back = _colour(style.color if style else None, ink), paper
    if style is not None:
        back = _colour(style.bgcolor, paper)
        if style.reverse:
            front, back = back, front
    x, y = at
    if back != paper:
        drawing.backgrounds.append(
            f'<rect x="{x * CELL_WIDTH:.5g}" y="{y * CELL_HEIGHT:g}" '
            f'width="{len(text) * CELL_WIDTH:.5g}" height="{CELL_HEIGHT:g}" fill="{back}"/>'
        )
    bold = bool(style and style.bold)
    run = ""
    for cell in [*text, ""]:
        if cell and cell.isascii() and not (cell == " " and run.endswith(" ")):
            run += cell
            x += 1
            continue
        _word(drawing, run, x - len(run), y, front, bold)
        run = ""
        if cell and cell != " ":
            _glyph(drawing, cell, x, y, front, bold)
        x += bool(cell)
    return x


def _word(drawing: _Drawing, run: str, x: int, y: int, colour: str, bold: bool) -> None:
    word = run.strip()
    if not word:
        return
    x += len(run) - len(run.lstrip())
    drawing.words[colour, bold].append(
        f'<text x="{x * CELL_WIDTH:.5g}" y="{y * CELL_HEIGHT + BASELINE:.5g}" '
        f'textLength="{len(word) * CELL_WIDTH:.5g}">{escape(word, quote=False)}</text>'
    )


def _glyph(drawing: _Drawing, cell: str, x: int, y: int, colour: str, bold: bool) -> None:
    """A character that is no ASCII: drawn where it is a frame or a bar, else set by itself."""
    left, top = x * CELL_WIDTH, y * CELL_HEIGHT
    name = unicodedata.name(cell, "")
    if cell in SHADES:
        drawing.filled[colour, SHADES[cell]].append(_box(left, top, CELL_WIDTH, CELL_HEIGHT))
    elif (bar := _bar(cell)) is not None:
        dx, dy, width, height = bar
        drawing.filled[colour, 1.0].append(
            _box(
                left + dx * CELL_WIDTH,
                top + dy * CELL_HEIGHT,
                width * CELL_WIDTH,
                height * CELL_HEIGHT,
            )
        )
    elif name.startswith("BOX DRAWINGS"):
        weight = HEAVY if "HEAVY" in name else LIGHT
        drawing.lines[colour, weight].append(_frame(name, left, top))
    else:
        drawing.words[colour, bold].append(
            f'<text x="{left + CELL_WIDTH / 2:.5g}" y="{top + BASELINE:.5g}" '
            f'text-anchor="middle">{escape(cell, quote=False)}</text>'
        )


def _bar(cell: str) -> tuple[float, float, float, float] | None:
    """Left, top, width, height of a block character in parts of its cell."""
    code = ord(cell)
    if cell == "▀":
        return 0.0, 0.0, 1.0, 0.5
    if cell == "▐":
        return 0.5, 0.0, 0.5, 1.0
    if 0x2581 <= code <= FULL_BLOCK:
        height = (code - 0x2580) / 8.0
        return 0.0, 1.0 - height, 1.0, height
    if FULL_BLOCK < code <= 0x258F:
        return 0.0, 0.0, (0x2590 - code) / 8.0, 1.0
    return None


def _frame(name: str, left: float, top: float) -> str:
    """The strokes of a box-drawing character from its Unicode name."""
    arms = [False] * 4
    for word in name.split():
        arms = [have or add for have, add in zip(arms, _ARMS.get(word, (False,) * 4), strict=True)]
    middle_x, middle_y = left + CELL_WIDTH / 2, top + CELL_HEIGHT / 2
    ends = (
        (middle_x, top),
        (middle_x, top + CELL_HEIGHT),
        (left, middle_y),
        (left + CELL_WIDTH, middle_y),
    )
    return "".join(
        f"M{middle_x:.5g} {middle_y:.5g}L{end_x:.5g} {end_y:.5g}"
        for arm, (end_x, end_y) in zip(arms, ends, strict=True)
        if arm
    )


def _box(left: float, top: float, width: float, height: float) -> str:
    return f"M{left:.5g} {top:.5g}h{width:.4g}v{height:.4g}h{-width:.4g}z"


def _colour(colour: Color | None, default: str) -> str:
    if colour is None or colour.is_default:
        return default
    return colour.get_truecolor().hex
