"""What the threads around a station tell: one kind for each thing that happens, with its payload.

Frozen values, posted from any thread. What a step has done is a ``Done`` of its own kind; the same
kind says which step failed, or how far it is.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from solarcal.errors import SolarcalError

if TYPE_CHECKING:
    # Named as payloads, in quotes: none of them is imported to be told of.
    from solarcal.model.analysis import Analysis
    from solarcal.model.solution import Solution
    from solarcal.session.records import (  # noqa: F401
        CheckRecord,
        ClockSet,
        Initialised,
        Note,
        PointRecord,
        RefCheck,
        SunOffset,
        UploadRecord,
        Void,
    )
    from solarcal.session.view import SessionView
    from solarcal.station.jogging import JogView  # noqa: F401
    from solarcal.station.point_judgement import PointJudgement  # noqa: F401
    from solarcal.station.state import Attempt, StationState  # noqa: F401
    from solarcal.station.uploading import UploadOffer  # noqa: F401
    from solarcal.unit.tracker import Spot, Status  # noqa: F401

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class StateChanged:
    """The station's state. A newer one replaces an older one still waiting."""

    state: "StationState"


@dataclass(frozen=True, eq=False)
class FitReady:
    """Fit and judgement of the session as it was at ``generation``; late ones are ignored.

    Where one of them is missing ``reason`` says why, unless there are simply too few points.
    """

    generation: int
    session: "SessionView"
    solution: "Solution | None"
    judgement: "Analysis | None" = None
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Done(Generic[Result]):
    """A step has returned. ``name`` is the step's, for a sentence."""

    name: ClassVar[str]
    result: Result

    def __init_subclass__(cls, *, name: str) -> None:
        super().__init_subclass__()
        cls.name = name


Kind = type[Done[Any]]


@dataclass(frozen=True, eq=False)
class StepFailed:
    """A step was refused or failed; ``error`` says it in one line."""

    kind: Kind | None
    """``None``: an action refused before there was a step."""
    error: SolarcalError


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a long step is, 0..1 or seconds so far, in words."""

    kind: Kind
    fraction: float | None
    words: str


News = StateChanged | FitReady | Done[Any] | StepFailed | Progress


# -- the line and the emulator -------------------------------------------------------------------


class StatusRead(Done["Status"], name="status"): ...


class Stopped(Done[None], name="stop"): ...


class Reconnected(Done[None], name="reconnect"): ...


class LossRecorded(Done[None], name="link"): ...


class SpeedTold(Done["float | None"], name="speed"):
    """Virtual seconds a second of an emulated unit."""


class TimeSkipped(Done[float], name="skip ahead"): ...


# -- the steps of the procedure ------------------------------------------------------------------


class FileInitialised(Done["Initialised"], name="initialise"): ...


class ClockAdjusted(Done["ClockSet"], name="set clock"): ...


class ReferenceChecked(Done["RefCheck"], name="reference check"): ...


class Tracking(Done[None], name="track"): ...


class JogSeen(Done["JogView"], name="look"): ...


class Jogged(Done["JogView"], name="jog"): ...


class OffsetSet(Done["SunOffset"], name="set sun offset"): ...


class OffsetTakenBack(Done["Void"], name="take back sun offset"): ...


class OffsetLeft(Done[bool], name="leave sun offset"): ...


class PointBegun(Done["Attempt"], name="begin point"): ...


class Answered(Done["Attempt"], name="answer"): ...


class SpotSeen(Done["Spot | None"], name="look at spot"): ...


class Gathered(Done["PointRecord | CheckRecord"], name="gather"): ...


class Judged(Done["PointJudgement | str | None"], name="judge the point"): ...


class Stored(Done["PointRecord | CheckRecord"], name="store"): ...


class FitRecorded(Done[None], name="fit"): ...


class UploadProposed(Done["UploadOffer | None"], name="propose upload"): ...


class UnitLookedAt(Done["UploadOffer | None"], name="look at the unit again"): ...


class Uploaded(Done["UploadRecord"], name="upload"): ...


class RolledBack(Done["UploadRecord"], name="rollback"): ...


class NoteWritten(Done["Note"], name="note"): ...


class RecordVoided(Done["Void"], name="void"): ...


class PointStruck(Done["Void"], name="strike point"): ...
