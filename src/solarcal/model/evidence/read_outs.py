"""Read-outs that contradict the motion of the Sun, or themselves."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from solarcal.model.finding import Finding, points_named
from solarcal.mount.formula import correction_deg
from solarcal.session.records import PointRecord, UnitRecord
from solarcal.session.view import SessionView
from solarcal.units import FloatArray

OFFSET_TOLERANCE_DEG = 0.02
"""O is set to counts and decimals; beyond this and the update range it is another number."""
MOVED_DEG = 0.5
"""An axis that had to move this far between two points cannot have stood still."""


def frozen_findings(
    labels: Sequence[int], reading_deg: FloatArray, ideal_deg: FloatArray
) -> tuple[Finding, ...]:
    """Read-outs that stood still or are exactly zero while the Sun moved.

    Parameters
    ----------
    labels
        n points in order of time.
    reading_deg, ideal_deg : (n, 2)
        Absolute read-outs and ideal angles, axis degrees.
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
            shown = "exactly zero" if zero else f"exactly {reading[first]:.5f} deg"
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
                f"axis {axis + 1}: the read-out less the ideal angle is {read[at, axis]:+.3f} "
                f"deg, the unit's formula and O give {commanded[at, axis]:+.3f} deg (allowed "
                f"difference {allowed:.3f})",
            )
    return found


def offset_evidence(session: SessionView) -> tuple[Finding, ...]:
    """Accepted points whose O contradicts their read-outs, or whose error is neither."""
    unit = session.header.unit
    if unit.typed:
        return ()
    disagreements = offset_disagreements(unit, session.accepted)
    found = []
    for point in session.accepted:
        said = list(disagreements.get(point.seq, ()))
        if point.reading_deg and point.ideal_deg and point.error_deg:
            for axis in (0, 1):
                read = point.reading_deg[axis] - point.ideal_deg[axis]
                read -= 360.0 * round(read / 360.0)
                off = abs(point.error_deg[axis] - read)
                if off > unit.update_range_deg + OFFSET_TOLERANCE_DEG:
                    said.append(
                        f"axis {axis + 1}: the recorded error is {point.error_deg[axis]:+.3f} deg, "
                        f"the read-out less the ideal angle {read:+.3f} deg"
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


def _runs(values: FloatArray) -> list[tuple[int, int]]:
    """Stretches [first, last) of equal values."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    edges = [0, *changes.tolist(), len(values)]
    return list(pairwise(edges))


def read_out_evidence(session: SessionView) -> tuple[Finding, ...]:
    """The read-outs of the accepted points."""
    whole = [p for p in session.accepted if p.reading_deg is not None and p.ideal_deg is not None]
    if len(whole) < 2:
        return ()
    return frozen_findings(
        [p.seq for p in whole],
        np.array([p.reading_deg for p in whole]),
        np.array([p.ideal_deg for p in whole]),
    )
