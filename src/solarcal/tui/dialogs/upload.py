"""Upload: old, new, rounding; written, read back, rolled back; then check points and sign-off."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.widget import Widget
from textual.widgets import Input

from solarcal.decimals import counted
from solarcal.model.analysis import Analysis
from solarcal.report.blocks import columns, number, text_of
from solarcal.report.judgement import formula_residuals_deg
from solarcal.report.tables import checks_table
from solarcal.session.records import UploadRecord
from solarcal.session.view import SessionView
from solarcal.station.news import (
    Done,
    RolledBack,
    StepFailed,
    Tracking,
    UnitLookedAt,
    Uploaded,
    UploadProposed,
)
from solarcal.station.procedure import Station
from solarcal.station.sign_off import sign_off
from solarcal.station.uploading import (
    BETTER_PROBABILITY,
    UploadOffer,
    propose_upload,
    refuse_doubtful,
    too_few_points,
)
from solarcal.stopping_rule import percent
from solarcal.tui.base import is_typed
from solarcal.tui.dialogs.dialog import Dialog, reason_field
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.lines import Field
from solarcal.tui.widgets.text_lines import TextLines
from solarcal.units import rms

BESIDE_TABLE = 10
"""Rows of the frame, the field of a reason, the longest sentence and the buttons."""


class UploadDialog(Dialog):
    """Nothing is written before it was looked at here; doubts want a reason, which is kept."""

    HEADING = "Upload coefficients"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("upload", "Write and read back", "y", "y"),
        DialogKey("again", "Again", "a", "a"),
        DialogKey("rollback", "Roll back", "b", "b"),
        DialogKey("track", "Track", "t", "t"),
    )

    DEFAULT_CSS = """
    UploadDialog #table { height: 1; background: $surface; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._proposal: UploadOffer | None = None
        self._sure = False

    def body(self) -> Iterable[Widget]:
        yield TextLines(id="table", wrap=True)
        yield reason_field("Reason to upload it anyway")

    def compose(self) -> ComposeResult:
        if is_typed(self.workstation):
            upload, *others = self.KEYS
            self.KEYS = (replace(upload, label="Key in and type back"), *others)  # type: ignore[misc]
        yield from super().compose()

    def on_mount(self) -> None:
        super().on_mount()
        self.query_one(TextLines).focus()
        self._propose()

    def _propose(self) -> None:
        self._sure = False
        self.offer()
        self.say("Reading what the unit holds ...")
        self.submit(UploadProposed, self._look())

    def _look(self) -> Callable[[Station], UploadOffer | None]:
        """Offers what the header's analysis says; one of its own while newer points are fitted."""
        judgement = self.workstation.judgement
        return lambda station: _propose(station, judgement)

    # -- keys --------------------------------------------------------------------------------

    def action_upload(self) -> None:
        proposal = self._proposal
        if proposal is None:
            return
        if proposal.against:
            self.ask_reason()
            return
        if proposal.judgement.verdict.state != "done" and not self._sure:
            self.say(_sure(proposal), "warning")
            # Not before it is on the screen: a key that bounces is no answer to it.
            self.call_after_refresh(self._warned)
            return
        self._upload(proposal, "")

    def _warned(self) -> None:
        self._sure = True

    def action_again(self) -> None:
        self.offer()
        self.submit(Uploaded, lambda station: station.upload_again())

    def on_input_submitted(self, event: Input.Submitted) -> None:
        reason = event.value.strip()
        if not reason:
            self.say("This upload needs a reason.", "warning")
        elif self._proposal is not None and not self.under_way():
            self._upload(self._proposal, reason)

    def action_rollback(self) -> None:
        self.offer()
        self.submit(RolledBack, lambda station: station.rollback())

    def action_track(self) -> None:
        self.offer()
        self.submit(Tracking, lambda station: station.track(), moves=True)

    def _upload(self, proposal: UploadOffer, reason: str) -> None:
        self.offer()
        self.say(
            "Key them in at the unit, then type what it shows."
            if is_typed(self.workstation)
            else "Writing. Do not unplug anything ..."
        )
        self.submit(
            Uploaded,
            lambda station: station.upload(
                proposal.rounded,
                method=proposal.judgement.solution.method,
                forced=refuse_doubtful(proposal, reason or None),
            ),
        )

    # -- what comes back -----------------------------------------------------------------------

    def link_restored(self) -> None:
        self._propose()

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        match done:
            case UploadProposed(proposal):
                self._proposal = proposal
                self._show_proposal()
            case UnitLookedAt(proposal):
                self._proposal = proposal
                self._show_table()
            case Uploaded(record) | RolledBack(record):
                self._tell(record)
            case Tracking():
                self.dismiss(None)

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if failed.kind in (UploadProposed, Uploaded, RolledBack, Tracking):
            self._offer_what_can_be()

    def _offer_what_can_be(self) -> None:
        session = self.workstation.state.session
        uploaded = session is not None and any(not u.rollback for u in session.uploads)
        self.offer(
            *(["upload"] if self._proposal is not None else []),
            *(["again"] if uploaded and _to_repeat(session) else []),
            *(["rollback", "track"] if uploaded else []),
        )

    def _show_proposal(self) -> None:
        self._offer_what_can_be()
        session = self.workstation.state.session
        if session is None:
            return
        self._show_table()
        proposal = self._proposal
        if proposal is None:
            self.finish(too_few_points(session), "warning")
        elif proposal.against:
            again = " a: those uploaded once more, with O = 0." if self.offered("again") else ""
            reasons = "; ".join(proposal.against)
            self.finish(f"REFUSED: {reasons}. Only with a reason.{again}", "warning")
        else:
            self.say(
                "Key in P1..P6 with O = 0, store, and type them back. Upload?"
                if is_typed(self.workstation)
                else "P1..P6 are written with O = 0, stored, and read back. Upload?"
            )

    def _show_table(self) -> None:
        """What is in force and would be, the checks, and what they prove."""
        session = self.workstation.state.session
        if session is None:
            return
        parts = []
        if session.uploads:
            # First: it is seen without scrolling.
            proof = sign_off([session], self.workstation.judgement)
            parts.append(proof.sentence)
        if self._proposal is not None:
            parts.append(proposal_table(self._proposal))
        if session.checks:
            checks = checks_table(session.checks[-3:], session.header.tolerance_deg)
            parts.append(text_of(*checks))
        table = self.query_one(TextLines)
        table.show("\n\n".join(parts).split("\n"))
        # What has no room beside sentence and buttons is scrolled to.
        table.styles.height = min(len(table.lines), self.app.size.height - BESIDE_TABLE)

    def _tell(self, record: UploadRecord) -> None:
        self.query_one(Field).display = False
        table = self.query_one(TextLines)
        table.focus()
        table.scroll_home(animate=False, immediate=True)
        self.offer("upload" if record.rollback else "rollback", "track")
        # What is in force has changed, and with it what the check points prove.
        self.submit(UnitLookedAt, self._look())
        if not record.verified:
            self.say(
                "READ BACK DIFFERS from what was written: upload again, or roll back.", "error"
            )
        elif record.rollback:
            self.finish("Rolled back: the unit holds its previous values, read back equal.")
        else:
            judged = self._proposal.judgement if self._proposal is not None else None
            if judged is None or judged.verdict.state == "done":
                then = "Now prove it with two check points: track, set the Sun offset, take point."
            else:
                then = (
                    f"The verdict is {_state(judged)}, not DONE: check points alone do not sign it "
                    "off. More data points, then upload again."
                )
            self.finish(f"Uploaded, stored and read back EQUAL. {then}")


def _to_repeat(session: SessionView | None) -> bool:
    """Whether P and O of the newest upload are not what the unit holds, or may not be."""
    if session is None:
        return False
    held = session.holds_upload and session.uploads[-1].verified
    return not held or session.offset_left is not None


def _propose(station: Station, judgement: Analysis | None) -> UploadOffer | None:
    # What was written a moment ago is not in the last status that the screen has.
    linked = station.tracker.capabilities.has_link
    status = station.poll() if linked else station.state.live.status
    return propose_upload(
        station.session,
        station.coefficients_in_force,
        offsets=None if status is None else status.offsets,
        judgement=judgement,
    )


def _sure(proposal: UploadOffer) -> str:
    """The question where the verdict is not done."""
    verdict = proposal.judgement.verdict
    return (
        f"The verdict is {_state(proposal.judgement)}, not DONE. Press y once more to write the "
        f"coefficients now. Against it: {verdict.reasons[0]}."
    )


def _state(judgement: Analysis) -> str:
    return judgement.verdict.words.split(":")[0]


def proposal_table(proposal: UploadOffer) -> str:
    """Old, new, difference and its size in sigmas; what rounding does to the year; the verdict."""
    rows = []
    for change in proposal.changes:
        decimals = 6 if change.unit == "deg/deg" else 4
        rows.append(
            [
                change.name,
                number(change.old, decimals, True),
                number(change.new, decimals, True),
                number(change.new - change.old, decimals, True),
                number(change.sigma, decimals),
                number(change.sigmas, 1, True),
                change.unit,
            ]
        )
    solution = proposal.judgement.solution
    left_deg = formula_residuals_deg(solution, solution.points)
    headings = ("", "in force", "new", "change", "sigma", "in sigmas", "unit")
    lines = columns(headings, rows, "<>>>>><")
    lines.append(
        f"{counted(solution.n_points, 'point')}, residual of the formula {rms(left_deg):.4f} deg "
        f"rms, largest {left_deg.max():.4f}"
    )
    fitted, kept = proposal.judgement.forecast, proposal.kept
    lines.append(
        f"over the year, 95 %: {fitted.year_p95_deg:.4f} deg as fitted, {kept.year_p95_deg:.4f} as "
        f"the unit stores it, {percent(kept.probability_within_tolerance, kept.rule.probability)} "
        f"sure of {kept.rule.tolerance_deg:g}"
    )
    if proposal.held is not None and proposal.better is not None:
        already = not proposal.better and all(c.new == c.old for c in proposal.changes)
        sure = percent(proposal.better, BETTER_PROBABILITY)
        lines.append(
            f"in force now, 95 %: {proposal.held.year_p95_deg:.4f} deg; the new ones"
            + (" are in force already" if already else f": better, {sure} sure")
        )
    lines.append(proposal.judgement.verdict.words)
    return "\n".join(lines)
