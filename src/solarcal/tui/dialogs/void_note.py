"""Void and note: strike a record, or restore it; write a remark. Nothing is ever removed."""

from collections.abc import Iterable
from typing import Any, ClassVar

from textual.content import Content
from textual.widget import Widget
from textual.widgets import Input, OptionList
from textual.widgets.option_list import Option

from solarcal.report.session_report import record_line
from solarcal.session.reader import live_records
from solarcal.session.records import Void
from solarcal.station.news import Done, NoteWritten, RecordVoided, StepFailed
from solarcal.station.procedure import Station
from solarcal.station.state import StationState
from solarcal.tui.base import Workstation
from solarcal.tui.dialogs.dialog import Dialog, DialogKey, open_dialog
from solarcal.tui.widgets.lines import Field


def open_void(app: Workstation) -> None:
    open_dialog(app, VoidDialog())


def open_note(app: Workstation) -> None:
    open_dialog(app, NoteDialog())


class NoteDialog(Dialog):
    """A remark, kept with its time."""

    HEADING = "Note"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (DialogKey("write", "Write it", "enter", "Enter"),)
    AUTO_FOCUS = "Input"

    def body(self) -> Iterable[Widget]:
        yield Field("text", "Remark")

    def on_mount(self) -> None:
        super().on_mount()
        self.say("Written into the session file with its time. F12 or Ctrl+S stops.")

    def on_input_submitted(self) -> None:
        self.action_write()

    def action_write(self) -> None:
        text = self.query_one(Field).value
        if not text:
            self.say("Nothing was typed.", "warning")
            return
        self.offer()
        self.submit(NoteWritten, lambda station: station.note(text))

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, NoteWritten):
            self.leave_saying(f"Noted as record {done.result.seq}.")

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if failed.kind is NoteWritten:
            self.offer("write")


class VoidDialog(Dialog):
    """The session's records, newest first; a struck one can be restored by voiding its void."""

    HEADING = "Void a record"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("choose", "Strike it, or restore it", "enter", "Enter"),
    )
    AUTO_FOCUS = "OptionList"

    DEFAULT_CSS = """
    VoidDialog OptionList { height: auto; max-height: 12; border: none; padding: 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._listed: tuple[int, ...] = ()
        self._chosen: int | None = None

    def body(self) -> Iterable[Widget]:
        yield OptionList(compact=True)
        field = Field("reason", "Reason")
        field.display = False
        yield field

    def on_mount(self) -> None:
        super().on_mount()
        self.say("Choose with the arrow keys, then Enter. To undo a void, void it.")

    def state_changed(self, state: StationState) -> None:
        session = state.session
        if session is None:
            return
        listed = tuple(record.seq for record in reversed(session.records))
        if listed == self._listed:
            return
        self._listed = listed
        live = {record.seq for record in live_records(session.records)}
        options = self.query_one(OptionList)
        at = options.highlighted
        options.clear_options()
        options.add_options(
            Option(
                # Never by colour or line alone: a struck record says so.
                Content(("  " if record.seq in live else "x ") + record_line(record)),
                id=str(record.seq),
            )
            for record in reversed(session.records)
        )
        if listed:
            options.highlighted = min(at or 0, len(listed) - 1)

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        self._chosen = int(event.option_id or 0)
        field = self.query_one(Field)
        field.display = True
        field.input.focus()
        self.say(f"Why is record {self._chosen} struck? Enter stores the reason, Esc cancels.")

    def action_choose(self) -> None:
        self.query_one(OptionList).action_select()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        reason, seq = event.value.strip(), self._chosen
        if not reason:
            self.say("A void needs a reason; it is written to the session file.", "warning")
            return
        if seq is None:
            return

        def step(station: Station) -> Void:
            return station.void(seq, reason)

        self.submit(RecordVoided, step)

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, RecordVoided):
            void = done.result
            self.leave_saying(f"Record {void.voids} is void (record {void.seq}).")
