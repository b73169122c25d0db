"""Leaving in the middle of something: asked once."""

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.widgets import Button, Static

from solarcal.tui.base import StationModal
from solarcal.tui.widgets.footer import StopKey


class LeaveScreen(StationModal[bool]):
    """Yes or no."""

    DEFAULT_CSS = """
    LeaveScreen { align: center middle; }
    LeaveScreen > Vertical {
        width: 64; height: auto; border: heavy $warning; padding: 1 2; background: $surface;
    }
    LeaveScreen Horizontal { height: auto; margin-top: 1; }
    LeaveScreen Button { margin-right: 2; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Leave", show=False),
        Binding("n", "answer(False)", "Stay", show=False),
    ]

    def __init__(self, activity: str) -> None:
        super().__init__()
        self._activity = activity

    def compose(self) -> ComposeResult:
        with Vertical():
            yield Static(
                f"The station is in the middle of: {self._activity}.\n"
                "Leaving now aborts it; an attempt at a point is kept as aborted.\n"
                "Leave?",
                markup=False,
            )
            with Horizontal():
                yield Button("y  Leave", id="yes", variant="warning")
                yield Button("n  Stay", id="no", variant="primary")
                yield StopKey()

    def on_mount(self) -> None:
        self.query_one("#no").focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        self.dismiss(event.button.id == "yes")

    def action_answer(self, yes: bool) -> None:
        self.dismiss(yes)
