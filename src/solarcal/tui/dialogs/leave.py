"""Leaving in the middle of something: asked once."""

from collections.abc import Iterable
from typing import ClassVar

from textual.widget import Widget
from textual.widgets import Static

from solarcal.tui.dialogs.dialog import Dialog, DialogKey


class LeaveDialog(Dialog):
    """Yes or no; needs no unit."""

    HEADING = "Leave"
    LEAVE = "Stay"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("out", "Leave", "y", "y"),
        DialogKey("leave", "Stay", "n,enter", "n", button=False),
    )

    def __init__(self, activity: str) -> None:
        super().__init__()
        self._activity = activity

    def body(self) -> Iterable[Widget]:
        yield Static(
            f"The station is in the middle of: {self._activity}.\n"
            "Leaving now aborts it; an attempt at a point is recorded as aborted.",
            markup=False,
        )

    def on_mount(self) -> None:
        super().on_mount()
        self.say("Leave?", "warning")

    def action_out(self) -> None:
        self.dismiss(None)
        self.workstation.leave_soon()
