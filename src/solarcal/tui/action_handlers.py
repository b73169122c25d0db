"""What each action of the workstation does: the screen it opens, or why it does not.

This module knows every screen, so it is imported after the first paint, or at the first key.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from solarcal.errors import ProcedureRefused
from solarcal.station import guards
from solarcal.station.news import SpeedTold, TimeSkipped
from solarcal.station.next_step import next_step
from solarcal.station.state import Activity
from solarcal.tui import recompute
from solarcal.tui.base import Workstation, show_once
from solarcal.tui.calculators import open_list
from solarcal.tui.dialogs import ref_check, report
from solarcal.tui.dialogs.data_file import InitialiseDialog, LeaveDialog, NoteDialog, VoidDialog
from solarcal.tui.dialogs.dialog import Dialog, open_dialog
from solarcal.tui.dialogs.link import ClockDialog, open_link
from solarcal.tui.dialogs.upload import UploadDialog
from solarcal.tui.help import HelpScreen
from solarcal.tui.offset import dialog as offset_dialog
from solarcal.tui.plan import open_screen as open_plan
from solarcal.tui.point.dialog import TakePointDialog
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
        app.push_screen(LeaveDialog(str(app.state.activity)))


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
