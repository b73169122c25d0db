"""Read-outs that contradict the motion of the Sun, or themselves."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from solarcal.model.finding import Finding, points_named
from solarcal.session.view import SessionView
from solarcal.units import FloatArray

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
