"""Words written anew with every status; one-row widgets: title, file, log, a text field.

And the row of a terminal too small.
"""

from functools import partial
from typing import TYPE_CHECKING

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Input, Label, OptionList, Static

from solarcal.decimals import decimal
from solarcal.errors import ConfigurationError

if TYPE_CHECKING:
    from textual.geometry import Size
    from textual.notifications import SeverityLevel
from textual.visual import VisualType

Part = str | tuple[str, str] | Content


class Words(Static):
    """A ``Static`` as wide as its place. Words it has already cost nothing; others are drawn, and
    only where they need more rows or fewer, the whole screen is laid out."""

    def update(self, content: VisualType = "", *, layout: bool = True) -> None:
        if _same(content, self.content):
            return
        rows = self._rows
        super().update(content, layout=layout and not self.is_mounted)
        if layout and self.is_mounted and (rows is None or rows != self._rows):
            self.refresh(layout=True)

    @property
    def _rows(self) -> int | None:
        """How many it needs, ``None`` where it is not in view; nought where they are fixed."""
        height = self.styles.height
        if height is not None and not height.is_auto:
            return 0
        width = self.size.width
        return self.get_content_height(self.app.size, self.app.size, width) if width else None


def _same(content: VisualType, before: VisualType) -> bool:
    if isinstance(content, Content):
        return isinstance(before, Content) and content.is_same(before)
    return isinstance(content, str) and isinstance(before, str) and content == before


class Choices(OptionList):
    """A full screen's list to choose from."""

    DEFAULT_CSS = """
    Choices {
        height: 1fr; padding: 0 1; background: $background;
        text-wrap: nowrap; text-overflow: ellipsis;
    }
    Choices, Choices:focus { border: none; }
    Choices > .option-list--option-highlighted { text-style: bold reverse; }
    """


class HeadLine(Words):
    """One row, parts on the left and on the right."""

    DEFAULT_CSS = """
    HeadLine {
        height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; padding: 0 1;
        link-color: $foreground; link-background: $panel; link-style: bold;
    }
    HeadLine#title { background: $primary; color: $background; text-style: bold; }
    """

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._shown: tuple[list[Part], list[Part]] | None = None

    def on_resize(self) -> None:
        # What was cut to the old width may have room now.
        if self._shown is not None:
            self.show(*self._shown)

    def show(self, left: list[Part], right: list[Part] | None = None) -> None:
        self._shown = (left, right or [])
        start, end = Content.assemble(*left), Content.assemble(*(right or []))
        # Not the size of this widget: before the first layout it has none.
        room = max(self.app.size.width - 2, 20)
        gap = room - start.cell_length - end.cell_length
        if gap < 1:
            start = start.truncate(max(1, room - end.cell_length - 1), ellipsis=True)
            gap = 1
        self.update(Content.assemble(start, " " * gap, end), layout=False)


SEVERITIES: "tuple[SeverityLevel, ...]" = ("error", "warning", "information")
MARKS = {"error": "! ", "warning": "! ", "information": ""}


class LogLine(HeadLine):
    """The newest thing worth telling; an error stays until something else happens.

    Notices stand here for their time, in rows of their own, and cover nothing.
    """

    DEFAULT_CSS = """
    LogLine { background: $background; }
    LogLine.-error, LogLine.-warning, LogLine.-information {
        text-style: bold; height: auto; max-height: 4; text-wrap: wrap; text-overflow: fold;
    }
    LogLine.-long { height: auto; max-height: 4; text-wrap: wrap; text-overflow: fold; }
    LogLine.-error { background: $error; color: $background; }
    LogLine.-warning { background: $warning; color: $background; }
    """

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._said: tuple[str, bool] = ("", False)
        self._brief = False
        self._notices: list[tuple[SeverityLevel, str]] = []

    def on_resize(self) -> None:
        self._show_newest()

    def say(self, sentence: str, *, error: bool = False, brief: bool = False) -> None:
        """Show a sentence, in as many rows as it needs; one that is ``brief`` in one, cut."""
        self._said = (sentence, error)
        self._brief = brief
        if error:
            self._notices.clear()
        self._show_newest()

    def notice(self, sentence: str, severity: "SeverityLevel", seconds: float) -> None:
        """Show this for so long, whatever comes meanwhile; only an error takes its place."""
        one = (severity, sentence)
        self._notices.append(one)
        self.set_timer(seconds, partial(self._over, one))
        self._show_newest()

    def forget_notices(self) -> None:
        """What has happened since has overtaken them; an error stays for its time."""
        self._notices = [one for one in self._notices if one[0] == "error"]
        self._show_newest()

    def _over(self, one: "tuple[SeverityLevel, str]") -> None:
        if one in self._notices:
            self._notices.remove(one)
            self._show_newest()

    def _show_newest(self) -> None:
        sentence, error = self._said
        worst = next((s for s in SEVERITIES if s in {level for level, _ in self._notices}), None)
        tone = worst or ("error" if error else None)
        for severity in SEVERITIES:
            self.set_class(severity == tone, f"-{severity}")
        # A sentence that needs more than a row has it: none is cut.
        long = len(sentence) >= self.app.size.width - 2 and not self._brief
        self.set_class(tone is None and long, "-long")
        self._shown = None
        if worst is not None:
            # The newest first: where there is no room for all, they are the ones to read.
            said = [f"{MARKS[level]}{words}" for level, words in reversed(self._notices)]
            self.update(Content("\n".join(said)))
        elif error:
            # An error is worth more than one row.
            self.update(Content(f"! {sentence}"))
        elif self.has_class("-long"):
            self.update(Content(sentence))
        else:
            self.show([sentence])


class NoticeLine(LogLine):
    """Notices on a screen that has nothing else to log: no row of it without one."""

    DEFAULT_CSS = """
    NoticeLine { display: none; }
    NoticeLine.-error, NoticeLine.-warning, NoticeLine.-information { display: block; }
    """


LEAST = (80, 24)
"""Columns and rows everything is laid out for."""


class TooSmall(Static):
    """One row on top; a click on it is a STOP, for STOP's own place may be out of sight."""

    DEFAULT_CSS = """
    TooSmall {
        dock: top; height: 1; width: 100%; background: $error; color: $background;
        text-style: bold; text-wrap: nowrap;
    }
    """

    async def on_click(self) -> None:
        await self.run_action("app.perform('stop')")


def say_if_too_small(screen: Screen[object], size: "Size") -> None:
    """Put the row there, or take it away."""
    there = screen.query(TooSmall)
    if size.width >= LEAST[0] and size.height >= LEAST[1]:
        there.remove()
        return
    words = f"STOP: F12 or here. {size.width}x{size.height}: make it {LEAST[0]}x{LEAST[1]}"
    if there:
        there.first().update(words)
    elif screen.is_mounted:
        screen.mount(TooSmall(words))


class Field(Horizontal):
    """``value`` is what was typed; ``number`` what it means."""

    DEFAULT_CSS = """
    Field { height: 1; }
    Field > .label { width: 28; }
    Field > Input { width: 1fr; max-width: 40; background: $panel; }
    Field > .unit { width: auto; padding-left: 1; color: $text-muted; }
    """

    def __init__(self, id: str, label: str, unit: str = "", value: str = "") -> None:
        super().__init__(id=id)
        self._label, self._unit, self._value = label, unit, value

    def compose(self) -> ComposeResult:
        yield Label(self._label, classes="label", markup=False)
        yield Input(self._value, compact=True)
        if self._unit:
            yield Label(self._unit, classes="unit", markup=False)

    @property
    def input(self) -> Input:
        return self.query_one(Input)

    @property
    def value(self) -> str:
        return self.input.value.strip()

    def number(self) -> float:
        """The number typed, a comma taken for a point; ConfigurationError where it is none."""
        try:
            return decimal(self.value, comma=True)
        except ConfigurationError as error:
            raise ConfigurationError(f"{self._label}: {error}") from None
