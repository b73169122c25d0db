"""Counts missed between two reference checks: how many is counted, when is told by the points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.model.extended_mechanism import ExtendedMechanism
from solarcal.model.f_tests import squares_beside
from solarcal.model.known_physics import SkyContext
from solarcal.model.points import PointSet
from solarcal.units import FloatArray

CLEARLY_WORSE = 9.0
"""By so much of the noise's square another moment must explain the points worse."""


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

    ``labels``: the points taken between them, in time.
    """

    axis: int
    reading_deg: float
    labels: tuple[int, ...]


def undo_losses(
    points: PointSet, context: SkyContext, values: FloatArray, losses: Sequence[Loss]
) -> tuple[PointSet, tuple[Moment, ...]]:
    """The points as they would read without the losses, and the moment of each.

    Each loss is put where the six numbers explain the points best. ``values`` (6,): about which
    the mechanism is linearised.
    """
    place = {label: i for i, label in enumerate(points.labels)}
    when: list[Moment] = []
    for loss in losses:
        between = [place[label] for label in loss.labels if label in place]
        trials = [_shifted(points, loss, between[k:]) for k in range(len(between) + 1)]
        squares = np.array([_squares(trial, context, values) for trial in trials])
        best = int(np.argmin(squares))
        points = trials[best]
        label = points.labels[between[best]] if best < len(between) else None
        variance = squares[best] / max(2 * len(points) - 6, 1)
        worse = np.delete(squares, best) - squares[best]
        when.append(Moment(label, bool((worse > CLEARLY_WORSE * variance).all())))
    return points, tuple(when)


def _shifted(points: PointSet, loss: Loss, after: Sequence[int]) -> PointSet:
    errors = [points.err1_deg.copy(), points.err2_deg.copy()]
    errors[loss.axis - 1][list(after)] -= loss.reading_deg
    return PointSet(
        geometry=points.geometry,
        ax1_deg=points.ax1_deg,
        ax2_deg=points.ax2_deg,
        err1_deg=errors[0],
        err2_deg=errors[1],
        sigma_deg=points.sigma_deg,
        labels=points.labels,
        utc_s=points.utc_s,
    )


def _squares(points: PointSet, context: SkyContext, values: FloatArray) -> float:
    rows = ExtendedMechanism.of(points, context).rows(values, {})
    return squares_beside(rows.six, rows.residuals)
