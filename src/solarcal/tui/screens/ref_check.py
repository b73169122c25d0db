"""Reference check: drive to the switches, see whether the counts are still right."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, ClassVar

from textual.widget import Widget
from textual.widgets import Static

from solarcal.errors import SolarcalError
from solarcal.report.tables import ref_checks_table
from solarcal.session.records import RefCheck
from solarcal.station.procedure import Station
from solarcal.station.question_evidence import counts_missed
from solarcal.station.state import StationState
from solarcal.tui.messages import Progress
from solarcal.tui.screens.dialog import Dialog, open_dialog
from solarcal.tui.widgets.key_button import DialogKey
from solarcal.unit.tracker import Mode

if TYPE_CHECKING:
    from solarcal.tui.app import SolarcalApp

STEP = "ref_check"
SHOWN_CHECKS = 5


def open_screen(app: "SolarcalApp") -> None:
    open_dialog(app, RefCheckDialog())


class RefCheckDialog(Dialog):
    """Asks, drives, and shows the difference against the check before."""

    HEADING = "Reference check"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("start", "Start: drive to the switches", "enter,y", "Enter y"),
        DialogKey("track", "Track again", "t", "t"),
    )

    DEFAULT_CSS = """
    RefCheckDialog #checks { height: auto; max-height: 9; }
    RefCheckDialog #axes { height: auto; margin-bottom: 1; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._running = False

    def body(self) -> Iterable[Widget]:
        yield Static("", id="axes")
        yield Static("", id="checks")

    def on_mount(self) -> None:
        super().on_mount()
        self.offer("start")
        status = self.station_app.state.live.status
        stopped = status is not None and status.mode is Mode.STOP
        first = "The unit is stopped; Start lets it go. " if stopped else ""
        self.say(f"{first}Watch both axes reach their switches. STOP ends it at any moment.")

    def state_changed(self, state: StationState) -> None:
        status, session = state.live.status, state.session
        if status is not None:
            self.query_one("#axes", Static).update(
                f"Axis 1 at {status.reading1_deg:9.3f} deg, register {status.counts1:8d}   "
                f"{_motion(status.moving[0])}\n"
                f"Axis 2 at {status.reading2_deg:9.3f} deg, register {status.counts2:8d}   "
                f"{_motion(status.moving[1])}"
            )
        if session is not None:
            self.query_one("#checks", Static).update(
                ref_checks_table(session.ref_checks[-SHOWN_CHECKS:])
            )

    def action_start(self) -> None:
        self._running = True
        self.offer()
        conductor = self.conductor

        def step(station: Station) -> RefCheck:
            return station.ref_check(
                lambda seconds: conductor.progress(STEP, None, f"driving for {seconds:.0f} s")
            )

        self.submit(STEP, step, moves=True)

    def action_track(self) -> None:
        self.offer()
        self.submit("track", lambda station: station.track(), moves=True)

    def show_progress(self, progress: Progress) -> None:
        if progress.name == STEP and self._running:
            self.say(f"Reference check running: {progress.words}. STOP ends it.")

    def step_done(self, name: str, result: object) -> None:
        super().step_done(name, result)
        if name == STEP and isinstance(result, RefCheck):
            self._running = False
            self.offer("start", "track")
            self._tell(result)
        elif name == "track":
            self.dismiss(None)

    def step_failed(self, name: str, error: SolarcalError) -> None:
        super().step_failed(name, error)
        if name in (STEP, "track"):
            self._running = False
            self.offer("start", "track")

    def _checks(self) -> Sequence[RefCheck]:
        session = self.station_app.state.session
        return session.ref_checks if session is not None else ()

    def _tell(self, check: RefCheck) -> None:
        d1, d2 = check.difference_counts
        if not check.complete:
            self.say(f"Check no. {check.number} did NOT end. Start it again.", "error")
        elif counts_missed(self._checks(), check):
            self.say(
                f"Check no. {check.number}: counts found {d1:+d} and {d2:+d} where 0 belong: "
                "counts were missed since the check before; points between them are doubtful.",
                "warning",
            )
        else:
            self.say(
                f"Check no. {check.number} complete, recorded: counts found {d1:+d} and {d2:+d}.",
                "good",
            )


def _motion(sense: int) -> str:
    return {1: "driving +", -1: "driving -"}.get(sense, "at rest")
