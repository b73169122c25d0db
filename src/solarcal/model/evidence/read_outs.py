"""Read-outs that contradict the motion of the Sun, themselves, or the reference switches.

Of counts missed between two reference checks the checks give the number, the points the time.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from solarcal.model.f_tests import ColumnFit, PointsTested
from solarcal.model.finding import Finding, points_named
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.mount.drive import reading_deg
from solarcal.mount.formula import correction_deg
from solarcal.session.records import PointRecord, RefCheck, SunOffset, UnitRecord
from solarcal.session.view import SessionView
from solarcal.units import FloatArray

if TYPE_CHECKING:
    from solarcal.model.mechanism_solution import MechanismSolution

OFFSET_TOLERANCE_DEG = 0.02
"""O is set to counts and decimals; beyond this and the update range it is another number."""
MOVED_DEG = 0.5
"""An axis that had to move this far between two points cannot have stood still."""
FEWEST_COUNTS = 5
"""A switch is found again to a few counts."""
SMALLEST_LOSS_DEG = 0.01

TIE = 1e-9
"""Relative: nearer than this two sums of squares differ by rounding only."""
CLEARLY_WORSE = 9.0
"""By so much of the noise's square another moment must explain the points worse."""


def frozen_findings(
    labels: Sequence[int], reading_deg: FloatArray, ideal_deg: FloatArray
) -> tuple[Finding, ...]:
    """Read-outs that stood still or are exactly zero while the Sun moved.

    Parameters
    ----------
    labels : n points in order of time.
    reading_deg, ideal_deg : (n, 2), absolute read-outs and ideal angles, axis degrees.
    """
    said = []
    for axis in (0, 1):
        reading, ideal = reading_deg[:, axis], ideal_deg[:, axis]
        for first, last in _runs(reading):
            moved = float(np.ptp(ideal[first:last]))
            zero = bool(reading[first] == 0.0)
            if last - first < 2 or moved <= MOVED_DEG:
                continue
            everywhere = last - first == len(reading)
            concerned = tuple(labels[first:last])
            where = "every point" if everywhere else points_named(concerned)
            shown = "exactly zero" if zero else f"exactly {reading[first]:z.5f} deg"
            said.append(
                Finding(
                    kind="frozen",
                    subject=f"axis {axis + 1}",
                    sentence=f"axis {axis + 1} read {shown} at {where} while the Sun moved "
                    f"{moved:.1f} deg: its read-out is "
                    f"{'dead' if zero and everywhere else 'frozen'}",
                    number=float(reading[first]),
                    direct=True,
                    labels=concerned,
                )
            )
    return tuple(said)


def offset_disagreements(
    unit: UnitRecord, points: Sequence[PointRecord]
) -> dict[int, tuple[str, ...]]:
    """Where the unit's O contradicts its own read-outs: point -> both numbers, per axis.

    E(P in force) + O is reading - ideal, to the unit's resolution; between two updates the axes
    stand up to an update range away. Not for typed read-outs, which are of another moment.
    """
    allowed = unit.update_range_deg + OFFSET_TOLERANCE_DEG
    whole = [p for p in points if p.ideal_deg and p.reading_deg and p.offsets]
    found: dict[int, tuple[str, ...]] = {}
    # All points of a day have the same coefficients, as a rule.
    for coefficients in dict.fromkeys(p.coefficients for p in whole if p.coefficients):
        alike = [p for p in whole if p.coefficients == coefficients]
        ideal = np.array([p.ideal_deg for p in alike], dtype=np.float64)
        offsets = np.array([(p.offsets.O1, p.offsets.O2) for p in alike if p.offsets])
        commanded = np.transpose(correction_deg(coefficients, *ideal.T)) + offsets
        read = np.array([p.reading_deg for p in alike]) - ideal
        read -= 360.0 * np.round(read / 360.0)
        for at, axis in np.argwhere(~(np.abs(read - commanded) <= allowed)).tolist():
            found[alike[at].seq] = (
                *found.get(alike[at].seq, ()),
                f"axis {axis + 1}: the read-out less the ideal angle is {read[at, axis]:+z.3f} "
                f"deg, the unit's formula and O give {commanded[at, axis]:+z.3f} deg (allowed "
                f"difference {allowed:.3f})",
            )
    return found


def offset_evidence(session: SessionView, points: Sequence[PointRecord]) -> tuple[Finding, ...]:
    """Points whose O contradicts their read-outs, whose error is neither, or whose numbers are not
    those of their Set Sun Offset."""
    unit, offsets = session.header.unit, session.offset_at
    typed = unit.typed
    disagreements = {} if typed else offset_disagreements(unit, points)
    found = []
    for point in points:
        said = list(disagreements.get(point.seq, ()))
        offset = offsets.get(point.read_utc or "")
        if point.basis == "sun_offset" and offset is not None:
            said += _unlike_its_offset(point, offset)
        if not typed and point.reading_deg and point.ideal_deg and point.error_deg:
            for axis in (0, 1):
                read = point.reading_deg[axis] - point.ideal_deg[axis]
                read -= 360.0 * round(read / 360.0)
                off = abs(point.error_deg[axis] - read)
                if off > unit.update_range_deg + OFFSET_TOLERANCE_DEG:
                    said.append(
                        f"axis {axis + 1}: the recorded error is {point.error_deg[axis]:+z.3f} deg,"
                        f" the read-out less the ideal angle {read:+z.3f} deg"
                    )
        if said:
            found.append(
                Finding(
                    kind="offsets",
                    subject=f"point {point.seq}",
                    sentence=f"point {point.seq} contradicts itself: {'; '.join(said)}",
                    direct=True,
                    labels=(point.seq,),
                )
            )
    return tuple(found)


def _unlike_its_offset(point: PointRecord, offset: SunOffset) -> Iterator[str]:
    """What the point and the Set Sun Offset whose numbers it has do not have in common."""
    for what, ours, recorded in (
        ("ideal angle", point.ideal_deg, offset.ideal_deg),
        ("read-out", point.reading_deg, offset.reading_deg),
        (
            "O",
            point.offsets and (point.offsets.O1, point.offsets.O2),
            (offset.offsets.O1, offset.offsets.O2),
        ),
    ):
        for axis, (here, there) in enumerate(zip(ours or (), recorded, strict=False), start=1):
            if not abs(here - there) <= OFFSET_TOLERANCE_DEG:
                yield (
                    f"axis {axis}: its {what} is {here:z.3f} deg, that of its Set Sun Offset "
                    f"(record {offset.seq}) {there:z.3f} deg"
                )


def _runs(values: FloatArray) -> list[tuple[int, int]]:
    """Stretches [first, last) of equal values."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    edges = [0, *changes.tolist(), len(values)]
    return list(pairwise(edges))


def read_out_evidence(points: Sequence[PointRecord]) -> tuple[Finding, ...]:
    """Read-outs that stood still from point to point."""
    whole = [p for p in points if p.reading_deg is not None and p.ideal_deg is not None]
    if len(whole) < 2:
        return ()
    return frozen_findings(
        [p.seq for p in whole],
        np.array([p.reading_deg for p in whole]),
        np.array([p.ideal_deg for p in whole]),
    )


@dataclass(frozen=True, slots=True)
class Moment:
    """``first_after``: the first point after a loss, None where it came after all of them.

    ``sure``: the next best moment fits clearly worse. An azimuth that jumps at noon looks like a
    scale, so there the points hardly tell.
    """

    first_after: int | None
    sure: bool


@dataclass(frozen=True, slots=True)
class Loss:
    """Axis 1 or 2 reads ``reading_deg`` too much after an unknown moment between two checks.

    ``labels``: the points taken between them, in time; ``struck``: points after these, before the
    second check, are struck out.
    """

    axis: int
    reading_deg: float
    labels: tuple[int, ...]
    struck: bool = False


def undo_losses(
    points: Points, context: SkyContext, values: FloatArray, losses: Sequence[Loss]
) -> tuple[Points, tuple[Moment, ...]]:
    """The points as they would read without the losses, and the moment of each.

    Each loss is put where the six numbers explain the points best. ``values`` (6,): about which
    the mechanism is linearised.
    """
    place = {label: i for i, label in enumerate(points.labels)}
    when: list[Moment] = []
    for loss in losses:
        between = [place[label] for label in loss.labels if label in place]
        trials = [_shifted(points, loss, between[k:]) for k in range(len(between) + 1)]
        fits = [_fit(trial, context, values) for trial in trials]
        squares = np.array([fit.squares for fit in fits])
        # A loss before all points is a zero like another, and explains as much as one after them.
        best = int(np.flatnonzero(squares <= squares.min() * (1.0 + TIE))[-1])
        points = trials[best]
        label = points.labels[between[best]] if best < len(between) else None
        worse = np.delete(squares, best) - squares[best]
        clearly = bool((worse > CLEARLY_WORSE * fits[best].noise ** 2).all())
        # Whoever struck the last points has said when: those kept need only fit it best.
        when.append(Moment(label, clearly or (label is None and loss.struck)))
    return points, tuple(when)


def _shifted(points: Points, loss: Loss, after: Sequence[int]) -> Points:
    errors = [points.err1_deg.copy(), points.err2_deg.copy()]
    errors[loss.axis - 1][list(after)] -= loss.reading_deg
    return points.replace(err1_deg=errors[0], err2_deg=errors[1])


def _fit(points: Points, context: SkyContext, values: FloatArray) -> ColumnFit:
    rows = PointsTested.of(points, context).rows(values, {})
    return ColumnFit(rows.six, rows.residuals)


def missed_counts_finding(
    check_number: int, counts: int, loss: Loss, moment: Moment | None = None
) -> Finding:
    """What a reference check after the first one found; ``moment``: what the points say of when."""
    sentence = (
        f"reference check {check_number} found {counts:+d} counts on axis {loss.axis} "
        f"({loss.reading_deg:+z.3f} deg): counts were missed since the previous check"
    )
    concerned = loss.labels
    if moment is not None and not moment.sure and loss.labels:
        likely = (
            f"after point {loss.labels[-1]}"
            if moment.first_after is None
            else f"before point {moment.first_after}"
        )
        sentence += f", perhaps {likely}, but the points hardly show when: doubt "
        sentence += points_named(concerned)
    elif moment is not None and moment.first_after is not None:
        concerned = loss.labels[loss.labels.index(moment.first_after) :]
        sentence += f", most likely before point {moment.first_after}; {points_named(concerned)} "
        sentence += f"read{'s' if len(concerned) == 1 else ''} wrong by as much"
    elif moment is not None and loss.labels:
        sentence += f", most likely after point {loss.labels[-1]}"
        concerned = ()
    return Finding(
        kind="missed_counts",
        subject=f"axis {loss.axis}",
        sentence=sentence,
        number=loss.reading_deg,
        direct=True,
        labels=concerned,
    )


def play_of_a_switch(counts: int, reading_deg: float) -> bool:
    """Whether a check found no more than a switch may be off by."""
    return abs(counts) < FEWEST_COUNTS or abs(reading_deg) <= SMALLEST_LOSS_DEG


def restarted_before(session: SessionView, check: RefCheck) -> bool:
    """Whether the unit has restarted since the complete check before: its counters began anew."""
    checks = session.ref_checks
    since = max((c.seq for c in checks if c.complete and c.seq < check.seq), default=-1)
    return any(since < r.seq < check.seq for r in session.restarts)


def losses(session: SessionView) -> tuple[tuple[RefCheck, int, Loss], ...]:
    """What each complete check but the first found missing on an axis: check, counts, loss.

    The first check finds whatever the register held at power-up; only later ones are evidence. A
    check without switches is none: what the read-outs say of themselves proves nothing.
    """
    found = []
    complete = [check for check in session.ref_checks if check.complete and check.at_switches]
    for before, check in pairwise(complete):
        if check.difference_counts is None or restarted_before(session, check):
            continue
        labels = tuple(p.seq for p in session.accepted if before.seq < p.seq < check.seq)
        last = max(labels, default=before.seq)
        struck = any(
            isinstance(r, PointRecord) and r.status == "accepted"
            for r in session.records
            if last < r.seq < check.seq
        )
        unit = session.header.unit
        drives = ((unit.drive1, unit.reference1_deg), (unit.drive2, unit.reference2_deg))
        axes = zip(drives, check.difference_counts, strict=True)
        for axis, ((drive, reference), counts) in enumerate(axes, start=1):
            angle = float(reading_deg(drive, reference, counts)) - reference
            if not play_of_a_switch(counts, angle):
                found.append((check, counts, Loss(axis, angle, labels, struck)))
    return tuple(found)


def count_evidence(
    session: SessionView, solution: "MechanismSolution | None" = None
) -> tuple[Finding, ...]:
    """What the reference checks found; a fit of the points dates it."""
    unproven = session.header.unit.has_switches and _unproven(session)
    cannot_tell = Finding(
        kind="missed_counts",
        subject="reference checks",
        sentence=f"{unproven}: whether counts were missed is not determinable",
        certainty="not_determinable",
        direct=True,
    )
    dated: dict[Loss, Moment] = {}
    found = losses(session)
    real = [loss for _, _, loss in found]
    if solution is not None and real:
        _, when = undo_losses(solution.points, solution.context, solution.posterior.mean, real)
        dated = dict(zip(real, when, strict=True))
    missed = (
        missed_counts_finding(check.number, counts, loss, dated.get(loss))
        for check, counts, loss in found
    )
    return (*missed, cannot_tell) if unproven else tuple(missed)


def _unproven(session: SessionView) -> str:
    """Why no reference check proves that the last point was read without missed counts; or not."""
    if not session.accepted:
        return ""
    if not session.ref_checks:
        return "no reference check is recorded"
    last = session.accepted[-1].seq
    complete = (check for check in session.ref_checks if check.complete and check.at_switches)
    since = any(check.seq > last and check.difference_counts is not None for check in complete)
    return "" if since else f"no reference check since point {last}"
