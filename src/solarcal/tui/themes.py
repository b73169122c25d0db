"""Themes: the original's amber on black, black on white for the sun, and Textual's own.

Every theme has ``$axis1`` and ``$axis2``, the colours of the two axes; they are never the only
sign, and with NO_COLOR nothing is lost but colour.
"""

from typing import Any

from textual.app import App
from textual.theme import Theme

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
