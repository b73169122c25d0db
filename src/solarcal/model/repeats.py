"""Rows that are one measurement: read twice, rounded, exported or copied. The first counts."""

from collections.abc import Iterable, Iterator
from itertools import chain, product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from solarcal.model.finding import Finding, points_named
from solarcal.units import FloatArray, wrap_deg

SAME_S = 2.0
"""No technician sets an offset twice in so short a time; a file may round its times by a second."""
SAME_DIRECTION_DEG = 0.1
"""A file may round its angles; directions farther apart are not those of one Sun at one instant."""
SAME_UNDATED_DEG = 1e-4
"""Where no time tells two points apart, all four angles are equal to so much."""
ROUNDING_DEG = 0.01
"""On the sky, copies of one measurement may be apart by so much."""
ANGLES = ("ax1_deg", "ax2_deg", "err1_deg", "err2_deg")


Copy: TypeAlias = tuple[int, int, float]
"""A row, the first row of the same measurement, and how far on the sky their errors are apart: 0
where that is no more than rounding and their sigmas. Or their labels."""


def repeats(
    utc_s: FloatArray, angles_deg: FloatArray, sigma_deg: FloatArray | None
) -> Iterator[Copy]:
    """The rows that repeat an earlier one; ``angles_deg`` (n, 4) are the columns ``ANGLES``.

    Rows of one instant and one direction are one measurement, whatever their errors. Where a time
    is not known (NaN), all four angles must be equal. The cost grows with n for any rows.
    """
    everything = np.arange(len(utc_s))
    dated = np.isfinite(utc_s)
    if dated.all() and (np.diff(np.sort(utc_s)) > SAME_S).all():
        return
    first = everything.copy()
    ax1, ax2 = np.radians(angles_deg[dated, :2]).T
    sky = np.column_stack([np.sin(ax2) * np.cos(ax1), np.sin(ax2) * np.sin(ax1), np.cos(ax2)])
    places = np.column_stack([utc_s[dated] / SAME_S, sky / np.radians(SAME_DIRECTION_DEG)])
    _join(first, everything[dated], places)
    if not dated.all():
        _join(first, everything, angles_deg / SAME_UNDATED_DEG)
    first = first[first]
    rows = np.flatnonzero(first != everything)
    of = first[rows]
    axis1, axis2 = wrap_deg(angles_deg[rows, 2:] - angles_deg[of, 2:]).T
    apart = np.hypot(axis1 * np.sin(np.radians(angles_deg[rows, 1])), axis2)
    least = np.full(len(rows), ROUNDING_DEG)
    if sigma_deg is not None:
        least = np.fmax(least, np.fmax(sigma_deg[rows], sigma_deg[of]))
    apart[apart <= least] = 0.0
    yield from zip(rows.tolist(), of.tolist(), apart.tolist(), strict=True)


def _join(first: NDArray[np.intp], rows: NDArray[np.intp], places: FloatArray) -> None:
    """Let each row count as the first before it whose place (n, 4) is within 1 in every column."""
    # Cells are 2 wide, so that all within 1 of a place is in the 16 cells around one corner.
    mix = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 1], np.uint64)
    around = np.array(list(product((0, 1), repeat=4)), np.uint64) @ mix
    own, corner = (
        np.floor(moved / 2.0).astype(np.int64).view(np.uint64) @ mix
        for moved in (places, places - 1.0)
    )
    members: dict[int, list[int]] = {}
    for at, (row, cell) in enumerate(zip(rows.tolist(), own.tolist(), strict=True)):
        cells = (members.get(key, ()) for key in (corner[at] + around).tolist())
        near = sorted(chain.from_iterable(cells))
        same = [other for other in near if (np.abs(places[other] - places[at]) <= 1.0).all()]
        if not same:
            members.setdefault(cell, []).append(at)
        elif first[row] == row:
            first[row] = first[rows[same[0]]]


def contradicted(copies: Iterable[Copy]) -> tuple[Finding, ...]:
    """A finding on the copies that differ from their first by more than rounding and sigma."""
    apart = [copy for copy in copies if copy[2]]
    if not apart:
        return ()
    label, first, most_deg = max(apart, key=lambda copy: copy[2])
    others = tuple(label for label, *_ in apart)
    contradict = "contradicts its" if len(apart) == 1 else "contradict their"
    return (
        Finding(
            kind="contradiction",
            subject=points_named(others),
            sentence=f"{points_named(others)} {contradict} first reading of the same instant "
            f"(points {first} and {label} differ by {most_deg:.3f} deg on the sky): only the first "
            "is used; check which one is right, and strike the other out",
            number=most_deg,
            direct=True,
            labels=(*others, *(first for _, first, _ in apart)),
        ),
    )
