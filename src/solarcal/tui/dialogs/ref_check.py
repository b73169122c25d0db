"""Reference check: drive to the switches, or have it done at the unit and type the counts."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

from textual.widget import Widget
from textual.widgets import Static

from solarcal.report.blocks import text_of
from solarcal.report.tables import ref_checks_table
from solarcal.session.records import RefCheck
from solarcal.session.view import SessionView
from solarcal.station.news import Done, ReferenceChecked, Tracking
from solarcal.station.question_evidence import counts_missed, found_words, whether_normal
from solarcal.station.state import Activity, StationState
from solarcal.tui.base import Workstation, is_typed
from solarcal.tui.dialogs.dialog import Dialog, Tone, open_dialog
from solarcal.tui.dialogs.paced import DriveWatch, progress_bar
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.lines import Words
from solarcal.unit.tracker import Mode, Status

SHOWN_CHECKS = 5


def open_screen(app: Workstation) -> None:
    if is_typed(app):
        open_dialog(app, TypedRefCheckDialog())
        return
    session = app.state.session
    open_dialog(app, RefCheckDialog(session is None or session.header.unit.has_switches))


class _CheckTeller(Dialog):
    """Lists the checks, and says what one that has ended found; a complete one is a step done."""

    def state_changed(self, state: StationState) -> None:
        if state.session is not None:
            self.query_one("#checks", Words).update(
                text_of(*ref_checks_table(state.session.ref_checks[-SHOWN_CHECKS:]))
            )

    def tell(self, check: RefCheck) -> None:
        if (session := self.workstation.state.session) is not None:
            (self.finish if check.complete else self.say)(*ref_check_words(check, session))


class RefCheckDialog(_CheckTeller):
    """Asks, drives, and shows the difference against the check before.

    ``switches``: whether the unit has any; one without goes to its reference position only.
    """

    HEADING = "Reference check"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("start", "Start: drive to the switches", "enter,y", "Enter y"),
        DialogKey("track", "Track again", "t", "t"),
    )
    AGAIN: ClassVar[Mapping[type[Done[Any]], tuple[str, ...]]] = dict.fromkeys(
        (ReferenceChecked, Tracking), ("start", "track")
    )

    DEFAULT_CSS = """
    RefCheckDialog #checks { height: auto; max-height: 9; }
    RefCheckDialog #axes { height: auto; margin-bottom: 1; }
    """

    def __init__(self, switches: bool = True) -> None:
        self._switches = switches
        if not switches:
            start, track = self.KEYS
            self.KEYS = (replace(start, label="Start: go to the reference position"), track)  # type: ignore[misc]
        super().__init__()
        self._drive = DriveWatch()

    def body(self) -> Iterable[Widget]:
        yield Words("", id="axes", markup=False)
        yield Words("", id="checks", markup=False)

    def on_mount(self) -> None:
        super().on_mount()
        self.offer("start")
        status = self.workstation.state.live.status
        stopped = status is not None and status.mode is Mode.STOP
        first = "The unit is stopped; Start lets it move. " if stopped else ""
        if self._switches:
            self.say(f"{first}Watch both axes reach their switches. STOP ends it at any time.")
        else:
            self.say(
                f"{first}This unit has no switches: it goes to its reference position. Check that "
                "both axes are at their marks there: only the marks show that the read-outs are "
                "right. STOP ends it at any time."
            )

    def state_changed(self, state: StationState) -> None:
        super().state_changed(state)
        if (status := state.live.status) is not None:
            self.query_one("#axes", Words).update(
                f"Axis 1 at {status.reading1_deg:z9.3f} deg, register {status.counts1:8d}   "
                f"{_motion(status.moving[0])}\n"
                f"Axis 2 at {status.reading2_deg:z9.3f} deg, register {status.counts2:8d}   "
                f"{_motion(status.moving[1])}"
            )
            if state.activity is Activity.REF_CHECK:
                self._tell_progress(state, status)

    def _tell_progress(self, state: StationState, status: Status) -> None:
        """By the read-outs: how far from the reference position, and how long from there."""
        if state.session is None:
            return
        unit = state.session.header.unit
        to_go = max(
            abs(unit.reference1_deg - status.reading1_deg),
            abs(unit.reference2_deg - status.reading2_deg),
        )
        self._drive.at(status.unit_utc_s, to_go)
        self.say(
            f"Reference check running {progress_bar(self._drive.fraction)}\n"
            f"{to_go:.0f} deg to go{self._drive.words()}. STOP ends it."
        )

    def action_start(self) -> None:
        self.offer()
        self._drive = DriveWatch()
        self.say("Reference check running. STOP ends it.")
        self.submit(ReferenceChecked, lambda station: station.ref_check(), moves=True)

    def action_track(self) -> None:
        self.offer()
        self.submit(Tracking, lambda station: station.track(), moves=True)

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        match done:
            case ReferenceChecked(check):
                self.offer("start", "track")
                self.tell(check)
            case Tracking():
                self.dismiss(None)


def ref_check_words(check: RefCheck, session: SessionView) -> tuple[str, Tone]:
    """What a check that has ended says among those of its session, and in which tone."""
    found = check.difference_counts or (0, 0)
    if not check.complete:
        return f"Check no. {check.number} did NOT end. Start it again.", "error"
    if counts_missed(session, check):
        return (
            f"Check no. {check.number}: counts found {found[0]:+d} and {found[1]:+d}, 0 expected: "
            "counts were missed since the previous check; points in between are doubtful.",
            "warning",
        )
    if not check.at_switches:
        return (
            f"Check no. {check.number} recorded: the read-outs are {found[0]:+d} and "
            f"{found[1]:+d} counts from the reference position. Are both axes at their marks? If "
            "not, correct the rotator's zero and begin again.",
            "good",
        )
    normal = whether_normal(session, check)
    return f"Check no. {check.number} complete, recorded: {found_words(check)}{normal}", "good"


def _motion(sense: int) -> str:
    return {1: "driving +", -1: "driving -"}.get(sense, "at rest")


class TypedRefCheckDialog(_CheckTeller):
    """The checks so far; the next one is done at the unit, and typed."""

    HEADING = "Reference check, at the unit"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("type", "It is done: type it", "enter,y", "Enter y"),
    )
    FIRST_WORDS = "When it has ended, Enter: type what it showed."
    AGAIN: ClassVar[Mapping[type[Done[Any]], tuple[str, ...]]] = {ReferenceChecked: ("type",)}

    DEFAULT_CSS = """
    TypedRefCheckDialog #guide { height: auto; margin-bottom: 1; }
    TypedRefCheckDialog #checks { height: auto; max-height: 9; }
    """

    def body(self) -> Iterable[Widget]:
        yield Static(
            "Start it at the unit (Alt-F5, or its RESET key) and watch BOTH axes reach their "
            "switches. Note the counts its display shows there, just before they become zero.",
            id="guide",
            markup=False,
        )
        yield Words("", id="checks")

    def action_type(self) -> None:
        self.offer()
        self.submit(ReferenceChecked, lambda station: station.ref_check())

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, ReferenceChecked):
            self.offer("type")
            self.tell(done.result)
