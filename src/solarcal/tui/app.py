"""The workstation: one app, one conductor, screens told what the station says."""

from collections.abc import Callable
from typing import Any, ClassVar

from textual.app import App
from textual.binding import BindingType

from solarcal.errors import ProcedureRefused
from solarcal.station.state import StationState
from solarcal.tui.bindings import ACTIONS, STOP_EVERYWHERE
from solarcal.tui.conductor import Conductor
from solarcal.tui.messages import (
    FitReady,
    Progress,
    StateChanged,
    StepDone,
    StepFailed,
    StepStarted,
)
from solarcal.tui.screens.base import StationModal, StationScreen

Performer = Callable[["SolarcalApp"], None]


class SolarcalApp(App[int]):
    """Keys become station commands, ``StationState`` becomes widgets; nothing is calculated here.

    Attributes
    ----------
    conductor : talks to the station while a line is open, else ``None``.
    state, fit : the newest the conductor has told.
    """

    TITLE = "solarcal"
    CSS_PATH = "solarcal.tcss"
    BINDINGS: ClassVar[list[BindingType]] = [
        *(action.binding() for action in ACTIONS),
        STOP_EVERYWHERE,
    ]

    def __init__(self, performers: dict[str, Performer]) -> None:
        super().__init__()
        self.conductor: Conductor | None = None
        self.state = StationState()
        self.fit: FitReady | None = None
        self._performers = performers

    # -- keys to commands --------------------------------------------------------------------

    def action_perform(self, action_id: str) -> None:
        """Do what a key, a click or the palette asked for."""
        if action_id == "stop":
            if self.conductor is not None:
                self.conductor.stop_motion()
            return
        performer = self._performers.get(action_id)
        if performer is not None:
            performer(self)

    def station_conductor(self) -> Conductor:
        """The conductor of the open line."""
        if self.conductor is None:
            raise ProcedureRefused("no unit is connected; choose one on the start screen")
        return self.conductor

    # -- the station to screens --------------------------------------------------------------

    def _told(self) -> list[StationScreen | StationModal[Any]]:
        return [s for s in self.screen_stack if isinstance(s, (StationScreen, StationModal))]

    def on_state_changed(self, message: StateChanged) -> None:
        if message.state.generation < self.state.generation:
            return
        self.state = message.state
        for screen in self._told():
            screen.show_state(message.state)

    def on_fit_ready(self, message: FitReady) -> None:
        if self.fit is not None and message.generation < self.fit.generation:
            return
        self.fit = message
        for screen in self._told():
            screen.show_fit(message)

    def on_progress(self, message: Progress) -> None:
        for screen in self._told():
            screen.show_progress(message)

    def on_step_started(self, message: StepStarted) -> None:
        for screen in self._told():
            screen.step_started(message.name)

    def on_step_done(self, message: StepDone) -> None:
        for screen in self._told():
            screen.step_done(message.name, message.result)

    def on_step_failed(self, message: StepFailed) -> None:
        for screen in self._told():
            screen.step_failed(message.name, message.error)
