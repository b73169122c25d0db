"""The manual's procedure, and the keys as they are bound now."""

import textwrap
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType

from solarcal.tui.base import StationScreen
from solarcal.tui.keys import Action
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, NoticeLine
from solarcal.tui.widgets.text_lines import TextLines

PROCEDURE: tuple[tuple[str | None, str], ...] = (
    ("clock", "Set the unit's clock to true time: 24 s of error are 0.1 deg of Sun."),
    (
        "ref_check",
        "Do a reference check and watch it: both axes home, counts near zero. Repeat it later "
        "in the day to prove that no counts are lost.",
    ),
    (
        "sun_offset",
        "Set Sun Offset: jog the collector exactly onto the Sun. Come from behind, in the "
        "direction the Sun moves, so that backlash is always taken up the same way; if you are "
        "past it, go behind it again first.",
    ),
    (None, "Watch it track for a minute, and see that an update centres it."),
    ("initialise", "Initialise the data file: once per calibration, clear of the limits."),
    (
        "take_point",
        "Take a point: three questions, a few seconds of gathering, then look at the result and "
        "store it or not. After any NO the attempt stays in the file as aborted and is never used.",
    ),
    (
        None,
        "Every 30 to 45 minutes: Set Sun Offset, watch, take a point. Seven points may be "
        "enough; take twelve over the whole day.",
    ),
    (
        "next_plot",
        "From the third point on look at the plot: new points should fall on the last curve, "
        "and the coefficients should stop jumping.",
    ),
    ("upload", "Upload the coefficients; they are read back and compared."),
    ("take_point", "Prove it with two check points, half an hour apart."),
)


def help_lines(actions: tuple[Action, ...], width: int = 78) -> list[str]:
    """The help text for the keys as bound now."""
    by_id = {action.id: action for action in actions}
    lines = ["THE PROCEDURE", ""]
    for number, (action_id, sentence) in enumerate(PROCEDURE, start=1):
        key = f" [{by_id[action_id].shown}]" if action_id is not None else ""
        lines += textwrap.wrap(
            sentence + key, width, initial_indent=f"{number:2}. ", subsequent_indent="    "
        )
    lines += ["", "THE KEYS", ""]
    for action in actions:
        head = f"{action.shown:18} {action.label:12} "
        lines += textwrap.wrap(
            head + action.tooltip, width, subsequent_indent=" " * len(head), drop_whitespace=True
        )
    lines += [
        "",
        "Tab, 1 2 3 4 5     Panes        Now, Points, P1-P6, Plot, Checks",
        "Ctrl+P             Palette      Every action by its name, and the themes",
        "Escape             Back         Leaves a dialog and changes nothing; after a step that",
        "                                is done the key of the next step does, too",
        "",
        *textwrap.wrap(
            "Keys can be changed in keymap.toml in the config folder (solarcal doctor shows "
            "where); solarcal keys shows what this terminal sends.",
            width,
        ),
    ]
    return lines


class HelpScreen(StationScreen):
    """Scrolls; any of F1, ? and Escape leaves it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,f1,question_mark,q", "back", "Back", show=False)
    ]

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield TextLines(id="help")
        yield NoticeLine()
        yield ActionFooter([FooterEntry("Esc", "Back", "screen.back")])

    def on_mount(self) -> None:
        self.query_one("#title", HeadLine).show([("Help", "bold")], ["arrow keys scroll"])
        lines = self.query_one(TextLines)
        lines.show(help_lines(self.workstation.actions, min(self.app.size.width - 4, 100)))
        lines.focus()
