"""Values that a session holds twice: counts and read-outs, answers and status, unit and unit."""

from collections.abc import Iterator, Sequence

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.evidence.read_outs import OFFSET_TOLERANCE_DEG, Loss, losses
from solarcal.model.evidence.unit_state import unlike
from solarcal.model.finding import Finding, listed, points_named
from solarcal.mount.drive import Drive, reading_deg
from solarcal.mount.formula import Offsets
from solarcal.session.records import (
    CheckRecord,
    KnownRecord,
    LinkRestored,
    PointRecord,
    RefCheck,
    Restarted,
    UnitRecord,
    UploadBegun,
    UploadRecord,
)
from solarcal.session.view import SessionView
from solarcal.timescale import second_of_day
from solarcal.units import wrap_deg

CHECK_TOLERANCE_DEG = 0.001
"""Errors of a check point are rounded to a ten-thousandth of a degree or finer."""
QUESTIONS = {
    "ref_check": "reference check",
    "sun_offset": "Set Sun Offset",
    "tracking": "tracking",
}


def point_contradictions(unit: UnitRecord, points: Sequence[PointRecord]) -> tuple[Finding, ...]:
    """Points whose counts, limits or answers contradict what else is recorded of them."""
    return (*_counts(unit, points), *_limits(unit, points), *_answers(points))


def session_contradictions(session: SessionView) -> tuple[Finding, ...]:
    """Another unit on the line, points without a reference, uploads and check points."""
    return (
        *_another_unit(session), *_unreferenced(session), *_not_set(session), *_uploads(session),
        *_checks(session),
    )  # fmt: skip


def _counts(unit: UnitRecord, points: Sequence[PointRecord]) -> Iterator[Finding]:
    whole = [p for p in points if p.counts is not None and p.reading_deg is not None]
    drives = ((unit.drive1, unit.reference1_deg), (unit.drive2, unit.reference2_deg))
    for axis, (drive, reference_deg) in enumerate(drives):
        counts = np.array([p.counts[axis] for p in whole if p.counts])
        shown = np.array([p.reading_deg[axis] for p in whole if p.reading_deg])
        angle, after = (_angles(drive, reference_deg, one) for one in (counts, counts + 1.0))
        off = np.abs(wrap_deg(angle - shown))
        wrong = np.flatnonzero(~(off <= OFFSET_TOLERANCE_DEG + np.abs(after - angle)))
        if not len(wrong):
            continue
        worst = int(wrong[np.argmax(off[wrong])])
        labels = tuple(whole[at].seq for at in wrong.tolist())
        said = f"{angle[worst]:z.3f} deg" if np.isfinite(angle[worst]) else "no angle"
        yield Finding(
            kind="counts",
            subject=f"axis {axis + 1}",
            sentence=f"axis {axis + 1}: counts and read-outs of {points_named(labels)} contradict "
            f"each other: at point {whole[worst].seq} {counts[worst]:+z.0f} counts are {said} by "
            f"the unit's drive and reference position, the read-out is {shown[worst]:z.3f} deg",
            number=float(off[worst]) if np.isfinite(off[worst]) else None,
            direct=True,
            labels=labels,
        )


def _angles(
    drive: Drive, reference_deg: float, counts: np.ndarray[tuple[int, ...], np.dtype[np.float64]]
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Read-outs (n,) of these counts; NaN where the drive has none."""
    try:
        return np.asarray(reading_deg(drive, reference_deg, counts), dtype=np.float64)
    except ConfigurationError:
        if len(counts) == 1:
            return np.full(1, np.nan)
        one = [_angles(drive, reference_deg, counts[at : at + 1]) for at in range(len(counts))]
        return np.concatenate(one)


def _limits(unit: UnitRecord, points: Sequence[PointRecord]) -> Iterator[Finding]:
    allowed = unit.update_range_deg + OFFSET_TOLERANCE_DEG
    read = {p.seq: p.reading_deg for p in points if p.reading_deg}
    labels = tuple(n for n, deg in read.items() if unit.limits.distance_deg(*deg) < -allowed)
    if labels:
        where = unit.limits.beyond(*read[labels[0]])
        yield Finding(
            kind="limits",
            subject="limits",
            sentence=f"the read-outs of {points_named(labels)} are beyond the unit's limits (point "
            f"{labels[0]}: {where} deg): read-outs or limits are not the unit's",
            direct=True,
            labels=labels,
        )


def _answers(points: Sequence[PointRecord]) -> Iterator[Finding]:
    for point in points:
        if no := _answered_no(point):
            yield Finding(
                kind="answers",
                subject=f"point {point.seq}",
                sentence=f"point {point.seq} {no}: strike it out, or take another",
                direct=True,
                labels=(point.seq,),
            )


def _answered_no(record: PointRecord | CheckRecord) -> str:
    no = [words for name, words in QUESTIONS.items() if getattr(record.answers, name) is False]
    return f"was accepted although the answer on {listed(no)} was NO" if no else ""


def _in_order(*kinds: Sequence[KnownRecord]) -> list[KnownRecord]:
    return sorted((record for kind in kinds for record in kind), key=lambda record: record.seq)


def _another_unit(session: SessionView) -> Iterator[Finding]:
    ours, other = session.header.unit.serial, None
    after: dict[LinkRestored, list[int]] = {}
    for record in _in_order(session.reconnections, session.accepted):
        if isinstance(record, LinkRestored):
            other = record if record.serial != ours else None
            if other is not None:
                after[other] = []
        elif other is not None:
            after[other].append(record.seq)
    for restored, points in after.items():
        if not points and restored is not other:
            continue
        concerned = f"; {points_named(tuple(points))} may be of it" if points else ""
        yield Finding(
            kind="another_unit",
            subject="unit",
            sentence=f"unit {restored.serial} answered from {second_of_day(restored.utc)} UTC on "
            f"(record {restored.seq}), the session is of unit {ours}{concerned}",
            direct=True,
            labels=tuple(points),
        )


def _unreferenced(session: SessionView) -> Iterator[Finding]:
    """A display that a person reads does not report a restart, and a check broken off there is."""
    restarts = () if session.header.unit.typed else session.restarts
    lost: Restarted | RefCheck | None = None
    without: dict[Restarted | RefCheck, list[int]] = {}
    for record in _in_order(restarts, session.ref_checks, session.accepted):
        if isinstance(record, Restarted):
            lost = record
        elif isinstance(record, RefCheck):
            lost = None if record.complete else record
        elif lost is not None:
            without.setdefault(lost, []).append(record.seq)
    for since, points in without.items():
        labels = tuple(points)
        what = (
            f"the unit had lost its reference at {second_of_day(since.utc)} UTC"
            if isinstance(since, Restarted)
            else f"reference check {since.number} did not end"
        )
        yield Finding(
            kind="restarted",
            subject="reference",
            sentence=f"{what} (record {since.seq}), and no reference check was made before "
            f"{points_named(labels)}: their read-outs may have another zero; strike them out, or "
            "take others",
            direct=True,
            labels=labels,
        )


def _not_set(session: SessionView) -> Iterator[Finding]:
    """Points without a Set Sun Offset, with an O that the unit had before."""
    for point in session.accepted:
        if (
            point.basis == "gathering"
            and not session.header.unit.typed
            and point.offsets is not None
            and session.known_offsets.get(point.offsets, point.seq) < point.seq
            and (point.read_utc or "") not in session.offset_at
        ):
            yield Finding(
                kind="answers",
                subject=f"point {point.seq}",
                sentence=f"no Set Sun Offset was made for point {point.seq}: it repeats what the "
                "unit had; strike it out, or take another",
                direct=True,
                labels=(point.seq,),
            )


def _uploads(session: SessionView) -> Iterator[Finding]:
    """What was to be written last, and what the outcome says was written."""
    begun, newest = None, session.uploads[-1] if session.uploads else None
    for record in session.records:
        if isinstance(record, UploadBegun):
            begun = record
        elif isinstance(record, UploadRecord) and begun is not None and record == newest:
            sets = ("old_coefficients", "old_offsets", "new_coefficients", "new_offsets")
            names = (unlike(getattr(record, name), getattr(begun, name)) for name in sets)
            if said := ", ".join(filter(None, names)):
                yield Finding(
                    kind="upload",
                    subject="upload",
                    sentence=f"records {begun.seq} and {record.seq} contradict each other on what "
                    f"was uploaded ({said}): upload again",
                    direct=True,
                )


def _checks(session: SessionView) -> Iterator[Finding]:
    """Errors of a check point against its sky error, its Set Sun Offset and its answers, and what
    else was recorded of the unit when it was taken."""
    offsets = session.offset_at
    missed = losses(session) if session.checks else ()
    for check in session.checks:
        error = check.error_deg
        if check.status != "accepted" or error is None or check.ideal_deg is None:
            continue
        said = [no] if (no := _answered_no(check)) else []
        said += _unit_at(session, check, missed)
        sky = float(np.hypot(error[0] * np.sin(np.radians(check.ideal_deg[1])), error[1]))
        if check.sky_error_deg is not None and not (
            abs(sky - check.sky_error_deg) <= CHECK_TOLERANCE_DEG
        ):
            said.append(
                f"its errors are {sky:.4f} deg on the sky, recorded as {check.sky_error_deg:.4f}"
            )
        offset = offsets.get(check.read_utc or "")
        written = [u for u in session.uploads if u.verified and u.seq < check.seq]
        before = offset.seq < written[-1].seq if offset and written else False
        if before or (written and (check.read_utc or "9") < written[-1].utc):
            said.append("it was read before the upload")
        if offset is None and session.known_offsets.get(Offsets(*error), check.seq) < check.seq:
            said.append("no Set Sun Offset was made for it, and its errors are an O of before")
        if offset is not None:
            if np.abs(np.subtract(check.ideal_deg, offset.ideal_deg)).max() > CHECK_TOLERANCE_DEG:
                said.append(f"its Sun is not that of its Set Sun Offset (record {offset.seq})")
            left = (offset.offsets.O1, offset.offsets.O2)
            if np.abs(np.subtract(error, left)).max() > CHECK_TOLERANCE_DEG:
                said.append(
                    f"its errors are {error[0]:+z.4f} and {error[1]:+z.4f} deg, O of its Set Sun "
                    f"Offset (record {offset.seq}) {left[0]:+z.4f} and {left[1]:+z.4f}"
                )
            if written and (other := unlike(offset.coefficients, written[-1].new_coefficients)):
                said.append(f"the unit did not hold what was uploaded: {other}")
        if said:
            yield Finding(
                kind="check_point",
                subject=f"check point {check.seq}",
                sentence=f"check point {check.seq} proves nothing ({'; '.join(said)}): strike it "
                "out, and take another",
                direct=True,
            )


def _unit_at(
    session: SessionView, check: CheckRecord, missed: Sequence[tuple[RefCheck, int, Loss]]
) -> Iterator[str]:
    """What was recorded of the unit around a check point that takes its meaning."""
    lost = max((r.seq for r in session.restarts if r.seq < check.seq), default=-1)
    if not any(c.complete and lost < c.seq < check.seq for c in session.ref_checks) and lost >= 0:
        yield "the unit had lost its reference, and no reference check was made before it"
    links = [link for link in session.reconnections if link.seq < check.seq]
    if links and links[-1].serial != session.header.unit.serial:
        yield f"unit {links[-1].serial} was on the line"
    for found, counts, loss in missed:
        since = [c.seq for c in session.ref_checks if c.complete and c.seq < found.seq]
        if since[-1] < check.seq < found.seq:
            yield (
                f"reference check {found.number} after it found {counts:+d} counts missed on axis "
                f"{loss.axis}"
            )
