"""The footer: every action as a target for mouse or finger, and STOP, always."""

from collections.abc import Sequence
from dataclasses import dataclass

from textual.app import ComposeResult
from textual.containers import Grid, Horizontal
from textual.content import Content
from textual.widgets import Static

from solarcal.tui.base import workstation_of


@dataclass(frozen=True, slots=True)
class FooterEntry:
    """One target: the key to show, the word, and the Textual action it runs."""

    key: str
    label: str
    action: str
    tooltip: str = ""


NARROW_ENTRIES = 14


class FooterKey(Static):
    """A target ten cells wide."""

    DEFAULT_CSS = """
    FooterKey { width: 1fr; height: 1; background: $panel; text-wrap: nowrap; }
    FooterKey:hover { background: $primary; color: $background; }
    """

    def __init__(self, entry: FooterEntry) -> None:
        super().__init__(
            Content.assemble((entry.key, "bold $footer-key-foreground"), f" {entry.label}")
        )
        self.entry = entry
        self.tooltip = entry.tooltip or None

    async def on_click(self) -> None:
        await self.run_action(self.entry.action)


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


ROOMY_COLUMNS = 100
"""From this width of the terminal on nine actions stand in a row of the footer."""


class ActionFooter(Horizontal):
    """Two rows of seven actions, nine where there is room, and STOP.

    What has no room must have a place elsewhere on a narrow screen.
    """

    DEFAULT_CSS = """
    ActionFooter { dock: bottom; height: 2; background: $panel; }
    ActionFooter Grid { grid-size: 7 2; grid-gutter: 0; height: 2; width: 1fr; }
    ActionFooter.-roomy Grid { grid-size: 9 2; }
    """

    def __init__(self, entries: Sequence[FooterEntry]) -> None:
        super().__init__()
        self._entries = tuple(entries)

    def compose(self) -> ComposeResult:
        with Grid():
            for entry in self._entries:
                yield FooterKey(entry)
        yield StopKey()

    def on_mount(self) -> None:
        self._fit_in()

    def on_resize(self) -> None:
        self._fit_in()

    def _fit_in(self) -> None:
        roomy = self.app.size.width >= ROOMY_COLUMNS and len(self._entries) > NARROW_ENTRIES
        self.set_class(roomy, "-roomy")
        for number, key in enumerate(self.query(FooterKey)):
            key.display = roomy or number < NARROW_ENTRIES
