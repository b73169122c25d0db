"""To which point? A number."""

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Input, Static

from solarcal.tui.screens.base import StationModal
from solarcal.tui.widgets.footer import StopKey


class JumpScreen(StationModal[int]):
    """One number, counted from one."""

    DEFAULT_CSS = """
    JumpScreen { align: center middle; }
    JumpScreen > Horizontal {
        width: 56; height: 6; border: heavy $primary; padding: 1 2; background: $surface;
        border-subtitle-style: bold;
    }
    JumpScreen Static { width: auto; }
    JumpScreen Input { width: 1fr; height: 1; border: none; margin: 0 1; }
    """

    def __init__(self, points: int) -> None:
        super().__init__()
        self._points = points

    def compose(self) -> ComposeResult:
        with Horizontal():
            yield Static(f"Jump to point (1 to {self._points}):", markup=False)
            yield Input(type="integer", max_length=5, compact=True)
            yield StopKey()

    def on_mount(self) -> None:
        self.query_one(Input).focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        number = int(event.value) if event.value.isdigit() else 0
        if event.value and not 1 <= number <= self._points:
            self.query_one(Horizontal).border_subtitle = f"! There is no point {event.value}"
        else:
            self.dismiss(number or None)
