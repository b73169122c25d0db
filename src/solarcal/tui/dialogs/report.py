"""Report: the certificate of the running session in every format, and the zip for the office."""

import threading
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual.widget import Widget

from solarcal.config import sessions_dir
from solarcal.errors import ProcedureRefused, SolarcalError
from solarcal.station.sign_off import sign_off
from solarcal.station.state import StationState
from solarcal.tui.base import Workstation
from solarcal.tui.dialogs.dialog import Dialog, DialogKey, open_dialog
from solarcal.tui.widgets.words import Words

if TYPE_CHECKING:
    from solarcal.report.issuing import Issued

ENDINGS = (".html", ".md", ".svg", ".txt")


def open_screen(app: Workstation) -> None:
    path = app.session_path
    if path is None:
        raise ProcedureRefused("there is no session file to write a report of")
    open_dialog(app, ReportDialog(path))


class ReportDialog(Dialog):
    """One key writes all; the session goes on."""

    HEADING = "Report"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("write", "Write html md svg txt zip", "y", "y"),
    )

    DEFAULT_CSS = """
    ReportDialog #told { height: auto; }
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path
        self._told = ""

    def body(self) -> Iterable[Widget]:
        yield Words("", id="told", markup=False)

    def on_mount(self) -> None:
        super().on_mount()
        self.say("The certificate of this session as of now. Write it?")

    def state_changed(self, state: StationState) -> None:
        """Until something is written, what the certificate will say."""
        session = state.session
        if self._told or session is None:
            return
        proof = sign_off([session], session.header.tolerance_deg)
        n = len(session.accepted)
        self.query_one("#told", Words).update(
            f"Session  {self._path.name}, {n} point{'' if n == 1 else 's'}\n"
            f"Status   {'SIGNED OFF' if proof.signed_off else 'not signed off'}: {proof.reason}\n"
            f"Folder   {sessions_dir()}"
        )

    def action_write(self) -> None:
        self.offer()
        self.say("Writing ...")
        threading.Thread(target=self._write, name="report", daemon=True).start()

    def _write(self) -> None:
        from solarcal.report.issuing import issue

        outputs = [sessions_dir() / f"{self._path.stem}-certificate{end}" for end in ENDINGS]
        try:
            found: Issued | SolarcalError = issue([self._path], {}, outputs, zip_too=True)
        except SolarcalError as error:
            found = error
        self.app.call_from_thread(self._written, found)

    def _written(self, found: "Issued | SolarcalError") -> None:
        if not self.is_mounted:
            return
        self.offer("write")
        if isinstance(found, SolarcalError):
            self.say(str(found), "error")
            return
        after = found.after
        self._told = f"In {found.paths[0].parent}\n" + "\n".join(
            f"  {path.name}" for path in found.paths
        )
        self.query_one("#told", Words).update(self._told)
        word = "Signed off" if after.signed_off else "Not signed off"
        self.say(f"Written. {word}: {after.reason}.", "good" if after.signed_off else "warning")
