"""The keys of the workstation itself: help, plots, an emulator's time, the way out."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from solarcal.errors import ProcedureRefused

if TYPE_CHECKING:
    from solarcal.model.judgement import Judgement
    from solarcal.station.procedure import Station
    from solarcal.tui.app import SolarcalApp
    from solarcal.unit.tracker import Emulation

SPEEDS = (1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0)
LOW_SUN_SKIP_S = 1800.0
"""How far to skip while the Sun is too low and no point is due."""


def open_help(app: "SolarcalApp") -> None:
    from solarcal.tui.screens.help import HelpScreen

    if not isinstance(app.screen, HelpScreen):
        app.push_screen(HelpScreen())


def next_plot(app: "SolarcalApp") -> None:
    from solarcal.tui.screens.replay import ReplayScreen
    from solarcal.tui.screens.workstation import WorkstationScreen

    if isinstance(app.screen, (WorkstationScreen, ReplayScreen)):
        app.screen.next_plot()


def change_theme(app: "SolarcalApp") -> None:
    """Between the theme for the sun and the one chosen before it."""
    app.theme = app.other_theme()


def leave(app: "SolarcalApp") -> None:
    """Out; asks first while something is going on."""
    from solarcal.station.state import Activity
    from solarcal.tui.screens.leave import LeaveScreen

    if isinstance(app.screen, LeaveScreen):
        return
    if app.state.activity is Activity.IDLE or app.conductor is None:
        app.run_worker(app.leave(), exit_on_error=True)
        return

    def answered(yes: bool | None) -> None:
        if yes:
            app.run_worker(app.leave(), exit_on_error=True)

    app.push_screen(LeaveScreen(str(app.state.activity)), answered)


def _emulation(station: "Station") -> "Emulation":
    emulation = station.tracker.emulation
    if emulation is None:
        raise ProcedureRefused("time can only be hurried on an emulated tracker")
    return emulation


def _change_speed(app: "SolarcalApp", step: int) -> None:
    now = app.emulated_speed
    if now is None:
        raise ProcedureRefused("time can only be hurried on an emulated tracker")
    nearest = min(range(len(SPEEDS)), key=lambda index: abs(SPEEDS[index] - now))
    wanted = SPEEDS[min(max(nearest + step, 0), len(SPEEDS) - 1)]
    # The next press may come before the unit has answered this one.
    app.emulated_speed = wanted
    app.station_conductor().submit("speed", lambda s: _emulation(s).set_speed(wanted))


def faster(app: "SolarcalApp") -> None:
    _change_speed(app, +1)


def slower(app: "SolarcalApp") -> None:
    _change_speed(app, -1)


def skip(app: "SolarcalApp") -> None:
    """Let an emulator's time pass until the next point is due."""
    if app.emulated_speed is None:
        raise ProcedureRefused("time can only be skipped on an emulated tracker")
    judgement = app.judgement
    app.station_conductor().submit("skip", lambda station: _skip(station, judgement))


def _skip(station: "Station", judgement: "Judgement | None") -> float:
    from solarcal.station import guards
    from solarcal.station.next_step import next_step

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


WORKSTATION_PERFORMERS: dict[str, Callable[["SolarcalApp"], None]] = {
    "help": open_help,
    "next_plot": next_plot,
    "theme": change_theme,
    "faster": faster,
    "slower": slower,
    "skip": skip,
    "quit": leave,
}
