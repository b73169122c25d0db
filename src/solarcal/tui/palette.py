"""The command palette: every action and every calculator by its name, and the themes.

STOP is on it too, where it is on every screen: the list ends above it.
"""

from collections.abc import Callable, Iterator
from functools import partial

from textual.app import ComposeResult
from textual.command import CommandPalette, DiscoveryHit, Hit, Hits, Provider
from textual.containers import Container, Horizontal
from textual.theme import ThemeProvider

from solarcal.tui.base import ONE_IMPORT, ShowsNotices, workstation_of
from solarcal.tui.behind import draw_behind
from solarcal.tui.themes import OWN_THEMES
from solarcal.tui.widgets.footer import StopKey
from solarcal.tui.widgets.lines import NoticeLine


class Palette(CommandPalette, ShowsNotices):
    """Textual's, with notices and STOP below it; ``s`` is a letter here, F12 and Ctrl+S stop."""

    DEFAULT_CSS = """
    Palette CommandList { max-height: 60vh; }
    Palette SearchIcon { color: $foreground; }
    Palette > #foot { dock: bottom; height: auto; background: $panel; }
    Palette > #foot > #stop { height: 2; align-horizontal: right; }
    """

    def compose(self) -> ComposeResult:
        yield from super().compose()
        with Container(id="foot"):
            yield NoticeLine()
            with Horizontal(id="stop"):
                yield StopKey("F12 ^S")

    def _render_content(self) -> None:
        if not draw_behind(self):
            super()._render_content()


class OwnThemesFirst(ThemeProvider):
    """The two made for this program stand before Textual's."""

    @property
    def commands(self) -> list[tuple[str, Callable[[], None]]]:
        own = [theme.name for theme in OWN_THEMES]
        found = dict(super().commands)
        return [(name, found.pop(name)) for name in own if name in found] + list(found.items())


class ActionProvider(Provider):
    """Every action of the workstation with its keys, every calculator, and what they are for."""

    def _entries(self) -> Iterator[tuple[str, str, Callable[[], object]]]:
        with ONE_IMPORT:
            from solarcal.instruments.catalogue import INSTRUMENTS
            from solarcal.tui.calculators import open_calculator

        app = workstation_of(self.screen)
        for action in app.actions:
            run = partial(app.action_perform, action.id)
            yield f"{action.label}   {action.shown}", action.tooltip, run
        yield "Theme", "phosphor, sunlight, and others", app.search_themes
        yield "Picture", "Keep this screen as an SVG file", app.deliver_screenshot
        for one in INSTRUMENTS:
            title = f"Calculator: {one.group}, {one.title}"
            yield title, one.purpose, partial(open_calculator, app, one)

    async def discover(self) -> Hits:
        for title, tooltip, run in self._entries():
            yield DiscoveryHit(title, run, help=tooltip)

    async def search(self, query: str) -> Hits:
        matcher = self.matcher(query)
        for title, tooltip, run in self._entries():
            score = max(matcher.match(title), 0.8 * matcher.match(tooltip))
            if score > 0.0:
                yield Hit(score, matcher.highlight(title), run, help=tooltip)
