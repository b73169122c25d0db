"""Before and after the upload side by side; the certificate in every format, and the zip."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.widget import Widget

from solarcal.decimals import counted
from solarcal.errors import ProcedureRefused, SolarcalError
from solarcal.report.certificate import issue
from solarcal.report.forecast_map import forecast_map
from solarcal.report.plots import error_plot, error_reach
from solarcal.report.scales import View
from solarcal.session.records import UploadRecord
from solarcal.session.view import SessionView
from solarcal.station.curves import before_and_after
from solarcal.station.news import FitReady
from solarcal.station.sign_off import SignOff, sign_off
from solarcal.station.state import StationState
from solarcal.station.uploading import forecast_with
from solarcal.tui.base import StationScreen, Workstation
from solarcal.tui.dialogs.dialog import Dialog, open_dialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, NoticeLine, Words
from solarcal.tui.widgets.plot import AnsiPlot, fine_characters, shades_differ

if TYPE_CHECKING:
    from solarcal.model.analysis import Analysis
    from solarcal.model.forecast import Forecast
    from solarcal.report.certificate import Issued

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
        DialogKey("compare", "Before and after", "v", "v"),
    )
    FIRST_WORDS = "The certificate of this session as of now. Write it?"

    DEFAULT_CSS = """
    ReportDialog #told { height: auto; }
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        # Beside the session, wherever that is.
        self._path = path.resolve()
        self._told = ""

    def body(self) -> Iterable[Widget]:
        yield Words("", id="told", markup=False)

    def state_changed(self, state: StationState) -> None:
        """Until something is written, what the certificate will say."""
        session = state.session
        if self._told or session is None:
            return
        proof = self._proof()
        self._offer(proof)
        n = len(session.accepted)
        self.query_one("#told", Words).update(
            f"Session  {self._path.name}, {counted(n, 'point')}\n"
            f"Status   {'SIGNED OFF' if proof.signed_off else 'not signed off'}: {proof.reason}\n"
            f"Folder   {self._path.parent}"
        )

    def _proof(self) -> SignOff:
        session = self.workstation.state.session
        if session is None:
            return SignOff(False, "no session")
        return sign_off([session], self.workstation.judgement)

    def _offer(self, proof: SignOff) -> None:
        self.offer("write", *(["compare"] if proof.newest is not None else []))

    def action_compare(self) -> None:
        self.dismiss(None)
        open_comparison(self.workstation)

    def action_write(self) -> None:
        self.offer()
        self.say("Writing ...")
        outputs = [self._path.with_name(f"{self._path.stem}-certificate{end}") for end in ENDINGS]
        self.compute(
            partial(issue, [self._path], {}, outputs, zip_too=True),
            self._written,
            self._not_written,
        )

    def _not_written(self, error: SolarcalError) -> None:
        self._offer(self._proof())
        self.finish(str(error), "error")

    def _written(self, found: "Issued") -> None:
        self._offer(self._proof())
        after = found.after
        self._told = f"In {found.paths[0].parent}\n" + "\n".join(
            f"  {path.name}" for path in found.paths
        )
        self.query_one("#told", Words).update(self._told)
        word = "Signed off" if after.signed_off else "Not signed off"
        self.finish(f"Written. {word}: {after.reason}.", "good" if after.signed_off else "warning")


BOTH_ROWS = 40
"""From this height on map and errors are one above the other; below it ``v`` goes between them."""


def open_comparison(app: Workstation) -> None:
    app.push_screen(ComparisonScreen())


class ComparisonScreen(StationScreen):
    """The year as the unit was found and as it is now: map and errors, on the same scales."""

    DEFAULT_CSS = """
    ComparisonScreen #proof {
        height: auto; min-height: 2; max-height: 4; padding: 0 1; background: $boost;
        text-style: bold;
    }
    ComparisonScreen .side { width: 1fr; }
    ComparisonScreen .side > Words { height: 2; text-style: bold; padding: 0 1; }
    ComparisonScreen .errors { display: none; }
    ComparisonScreen.-errors .errors, ComparisonScreen.-both .errors { display: block; }
    ComparisonScreen.-errors .year { display: none; }
    ComparisonScreen.-both .year { display: block; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("v", "turn", "Map or errors", show=False),
        Binding("escape", "back", "Back", show=False),
    ]
    AUTO_FOCUS = ""

    def __init__(self) -> None:
        super().__init__()
        self._judged: Analysis | None = None

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield Words("", id="proof", markup=False)
        with Horizontal():
            for side in ("before", "after"):
                with Vertical(classes="side"):
                    yield Words("", id=f"{side}-words", markup=False)
                    yield AnsiPlot(id=f"{side}-year").add_class("year")
                    yield AnsiPlot(id=f"{side}-errors").add_class("errors")
        yield NoticeLine()
        yield ActionFooter(
            [
                FooterEntry("e", "Certif.", "app.perform('report')", "Write the certificate"),
                FooterEntry("v", "Errors", "screen.turn", "Map of the year, or errors"),
                FooterEntry("Esc", "Back", "screen.back"),
            ]
        )

    def on_mount(self) -> None:
        name = self.workstation.session_name
        self.query_one("#title", HeadLine).show([f"Before and after  {name}"], ["e: certificate"])
        self.query_one("#proof", Words).update("Computing the year ...")
        self._judge()

    def on_resize(self) -> None:
        self.set_class(self.app.size.height >= BOTH_ROWS, "-both")

    def show_fit(self, fit: FitReady) -> None:
        self._judge()

    def action_turn(self) -> None:
        self.toggle_class("-errors")

    def _judge(self) -> None:
        """Both years, on a thread: each takes as long as a judgement."""
        judged, session = self.workstation.judgement, self.workstation.state.session
        if judged is None or session is None or judged is self._judged:
            return
        self._judged = judged
        proof = sign_off([session], judged)
        header, upload = session.header, proof.newest
        if upload is not None:
            self.compute(
                lambda: (
                    forecast_with(judged, header.coefficients, header.offsets),
                    forecast_with(judged, upload.new_coefficients, upload.new_offsets),
                ),
                lambda years: self._show(session, judged, proof, upload, years),
            )

    def _show(
        self,
        session: SessionView,
        judged: "Analysis",
        proof: SignOff,
        upload: UploadRecord,
        years: "tuple[Forecast, Forecast]",
    ) -> None:
        word = "SIGNED OFF" if proof.signed_off else "NOT SIGNED OFF"
        self.query_one("#proof", Words).update(f"■ {word}: {proof.reason}.")
        fine, tolerance = fine_characters(self.app.console.encoding), session.header.tolerance_deg
        shades = shades_differ(self.app.console.color_system)
        errors = before_and_after(session, judged.solution, upload)
        reach_deg = error_reach(*errors)
        heads = (
            f"BEFORE, as found {session.header.utc[:10]}",
            f"AFTER, as uploaded {upload.utc[:10]}",
        )
        for side, head, year, data in zip(("before", "after"), heads, years, errors, strict=True):
            self.query_one(f"#{side}-words", Words).update(
                f"{head}\nyear: 95 % {year.year_p95_deg:.3f} deg, rms {year.year_rms_deg:.3f}"
            )
            self.query_one(f"#{side}-year", AnsiPlot).show(
                partial(forecast_map, year, tolerance_deg=tolerance, fine=fine and shades)
            )
            self.query_one(f"#{side}-errors", AnsiPlot).show(
                partial(error_plot, data, view=View(fine=fine), reach_deg=reach_deg)
            )
