"""Lines that scroll by keys: tables of the report, sentences, help; and those with a chosen row."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from rich.cells import cell_len
from rich.segment import Segment
from rich.style import Style
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.events import Click
from textual.geometry import Size
from textual.message import Message
from textual.scroll_view import ScrollView
from textual.strip import Strip
from textual.visual import Visual

from solarcal.report.blocks import REMARK_INDENT

ENDLESS = 10_000
"""Columns, for lines that are folded where they are shown."""

Line = str | Content

REMARK = " " * REMARK_INDENT


class TextLines(ScrollView, can_focus=True):
    """Lines of text; only those in view are rendered. The last row says how many more follow.

    Parameters
    ----------
    follow : keep the last line in view when lines are added.
    wrap : fold lines to the width instead of scrolling sideways.
    """

    DEFAULT_CSS = """
    TextLines { height: 1fr; scrollbar-size: 1 1; background: $background; }
    TextLines:focus { background-tint: $foreground 4%; }
    """

    def __init__(
        self,
        id: str | None = None,
        *,
        follow: bool = False,
        wrap: bool = False,
        classes: str | None = None,
    ) -> None:
        super().__init__(id=id, classes=classes)
        self._given: tuple[Line, ...] = ()
        self._lines: tuple[Line, ...] = ()
        self._pinned = 0
        self._follow = follow
        self._wrap = wrap

    @property
    def lines(self) -> tuple[str, ...]:
        """What is shown, as plain text, folded where it is."""
        return tuple(line if isinstance(line, str) else line.plain for line in self._lines)

    def show(self, lines: Sequence[Line], pinned: int = 0) -> None:
        """Show these, the first ``pinned`` always; with ``follow`` the last ones are in view."""
        given = tuple(lines)
        self._pinned = pinned
        if given == self._given:
            return
        self._given = given
        self._lay_out()
        if self._follow:
            self.call_after_refresh(self.scroll_end, animate=False)

    def on_resize(self) -> None:
        if self._wrap:
            self._lay_out()

    def _lay_out(self) -> None:
        width, height = self.content_size
        lines = self._given
        if self._wrap and width > 0:
            lines = _all_folded(self._given, width)
            if len(lines) > height:
                # The scrollbar takes its column.
                lines = _all_folded(self._given, width - self.styles.scrollbar_size_vertical)
        self._lines = lines
        longest = 0 if self._wrap else max((_length(line) for line in lines), default=0)
        self.virtual_size = Size(longest, len(lines))
        self.refresh()

    @property
    def below(self) -> int:
        """How many lines follow below what is in view, with the last row if the mark covers it."""
        (column, top), region = self.scroll_offset, self.scrollable_content_region
        follow = len(self._lines) - top - region.height
        if follow <= 0:
            return 0
        line = self._lines[top + region.height - 1]
        text = line if isinstance(line, str) else line.plain
        covered = cell_len(text.rstrip()) - column > region.width - len(_mark(follow))
        return follow + covered

    def render_line(self, y: int) -> Strip:
        column, row = self.scroll_offset
        region = self.scrollable_content_region
        at = y if y < self._pinned else row + y
        style = self.row_style(at)
        line: Line = self._lines[at] if at < len(self._lines) else ""
        if isinstance(line, Content):
            wide = max(region.width, line.cell_length)
            strips = Visual.to_strips(self, line, wide, 1, self.visual_style)
            strip = strips[0] if strips else Strip.blank(wide, style)
        else:
            strip = Strip([Segment(line, style)])
        strip = strip.crop_extend(column, column + region.width, style)
        below = self.below
        if not below or y != region.height - 1:
            return strip
        words = _mark(below)
        if below > len(self._lines) - row - region.height:
            # Not half a line: none of it.
            strip = Strip.blank(region.width, style)
        mark = Strip([Segment(words, style + Style(bold=True))])
        return Strip.join([strip.crop(0, max(0, region.width - len(words))), mark])

    def line_at(self, event: Click) -> int:
        """Which line a click meant."""
        return event.y if event.y < self._pinned else event.y + self.scroll_offset.y

    def keep_in_view(self, line: int) -> None:
        height, top = self.scrollable_content_region.height, self.scroll_offset.y
        # The last row in view may carry how many more follow.
        if line < top + self._pinned:
            self.scroll_to(y=max(0, line - self._pinned), animate=False)
        elif height and line > top + height - 2:
            self.scroll_to(y=line - height + 2, animate=False)

    def row_style(self, at: int) -> Style:
        """The style of a line; a chosen one differs."""
        del at
        return self.rich_style


def _mark(below: int) -> str:
    return f" ▼ {below} more "


def _length(line: Line) -> int:
    return len(line) if isinstance(line, str) else line.cell_length


def _all_folded(lines: Sequence[Line], width: int) -> tuple[Line, ...]:
    return tuple(part for line in lines for part in _folded(line, width))


def _folded(line: Line, width: int) -> list[Line]:
    """A line in as many rows as it needs, all indented as the first; those of a bullet hang."""
    if _length(line) <= width:
        return [line]
    content = Content(line) if isinstance(line, str) else line
    indent = min(len(content.plain) - len(content.plain.lstrip(" ")), width // 2)
    hang = indent + 2 * content.plain[indent:].startswith("- ")
    first, *rows = content[hang:].wrap(width - hang)
    return [content[:hang] + first, *(Content(" " * hang) + row for row in rows)]


class ChosenLines(TextLines):
    """A table of which one row is chosen by the arrow keys; Enter opens it.

    Rows that begin with a number can be chosen; it is what they are opened by. The chosen row is
    reversed where the table has the focus. Remarks, which are indented, are folded to the width.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "choose(-1)", "Row up", show=False),
        Binding("down", "choose(1)", "Row down", show=False),
        Binding("pageup", "choose_page(-1)", "Page up", show=False),
        Binding("pagedown", "choose_page(1)", "Page down", show=False),
        Binding("home", "choose_end(False)", "First row", show=False),
        Binding("end", "choose_end(True)", "Last row", show=False),
        Binding("enter", "open", "Open", show=False),
    ]

    @dataclass
    class Opened(Message):
        """The row of this number was opened."""

        number: int

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id, follow=True, wrap=True)
        self._rows: tuple[tuple[int, int], ...] = ()
        self._chosen = 0

    def show(self, lines: Sequence[Line], pinned: int = 0) -> None:
        before = len(self._rows)
        super().show(lines, pinned)
        if len(self._rows) != before:
            # A new row is the one to look at.
            self._chosen = max(0, len(self._rows) - 1)

    def _lay_out(self) -> None:
        super()._lay_out()
        heads = [
            (at, line.split(maxsplit=1)[:1])
            for at, line in enumerate(self.lines)
            if not line.startswith(REMARK)
        ]
        self._rows = tuple((at, int(head[0])) for at, head in heads if head and head[0].isdigit())

    def row_style(self, at: int) -> Style:
        style = self.rich_style
        if self.has_focus and self._rows and at == self._rows[self._chosen][0]:
            return style + Style(reverse=True, bold=True)
        return style

    def action_choose(self, step: int) -> None:
        self._choose(self._chosen + step)

    def action_choose_page(self, step: int) -> None:
        room = max(1, self.scrollable_content_region.height - self._pinned - 1)
        self._choose(self._chosen + step * room)

    def action_choose_end(self, last: bool) -> None:
        self._choose(len(self._rows) - 1 if last else 0)

    def _choose(self, row: int) -> None:
        if not self._rows:
            return
        self._chosen = min(max(row, 0), len(self._rows) - 1)
        self.keep_in_view(self._rows[self._chosen][0])
        self.refresh()

    def on_focus(self) -> None:
        self.refresh()

    def on_blur(self) -> None:
        self.refresh()

    def action_open(self) -> None:
        if self._rows:
            self.post_message(self.Opened(self._rows[self._chosen][1]))

    def on_click(self, event: Click) -> None:
        at = self.line_at(event)
        row = next((row for row, (line, _) in enumerate(self._rows) if line == at), None)
        if row is None:
            return
        again = row == self._chosen and self.has_focus
        self._choose(row)
        if again:
            self.action_open()
