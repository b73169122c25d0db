"""Which parameters the points cannot tell apart, in words."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
    labels
        The parameters as a technician calls them, k of them.
    null_directions : (k, q)
        Orthonormal directions, in column-normalised parameters, that leave every datum unchanged.
    correlations : (k, k) or None
        Correlation matrix of the estimates.
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
            names = _listed([labels[i] for i in group])
            sentences.append(
                f"{names} can hardly be separated with these points "
                f"({'r' if len(group) == 2 else 'strongest r'} = {_correlation(strongest)})"
            )
    return tuple(sentences)


def _free_sentence(names: list[str], shares: FloatArray) -> str:
    if len(names) == 1:
        return f"these points say nothing about {names[0]}"
    combinations = len(names) - round(float(shares.sum()))
    if combinations <= 0:
        return f"these points say nothing about {_listed(names)}"
    fixed = "one combination" if combinations == 1 else f"{combinations} combinations"
    return (
        f"{_listed(names)} cannot be separated with these points: only {fixed} of them is fixed"
        if combinations == 1
        else f"{_listed(names)} cannot be separated with these points: only {fixed} of them "
        "are fixed"
    )


def _correlation(r: float) -> str:
    # -0.9999996 must not be printed as a perfect -1.00.
    decimals = 2 if abs(r) < 0.995 else 4
    text = f"{r:+.{decimals}f}"
    return text if abs(float(text)) < 1.0 else f"{'-' if r < 0 else '+'}0.9999"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


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
