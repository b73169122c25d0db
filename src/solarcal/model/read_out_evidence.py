"""What reference checks and read-outs say by themselves: missed counts, frozen read-outs."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from solarcal.model.finding import Finding, points_named
from solarcal.model.losses import Loss, Moment
from solarcal.units import FloatArray

FEWEST_COUNTS = 5
"""A switch is found again to a few counts."""
SMALLEST_LOSS_DEG = 0.01
MOVED_DEG = 0.5
"""An axis that had to move this far between two points cannot have stood still."""


def missed_counts_finding(
    check_number: int, counts: int, loss: Loss, moment: Moment | None = None
) -> Finding | None:
    """What a reference check after the first one found; None where that is nothing.

    ``moment``: what the points say of when.
    """
    if abs(counts) < FEWEST_COUNTS or abs(loss.reading_deg) <= SMALLEST_LOSS_DEG:
        return None
    sentence = (
        f"reference check {check_number} found {counts:+d} counts on axis {loss.axis} "
        f"({loss.reading_deg:+.3f} deg): counts were missed since the check before"
    )
    concerned = loss.labels
    if moment is not None and not moment.sure and loss.labels:
        likely = (
            f"after point {loss.labels[-1]}"
            if moment.first_after is None
            else f"before point {moment.first_after}"
        )
        sentence += f", perhaps {likely}, but the points hardly tell when: doubt "
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
