"""What the station knows, immutable: the session's records and the live side of the line.

Everything that survives a crash is derived from the records alone (``SessionView``), so a replay
that feeds the same records shows the same state. What only exists while a line is open is in
``LiveView``. ``StationState`` is both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import msgspec

from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.records import Answers, CheckRecord, PointRecord, UploadRecord
from solarcal.session.view import SessionView
from solarcal.unit.tracker import Capabilities, Status, Stored, UnitIdentity


class LinkState(StrEnum):
    CLOSED = "closed"
    CONNECTED = "connected"
    LOST = "lost"


class Activity(StrEnum):
    """What the station is in the middle of."""

    IDLE = "idle"
    REF_CHECK = "reference check"
    QUESTIONS = "questions"
    READY = "ready to gather"
    GATHERING = "gathering"
    RESULT = "result"
    UPLOADING = "uploading"


@dataclass(frozen=True, slots=True)
class Pending:
    """What is going on, what has to be done before another step, and the action that does it."""

    sentence: str
    first: str
    action: str | None = None


PENDING = {
    Activity.REF_CHECK: Pending(
        "a reference check is running", "wait for its end, or stop it", "stop"
    ),
    Activity.QUESTIONS: Pending(
        "the questions of a point are open", "answer them first", "take_point"
    ),
    Activity.READY: Pending("a point is about to be gathered", "gather it first", "take_point"),
    Activity.GATHERING: Pending("a point is being gathered", "wait a few seconds"),
    Activity.RESULT: Pending(
        "a gathered point is not stored yet", "store or reject it first", "take_point"
    ),
    Activity.UPLOADING: Pending("an upload is running", "wait for its end"),
}
"""Of every activity but ``IDLE``."""

QUESTIONS = (
    "Did you do a reference check?",
    "Did you do a 'Set Sun Offset'?",
    "Do you like the way it is tracking?",
)
"""In the manual's order. The first NO ends the attempt."""


@dataclass(frozen=True, slots=True)
class Attempt:
    """A data point (or check point) being taken."""

    check: bool
    answers: Answers = field(default_factory=Answers)
    asked: int = 0
    candidate: PointRecord | CheckRecord | None = None

    @property
    def question(self) -> str | None:
        return QUESTIONS[self.asked] if self.asked < len(QUESTIONS) else None

    def answered(self, yes: bool) -> "Attempt":
        """This attempt with the open question answered and the next one open."""
        asked = ("ref_check", "sun_offset", "tracking")[self.asked]
        answers = msgspec.structs.replace(self.answers, **{asked: yes})
        return replace(self, answers=answers, asked=self.asked + 1)


@dataclass(frozen=True, slots=True)
class LiveView:
    """What the line said last. ``laptop_utc_s`` is the laptop's clock at that status."""

    link: LinkState = LinkState.CLOSED
    identity: UnitIdentity | None = None
    capabilities: Capabilities = field(default_factory=Capabilities)
    status: Status | None = None
    laptop_utc_s: float | None = None
    unit_minus_laptop_s: float | None = None
    distance_to_limits_deg: float | None = None
    progress: float | None = None
    link_message: str = ""
    losses_unrecorded: int = 0
    """Of a line that comes and goes: since the last record of it."""


@dataclass(frozen=True, slots=True)
class StationState:
    """Everything a screen, a report or a test may want to know.

    ``generation`` grows by one with every change.
    """

    session: SessionView | None = None
    live: LiveView = field(default_factory=LiveView)
    activity: Activity = Activity.IDLE
    attempt: Attempt | None = None
    generation: int = 0


def newest_upload(uploads: Sequence[UploadRecord]) -> UploadRecord | None:
    """The newest upload that is no rollback itself.

    One that wrote what the unit held already replaced nothing: the one before it is meant, if any.
    """
    found = [upload for upload in uploads if not upload.rollback]
    newest = [upload for upload in found if upload.changed] or found
    return newest[-1] if newest else None


def uploads_as_replaced(uploads: Sequence[UploadRecord]) -> list[UploadRecord]:
    """Each with the old P and O that a rollback of it restores.

    One that repeats the upload before it found its own numbers in the unit already: it replaced
    what that one had replaced.
    """
    told: list[UploadRecord] = []
    for upload in uploads:
        last = told[-1] if told else None
        if (
            last is not None
            and not upload.changed
            and (last.writes, last.rollback) == (upload.writes, upload.rollback)
        ):
            old, old_offsets = last.replaces
            upload = msgspec.structs.replace(upload, old_coefficients=old, old_offsets=old_offsets)
        told.append(upload)
    return told


def held_before_upload(
    session: SessionView, found: Stored, new: Coefficients, offsets: Offsets
) -> tuple[Coefficients, Offsets]:
    """What an upload of ``new`` replaces, for the rollback: what the unit holds (``found``).

    An upload whose line was lost may have got through without its record, or with one that does not
    say so. A unit that holds ``new`` already then held before what the session last knew of it.
    """
    if (found.coefficients, found.offsets) != (new, offsets):
        return found.coefficients, found.offsets
    if session.uploads:
        last = uploads_as_replaced(session.uploads)[-1]
        if not last.verified and last.writes == (new, offsets):
            return last.replaces
        return last.writes
    return session.header.coefficients, session.header.offsets
