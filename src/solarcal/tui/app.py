"""The workstation: one app, one conductor, screens told what the station says."""

import asyncio
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
from textual import events
from textual.app import App, SystemCommand
from textual.binding import BindingType
from textual.screen import Screen

from solarcal.config import Choice, Settings, save_settings
from solarcal.errors import ConfigurationError, ProcedureRefused, SolarcalError
from solarcal.profiles import Profile
from solarcal.tui.bindings import ACTIONS, STOP_EVERYWHERE, Action
from solarcal.tui.fitting import Fitter
from solarcal.tui.keyboard import bound_actions, modified_f3
from solarcal.tui.messages import (
    FitReady,
    LineFailed,
    LineOpened,
    Progress,
    StateChanged,
    StepDone,
    StepFailed,
    StepStarted,
)
from solarcal.tui.performers import Performer
from solarcal.tui.screens.base import StationModal, StationScreen
from solarcal.tui.screens.start import StartScreen
from solarcal.tui.themes import DEFAULT_THEME, OWN_THEMES, axis_colours

if TYPE_CHECKING:
    from textual.command import Provider

    from solarcal.station.procedure import Station
    from solarcal.station.state import StationState
    from solarcal.tui.conductor import Conductor
    from solarcal.tui.opening import OpenLine

NOTICED_S = 20.0
"""How long something noticed while opening stays on the screen."""


def _action_provider() -> "type[Provider]":
    from solarcal.tui.palette import ActionProvider

    return ActionProvider


class SolarcalApp(App[int]):
    """Keys become station commands, ``StationState`` becomes widgets; nothing is calculated here.

    Parameters
    ----------
    performers : what each action does.
    settings, profile, keymap : the user's; defaults without them.
    start : open this at once instead of asking.
    output, trace : the first session file; a transcript of the line.
    remember : write settings back to the config folder.

    Attributes
    ----------
    conductor : talks to the station while a line is open, else ``None``.
    line : the open line, else ``None``.
    state, fit : the newest the conductor and the fitter have told.
    """

    TITLE = "solarcal"
    CSS_PATH = "solarcal.tcss"
    COMMANDS = App.COMMANDS | {_action_provider}
    BINDINGS: ClassVar[list[BindingType]] = [
        *(action.binding() for action in ACTIONS),
        STOP_EVERYWHERE,
    ]

    def __init__(
        self,
        performers: dict[str, Performer],
        *,
        settings: Settings | None = None,
        profile: Profile | None = None,
        keymap: Mapping[str, str] | None = None,
        start: Choice | None = None,
        output: Path | None = None,
        trace: str | None = None,
        remember: bool = False,
    ) -> None:
        super().__init__()
        self.conductor: Conductor | None = None
        self.line: OpenLine | None = None
        self._state: StationState | None = None
        self.fit: FitReady | None = None
        self.settings = settings or Settings()
        self.profile = profile or Profile()
        self.actions: tuple[Action, ...] = bound_actions(keymap or {})
        self._performers = performers
        self._start = start
        self._output, self._trace = output, trace
        self._remember = remember
        self._keymap_given = dict(keymap or {})
        self._fitter = Fitter(self.post_message)
        self._fitted: object = None
        self._opening = False
        self._leaving = False
        self._path: Path | None = None
        self.emulated_speed: float | None = None

    @property
    def state(self) -> "StationState":
        """The newest state the conductor has told; an empty one before there is a conductor."""
        if self._state is None:
            # Numpy comes with it: not before the first paint.
            from solarcal.station.state import StationState

            self._state = StationState()
        return self._state

    # -- life ----------------------------------------------------------------------------------

    def get_default_screen(self) -> Screen[Any]:
        return StartScreen()

    def get_system_commands(self, screen: Screen[Any]) -> Iterator[SystemCommand]:
        """Of Textual's own commands those a technician has a use for."""
        yield SystemCommand("Theme", "phosphor, sunlight, and others", self.search_themes)
        yield SystemCommand("Picture", "Keep this screen as an SVG file", self.deliver_screenshot)

    def get_theme_variable_defaults(self) -> dict[str, str]:
        return axis_colours(self.current_theme.dark)

    def on_mount(self) -> None:
        for theme in OWN_THEMES:
            self.register_theme(theme)
        known = self.settings.theme in self.available_themes
        self.theme = self.settings.theme if known else DEFAULT_THEME
        self.theme_changed_signal.subscribe(self, lambda theme: self._theme_chosen(theme.name))
        if self._keymap_given:
            self.set_keymap(self._keymap_given)
        self._fitter.start()
        self.call_after_refresh(self._after_first_paint)

    def _after_first_paint(self) -> None:
        """What takes long to import is fetched while the technician reads the first screen."""
        threading.Thread(target=_prewarm, name="prewarm", daemon=True).start()
        if self._start is not None:
            self.open_choice(self._start)

    def _theme_chosen(self, name: str) -> None:
        if name != self.settings.theme:
            self.remember(msgspec.structs.replace(self.settings, theme=name))

    def remember(self, settings: Settings) -> None:
        """Keep settings, in the config folder too unless this run shall leave no trace."""
        self.settings = settings
        if not self._remember:
            return
        try:
            save_settings(settings)
        except ConfigurationError as error:
            self.notify(str(error), severity="warning")

    # -- the line ------------------------------------------------------------------------------

    def open_choice(self, choice: Choice) -> None:
        """Open a unit or an emulated one, or replay a session."""
        if choice.replay:
            self._open_replay(choice)
        elif self.line is not None or self._opening:
            self.notify("a unit is connected already; quit first", severity="warning")
        else:
            self._opening = True
            self._tell_start(f"opening {choice.words()} ...")
            arguments = (choice, self.profile)
            threading.Thread(
                target=self._open_in_thread, args=arguments, name="opening", daemon=True
            ).start()

    def _open_replay(self, choice: Choice) -> None:
        from solarcal.station.replay import Replay
        from solarcal.tui.screens.replay import ReplayScreen

        try:
            replay = Replay.open(Path(choice.replay))
        except SolarcalError as error:
            self._tell_start(str(error), error=True)
            return
        self.remember(msgspec.structs.replace(self.settings, last=choice))
        self.push_screen(ReplayScreen(replay, Path(choice.replay).name))

    def _open_in_thread(self, choice: Choice, profile: Profile) -> None:
        from solarcal.tui.opening import open_line

        try:
            line = open_line(choice, profile, output=self._output, trace=self._trace)
        except SolarcalError as error:
            self.post_message(LineFailed(error))
        else:
            self.post_message(LineOpened(line))

    def on_line_failed(self, message: LineFailed) -> None:
        self._opening = False
        self._tell_start(str(message.error), error=True)

    def on_line_opened(self, message: LineOpened) -> None:
        from solarcal.tui.screens.workstation import WorkstationScreen

        self._opening = False
        self.line = message.line
        self._output = None
        self.adopt(message.line.station)
        self.push_screen(WorkstationScreen())
        for sentence in message.line.noticed:
            self.notify(sentence, severity="warning", timeout=NOTICED_S)

    def adopt(self, station: "Station") -> None:
        """Conduct this station from now on."""
        from solarcal.tui.conductor import Conductor

        self.conductor = Conductor(station, self.post_message)
        self.emulated_speed = 1.0 if station.tracker.emulation is not None else None
        self.conductor.start()
        self.on_state_changed(StateChanged(station.state))

    def _tell_start(self, sentence: str, *, error: bool = False) -> None:
        for screen in self.screen_stack:
            if isinstance(screen, StartScreen):
                screen.tell(sentence, error=error)

    async def leave(self) -> None:
        """Close file and line, and end the program. Whatever was acknowledged is in the file."""
        self._leaving = True
        conductor, line = self.conductor, self.line
        if conductor is not None:
            await asyncio.to_thread(conductor.close)
        self._fitter.close()
        if line is not None:
            try:
                await asyncio.to_thread(line.close)
            except SolarcalError as error:
                self.exit(error.exit_code, message=f"solarcal: {error}")
                return
        self.exit(0, message=f"session file: {line.path}" if line is not None else None)

    def release(self) -> None:
        """After a crash of the program itself: free file and line; nothing is written."""
        if self.line is not None:
            self.line.resources.close()

    # -- keys to commands ----------------------------------------------------------------------

    def action_perform(self, action_id: str) -> None:
        """Do what a key, a click or the palette asked for."""
        if action_id == "stop":
            if self.conductor is not None:
                self.conductor.stop_motion()
            return
        performer = self._performers.get(action_id)
        if performer is None:
            return
        try:
            performer(self)
        except SolarcalError as error:
            self.notify(str(error), severity="warning")
            self.post_message(StepFailed(action_id, error))

    async def action_quit(self) -> None:
        """Textual's own way out takes ours."""
        self.action_perform("quit")

    def on_cursor_position(self, event: events.CursorPosition) -> None:
        """Turn the report that is none back into the key it was."""
        key = modified_f3(event.y + 1, event.x + 1)
        if key is not None:
            self.simulate_key(key)

    def station_conductor(self) -> "Conductor":
        """The conductor of the open line."""
        if self.conductor is None:
            raise ProcedureRefused("no unit is connected; choose one on the start screen")
        return self.conductor

    def keys_of(self, action_id: str | None) -> str:
        """The keys of an action as bound now, for a sentence; the first two."""
        action = next((a for a in self.actions if a.id == action_id), None)
        return " ".join(action.shown.split()[:2]) if action is not None else ""

    # -- the station to screens ----------------------------------------------------------------

    def _told(self) -> list[StationScreen | StationModal[Any]]:
        if self._leaving:
            # Screens are being taken down; what still comes is for the file, not for them.
            return []
        return [s for s in self.screen_stack if isinstance(s, (StationScreen, StationModal))]

    def on_state_changed(self, message: StateChanged) -> None:
        if message.state.generation < self.state.generation:
            return
        self._state = message.state
        self._remember_file()
        self._fit_if_needed(message.state)
        for screen in self._told():
            screen.show_state(message.state)

    @property
    def session_name(self) -> str:
        """Name of the open session file."""
        return self._path.name if self._path is not None else ""

    def _remember_file(self) -> None:
        """On which line each session was taken: after a crash it goes on there."""
        path = self.conductor.station.session_path if self.conductor is not None else None
        if path is None or path == self._path:
            return
        self._path = path
        if self.line is None:
            return
        plain = msgspec.structs.replace(self.line.choice, session="", start_utc="")
        settings = msgspec.structs.replace(self.settings, last=plain)
        self.remember(settings.with_line(path, plain))

    def _fit_if_needed(self, state: "StationState") -> None:
        """A fit costs milliseconds, a status comes every second: only when the points changed."""
        session = state.session
        if session is None:
            return
        wanted = (session.header, session.points)
        if wanted != self._fitted:
            self._fitted = wanted
            self._fitter.fit(state.generation, session)

    def on_fit_ready(self, message: FitReady) -> None:
        if self.fit is not None and message.generation < self.fit.generation:
            return
        self.fit = message
        self._record_fit(message)
        for screen in self._told():
            screen.show_fit(message)

    def _record_fit(self, fit: FitReady) -> None:
        """Keep what the fit said after a point: the history of the coefficients."""
        solution = fit.solution
        if self.conductor is None or solution is None or fit.session.fit_recorded:
            return

        def record(station: "Station") -> None:
            # Meanwhile another point may have come, or its own step has recorded the fit.
            session = station.session
            if not session.fit_recorded and solution.n_points == len(session.accepted):
                station.record_fit(solution)

        self.conductor.submit("fit", record)

    def on_progress(self, message: Progress) -> None:
        for screen in self._told():
            screen.show_progress(message)

    def on_step_started(self, message: StepStarted) -> None:
        for screen in self._told():
            screen.step_started(message.name)

    def on_step_done(self, message: StepDone) -> None:
        # A speed asked for while this one was on its way is the newer one.
        newest = self.conductor is not None and not self.conductor.busy
        if message.name == "speed" and isinstance(message.result, float) and newest:
            self.emulated_speed = message.result
        for screen in self._told():
            screen.step_done(message.name, message.result)

    def on_step_failed(self, message: StepFailed) -> None:
        for screen in self._told():
            screen.step_failed(message.name, message.error)


def _prewarm() -> None:
    """Import what the first plot and the first Sun need."""
    import erfa  # noqa: F401
    import plotext  # noqa: F401

    import solarcal.report.plots
    import solarcal.sun.precise
    import solarcal.tui.opening
    import solarcal.tui.screens.workstation
    import solarcal.tui.widgets.workstation_view  # noqa: F401
