"""A few seconds of readings, and the data point they make.

What the technician vouches for is the instant of the Set Sun Offset: there the axes stood on the
Sun, and reading - ideal is the axis error. A minute later the ideal has moved on, and with a lean
of 2.5 deg the error with it by 0.01 deg. So the error is taken from the Set Sun Offset when we saw
it made, and the gathering proves that nothing has changed since: same O, same P, still tracking.
Where the offset was set without us seeing it (on the unit's own keys), O is a new one, and the
error is taken from the gathering: E(P in force) + O there, for the tracking the technician has
watched.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from solarcal.errors import ProcedureRefused
from solarcal.model.evidence.read_outs import OFFSET_TOLERANCE_DEG, offset_disagreements
from solarcal.model.evidence.unit_state import check_unit_sun
from solarcal.model.fit import FEWEST_POINTS
from solarcal.mount.controller import commanded_error_deg
from solarcal.mount.drive import register
from solarcal.mount.formula import Coefficients
from solarcal.session.records import Answers, CheckRecord, PointRecord, SunOffset
from solarcal.session.view import SessionView
from solarcal.station import guards
from solarcal.station.fitting import solve
from solarcal.sun import sun_position
from solarcal.timescale import format_utc, parse_utc
from solarcal.unit.tracker import Status, TypedDisplay

if TYPE_CHECKING:
    from solarcal.station.core import StationCore


READINGS = 5
MOST_ERROR_DEG = 180.0
READING_INTERVAL_S = 1.0
MAX_OFFSET_AGE_S = 1800.0
"""A Set Sun Offset older than this no longer vouches for where the collector is now."""
STALE = "The Set Sun Offset is more than half an hour old"


UNSEEN = "no Set Sun Offset seen since the last point"


@dataclass(frozen=True, slots=True)
class Gathered:
    """The readings of one gathering, first to last, and the laptop's clock at each."""

    statuses: tuple[Status, ...]
    laptop_utc_s: tuple[float, ...]

    @property
    def unit_minus_laptop_s(self) -> float:
        differences = [
            s.unit_utc_s - t for s, t in zip(self.statuses, self.laptop_utc_s, strict=True)
        ]
        return round(float(np.median(differences)), 3)


GATHERING_S = (READINGS - 1) * READING_INTERVAL_S
"""How long a gathering takes."""


def gather(station: "StationCore", progress: Callable[[float], None] | None = None) -> Gathered:
    """Read the unit a few times; refuse (ProcedureRefused) what does not hang together.

    Refused is a unit that does not track, whose offsets changed meanwhile, or whose Sun differs.
    """
    if station.tracker.display is not None:
        return _read_off(station, station.tracker.display, progress)
    statuses: list[Status] = []
    times: list[float] = []
    for index in range(READINGS):
        if index:
            station.clock.wait(READING_INTERVAL_S)
        status = station.poll()
        guards.demand_tracking(station.session.header, status)
        statuses.append(status)
        times.append(station.clock.utc_s())
        if progress is not None:
            progress((index + 1) / READINGS)
    if len({status.offsets for status in statuses}) > 1:
        raise ProcedureRefused(
            "the reference offsets changed while gathering; do not touch the unit's keys meanwhile"
        )
    if station.unit_site is None:
        raise ProcedureRefused("the unit has not reported its site; connect again")
    last = statuses[-1]
    sun = check_unit_sun(
        station.unit_site, station.session.header.site, last.unit_utc_s, last.ideal_deg, times[-1]
    )
    if not sun.agrees:
        raise ProcedureRefused(
            f"the unit's Sun is {sun.difference_deg:.3f} deg from ours for the clock and site it "
            f"reports: {sun.explanation}"
        )
    return Gathered(tuple(statuses), tuple(times))


def _read_off(
    station: "StationCore", display: TypedDisplay, progress: Callable[[float], None] | None
) -> Gathered:
    """One look at the display. What is typed is held against Sun, P and O as it is typed."""
    status = display.read_display()
    if progress is not None:
        progress(1.0)
    typed_utc_s = status.typed_utc_s
    return Gathered((status,), (station.clock.utc_s() if typed_utc_s is None else typed_utc_s,))


def stale(offset: SunOffset | None, laptop_utc_s: float | None) -> bool:
    """Whether a Set Sun Offset is too old to vouch for where the collector is now."""
    if offset is None or laptop_utc_s is None:
        return False
    return laptop_utc_s - parse_utc(offset.instant) > MAX_OFFSET_AGE_S


def _standing(
    session: SessionView, last: Status, laptop_utc_s: float
) -> tuple[SunOffset | None, str]:
    """The Set Sun Offset this attempt uses, or why it uses the gathering instead.

    Refused (ProcedureRefused) where the unit holds an O that it has held before: it was not set on
    the Sun since, and E(P) + O would only be what the unit has.
    """
    fresh = session.fresh_sun_offset
    if fresh is not None and fresh.offsets == last.offsets:
        if stale(fresh, laptop_utc_s):
            return None, f"{STALE[0].lower()}{STALE[1:]}"
        return fresh, ""
    if last.offsets in session.known_offsets:
        raise ProcedureRefused(
            f"{UNSEEN}, and the unit's O is one it had before: the point would only repeat what "
            "the unit has; set the Sun offset first"
        )
    if fresh is None:
        return None, UNSEEN
    return None, "the offsets were changed on the unit after our Set Sun Offset"


def point_candidate(
    session: SessionView, gathered: Gathered, answers: Answers, in_force: Coefficients
) -> PointRecord:
    """The data point that these readings make, not yet stored."""
    last = gathered.statuses[-1]
    laptop_utc_s = gathered.laptop_utc_s[-1]
    basis, why = _standing(session, last, laptop_utc_s)
    stood: SunOffset | Status = last if basis is None else basis
    read_utc = format_utc(laptop_utc_s) if basis is None else basis.instant
    coefficients = in_force if basis is None else basis.coefficients
    ideal, reading = stood.ideal_deg, stood.reading_deg
    error = round(reading[0] - ideal[0], 6), round(reading[1] - ideal[1], 6)
    if session.header.unit.typed:
        # Read-outs are read a moment before or after, between two updates: they prove E + O,
        # which the unit itself computed at that instant.
        e1, e2 = commanded_error_deg(coefficients, stood.offsets, *ideal)
        error = round(e1, 6), round(e2, 6)
    sun = sun_position("precise", parse_utc(read_utc), session.header.site)
    precise1, precise2 = session.true_axes_deg(sun.azimuth_deg, sun.zenith_deg)
    expected, found = counts_since_last_point(session, ideal, reading)
    return PointRecord(
        seq=-1,
        utc="",
        status="accepted",
        answers=answers,
        reason=why,
        basis="sun_offset" if basis is not None else "gathering",
        read_utc=read_utc,
        unit_minus_laptop_s=gathered.unit_minus_laptop_s,
        ideal_deg=ideal,
        precise_deg=(round(precise1, 6), round(precise2, 6)),
        reading_deg=reading,
        counts=stood.counts,
        offsets=last.offsets,
        coefficients=coefficients,
        approach=stood.approach,
        distance_to_limits_deg=round(guards.distance_to_limits_deg(session.header.unit, last), 5),
        error_deg=error,
        expected_counts=expected,
        found_counts=found,
    )


def demand_plausible(session: SessionView, candidate: PointRecord | CheckRecord) -> None:
    """Refuse (ProcedureRefused) a point that contradicts itself, before it can be stored.

    The error is reading - ideal; E(P in force) + O is the same number said by the unit, to its
    resolution and, while it tracks, to its update range. An error of more than half a turn, and
    read-outs well beyond a limit, are refused too.
    """
    error = candidate.error_deg
    if error is None:
        return
    for axis, value in enumerate(error, start=1):
        if not abs(value) <= MOST_ERROR_DEG:
            raise ProcedureRefused(
                f"the error of axis {axis} would be {value:+z.3f} deg, more than half a turn: "
                "the unit's read-out or offset is wrong"
            )
    if isinstance(candidate, CheckRecord) or candidate.reading_deg is None:
        return
    unit = session.header.unit
    beyond = -float(unit.limits.distance_deg(*candidate.reading_deg))
    if beyond > unit.update_range_deg + OFFSET_TOLERANCE_DEG:
        raise ProcedureRefused(
            f"the read-outs ({candidate.reading_deg[0]:z.3f}, {candidate.reading_deg[1]:z.3f}) deg "
            f"lie {beyond:.3f} deg beyond a limit: no axis can be there"
        )
    disagreements = {} if unit.typed else offset_disagreements(unit, [candidate])
    for sentence in disagreements.get(candidate.seq, ()):
        raise ProcedureRefused(f"{sentence}; do a reference check and set the Sun offset again")


def counts_since_last_point(
    session: SessionView, ideal: tuple[float, float], reading: tuple[float, float]
) -> tuple[tuple[float, float] | None, tuple[int, int] | None]:
    """Counts each axis should have moved since the last accepted point, and did move.

    Expected: what the present fit (or, before there is one, the last point's error) predicts for
    this Sun; found: what the read-outs say. A difference is an error of the new point, of the
    last one, or counts that were missed between them.
    """
    accepted = session.accepted
    if not accepted:
        return None, None
    previous = accepted[-1]
    if previous.reading_deg is None or previous.error_deg is None:
        return None, None
    solution = solve(session)
    predicted = previous.error_deg
    if solution is not None and len(accepted) >= FEWEST_POINTS:
        e1, e2 = solution.predict_deg(np.asarray(ideal[0]), np.asarray(ideal[1]))
        predicted = (float(e1), float(e2))
    unit = session.header.unit
    expected: list[float] = []
    found: list[int] = []
    axes = zip(
        (unit.drive1, unit.drive2),
        (unit.reference1_deg, unit.reference2_deg),
        ideal,
        predicted,
        reading,
        previous.reading_deg,
        strict=True,
    )
    for drive, reference, angle, error, now, before in axes:
        start = register(drive, reference, before)
        expected.append(round(register(drive, reference, float(angle + error)) - start, 1))
        found.append(register(drive, reference, now) - start)
    return (expected[0], expected[1]), (found[0], found[1])


def check_candidate(session: SessionView, gathered: Gathered, answers: Answers) -> CheckRecord:
    """The check point these readings make: what the uploaded coefficients leave, on the Sun.

    The axes were centred once more by a Set Sun Offset; whatever O that gave is what the formula
    with the P in force left over.
    """
    last = gathered.statuses[-1]
    basis, why = _standing(session, last, gathered.laptop_utc_s[-1])
    stood: SunOffset | Status = last if basis is None else basis
    left = (stood.offsets.O1, stood.offsets.O2)
    sky = float(np.hypot(left[0] * np.sin(np.radians(stood.ideal_deg[1])), left[1]))
    return CheckRecord(
        seq=-1,
        utc="",
        status="accepted",
        answers=answers,
        reason=why,
        read_utc=basis.instant if basis else format_utc(gathered.laptop_utc_s[-1]),
        ideal_deg=stood.ideal_deg,
        error_deg=left,
        sky_error_deg=round(sky, 5),
    )
