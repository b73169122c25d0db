"""What every screen of the workstation can be told, and the STOP it always carries."""

from typing import TYPE_CHECKING, ClassVar, TypeVar, cast

from textual.binding import Binding, BindingType
from textual.screen import ModalScreen, Screen

from solarcal.errors import SolarcalError
from solarcal.tui.messages import FitReady, Progress
from solarcal.tui.widgets.too_small import say_if_too_small

if TYPE_CHECKING:
    from textual.geometry import Size

    from solarcal.station.state import StationState
    from solarcal.tui.app import SolarcalApp

Result = TypeVar("Result")


class _Told:
    """Hooks the app calls on every screen of the stack, on the event loop."""

    def on_screen_resume(self) -> None:
        # An older one may have been covered while the terminal changed.
        screen = cast("Screen[object]", self)
        say_if_too_small(screen, screen.app.size)

    def show_size(self, size: "Size") -> None:
        """The terminal is this large now."""
        say_if_too_small(cast("Screen[object]", self), size)

    def show_state(self, state: "StationState") -> None:
        """The station's newest state."""

    def show_fit(self, fit: FitReady) -> None:
        """The newest fit of the session."""

    def show_progress(self, progress: Progress) -> None:
        """How far a long step is."""

    def step_started(self, name: str) -> None:
        """A station command has begun."""

    def step_done(self, name: str, result: object) -> None:
        """A station command has returned."""

    def step_failed(self, name: str, error: SolarcalError) -> None:
        """A station command was refused or failed."""


class StationScreen(_Told, Screen[None]):
    """A full screen."""

    @property
    def station_app(self) -> "SolarcalApp":
        return cast("SolarcalApp", self.app)


class StationModal(_Told, ModalScreen[Result]):
    """A dialog. ``escape`` leaves it and changes nothing; STOP works here too."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("s", "app.perform('stop')", "STOP", show=False, id="stop"),
        Binding("escape", "leave", "Back", show=False),
    ]

    @property
    def station_app(self) -> "SolarcalApp":
        return cast("SolarcalApp", self.app)

    def palette_refused(self) -> None:
        """The palette was asked for, and does not open over a dialog."""

    def action_leave(self) -> None:
        self.dismiss(None)
