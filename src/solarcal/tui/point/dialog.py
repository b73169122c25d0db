"""Take a data point (or a check point): three questions, a gathering, the result, store or not.

What is shown follows from the station's state alone: left and opened again, the dialog goes on
where the attempt stands.
"""

from collections.abc import Iterable
from functools import partial
from typing import Any, ClassVar

from textual.widget import Widget
from textual.widgets import Input

from solarcal.errors import ProcedureRefused
from solarcal.report.tables import check_result, point_result
from solarcal.session.records import CheckRecord, PointRecord
from solarcal.station.guards import GuardRefused
from solarcal.station.news import (
    Answered,
    Done,
    Gathered,
    Judged,
    PointBegun,
    Progress,
    SpotSeen,
    StepFailed,
    Stored,
)
from solarcal.station.next_step import next_step
from solarcal.station.point_judgement import PointJudgement, judge_check, judge_point
from solarcal.station.procedure import Station
from solarcal.station.question_evidence import question_evidence
from solarcal.station.sign_off import sign_off
from solarcal.station.state import Activity, Attempt, StationState
from solarcal.tui.base import is_typed
from solarcal.tui.dialogs.dialog import reason_field
from solarcal.tui.dialogs.paced import PacedDialog
from solarcal.tui.dialogs.report import open_comparison
from solarcal.tui.keys import DialogKey
from solarcal.tui.point.attempt_words import Gathering, Question
from solarcal.tui.widgets.lines import Field, Words
from solarcal.unit.tracker import Spot

LOOK_EVERY_S = 2.0
ANSWER_TAKEN_S = 0.1
"""From the key to the answer. A key that is held down comes again sooner than that: then it answers
no second question, and does not count until it was let go."""

NOT_STORED = "the technician did not store it"


class TakePointDialog(PacedDialog):
    HEADING = "Take a data point"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("check", "Check point (proof)", "c,enter", "c Enter"),
        DialogKey("data", "Data point (fitted)", "d", "d"),
        DialogKey("yes", "Yes", "y", "y"),
        DialogKey("no", "No", "n", "n"),
        DialogKey("again", "Try again", "r", "r"),
        DialogKey("override", "Override, with a reason", "o", "o"),
    )

    def __init__(self) -> None:
        super().__init__()
        self._spot: Spot | None = None
        self._check = False
        self._attempt: Attempt | None = None
        self._answer_before: bool | None = None
        self._asked_to_judge = False
        self._choosing = False
        self._interrupted = False
        self._back = ""

    def body(self) -> Iterable[Widget]:
        yield Question(id="question")
        yield Gathering(id="gathering")
        yield Words("", id="result", markup=False)
        yield reason_field("Reason for the override")

    def on_mount(self) -> None:
        self.offer()
        state = self.workstation.state
        super().on_mount()
        session = state.session
        if state.attempt is None:
            if session is not None and session.uploads and not session.uploads[-1].rollback:
                self._choose()
            else:
                self._begin(check=False)
        if self.worker.station.tracker.emulation is not None:
            self.set_interval(LOOK_EVERY_S, self._look)

    # -- keys ----------------------------------------------------------------------------------

    def action_check(self) -> None:
        self._begin(check=True)

    def action_data(self) -> None:
        self._begin(check=False)

    def action_again(self) -> None:
        self._begin(check=self._check)

    def action_yes(self) -> None:
        self._decide(True)

    def action_no(self) -> None:
        self._decide(False)

    def action_override(self) -> None:
        self.ask_reason()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        reason = event.value.strip()
        if not reason:
            self.say("An override needs a reason.", "warning")
            return
        if self.under_way():
            return
        self.query_one(Field).display = False
        self.set_focus(None)
        self._begin(check=self._check, override_reason=reason)

    def action_leave(self) -> None:
        activity = self.workstation.state.activity
        if activity is Activity.GATHERING:
            self.say("Keys are ignored while gathering, a few seconds. STOP works.", "warning")
            return
        if self.workstation.state.attempt is not None:
            keys = self.workstation.keys_of("take_point")
            self.leave_saying(f"The attempt stays open: {keys} goes on with it.", "warning")
        else:
            self.dismiss(None)

    def _choose(self) -> None:
        self._choosing = True
        self.offer("check", "data")
        judged = self.workstation.judgement
        unsure = judged is not None and judged.verdict.state != "done"
        which = " The verdict is not DONE: a data point (d)." if unsure else ""
        asks = f"After an upload: a check point, or one more data point?{which}"
        self.say(f"{self._back} {asks}".lstrip())

    def _begin(self, *, check: bool, override_reason: str | None = None) -> None:
        self._check, self._choosing, self._back = check, False, ""
        self._answer_before = None
        self.offer()
        self.submit(
            PointBegun,
            lambda station: station.begin_point(check=check, override_reason=override_reason),
        )

    def _decide(self, yes: bool) -> None:
        repeated = yes == self._answer_before
        self.offer()
        self.set_timer(ANSWER_TAKEN_S, partial(self._decided, yes, repeated))

    def _decided(self, yes: bool, repeated: bool) -> None:
        attempt = self._attempt
        if attempt is None:
            return
        if repeated and self.came_early("yes" if yes else "no"):
            self.offer("yes", "no")
            return
        self._answer_before = yes
        if attempt.question is not None:
            asked = attempt.asked
            self.submit(Answered, lambda station: _answer(station, asked, yes))
        else:
            self.submit(Stored, lambda station: station.store(yes, "" if yes else NOT_STORED))

    def _gather(self) -> None:
        self.offer()
        worker = self.worker
        self.submit(
            Gathered,
            lambda station: station.gather_point(
                lambda part: worker.progress(Gathered, part, "gathering")
            ),
        )

    def _look(self) -> None:
        if self._attempt is not None and not self.worker.busy and not self._lost:
            self.submit(SpotSeen, _look)

    # -- the station ---------------------------------------------------------------------------

    def state_changed(self, state: StationState) -> None:
        attempt = state.attempt
        before, self._attempt = self._attempt, attempt
        gathering, result = self.query_one(Gathering), self.query_one("#result", Words)
        self.query_one(Question).display = state.activity is Activity.QUESTIONS
        gathering.display = state.activity in (Activity.READY, Activity.GATHERING)
        result.display = state.activity is Activity.RESULT
        if attempt is None:
            self._demand_reference(state)
            return
        self._check = attempt.check
        self.query_one("#dialog").border_title = (
            "Take a check point" if attempt.check else self.HEADING
        )
        new = before is None or (before.asked, before.candidate) != (
            attempt.asked,
            attempt.candidate,
        )
        if state.activity is Activity.QUESTIONS:
            if new or self.offered("yes"):
                self._ask()
        elif state.activity is Activity.READY and new:
            if is_typed(self.workstation):
                gathering.typing()
            else:
                gathering.at(0.0)
            self.say("")
            self._gather()
        elif state.activity is Activity.RESULT and not self._asked_to_judge:
            self._asked_to_judge = True
            self.submit(Judged, _judge)

    def _ask(self) -> None:
        state, attempt = self.workstation.state, self._attempt
        if attempt is None or state.session is None or state.activity is not Activity.QUESTIONS:
            return
        facts = question_evidence(attempt.asked, state.session, state.live, self._spot)
        self.query_one(Question).ask(attempt.asked, facts, attempt.answers)
        if not self.offered("yes"):
            self.offer("yes", "no")
            self.say("The first NO ends the attempt; it stays in the file as aborted.")

    def show_progress(self, progress: Progress) -> None:
        if is_typed(self.workstation):
            return
        if progress.kind is Gathered and progress.fraction is not None:
            self.query_one(Gathering).at(progress.fraction)

    def link_lost(self) -> None:
        self._asked_to_judge = False
        self._interrupted = self._attempt is not None
        self.offer()

    def link_restored(self) -> None:
        if self.workstation.state.attempt is not None:
            return
        self._back = "The link is back."
        if self._interrupted:
            self._back += " The attempt was aborted and is in the file."
        if self._choosing:
            self._choose()
        else:
            self.say(self._back, "warning")
            self.offer("again")

    def _demand_reference(self, state: StationState) -> None:
        """After a lost line: a unit that has restarted meanwhile gives no point before."""
        if not self._back:
            return
        step = next_step(state)
        if step.action == "ref_check":
            self.offer()
            self.finish(f"{self._back} {step.sentence}", "warning")
            self._back = ""

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        match done:
            case SpotSeen(spot):
                self._spot = spot
            case Answered(attempt) if self.workstation.state.attempt is None:
                self._answered_no(attempt)
            case Judged(judged) if judged is not None:
                self._show_result(judged)
            case Stored(record):
                self._stored(record)

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if self._lost or failed.kind not in (PointBegun, Gathered, Stored, Answered):
            return
        if failed.kind is Stored and self.workstation.state.attempt is not None:
            self.offer("yes", "no")
        elif isinstance(failed.error, GuardRefused):
            self.offer("override", "again")
        elif self.workstation.state.attempt is None:
            self.offer("again")

    def _answered_no(self, attempt: Attempt) -> None:
        self.leave_saying(
            f"NO to question {attempt.asked}: the attempt is kept as aborted and not used.",
            "warning",
        )

    def _show_result(self, judged: PointJudgement | str) -> None:
        attempt = self._attempt
        candidate = attempt.candidate if attempt is not None else None
        result = self.query_one("#result", Words)
        if isinstance(candidate, PointRecord) and isinstance(judged, PointJudgement):
            result.update(point_result(candidate, judged))
            self.say(f"{judged.sentence} Store it?", "warning" if judged.suspicious else "plain")
        elif isinstance(candidate, CheckRecord) and isinstance(judged, str):
            result.update(check_result(candidate))
            self.say(f"{judged} Store it?", "warning" if "BEYOND" in judged else "plain")
        self.offer("yes", "no")

    def _stored(self, record: PointRecord | CheckRecord) -> None:
        if record.status != "accepted":
            what = "Check point" if isinstance(record, CheckRecord) else "Point"
            self.leave_saying(f"{what} kept as rejected (record {record.seq}); not used.")
            return
        self.dismiss(None)
        if isinstance(record, CheckRecord):
            proof = sign_off([self.worker.station.session], self.workstation.judgement)
            if proof.signed_off:
                open_comparison(self.workstation)


def _answer(station: Station, asked: int, yes: bool) -> Attempt:
    """Answer the question that was on the screen, and no other."""
    attempt = station.state.attempt
    if attempt is None or attempt.asked != asked:
        raise ProcedureRefused("that question is no longer open")
    return station.answer(yes)


def _judge(station: Station) -> PointJudgement | str | None:
    attempt = station.state.attempt
    candidate = attempt.candidate if attempt is not None else None
    if isinstance(candidate, CheckRecord):
        return judge_check(candidate, station.session.header.tolerance_deg)
    return judge_point(station.session, candidate) if candidate is not None else None


def _look(station: Station) -> Spot | None:
    emulation = station.tracker.emulation
    return emulation.spot() if emulation is not None else None
