"""Is there something wrong with fitted numbers: not separable by these points, or no tracker's.

'Parameters still unrealistic' is the original's message: the numbers cannot be a tracker."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solarcal.model.finding import listed
from solarcal.model.points import Points
from solarcal.model.terms import NativeAngles, Term, degrees_per_unit, design_matrix
from solarcal.mount.geometry import Limits
from solarcal.units import FloatArray

NEAR_LIMIT = 0.95
"""|r| above which two parameters can hardly be separated."""

SHARE_LIMIT = 0.02
"""Part of a parameter (squared, column-normalised) that must lie in a free direction for the
parameter to be named; below it is the rounding of the decomposition."""


def inseparable_sentences(
    labels: Sequence[str], null_directions: FloatArray, correlations: FloatArray | None
) -> tuple[str, ...]:
    """Sentences naming the groups of parameters that stand or fall together.

    Parameters
    ----------
    labels : the parameters as a technician calls them, k of them.
    null_directions : (k, q), orthonormal directions, in column-normalised parameters, that leave
        every datum unchanged.
    correlations : (k, k), correlation matrix of the estimates.
    """
    k = len(labels)
    shared = null_directions @ null_directions.T
    shares = np.diag(shared)
    free_groups = [
        group
        for group in _groups((np.abs(shared) > SHARE_LIMIT) & ~np.eye(k, dtype=bool))
        if shares[group].max() > SHARE_LIMIT
    ]
    sentences = [_free_sentence([labels[i] for i in group], shares[group]) for group in free_groups]
    if correlations is None:
        return tuple(sentences)
    near = np.abs(correlations) > NEAR_LIMIT
    np.fill_diagonal(near, False)
    for group in free_groups:
        near[group, :] = near[:, group] = False
    for group in _groups(near):
        if len(group) > 1:
            pairs = correlations[np.ix_(group, group)] - np.eye(len(group))
            strongest = pairs.flat[np.abs(pairs).argmax()]
            names = listed([labels[i] for i in group])
            sentences.append(
                f"{names} can hardly be separated with these points "
                f"({'r' if len(group) == 2 else 'strongest r'} = {correlation_text(strongest)})"
            )
    return tuple(sentences)


def _free_sentence(names: list[str], shares: FloatArray) -> str:
    combinations = len(names) - round(float(shares.sum()))
    if len(names) == 1 or combinations <= 0:
        return f"these points say nothing about {listed(names)}"
    one = combinations == 1
    fixed = "one combination of them is" if one else f"{combinations} combinations of them are"
    return f"{listed(names)} cannot be separated with these points: only {fixed} fixed"


def correlation_text(r: float) -> str:
    """A correlation in two decimals, in four near one: -0.9999996 is not a perfect -1.00."""
    decimals = 2 if abs(r) < 0.995 else 4
    text = f"{r:+z.{decimals}f}"
    return text if abs(float(text)) < 1.0 else f"{'-' if r < 0 else '+'}0.9999"


def _groups(linked: NDArray[np.bool_]) -> list[list[int]]:
    """Connected components of an undirected graph given as a boolean (k, k) matrix."""
    waiting = set(range(len(linked)))
    groups = []
    while waiting:
        group: set[int] = set()
        reached = {min(waiting)}
        while reached:
            group |= reached
            reached = {int(j) for i in reached for j in np.flatnonzero(linked[i])} - group
        waiting -= group
        groups.append(sorted(group))
    return groups


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
    terms: Sequence[Term], values: FloatArray, points: Points, limits: Limits | None
) -> str | None:
    """The contract's rule: lean, zeros, scales, or the correction anywhere within limits.

    The correction is judged ON SKY: in axis degrees it grows without bound near a pole of axis 2
    for the smallest lean. Without limits it is judged within ``SURROUNDINGS_DEG`` of the points.
    """
    kinds = [term.kind for term in terms]
    in_degrees = list(zip(kinds, (values * degrees_per_unit(terms)).tolist(), strict=True))
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
    terms: Sequence[Term], values: FloatArray, points: Points, limits: Limits | None
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
    return (float(angles_deg.min()) - SURROUNDINGS_DEG, float(angles_deg.max()) + SURROUNDINGS_DEG)


def _steps(low_deg: float, high_deg: float) -> FloatArray:
    count = max(2, int(np.ceil(abs(high_deg - low_deg) / GRID_STEP_DEG)) + 1)
    return np.linspace(low_deg, high_deg, count)
