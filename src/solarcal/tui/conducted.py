"""The station under the app: its conductor, its newest state and fit, and who is told of them."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from textual.app import App

from solarcal.errors import ProcedureRefused
from solarcal.tui.fitting import Fitter
from solarcal.tui.messages import (
    FitReady,
    Progress,
    StateChanged,
    StepDone,
    StepFailed,
    StepStarted,
)
from solarcal.tui.screens.base import StationModal, StationScreen

if TYPE_CHECKING:
    from solarcal.station.procedure import Station
    from solarcal.station.state import StationState
    from solarcal.tui.conductor import Conductor


class ConductedApp(App[int]):
    """Messages of the conductor and the fitter become the newest state, and go on to the screens.

    Attributes
    ----------
    conductor : talks to the station while a line is open, else ``None``.
    state, fit : the newest the conductor and the fitter have told.
    emulated_speed : virtual seconds a second of an emulated unit, ``None`` for a real one.
    """

    def __init__(self) -> None:
        super().__init__()
        self.conductor: Conductor | None = None
        self.fit: FitReady | None = None
        self.emulated_speed: float | None = None
        self._state: StationState | None = None
        self._fitter = Fitter(self.post_message)
        self._fitted: object = None
        self._path: Path | None = None
        self._leaving = False

    @property
    def state(self) -> "StationState":
        """The newest state the conductor has told; an empty one before there is a conductor."""
        if self._state is None:
            # Numpy comes with it: not before the first paint.
            from solarcal.station.state import StationState

            self._state = StationState()
        return self._state

    def adopt(self, station: "Station") -> None:
        """Conduct this station from now on."""
        from solarcal.tui.conductor import Conductor

        self.conductor = Conductor(station, self.post_message)
        self.conductor.start()
        emulation = station.tracker.emulation
        if emulation is not None:
            self.emulated_speed = 1.0
            # Another process may have been told another speed; only the unit knows.
            self.conductor.submit("speed", lambda station: emulation.speed())
        self.on_state_changed(StateChanged(station.state))

    def station_conductor(self) -> "Conductor":
        """The conductor of the open line."""
        if self.conductor is None:
            raise ProcedureRefused("no unit is connected; choose one on the start screen")
        return self.conductor

    # -- telling the screens -------------------------------------------------------------------

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
        path = self.conductor.station.session_path if self.conductor is not None else None
        if path is not None and path != self._path:
            self._path = path
            self.file_opened(path)

    def file_opened(self, path: Path) -> None:
        """The session goes into another file now."""

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
