"""What to do next, in one sentence: the manual's procedure, read off the state.

A pure function of the state and the time, so that the screen, a replay and a test agree.
"""

import math
from dataclasses import dataclass, replace

from solarcal.model.analysis import Analysis
from solarcal.model.evidence.clocks import CLOCK_TOLERANCE_S
from solarcal.session.view import SessionView
from solarcal.station import guards
from solarcal.station.gathering import STALE, stale
from solarcal.station.sign_off import CHECK_POINTS, sign_off
from solarcal.station.state import Activity, LinkState, StationState
from solarcal.station.uploading import offer_upload
from solarcal.timescale import SECONDS_PER_SUN_DEG, parse_utc
from solarcal.unit.tracker import Mode

POINT_INTERVAL_S = 1800.0
"""The manual takes a point every 30 to 45 minutes: from 30 on the next one is due. A plan knows
better."""

ENOUGH_POINTS = 7
"""The fewest points the manual calls a calibration; it goes on to twelve."""

FULL_CALIBRATION = 12
NOT_TODAY = " Today's will not reach the tolerance."


@dataclass(frozen=True, slots=True)
class NextStep:
    """The sentence, the action it asks for (an id of the workstation's), and when it is due.

    ``due_utc_s`` is on the laptop's clock; ``None`` means now, or that time does not matter.
    """

    sentence: str
    action: str | None = None
    due_utc_s: float | None = None

    def countdown_s(self, utc_s: float | None) -> float | None:
        """Seconds left, 0 when it is due; ``None`` without a time to wait for."""
        if self.due_utc_s is None or utc_s is None:
            return None
        return max(0.0, self.due_utc_s - utc_s)


def countdown_text(seconds: float) -> str:
    """A time to wait: ``40 s``, ``12 min 5 s`` or ``1 h 2 min``; never less than is left."""
    whole = math.ceil(seconds)
    if whole >= 3600:
        hours, minutes = divmod(math.ceil(whole / 60), 60)
        return f"{hours} h {minutes} min"
    minutes, left = divmod(whole, 60)
    return f"{minutes} min {left} s" if minutes else f"{left} s"


def next_step(
    state: StationState, sun_elevation_deg: float | None = None, judgement: Analysis | None = None
) -> NextStep:
    """What the technician does next.

    Parameters
    ----------
    judgement : of the session's points as they are: its plan says when the next one is due, its
        verdict when there are enough. Without one the manual's rules hold.
    sun_elevation_deg : of the Sun now, where it is known: too low a Sun gives no points.
    """
    live, session = state.live, state.session
    if live.link is LinkState.LOST:
        return NextStep(
            "The link is lost; it reconnects automatically. Check the cable and the unit's power.",
            "link",
        )
    if session is None or live.link is LinkState.CLOSED:
        return NextStep("No unit is connected.", "link")
    if (busy := _during(state, session)) is not None:
        return busy
    lost = live.status is not None and not live.status.referenced
    if session.ref_checks and lost and live.capabilities.has_link:
        return NextStep(
            "The unit has lost its reference (did it restart?): do a reference check.", "ref_check"
        )
    newest = session.uploads[-1] if session.uploads else None
    back = newest is not None and newest.rollback and newest.verified and session.holds_upload
    if newest is not None and not back:
        step = _after_upload(state, session, sun_elevation_deg, judgement)
    elif (preparation := _preparation(state, session)) is not None:
        step = preparation
    else:
        step = _next_point(state, session, sun_elevation_deg, judgement)
        if newest is not None and session.newest_evidence == newest.seq:
            step = replace(step, sentence=f"Rolled back. {step.sentence}")
    return _in_reach(state, session, step)


def _in_reach(state: StationState, session: SessionView, step: NextStep) -> NextStep:
    """The step, or how long the unit waits at a limit for a Sun that step needs."""
    status = state.live.status
    needs_sun = step.action in ("sun_offset", "initialise", "take_point")
    if status is None or status.mode is not Mode.LIMIT or not needs_sun:
        return step
    header = session.header
    back_s = guards.back_in_reach_s(header, status)
    if back_s is None:
        return NextStep(f"{guards.AT_LIMIT[0].upper()}{guards.AT_LIMIT[1:]}.")
    limits = header.unit.limits
    first = limits.axis1.distance_deg(status.ideal1_deg)
    axis = 1 if first < limits.axis2.distance_deg(status.ideal2_deg) else 2
    return NextStep(
        f"The unit waits at an axis limit, the Sun is beyond that of axis {axis}: wait until "
        f"{guards.back_words(header, status)}.",
        due_utc_s=back_s,
    )


def _during(state: StationState, session: SessionView) -> NextStep | None:
    """In the middle of something: what it waits for."""
    typed = not state.live.capabilities.has_link
    ends = "switches" if session.header.unit.has_switches else "marks"
    match state.activity:
        case Activity.REF_CHECK:
            return NextStep(f"Reference check running: watch both axes reach their {ends}.")
        case Activity.QUESTIONS | Activity.READY:
            return NextStep("A point is being taken: answer the questions.", "take_point")
        case Activity.GATHERING if typed:
            return NextStep("Type what the unit's display shows.", "take_point")
        case Activity.UPLOADING if typed:
            return NextStep("Key the coefficients in at the unit, and type them back.")
        case Activity.GATHERING:
            return NextStep("Gathering: a few seconds, touch nothing.")
        case Activity.RESULT:
            return NextStep("Look at the result: store it or not?", "take_point")
        case Activity.UPLOADING:
            return NextStep("Uploading: do not unplug anything.")
        case _:
            return None


def _preparation(state: StationState, session: SessionView) -> NextStep | None:
    has_clock = state.live.capabilities.has_clock
    difference_s = state.live.unit_minus_laptop_s
    if has_clock and difference_s is not None and abs(difference_s) > CLOCK_TOLERANCE_S:
        return NextStep(
            f"Set the unit's clock: it differs from the laptop's by {difference_s:+z.1f} s "
            f"({abs(difference_s) / SECONDS_PER_SUN_DEG:.2f} deg of Sun).",
            "clock",
        )
    if has_clock and not session.clock_sets and not session.accepted:
        return NextStep("Set the unit's clock to the laptop's, once per calibration.", "clock")
    if not any(check.complete for check in session.ref_checks):
        return NextStep("Do a reference check, and watch both axes reach home.", "ref_check")
    if session.initialised is None:
        if session.fresh_sun_offset is None:
            return NextStep("Set Sun Offset: jog the collector exactly onto the Sun.", "sun_offset")
        return NextStep("Initialise the data file: the calibration begins here.", "initialise")
    return None


def _next_point(
    state: StationState,
    session: SessionView,
    sun_elevation_deg: float | None,
    judgement: Analysis | None,
    what: str = "point",
) -> NextStep:
    n = len(session.accepted)
    newest = session.uploads[-1] if session.uploads else None
    untried = (
        newest is None
        or newest.rollback
        or any(point.seq > newest.seq for point in session.accepted)
    )
    low = _low(sun_elevation_deg)
    if not low and stale(session.fresh_sun_offset, state.live.laptop_utc_s):
        return NextStep(f"{STALE}: set it again, then take {what} {n + 1}.", "sun_offset")
    if not low and session.fresh_sun_offset is not None:
        status = state.live.status
        if status is not None and status.mode not in (Mode.TRACK, Mode.LIMIT):
            return NextStep(
                f"The unit is in mode {status.mode}: let it track (t in Set Sun Offset), and "
                "watch it for a minute.",
                "sun_offset",
            )
        return NextStep(
            f"Watch it track for a minute and through one update, then take {what} {n + 1}.",
            "take_point",
        )
    misfit = judgement is not None and judgement.verdict.state == "does_not_fit"
    if judgement is not None and judgement.verdict.state == "done":
        if any(f.kind == "missed_counts" and f.certainty == "found" for f in judgement.findings):
            return NextStep(
                "Good for the year, but counts were missed: find the cause, then upload.", "upload"
            )
        return NextStep("Good for the year: upload the coefficients, then verify them.", "upload")
    if judgement is not None and judgement.verdict.first and not misfit:
        return NextStep(
            "More points alone will not do: settle what the verdict names (strike out: x).", "void"
        )
    day = None if judgement is None else judgement.plan
    planned = None if day is None else day.recommended
    if planned is not None and planned.points:
        due_utc_s: float | None = planned.times_utc_s[0]
    elif day is None and n >= FULL_CALIBRATION and untried and not misfit:
        return NextStep(f"{n} points: upload the coefficients, then prove them.", "upload")
    else:
        due_utc_s = parse_utc(session.accepted[-1].utc) + POINT_INTERVAL_S if n else None
    now_utc_s = state.live.laptop_utc_s
    waits = due_utc_s is not None and now_utc_s is not None and due_utc_s > now_utc_s
    # A planned time is one with the Sun high enough.
    if low and not (waits and planned is not None and planned.points):
        enough = n >= ENOUGH_POINTS and untried and not misfit
        least = "upload what you have, or go on" if enough else "go on"
        why = " Meanwhile find out why the points do not fit." if misfit else ""
        return NextStep(
            f"The Sun is too low for a point{low}; {least} {HIGH_ENOUGH}.{why}",
            "upload" if enough else None,
        )
    if misfit:
        return NextStep(
            f"Find out why the points do not fit, or go on with {what} {n + 1}.",
            "sun_offset",
            due_utc_s,
        )
    if planned is not None and planned.points:
        but = "" if day is None or not day.hopeless else NOT_TODAY
        of = f" of ~{n + planned.points}" if planned.points > 1 else ", perhaps the last"
        return NextStep(
            f"{what.capitalize()} {n + 1}{of}: set the Sun offset, then take it.{but}",
            "sun_offset",
            due_utc_s,
        )
    rest = f"{what.capitalize()} {n + 1}: set the Sun offset, then take it"
    if day is not None and day.hopeless:
        return NextStep(f"{rest}.{NOT_TODAY}", "sun_offset", due_utc_s)
    if n >= ENOUGH_POINTS and untried:
        rest += " (or upload: there are enough to try)"
    return NextStep(rest + ".", "sun_offset", due_utc_s)


HIGH_ENOUGH = f"when it is above {guards.MIN_ELEVATION_DEG:.0f} deg"


def _low(sun_elevation_deg: float | None) -> str:
    """How low the Sun is where that is too low for a point; else nothing."""
    if sun_elevation_deg is None or sun_elevation_deg >= guards.MIN_ELEVATION_DEG:
        return ""
    return f" ({sun_elevation_deg:z.0f} deg)"


LEFT = "A Set Sun Offset is in force beside what was uploaded"


def _at_limit(state: StationState) -> bool:
    return state.live.status is not None and state.live.status.mode is Mode.LIMIT


def _doubtful(state: StationState, session: SessionView, judgement: Analysis) -> bool:
    """Whether an upload of the coefficients of all points is refused without a reason."""
    held, status = session.uploads[-1].writes, state.live.status
    if session.offset_left is not None and status is not None:
        held = held[0], status.offsets
    return bool(offer_upload(judgement, session.header.unit, held).against)


def _after_upload(
    state: StationState,
    session: SessionView,
    sun_elevation_deg: float | None,
    judgement: Analysis | None,
) -> NextStep:
    upload = session.uploads[-1]
    if not upload.verified:
        return NextStep(
            f"The upload failed ({upload.failure}): upload again, or roll back."
            if upload.failure
            else "The read-back DIFFERS from what was written: upload again, or roll back.",
            "upload",
        )
    if not session.holds_upload:
        return NextStep(
            "The unit does not hold what was uploaded: upload again, then prove it.", "upload"
        )
    since = session.checks_after(upload)
    proof = sign_off([session], judgement)
    number = f"check point {len(since) + 1} of {max(CHECK_POINTS, len(since) + 1)}"
    why = f"NOT signed off: {proof.open[0].partition(': ')[0]}." if proof.open else ""
    low = _low(sun_elevation_deg)
    offset = session.fresh_sun_offset
    usable = offset is not None and not stale(offset, state.live.laptop_utc_s)
    if proof.superseded and judgement is not None:
        reason = " (it asks for a reason)" if _doubtful(state, session, judgement) else ""
        return NextStep(f"{why} Upload the coefficients of all points{reason}.", "upload")
    if session.offset_left is not None and (low or _at_limit(state)):
        return NextStep(f"{LEFT}: upload again (F8, a).", "upload")
    if judgement is not None and judgement.verdict.state != "done":
        step = _next_point(state, session, sun_elevation_deg, judgement, "data point")
        if not judgement.forecast.sure and judgement.verdict.state != "does_not_fit":
            # With all points: of what was uploaded it does not grow with the next one.
            why = f"NOT signed off: the year is {judgement.forecast.sure_words}."
        return replace(step, sentence=f"{why} {step.sentence}")
    if session.offset_left is not None and len(since) >= CHECK_POINTS:
        take = f"take {number} with it" if usable else f"set it anew and take {number}"
        return NextStep(
            f"{LEFT}: {take}, or upload again (F8, a).", "take_point" if usable else "sun_offset"
        )
    if len(since) >= CHECK_POINTS and proof.proven:
        if proof.signed_off:
            return NextStep("Signed off: calibrated and proven. Write the report.", "report")
        then = "Take more points and upload again, or roll back."
        return NextStep(f"{why} {then}", "sun_offset")
    if low:
        return NextStep(f"The Sun is too low for {number}{low}; go on {HIGH_ENOUGH}.")
    if stale(offset, state.live.laptop_utc_s):
        return NextStep(f"{STALE}: set it again, then take {number}.", "sun_offset")
    if offset is not None:
        return NextStep(f"Take {number}: the same questions, never fitted.", "take_point")
    due_utc_s = parse_utc(since[-1].utc) + POINT_INTERVAL_S if since else None
    return NextStep(f"Prove it with {number}: set the Sun offset first.", "sun_offset", due_utc_s)
