"""The command palette: every action and every calculator by its name; and the themes it offers.

STOP is on it too, where it is on every screen: the list ends above it.

The themes are the original's amber on black, black on white for the sun, and Textual's own. Every
theme has ``$axis1`` and ``$axis2``, the colours of the two axes; they are never the only sign, and
with NO_COLOR nothing is lost but colour.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from textual.app import App, ComposeResult
from textual.command import CommandPalette, DiscoveryHit, Hit, Hits, Provider
from textual.containers import Container, Horizontal
from textual.theme import Theme, ThemeProvider

from solarcal.tui.base import ONE_IMPORT, ShowsNotices, workstation_of
from solarcal.tui.behind import draw_behind
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


PHOSPHOR = Theme(
    name="phosphor",
    primary="#ffb000",
    secondary="#33d17a",
    accent="#ffd75f",
    warning="#ffd75f",
    error="#ff5f5f",
    success="#5fff87",
    foreground="#ffc340",
    background="#0a0a06",
    surface="#12110a",
    panel="#211d0c",
    dark=True,
    variables={
        "axis1": "#ffaf00",
        "axis2": "#5fff5f",
        "faint": "#9a7a2a",
        "footer-key-foreground": "#5fff87",
    },
)

SUNLIGHT = Theme(
    name="sunlight",
    primary="#00408a",
    secondary="#005f00",
    accent="#7a1f00",
    warning="#7a3b00",
    error="#b00000",
    success="#005f00",
    foreground="#000000",
    background="#ffffff",
    surface="#ffffff",
    panel="#e4e4e4",
    dark=False,
    variables={"axis1": "#8a4500", "axis2": "#005a00", "faint": "#585858"},
)

OWN_THEMES = (PHOSPHOR, SUNLIGHT)
DEFAULT_THEME = PHOSPHOR.name


def axis_colours(dark: bool) -> dict[str, str]:
    """``$axis1``, ``$axis2`` and ``$faint`` for a theme that does not define them."""
    theme = PHOSPHOR if dark else SUNLIGHT
    return {name: theme.variables[name] for name in ("axis1", "axis2")} | {
        "faint": "#8a8a8a" if dark else "#585858"
    }


def begin_with_theme(app: App[Any], name: str) -> None:
    """Ours and the one chosen, before anything is styled.

    Set later a theme has every sheet parsed anew and the first screen drawn twice.
    """
    for theme in OWN_THEMES:
        app.register_theme(theme)
    chosen = name if name in app.available_themes else DEFAULT_THEME
    app.set_reactive(App.theme, chosen)
    dark = app.current_theme.dark
    classes = {f"-theme-{chosen}": True, "-dark-mode": dark, "-light-mode": not dark}
    app.update_classes(classes, update=False)
    app._refresh_truecolor_filter(app.ansi_theme)
    app.stylesheet.set_variables(app.get_css_variables())
