"""The actions of the workstation: what each does, and the help that lists them.

This module knows every screen, so it is imported after the first paint, or at the first key.
"""

import textwrap
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType

from solarcal.errors import ProcedureRefused
from solarcal.station import guards
from solarcal.station.news import SpeedTold, TimeSkipped
from solarcal.station.next_step import next_step
from solarcal.station.state import PENDING, Activity
from solarcal.tui import recompute
from solarcal.tui.base import StationScreen, Workstation, show_once
from solarcal.tui.calculators import open_list
from solarcal.tui.dialogs import ref_check, report
from solarcal.tui.dialogs.data_file import InitialiseDialog, LeaveDialog, NoteDialog, VoidDialog
from solarcal.tui.dialogs.dialog import Dialog, open_dialog
from solarcal.tui.dialogs.link import ClockDialog, open_link
from solarcal.tui.dialogs.upload import UploadDialog
from solarcal.tui.keys import Action
from solarcal.tui.offset import dialog as offset_dialog
from solarcal.tui.plan import open_screen as open_plan
from solarcal.tui.point.dialog import TakePointDialog
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, NoticeLine
from solarcal.tui.widgets.text_lines import TextLines
from solarcal.tui.workstation.view import PanesScreen

if TYPE_CHECKING:
    from solarcal.model.analysis import Analysis
    from solarcal.station.procedure import Station
    from solarcal.unit.tracker import Emulation

ActionHandler = Callable[[Workstation], None]

SPEEDS = (1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0)
LOW_SUN_SKIP_S = 1800.0
"""How far to skip while the Sun is too low and no point is due."""


def opens(dialog: Callable[[], Dialog]) -> ActionHandler:
    """What opens a dialog of the procedure."""
    return lambda app: open_dialog(app, dialog())


def open_help(app: Workstation) -> None:
    show_once(app, HelpScreen, HelpScreen)


def next_plot(app: Workstation) -> None:
    if isinstance(app.screen, PanesScreen):
        app.screen.next_plot()


def leave(app: Workstation) -> None:
    """Out; asks first while something is going on."""
    if isinstance(app.screen, LeaveDialog):
        return
    if app.state.activity is Activity.IDLE or app.worker is None:
        app.leave_soon()
    else:
        app.push_screen(LeaveDialog(PENDING[app.state.activity].sentence))


def _emulation(station: "Station") -> "Emulation":
    emulation = station.tracker.emulation
    if emulation is None:
        raise ProcedureRefused("only emulated time can be accelerated")
    return emulation


def _change_speed(app: Workstation, step: int) -> None:
    now = app.emulated_speed
    if now is None:
        raise ProcedureRefused("only emulated time can be accelerated")
    nearest = min(range(len(SPEEDS)), key=lambda index: abs(SPEEDS[index] - now))
    wanted = SPEEDS[min(max(nearest + step, 0), len(SPEEDS) - 1)]
    # The next press may come before the unit has answered this one.
    app.emulated_speed = wanted
    # Beside a reference check that runs: it is what one wants to be faster.
    app.station_worker().submit_beside(SpeedTold, lambda s: _emulation(s).set_speed(wanted))


def skip(app: Workstation) -> None:
    """Let an emulator's time pass until the next point is due."""
    if app.emulated_speed is None:
        raise ProcedureRefused("time can only be skipped on an emulated tracker")
    judgement = app.judgement
    app.station_worker().submit(TimeSkipped, lambda station: _skip(station, judgement))


def _skip(station: "Station", judgement: "Analysis | None") -> float:
    emulation = _emulation(station)
    elevation = station.sun_elevation_deg()
    step = next_step(station.state, elevation, judgement)
    wait_s = step.countdown_s(station.clock.utc_s())
    if wait_s is None and elevation < guards.MIN_ELEVATION_DEG:
        wait_s = LOW_SUN_SKIP_S
    if not wait_s:
        raise ProcedureRefused(f"there is nothing to wait for. {step.sentence}")
    emulation.advance(round(wait_s, 3))
    station.poll()
    return wait_s


ACTION_HANDLERS: dict[str, ActionHandler] = {
    "link": open_link,
    "initialise": opens(InitialiseDialog),
    "ref_check": ref_check.open_screen,
    "sun_offset": offset_dialog.open_screen,
    "take_point": opens(TakePointDialog),
    "upload": opens(UploadDialog),
    "recompute": recompute.open_screen,
    "clock": opens(ClockDialog),
    "plan": open_plan,
    "report": report.open_screen,
    "void": opens(VoidDialog),
    "note": opens(NoteDialog),
    "calculators": open_list,
    "help": open_help,
    "next_plot": next_plot,
    "theme": lambda app: app.change_theme(),
    "alerts": lambda app: app.switch_alerts(),
    "faster": lambda app: _change_speed(app, +1),
    "slower": lambda app: _change_speed(app, -1),
    "skip": skip,
    "quit": leave,
}


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
        "                                is done or refused the key of the next does, too",
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
