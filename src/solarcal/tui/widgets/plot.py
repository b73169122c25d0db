"""A plot of the report as a widget: drawn when it changes, kept as strips until then."""

import re
from collections.abc import Callable
from functools import lru_cache

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

_SGR = re.compile(r"\x1b\[([0-9;]*)m")

Draw = Callable[[int, int, bool, str], str]
"""Width, height, colour wanted, ``phosphor`` or ``light`` -> the plot as text with ANSI colours."""


@lru_cache(maxsize=256)
def _after(style: Style, codes: str) -> Style:
    """The style after one SGR sequence; only what the plots use: reset, bold, 256 colours."""
    numbers = [int(code) for code in codes.split(";") if code] or [0]
    index = 0
    while index < len(numbers):
        code = numbers[index]
        if code == 0:
            style = Style.null()
        elif code == 1:
            style += Style(bold=True)
        elif code == 39:
            style = Style(bold=style.bold)
        elif code == 38 and numbers[index + 1 : index + 2] == [5]:
            style += Style(color=f"color({numbers[index + 2]})")
            index += 2
        index += 1
    return style


def strips_of_ansi(text: str, width: int, base: Style) -> list[Strip]:
    """Lines with ANSI colours as strips of ``width`` cells over a base style.

    Straight to segments: by way of rich's own parser it takes three times as long.
    """
    strips = []
    for line in text.split("\n"):
        style, segments, at = Style.null(), [], 0
        for found in _SGR.finditer(line):
            if found.start() > at:
                segments.append(Segment(line[at : found.start()], base + style))
            style, at = _after(style, found.group(1)), found.end()
        if at < len(line):
            segments.append(Segment(line[at:], base + style))
        strips.append(Strip(segments).adjust_cell_length(width, base))
    return strips


class AnsiPlot(Widget):
    """Shows what a ``Draw`` function draws; draws again when that, the size or the theme changes.

    plotext has one figure for the whole process, so all of this happens on the event loop.
    """

    DEFAULT_CSS = """
    AnsiPlot { width: 1fr; height: 1fr; min-width: 40; min-height: 10; }
    """

    SMALLEST = (40, 10)

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._what: object = None
        self._draw: Draw | None = None
        self._drawn: tuple[object, ...] | None = None
        self._strips: list[Strip] = []

    def show(self, draw: Draw, what: object = None) -> None:
        """Draw this from now on; nothing is done when just this ``what`` is shown already."""
        if what is not None and what == self._what:
            return
        self._what, self._draw, self._drawn = what, draw, None
        self.refresh()

    def render_line(self, y: int) -> Strip:
        width, height = self.size
        base = self.rich_style
        wanted = (width, height, base, self.app.theme)
        if self._drawn != wanted:
            self._drawn = wanted
            self._strips = self._drawing(width, height, base)
        return self._strips[y] if y < len(self._strips) else Strip.blank(width, base)

    def _drawing(self, width: int, height: int, base: Style) -> list[Strip]:
        least_width, least_height = self.SMALLEST
        if self._draw is None:
            return []
        if width < least_width or height < least_height:
            return strips_of_ansi("no room for the plot; make the window larger", width, base)
        theme = "phosphor" if self.app.current_theme.dark else "light"
        return strips_of_ansi(self._draw(width, height, True, theme), width, base)
