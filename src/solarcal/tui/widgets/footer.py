"""Keys as targets for mouse or finger: the footer with every action, and STOP; a dialog's keys."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.events import Click, MouseMove
from textual.geometry import Offset, Region
from textual.widget import Widget
from textual.widgets import Static

from solarcal.tui.base import workstation_of


@dataclass(frozen=True, slots=True)
class FooterEntry:
    """One target: the key to show, the word, and the Textual action it runs."""

    key: str
    label: str
    action: str
    tooltip: str = ""

    @property
    def words(self) -> Content:
        return Content.assemble((self.key, "bold $footer-key-foreground"), f" {self.label}")


class Keys(Widget):
    """Targets drawn by one widget: one of its own for each made every layout slower."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"keys--pointed-at"}
    DEFAULT_CSS = """
    Keys { width: 1fr; background: $panel; text-wrap: nowrap; }
    Keys > .keys--pointed-at { background: $primary; color: $background; }
    """

    def __init__(self, entries: Sequence[FooterEntry], id: str | None = None) -> None:
        super().__init__(id=id)
        self.entries = tuple(entries)
        self._pointed_at: FooterEntry | None = None
        self._clicked_at = -math.inf

    def places(self) -> Iterator[tuple[FooterEntry, Region]]:
        """The targets that are shown, row by row, and where in this widget each stands."""
        raise NotImplementedError

    def target_at(self, offset: Offset) -> FooterEntry | None:
        return next((entry for entry, place in self.places() if place.contains_point(offset)), None)

    def render(self) -> Content:
        rows = [Content()] * self.size.height
        for entry, place in self.places():
            gap = place.x - rows[place.y].cell_length
            words = self._words(entry).truncate(place.width, pad=True)
            if entry is self._pointed_at:
                words = words.stylize_before(self.get_visual_style("keys--pointed-at"))
            rows[place.y] = Content.assemble(rows[place.y], " " * gap, words)
        return Content("\n").join(rows)

    def _words(self, entry: FooterEntry) -> Content:
        return entry.words

    def on_mouse_move(self, event: MouseMove) -> None:
        self._point_at(self.target_at(event.offset))

    def on_leave(self) -> None:
        self._point_at(None)

    def _point_at(self, entry: FooterEntry | None) -> None:
        if entry is self._pointed_at:
            return
        self._pointed_at = entry
        self.tooltip = (entry and entry.tooltip) or None
        self.refresh()

    async def on_click(self, event: Click) -> None:
        if event.chain > 1 and event.time - self._clicked_at > self.app.CLICK_CHAIN_TIME_THRESHOLD:
            # The rest of a double click that opened the screen this stands on.
            return
        self._clicked_at = event.time
        if entry := self.target_at(event.offset):
            await self.run_action(entry.action)


class KeysInLine(Keys):
    """One row of targets as wide as their words, at the right."""

    DEFAULT_CSS = """
    KeysInLine { height: 1; }
    """

    def places(self) -> Iterator[tuple[FooterEntry, Region]]:
        widths = [self._words(entry).cell_length for entry in self.entries]
        start = max(0, self.size.width - sum(widths))
        for entry, width in zip(self.entries, widths, strict=True):
            yield entry, Region(start, 0, width, 1)
            start += width

    def _words(self, entry: FooterEntry) -> Content:
        return Content.assemble(" ", entry.words)


ROOMY_COLUMNS = 100
"""From this width of the terminal on nine actions stand in a row of the footer."""

NARROW_ENTRIES = 14


class KeysInTwoRows(Keys):
    """Two rows of seven targets, of nine where there is room; each at least ten cells wide."""

    DEFAULT_CSS = """
    KeysInTwoRows { height: 2; }
    """

    def places(self) -> Iterator[tuple[FooterEntry, Region]]:
        roomy = self.app.size.width >= ROOMY_COLUMNS and len(self.entries) > NARROW_ENTRIES
        columns = 9 if roomy else NARROW_ENTRIES // 2
        edges = [self.size.width * column // columns for column in range(columns + 1)]
        for number, entry in enumerate(self.entries[: 2 * columns]):
            row, column = divmod(number, columns)
            start = edges[column]
            yield entry, Region(start, row, edges[column + 1] - start, 1)


class StopKey(Static):
    """STOP: two rows high, at the same place on every screen."""

    DEFAULT_CSS = """
    StopKey {
        width: 10; height: 2; background: $error; color: $background;
        text-style: bold; content-align: center middle; text-align: center;
    }
    StopKey:hover { text-style: bold reverse; }
    """

    def __init__(self, keys: str = "") -> None:
        super().__init__("▌ STOP ▐")
        self._keys = keys
        self.tooltip = "Stop every motion now, without asking"

    def on_mount(self) -> None:
        keys = self._keys or workstation_of(self).stop_keys()
        self.update(f"▌ STOP ▐\n{keys}")

    async def on_click(self) -> None:
        await self.run_action("app.perform('stop')")


class ActionFooter(Horizontal):
    """Two rows of actions, and STOP.

    What has no room must have a place elsewhere on a narrow screen.
    """

    DEFAULT_CSS = """
    ActionFooter { dock: bottom; height: 2; background: $panel; }
    """

    def __init__(self, entries: Sequence[FooterEntry]) -> None:
        super().__init__()
        self._entries = tuple(entries)

    def compose(self) -> ComposeResult:
        yield KeysInTwoRows(self._entries)
        yield StopKey()


class KeyButton(Static):
    """Shows a key and what it does; a click does it too. Never takes the focus from a field.

    A double click does it once: the second was aimed at what stood here before the first.
    """

    DEFAULT_CSS = """
    KeyButton {
        width: auto; height: 3; padding: 0 1; margin-right: 1; border: round $primary;
        border-title-color: $accent; border-title-style: bold; content-align: center middle;
    }
    KeyButton:hover { background: $primary; color: $background; }
    KeyButton.-stop { border: heavy $error; color: $error; text-style: bold; }
    KeyButton.-stop:hover { background: $error; color: $background; }
    """

    def __init__(
        self, shown: str, label: str, action: str, *, stop: bool = False, id: str | None = None
    ) -> None:
        # A frame's title needs the room for the key and its corners.
        words = label.center(len(shown) + 2)
        super().__init__(Content(words), id=id)
        self.cells = len(words) + (4 if stop else 5)
        self.border_title = shown
        self.styles.min_width = len(shown) + 6
        self.runs = action
        self.set_class(stop, "-stop")

    async def on_click(self, event: Click) -> None:
        if event.chain == 1 or self.has_class("-stop"):
            await self.app.run_action(self.runs, default_namespace=self.screen)
