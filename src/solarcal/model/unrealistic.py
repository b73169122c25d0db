"""'Parameters still unrealistic': when the numbers cannot be a tracker."""

from collections.abc import Sequence

import numpy as np

from solarcal.model.points import PointSet
from solarcal.model.terms import NativeAngles, Term, design_matrix
from solarcal.mount.limits import Limits
from solarcal.units import FloatArray

MESSAGE = "Parameters still unrealistic"
LEAN_LIMIT_DEG = 10.0
ZERO_LIMIT_DEG = 30.0
SCALE_LIMIT = 0.05
CORRECTION_LIMIT_DEG = 15.0

GRID_STEP_DEG = 5.0
SURROUNDINGS_DEG = 30.0
"""How far around the points the correction is judged when no limits are known."""

POLE_DEG = 0.5
"""The grid keeps this far from the poles of axis 2, where axis 1 has no direction."""


def unrealistic_message(
    terms: Sequence[Term], values: FloatArray, points: PointSet, limits: Limits | None
) -> str | None:
    """The contract's rule: lean, zeros, scales, or the correction anywhere within limits.

    The correction is judged ON SKY: in axis degrees it grows without bound near a pole of axis 2
    for the smallest lean. Without limits it is judged within ``SURROUNDINGS_DEG`` of the points.
    """
    in_degrees = [
        (term.kind, value * term.degrees_per_unit)
        for term, value in zip(terms, values.tolist(), strict=True)
    ]
    lean_deg = np.hypot.reduce([value for kind, value in in_degrees if kind == "lean"], initial=0.0)
    if (
        lean_deg > LEAN_LIMIT_DEG
        or any(abs(v) > ZERO_LIMIT_DEG for kind, v in in_degrees if kind == "zero")
        or any(abs(v) > SCALE_LIMIT for kind, v in in_degrees if kind == "scale")
        or _largest_correction_deg(terms, values, points, limits) > CORRECTION_LIMIT_DEG
    ):
        return MESSAGE
    return None


def _largest_correction_deg(
    terms: Sequence[Term], values: FloatArray, points: PointSet, limits: Limits | None
) -> float:
    centre = points.geometry.ax1_centre_deg
    if limits is not None:
        range1 = (limits.axis1.low_deg, limits.axis1.high_deg)
        range2 = (limits.axis2.low_deg, limits.axis2.high_deg)
    else:
        range1 = _around(points.ax1_deg)
        range2 = _around(points.ax2_deg)
    ax1 = _steps(max(range1[0], centre - 180.0), min(range1[1], centre + 180.0))
    ax2 = _steps(max(range2[0], POLE_DEG), min(range2[1], 180.0 - POLE_DEG))
    grid1, grid2 = (grid.ravel() for grid in np.meshgrid(ax1, ax2))
    at = NativeAngles.at(points.geometry, grid1, grid2)
    e1, e2 = np.einsum("k,kan->an", values, design_matrix(terms, at))
    return float(np.hypot(e1 * at.sin2, e2).max())


def _around(angles_deg: FloatArray) -> tuple[float, float]:
    return (
        float(angles_deg.min()) - SURROUNDINGS_DEG,
        float(angles_deg.max()) + SURROUNDINGS_DEG,
    )


def _steps(low_deg: float, high_deg: float) -> FloatArray:
    count = max(2, int(np.ceil(abs(high_deg - low_deg) / GRID_STEP_DEG)) + 1)
    return np.linspace(low_deg, high_deg, count)
