"""The data file: begin the calibration in it, write a remark, strike or restore a record, leave it.

Its beginning asks for verification: once per calibration, never near a limit. Nothing is ever
removed. Leaving in the middle of something is asked once.
"""

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from textual.content import Content
from textual.widget import Widget
from textual.widgets import Input, OptionList, Static
from textual.widgets.option_list import Option

from solarcal.decimals import counted
from solarcal.mount.geometry import from_limit
from solarcal.report.session_report import record_lines
from solarcal.session.records import Void
from solarcal.session.voids import live_records
from solarcal.station.guards import GuardRefused, demand_clear_of_limits
from solarcal.station.news import Done, FileInitialised, NoteWritten, RecordVoided, StepFailed
from solarcal.station.state import StationState
from solarcal.tui.dialogs.dialog import Dialog, reason_field
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.lines import Field, Words


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
        self._refused: bool | None = None

    def body(self) -> Iterable[Widget]:
        yield Words("", id="asked", markup=False)
        yield reason_field("Reason for the override")

    def _offer(self) -> None:
        self.offer("override" if self._refused else "begin")

    def state_changed(self, state: StationState) -> None:
        session, status = state.session, state.live.status
        if session is None or status is None or not self.query("#asked"):
            return
        lines = ["This begins the calibration: do it once per calibration."]
        path = self.worker.station.session_path
        if path is not None:
            lines.append(f"Data file: {path.name}")
        self._again = session.initialised is not None
        if session.initialised is not None:
            lines.append(
                f"It was initialised at {session.initialised.utc[:19].replace('T', ' ')} UTC with "
                f"{counted(len(session.accepted), 'point')} since.\nInitialising AGAIN closes this "
                "file and starts another; nothing is overwritten."
            )
        try:
            distance, refusal = demand_clear_of_limits(session.header, status, "initialise"), ""
            lines += [f"The axes are {from_limit(distance, 2)}.", "\nAre you sure?"]
        except GuardRefused as guard:
            refusal = str(guard)
        self.query_one("#asked", Words).update("\n".join(lines))
        if self._refused is not bool(refusal):
            self._refused = self._finished = bool(refusal)
            self.say(refusal, "error" if refusal else "plain")
            if not self.under_way():
                self._offer()

    def action_begin(self) -> None:
        self._submit(None)

    def action_override(self) -> None:
        self.ask_reason()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        if not event.value.strip():
            self.say("An override needs a reason.", "warning")
        elif not self.under_way():
            self._submit(event.value.strip())

    def _submit(self, reason: str | None) -> None:
        self.offer()
        line = self.workstation.line
        create = line.create_journal if line is not None and self._again else None
        self.submit(
            FileInitialised,
            lambda station: station.initialise(
                confirmed=True, override_reason=reason, start_next=create
            ),
        )

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, FileInitialised):
            path = self.worker.station.session_path
            where = f" in {path.name}" if path is not None else ""
            self.leave_saying(f"The calibration begins{where}.")

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if failed.kind is FileInitialised:
            self._offer()

    def link_lost(self) -> None:
        self._offer()


class NoteDialog(Dialog):
    """A remark, kept with its time."""

    HEADING = "Note"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (DialogKey("write", "Write it", "enter", "Enter"),)
    AUTO_FOCUS = "Input"
    FIRST_WORDS = "Written into the session file with its time. F12 or Ctrl+S stops."
    AGAIN: ClassVar[Mapping[type[Done[Any]], tuple[str, ...]]] = {NoteWritten: ("write",)}

    def body(self) -> Iterable[Widget]:
        yield Field("text", "Remark")

    def on_input_submitted(self) -> None:
        if not self.under_way():
            self.action_write()

    def action_write(self) -> None:
        text = self.query_one(Field).value
        if not text:
            self.say("Nothing was typed.", "warning")
            return
        self.offer()
        self.submit(NoteWritten, lambda station: station.note(text), needs_unit=False)

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, NoteWritten):
            self.leave_saying(f"Noted as record {done.result.seq}.")


class VoidDialog(Dialog):
    """The session's records, newest first; a struck one can be restored by voiding its void."""

    HEADING = "Void a record"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("choose", "Strike it, or restore it", "enter", "Enter"),
    )
    AUTO_FOCUS = "OptionList"
    FIRST_WORDS = "Choose with the arrow keys, then Enter. One that is struck (x) is restored."

    DEFAULT_CSS = """
    VoidDialog OptionList { height: auto; max-height: 12; border: none; padding: 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._listed: tuple[int, ...] | None = None
        self._chosen: int | None = None

    def body(self) -> Iterable[Widget]:
        yield OptionList(compact=True)
        yield reason_field("Reason")

    def state_changed(self, state: StationState) -> None:
        session = state.session
        if session is None:
            return
        listed = tuple(record.seq for record in reversed(session.records))
        if listed == self._listed:
            return
        if not listed:
            self.offer()
            # After the first words of the dialog.
            self.call_later(
                self.finish, "Nothing is recorded yet: no record can be struck.", "plain"
            )
        elif not self._listed:
            self.offer("choose")
        self._listed = listed
        live = {record.seq for record in live_records(session.records)}
        options = self.query_one(OptionList)
        at = options.highlighted
        options.clear_options()
        options.add_options(
            Option(
                # Never by colour or line alone: a struck record says so.
                Content(("  " if record.seq in live else "x ") + line),
                id=str(record.seq),
            )
            for record, line in reversed(
                list(zip(session.records, record_lines(session.records), strict=True))
            )
        )
        if listed:
            options.highlighted = min(at or 0, len(listed) - 1)

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        session = self.workstation.state.session
        seq = int(event.option_id or 0)
        live = live_records(session.records) if session is not None else ()
        # A record is restored by striking what strikes it, chosen by the one or by the other.
        voids = [r for r in live if isinstance(r, Void)]
        void = next((r for r in voids if seq in (r.voids, r.seq)), None)
        self._chosen = seq if void is None else void.seq
        what = f"record {seq} struck" if void is None else f"record {void.voids} restored"
        self.ask_reason(f"Why is {what}? Enter stores the reason, Esc cancels.")

    def action_choose(self) -> None:
        self.query_one(OptionList).action_select()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        reason, seq = event.value.strip(), self._chosen
        if not reason:
            self.say("A void needs a reason; it is written to the session file.", "warning")
            return
        if seq is None:
            return
        self.submit(RecordVoided, lambda station: station.void(seq, reason), needs_unit=False)

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, RecordVoided):
            void, session = done.result, self.worker.station.session
            struck = next(r for r in session.records if r.seq == void.voids)
            what = (
                f"{struck.voids} is restored" if isinstance(struck, Void)
                else f"{void.voids} is struck out"
            )  # fmt: skip
            self.leave_saying(f"Record {what} (record {void.seq}).")


class LeaveDialog(Dialog):
    """Yes or no; needs no unit."""

    HEADING = "Leave"
    LEAVE = "Stay"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("out", "Leave", "y", "y"),
        DialogKey("leave", "Stay", "n,enter", "n", button=False),
    )

    def __init__(self, pending: str) -> None:
        super().__init__()
        self._pending = pending

    def body(self) -> Iterable[Widget]:
        yield Static(
            f"{self._pending[0].upper()}{self._pending[1:]}.\n"
            "Leaving now aborts it; an attempt at a point is recorded as aborted.",
            markup=False,
        )

    def on_mount(self) -> None:
        super().on_mount()
        self.say("Leave?", "warning")

    def action_out(self) -> None:
        self.dismiss(None)
        self.workstation.leave_soon()
