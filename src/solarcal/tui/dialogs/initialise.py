"""Initialize data file: asks for verification; once per calibration, never near a limit."""

from collections.abc import Iterable
from typing import Any, ClassVar

from textual.widget import Widget
from textual.widgets import Input

from solarcal.session.records import Initialised
from solarcal.station.guards import GuardRefused, near_limit_threshold_deg
from solarcal.station.news import Done, FileInitialised, StepFailed
from solarcal.station.procedure import Station
from solarcal.station.state import StationState
from solarcal.tui.base import Workstation
from solarcal.tui.dialogs.dialog import Dialog, DialogKey, open_dialog
from solarcal.tui.widgets.lines import Field, Words


def open_screen(app: Workstation) -> None:
    open_dialog(app, InitialiseDialog())


class InitialiseDialog(Dialog):
    """Confirmation; a refusal near a limit may be overruled with a reason, which is recorded."""

    HEADING = "Initialise the data file"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("begin", "Yes, begin the calibration", "y", "y"),
        DialogKey("override", "Override, with a reason", "o", "o"),
        DialogKey("leave", "No", "n", "n", button=False),
    )
    LEAVE = "No"

    def __init__(self) -> None:
        super().__init__()
        self._again = False

    def body(self) -> Iterable[Widget]:
        yield Words("", id="asked", markup=False)
        field = Field("reason", "Reason for the override")
        field.display = False
        yield field

    def on_mount(self) -> None:
        super().on_mount()
        self.offer("begin")

    def state_changed(self, state: StationState) -> None:
        session = state.session
        if session is None or not self.query("#asked"):
            return
        lines = ["This begins the calibration: do it once per calibration."]
        path = self.worker.station.session_path
        if path is not None:
            lines.append(f"Data file: {path.name}")
        self._again = session.initialised is not None
        if session.initialised is not None:
            lines.append(
                f"It was initialised at {session.initialised.utc[:19].replace('T', ' ')} UTC with "
                f"{len(session.accepted)} points since.\nInitialising AGAIN closes this "
                "file and starts another; nothing is overwritten."
            )
        distance = state.live.distance_to_limits_deg
        if distance is not None:
            needed = near_limit_threshold_deg(session.header.unit.update_range_deg)
            lines.append(f"Distance to the nearest limit: {distance:.2f} deg ({needed:.2f} needed)")
        lines.append("\nAre you sure?")
        self.query_one("#asked", Words).update("\n".join(lines))

    def action_begin(self) -> None:
        self._submit(None)

    def action_override(self) -> None:
        field = self.query_one("#reason", Field)
        field.display = True
        field.input.focus()
        self.say("Type the reason and press Enter; it is written to the session file.")

    def on_input_submitted(self, event: Input.Submitted) -> None:
        if not event.value.strip():
            self.say("An override needs a reason.", "warning")
            return
        self._submit(event.value.strip())

    def _submit(self, reason: str | None) -> None:
        self.offer()
        line = self.workstation.line
        create = line.create_journal if line is not None and self._again else None

        def step(station: Station) -> Initialised:
            return station.initialise(confirmed=True, override_reason=reason, start_next=create)

        self.submit(FileInitialised, step)

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, FileInitialised):
            path = self.worker.station.session_path
            where = f" in {path.name}" if path is not None else ""
            self.leave_saying(f"The calibration begins{where}.")

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if failed.kind is FileInitialised:
            self.offer("begin", *(["override"] if isinstance(failed.error, GuardRefused) else []))

    def link_lost(self) -> None:
        self.offer("begin")
