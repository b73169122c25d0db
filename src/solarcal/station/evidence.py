"""Direct evidence: what clocks, reference checks and read-outs say without any fit."""

from collections.abc import Sequence

import numpy as np

from solarcal.mount.drive import reading_deg
from solarcal.session.records import ClockSet, PointRecord, UnitRecord
from solarcal.station.branch_watch import branch_warning
from solarcal.station.state import SessionView
from solarcal.timescale import SECONDS_PER_DAY, parse_utc

CLOCK_SCATTER_S = 0.05
"""Differences are read to the millisecond over a line that takes tens of them."""

SECONDS_PER_SUN_DEG = 240.0
LAPTOP_CLOCK = (
    "a constant error of the laptop's own clock cannot be found from points: 24 s of it is a "
    "rotation of 0.1 deg about the celestial pole and hides in the coefficients; compare the "
    "laptop with a time signal"
)


def clock_drift_s_per_day(
    clock_sets: Sequence[ClockSet], points: Sequence[PointRecord]
) -> tuple[float, float] | None:
    """Drift of the unit's clock against the laptop's since it was last set, and its sigma.

    A straight line through unit - laptop at every point after the last setting; ``None`` with fewer
    than three points or less than half an hour.
    """
    since = parse_utc(clock_sets[-1].utc) if clock_sets else -np.inf
    rows = [
        (parse_utc(p.utc), p.unit_minus_laptop_s)
        for p in points
        if p.unit_minus_laptop_s is not None and parse_utc(p.utc) >= since
    ]
    if len(rows) < 3 or rows[-1][0] - rows[0][0] < 1800.0:
        return None
    t_s, difference_s = np.array(rows, dtype=float).T
    days = (t_s - t_s.mean()) / SECONDS_PER_DAY
    spread = float(days @ days)
    slope = float(days @ difference_s) / spread
    rest = difference_s - difference_s.mean() - slope * days
    scatter = max(float(np.sqrt(rest @ rest / (len(rows) - 2))), CLOCK_SCATTER_S)
    return slope, scatter / float(np.sqrt(spread))


def _counts_as_deg(unit: UnitRecord, axis: int, counts: int) -> float:
    drive = (unit.drive1, unit.drive2)[axis]
    reference = (unit.reference1_deg, unit.reference2_deg)[axis]
    return float(reading_deg(drive, reference, counts)) - reference


def evidence(session: SessionView) -> tuple[str, ...]:
    """Sentences, each with its number; empty where nothing stands out."""
    said: list[str] = []
    taken = [p for p in session.points if p.status == "accepted"]
    drift = clock_drift_s_per_day(session.clock_sets, taken)
    if drift is not None and abs(drift[0]) > max(3.0 * drift[1], 2.0):
        said.append(
            f"the unit's clock drifts {drift[0]:+.1f} +- {drift[1]:.1f} s/day against the "
            f"laptop's: "
            f"{abs(drift[0]) / SECONDS_PER_SUN_DEG:.3f} deg of Sun after a day"
        )
    differences = [p.unit_minus_laptop_s for p in taken if p.unit_minus_laptop_s is not None]
    if differences and max(map(abs, differences)) > 1.0:
        worst = max(differences, key=abs)
        said.append(
            f"unit and laptop clocks differed by up to {worst:+.1f} s at a point "
            f"({abs(worst) / SECONDS_PER_SUN_DEG:.3f} deg of Sun)"
        )
    # The first check finds whatever the register held at power-up; only later ones are evidence.
    for check in session.ref_checks[1:]:
        for axis, counts in enumerate(check.difference_counts):
            angle = _counts_as_deg(session.header.unit, axis, counts)
            if check.complete and abs(counts) >= 5 and abs(angle) > 0.01:
                said.append(
                    f"reference check {check.number} found {counts:+d} counts on axis {axis + 1} "
                    f"({angle:+.3f} deg): counts were missed since the check before"
                )
    said.extend(_frozen(taken))
    if taken:
        if warning := branch_warning(session.header, parse_utc(taken[0].utc)):
            said.append(warning)
        said.append(LAPTOP_CLOCK)
    return tuple(said)


def _frozen(points: Sequence[PointRecord]) -> list[str]:
    said = []
    for axis in (0, 1):
        readings = [p.reading_deg[axis] for p in points if p.reading_deg is not None]
        ideals = [p.ideal_deg[axis] for p in points if p.ideal_deg is not None]
        if len(readings) >= 3 and len(set(readings)) == 1 and np.ptp(ideals) > 0.5:
            said.append(
                f"axis {axis + 1} read exactly {readings[0]:.5f} deg at every point while the Sun "
                f"moved {np.ptp(ideals):.1f} deg: its read-out is frozen"
            )
    return said
