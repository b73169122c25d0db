"""Direct evidence: what clocks, reference checks, settings and read-outs say without any fit."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from solarcal.model.clock_evidence import ClockSetting, clock_findings, laptop_finding
from solarcal.model.finding import Finding
from solarcal.model.losses import Loss, Moment, undo_losses
from solarcal.model.read_out_evidence import frozen_findings, missed_counts_finding
from solarcal.mount.drive import reading_deg
from solarcal.session.records import PointRecord, RefCheck, UnitRecord
from solarcal.station.branch_watch import branch_warning
from solarcal.station.state import SessionView
from solarcal.station.unit_sun import check_unit_sun
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import Mode, Status, UnitSite

if TYPE_CHECKING:
    from solarcal.model.mechanism_solution import MechanismSolution

SITE_AGREEMENT_DEG = 0.005
"""A site wrong by this much moves the Sun by as much."""

SUN_AGREEMENT_DEG = 0.01
"""The clocks were compared minutes after the angles were read: 2 s of drift lie between at most."""


def evidence(session: SessionView) -> tuple[str, ...]:
    """Sentences, each with its number; empty where nothing stands out."""
    return tuple(finding.sentence for finding in direct_findings(session))


def direct_findings(
    session: SessionView, solution: "MechanismSolution | None" = None
) -> tuple[Finding, ...]:
    """Clocks, counts, site and Sun, read-outs; a fit of the points dates missed counts."""
    if session.header.unit.imported:
        return ()
    taken = session.accepted
    timed = [p for p in taken if p.unit_minus_laptop_s is not None]
    said = [
        *clock_findings(
            [parse_utc(p.utc) for p in timed],
            [p.unit_minus_laptop_s for p in timed if p.unit_minus_laptop_s is not None],
            [ClockSetting(parse_utc(c.utc), c.before_s, c.after_s) for c in session.clock_sets],
            [p.seq for p in timed],
        ),
        *_missed(session, solution),
        *_site_and_sun(session),
        *_frozen(taken),
    ]
    if taken:
        if warning := branch_warning(session.header, parse_utc(taken[0].utc)):
            said.append(Finding(kind="branch", subject="axis 1", sentence=warning, direct=True))
        ticks = [c for c in session.clock_sets if c.tick_minus_laptop_s is not None]
        newest = ticks[-1] if ticks else None
        said.append(
            laptop_finding(
                newest.tick_minus_laptop_s if newest else None,
                newest.tick_sigma_s if newest else None,
            )
        )
    return tuple(said)


def losses(session: SessionView) -> tuple[tuple[RefCheck, int, Loss], ...]:
    """What each complete check but the first found on each axis: check, counts, loss.

    The first check finds whatever the register held at power-up; only later ones are evidence. A
    check without switches is none: what the read-outs say of themselves proves nothing.
    """
    found = []
    complete = [check for check in session.ref_checks if check.complete and check.at_switches]
    for before, check in pairwise(complete):
        if check.difference_counts is None:
            continue
        labels = tuple(p.seq for p in session.accepted if before.seq < p.seq < check.seq)
        for axis, counts in enumerate(check.difference_counts):
            angle = _counts_as_deg(session.header.unit, axis, counts)
            found.append((check, counts, Loss(axis + 1, angle, labels)))
    return tuple(found)


def real_losses(session: SessionView) -> tuple[Loss, ...]:
    """Those that are more than the play of a switch."""
    return tuple(
        loss
        for check, counts, loss in losses(session)
        if missed_counts_finding(check.number, counts, loss) is not None
    )


def _missed(session: SessionView, solution: "MechanismSolution | None") -> list[Finding]:
    dated: dict[Loss, Moment] = {}
    real = real_losses(session)
    if solution is not None and real:
        _, when = undo_losses(solution.points, solution.context, solution.posterior.mean, real)
        dated = dict(zip(real, when, strict=True))
    findings = [
        missed_counts_finding(check.number, counts, loss, dated.get(loss))
        for check, counts, loss in losses(session)
    ]
    return [finding for finding in findings if finding is not None]


def _counts_as_deg(unit: UnitRecord, axis: int, counts: int) -> float:
    drive = (unit.drive1, unit.drive2)[axis]
    reference = (unit.reference1_deg, unit.reference2_deg)[axis]
    return float(reading_deg(drive, reference, counts)) - reference


def _site_and_sun(session: SessionView) -> list[Finding]:
    header = session.header
    told, ours = header.unit.site, header.site
    said = [
        Finding(
            kind="unit_sun",
            subject="unit site",
            sentence=f"the unit's {name} is {theirs:.4f}, ours {here:.4f}{remark}",
            number=theirs - here,
            direct=True,
        )
        for name, theirs, here, remark in (
            (
                "latitude",
                told.latitude_deg,
                ours.latitude_deg,
                ": the other hemisphere"
                if abs(told.latitude_deg + ours.latitude_deg) < 2.0 * SITE_AGREEMENT_DEG
                else "",
            ),
            ("longitude", told.longitude_deg, ours.longitude_deg, " (positive east)"),
        )
        if abs(theirs - here) > SITE_AGREEMENT_DEG
    ]
    if header.sun_model != "solartrak":
        return said
    strange: dict[str, list[tuple[int, float]]] = {}
    for point in session.accepted:
        status = _status_at(point)
        if status is not None and point.read_utc is not None:
            told_site = UnitSite(
                told,
                header.unit.zone_west_h,
                header.geometry,
                header.ax1_centre_deg,
                header.unit.heliostat,
            )
            sun = check_unit_sun(told_site, ours, status, parse_utc(point.read_utc))
            if sun.difference_deg > SUN_AGREEMENT_DEG:
                strange.setdefault(sun.explanation, []).append((point.seq, sun.difference_deg))
    for words, points in strange.items():
        worst = max(off for _, off in points)
        said.append(
            Finding(
                kind="unit_sun",
                subject="unit Sun",
                sentence=f"the unit's Sun was {worst:.3f} deg from ours for the clock and site it "
                f"reports, at {len(points)} point{'s' if len(points) > 1 else ''}: {words}",
                number=worst,
                direct=True,
                labels=tuple(seq for seq, _ in points),
            )
        )
    return said


def _status_at(point: PointRecord) -> Status | None:
    """What the unit said when a point's angles were read, as far as the point has kept it."""
    if (
        point.unit_minus_laptop_s is None
        or point.read_utc is None
        or point.ideal_deg is None
        or point.reading_deg is None
        or point.counts is None
        or point.offsets is None
    ):
        return None
    return Status(
        mode=Mode.TRACK,
        unit_utc_s=parse_utc(point.read_utc) + point.unit_minus_laptop_s,
        ideal1_deg=point.ideal_deg[0],
        ideal2_deg=point.ideal_deg[1],
        reading1_deg=point.reading_deg[0],
        reading2_deg=point.reading_deg[1],
        counts1=point.counts[0],
        counts2=point.counts[1],
        target1_deg=point.reading_deg[0],
        target2_deg=point.reading_deg[1],
        offsets=point.offsets,
        moving=(0, 0),
        approach=point.approach or (0, 0),
        update_phase=0.0,
        referenced=True,
        unlocked_s=0.0,
    )


def _frozen(points: Sequence[PointRecord]) -> tuple[Finding, ...]:
    whole = [p for p in points if p.reading_deg is not None and p.ideal_deg is not None]
    if len(whole) < 2:
        return ()
    return frozen_findings(
        [p.seq for p in whole],
        np.array([p.reading_deg for p in whole]),
        np.array([p.ideal_deg for p in whole]),
    )
