"""Plain lines that scroll: tables of the report, and help."""

from collections.abc import Sequence

from rich.segment import Segment
from textual.geometry import Size
from textual.scroll_view import ScrollView
from textual.strip import Strip


class TextLines(ScrollView, can_focus=True):
    """Lines of text; only those in view are rendered."""

    DEFAULT_CSS = """
    TextLines { height: 1fr; scrollbar-size: 1 1; background: $background; }
    TextLines:focus { background-tint: $foreground 4%; }
    """

    def __init__(self, id: str | None = None, *, follow: bool = False) -> None:
        super().__init__(id=id)
        self._lines: tuple[str, ...] = ()
        self._pinned = 0
        self._follow = follow

    @property
    def lines(self) -> tuple[str, ...]:
        return self._lines

    def show(self, lines: Sequence[str], pinned: int = 0) -> None:
        """Show these, the first ``pinned`` always; with ``follow`` the last ones are in view."""
        lines = tuple(lines)
        self._pinned = pinned
        if lines == self._lines:
            return
        self._lines = lines
        self.virtual_size = Size(max(map(len, lines), default=0), len(lines))
        self.refresh()
        if self._follow:
            self.call_after_refresh(self.scroll_end, animate=False)

    def render_line(self, y: int) -> Strip:
        column, row = self.scroll_offset
        style = self.rich_style
        at = y if y < self._pinned else row + y
        text = self._lines[at] if at < len(self._lines) else ""
        line = Strip([Segment(text, style)])
        return line.crop_extend(column, column + self.size.width, style)
