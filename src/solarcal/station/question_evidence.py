"""Beside each of the three questions: what the session and the unit say to it.

Facts, not answers. The technician answers; a fact that speaks for NO is marked.
"""

from dataclasses import dataclass

from solarcal.model.evidence.clocks import CLOCK_TOLERANCE_S
from solarcal.model.evidence.read_outs import FEWEST_COUNTS, restarted_before
from solarcal.model.parameter_checks import CORRECTION_LIMIT_DEG
from solarcal.session.records import RefCheck
from solarcal.session.view import SessionView
from solarcal.station.gathering import stale
from solarcal.station.jogging import TAKEN_UP_DEG
from solarcal.station.state import LiveView
from solarcal.station.sun_path import forward_sense, sun_rates_deg_per_s
from solarcal.timescale import parse_utc, second_of_day
from solarcal.unit.tracker import Mode, Spot, Status

WATCH_S = 60.0
"""The manual has it watched for a minute before a point."""


@dataclass(frozen=True, slots=True)
class Fact:
    """One sentence; ``against`` when it speaks for NO."""

    sentence: str
    against: bool = False


def ago_text(seconds: float) -> str:
    """How long ago: ``40 s``, ``12 min``, ``3 h 05 min`` ago."""
    whole = max(0, round(seconds))
    if whole < 100:
        return f"{whole} s ago"
    minutes = round(whole / 60.0)
    if minutes < 100:
        return f"{minutes} min ago"
    return f"{minutes // 60} h {minutes % 60:02d} min ago"


def question_evidence(
    number: int, session: SessionView, live: LiveView, spot: Spot | None = None
) -> tuple[Fact, ...]:
    """Facts about question 0 (reference check), 1 (Set Sun Offset) or 2 (tracking).

    ``spot``: what the sunspot device of an emulated unit shows now.
    """
    return (_reference, _offset, _tracking)[number](session, live, spot)


def counts_missed(session: SessionView, check: RefCheck) -> bool:
    """Whether a check found more counts than the play of a switch explains.

    The first complete one of a session, or since a restart, finds whatever the register held.
    Without switches, or where they are not shown, counts prove nothing.
    """
    if not check.difference_counts or not check.at_switches or restarted_before(session, check):
        return False
    before = _complete_before(session, check)
    return before and max(abs(found) for found in check.difference_counts) >= FEWEST_COUNTS


def found_words(check: RefCheck) -> str:
    """The counts a check found, in words."""
    if check.difference_counts is None:
        return "counts not shown by the unit"
    what = "counts found" if check.at_switches else "no switches; read-outs off by counts"
    return "{} {:+d}, {:+d}".format(what, *check.difference_counts)


def _since_s(utc: str, live: LiveView) -> float:
    return (live.laptop_utc_s or parse_utc(utc)) - parse_utc(utc)


def _reference(session: SessionView, live: LiveView, spot: Spot | None) -> tuple[Fact, ...]:
    del spot
    status = live.status
    facts = []
    if not session.ref_checks:
        facts.append(Fact("No reference check in this session.", against=True))
    else:
        last = session.ref_checks[-1]
        when = f"{second_of_day(last.utc)} UTC, {ago_text(_since_s(last.utc, live))}"
        if not last.complete:
            facts.append(
                Fact(f"The last check (no. {last.number}, {when}) did NOT end.", against=True)
            )
        else:
            facts.append(Fact(f"Check no. {last.number} at {when}: complete."))
            facts.append(Fact(_counts_found(session, last)))
    if status is not None and not status.referenced and live.capabilities.has_link:
        facts.append(Fact("The unit reports: NOT referenced since power-up.", against=True))
    return tuple(facts)


def _counts_found(session: SessionView, check: RefCheck) -> str:
    if check.difference_counts is None:
        return "The unit does not show the counts found at the switches."
    d1, d2 = check.difference_counts
    if not check.at_switches:
        return (
            f"No switches: the read-outs stood {d1:+d}, {d2:+d} counts from the reference "
            "position. Did both axes stand at their marks there?"
        )
    found = f"Counts found at the switches: axis 1 {d1:+d}, axis 2 {d2:+d}"
    if counts_missed(session, check):
        return f"{found}: counts were missed before it."
    return f"{found}{whether_normal(session, check)}"


def whether_normal(session: SessionView, check: RefCheck) -> str:
    """The end of a sentence on the counts of a check that found none missed."""
    if restarted_before(session, check):
        return "; any number is normal after a restart."
    shown = check.at_switches and check.difference_counts is not None
    if shown and not _complete_before(session, check):
        return "; any number is normal at the first check."
    return "."


def _complete_before(session: SessionView, check: RefCheck) -> bool:
    return any(other.complete and other.seq < check.seq for other in session.ref_checks)


def _offset(session: SessionView, live: LiveView, spot: Spot | None) -> tuple[Fact, ...]:
    del spot
    fresh, status = session.fresh_sun_offset, live.status
    if fresh is None and (given_up := session.unused_sun_offset) is not None:
        return (
            Fact(
                f"The Set Sun Offset of {second_of_day(given_up.instant)} UTC was given up with "
                "its point: one more would repeat its error; set it again.",
                against=True,
            ),
        )
    if fresh is None:
        since = "since the last point" if session.sun_offsets else "in this session"
        as_before = status is not None and status.offsets in session.known_offsets
        then = ", and O is as it was: set it first." if as_before else "."
        return (Fact(f"No Set Sun Offset seen {since}{then}", against=True),)
    age_s = _since_s(fresh.instant, live)
    facts = [
        Fact(
            f"Set at {second_of_day(fresh.instant)} UTC, {ago_text(age_s)}: "
            f"O1 {fresh.offsets.O1:+z.4f}, O2 {fresh.offsets.O2:+z.4f} deg."
        )
    ]
    off_deg = float(session.geometry.sky_separation_deg(*fresh.ideal_deg, *fresh.reading_deg))
    if off_deg > CORRECTION_LIMIT_DEG:
        facts.append(
            Fact(f"Set {off_deg:.0f} deg from the ideal Sun: is the collector on the Sun?", True)
        )
    if stale(fresh, live.laptop_utc_s):
        facts.append(Fact("That is more than half an hour: set it again.", against=True))
    if status is not None and status.offsets != fresh.offsets:
        facts.append(Fact("The unit's offsets have been changed since.", True))
    unit = session.header.unit
    rates = sun_rates_deg_per_s(
        session.geometry, unit.site, parse_utc(fresh.instant), unit.heliostat
    )
    for axis in (0, 1):
        approach = fresh.approach[axis]
        wrong = approach != 0 and approach != forward_sense(rates[axis], approach)
        if axis + 1 in fresh.slack_axes:
            facts.append(
                Fact(
                    f"Axis {axis + 1} came forward by less than {TAKEN_UP_DEG:g} deg: its backlash "
                    "may be in the error.",
                    against=True,
                )
            )
            continue
        facts.append(
            Fact(f"Axis {axis + 1} came from the WRONG side: its backlash is in the error.", True)
            if wrong
            else Fact(
                f"Axis {axis + 1} came from behind the Sun."
                if approach
                else f"Axis {axis + 1}: from which side it came is not known."
            )
        )
    return tuple(facts)


def _tracking(session: SessionView, live: LiveView, spot: Spot | None) -> tuple[Fact, ...]:
    status = live.status
    if status is None:
        return (Fact("No status from the unit yet.", against=True),)
    update_range = session.header.unit.update_range_deg
    if not live.capabilities.has_link:
        facts = [Fact("No connection to this unit: watch the spot through an update.")]
    else:
        facts = [
            Fact(f"The unit is in mode {status.mode}.", against=status.mode is not Mode.TRACK),
            _lag(status, update_range),
        ]
    if (fresh := session.fresh_sun_offset) is not None:
        watched_s = _since_s(fresh.instant, live)
        facts.append(
            Fact(
                f"Watched for {watched_s:.0f} s since the offset was set"
                + ("." if watched_s >= WATCH_S else "; the manual requires a minute."),
                against=watched_s < WATCH_S,
            )
        )
    if spot is not None:
        allowed_deg = update_range + session.header.tolerance_deg
        facts.append(_spot_fact(spot, status, allowed_deg))
    difference_s = live.unit_minus_laptop_s
    own_clock = live.capabilities.has_clock
    if own_clock and difference_s is not None and abs(difference_s) > CLOCK_TOLERANCE_S:
        facts.append(Fact(f"Its clock is {difference_s:+z.1f} s off the laptop's.", against=True))
    return tuple(facts)


def _lag(status: Status, update_range_deg: float) -> Fact:
    lag1_deg, lag2_deg = map(abs, status.off_target_deg)
    off = max(lag1_deg, lag2_deg) > 2.0 * update_range_deg
    return Fact(
        f"Axes {lag1_deg:z.3f}, {lag2_deg:z.3f} deg from their targets (update range "
        f"{update_range_deg:g} deg)" + (": they do NOT follow." if off else "."),
        against=off,
    )


def _spot_fact(spot: Spot, status: Status, allowed_deg: float) -> Fact:
    if not spot.visible:
        return Fact("No spot on the plate.", against=True)
    on_sky = status.on_sky_deg(spot.error1_deg, spot.error2_deg)
    return Fact(
        f"The spot is {on_sky:.3f} deg off centre now"
        + (": it does NOT stay centred." if on_sky > allowed_deg else "."),
        against=on_sky > allowed_deg,
    )
