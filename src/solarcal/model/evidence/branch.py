"""The Sun's path against axis 1's branch: does one range of it hold the day?

Where the path crosses the edge of the branch, points on its two sides are two calibrations.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from solarcal.model.finding import Finding, points_named
from solarcal.model.sky_context import LOWEST_ELEVATION_DEG, SkyContext
from solarcal.mount.controller import ideal_and_elevation_deg
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry, crosses_branch
from solarcal.optics.offset_mirror import Heliostat
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.session.view import SessionView
from solarcal.site import Site
from solarcal.timescale import SECONDS_PER_DAY, format_utc, parse_utc
from solarcal.units import FloatArray, wrap_deg

_STEP_S = 60.0
_GAP_DEG = 90.0
"""Of axis 1: no two points of a day that is looked at in full are as far apart."""


def side_evidence(
    table: PointTable, context: SkyContext, fitted: AbstractSet[tuple[int, float]] | None = None
) -> tuple[Finding, ...]:
    """Points taken on both sides of the end of axis 1's branch: two calibrations, not one.

    ``fitted``: label and AX2 of the points a fit uses; None: all accepted ones.
    """
    used = table.accepted()
    if fitted is not None:
        places = enumerate(zip(used.labels, used.ax2_deg, strict=True))
        used = used.rows([row for row, place in places if place in fitted])
    if not len(used):
        return ()
    from_centre = np.asarray(wrap_deg(used.ax1_deg - table.ax1_centre_deg), dtype=np.float64)
    runs = (
        _runs_in_time(context, used.utc_s, from_centre)
        if np.isfinite(used.utc_s).all()
        else _runs_by_gap(from_centre)
    )
    *others, many = sorted(_ranges(runs, from_centre), key=len)
    if not others:
        return ()
    few = np.sort(np.concatenate(others))
    labels = tuple(used.labels[i] for i in few)
    end = table.ax1_centre_deg + 180.0
    return (
        Finding(
            kind="branch",
            subject="axis 1",
            sentence=f"{points_named(labels)} {'lies' if len(few) == 1 else 'lie'} beyond the end "
            f"of axis 1's branch at {end:g} deg, the other {len(many)} on this side: a scale error "
            "P5 has another effect there, so these are two calibrations; strike one side out: the "
            "forecast is for the other side only",
            direct=True,
            labels=labels,
        ),
    )


def _runs_in_time(
    context: SkyContext, utc_s: FloatArray, from_centre_deg: FloatArray
) -> list[NDArray[np.intp]]:
    """Positions in the order of time, parted where the Sun crossed the end of the branch."""
    order = np.argsort(utc_s, kind="stable")
    steps = np.abs(np.diff(from_centre_deg[order]))
    # A step of more than 270 deg along the branch is a short one across its ends; of one of more
    # than half a turn the Sun's path tells: its points may be of two days.
    if not any(
        step > 270.0 or (step > 180.0 and _crossed_between(context, first_s, second_s))
        for step, (first_s, second_s) in zip(steps, pairwise(utc_s[order]), strict=True)
    ):
        return [order]
    return np.split(order, np.flatnonzero(steps > 180.0) + 1)


def _runs_by_gap(from_centre_deg: FloatArray) -> list[NDArray[np.intp]]:
    """Without times: positions near both ends of the branch and a quarter turn of nothing between
    them are two runs."""
    order = np.argsort(from_centre_deg, kind="stable")
    along = from_centre_deg[order]
    gaps = np.diff(along)
    across_deg = 360.0 - (along[-1] - along[0])
    if not len(gaps) or not across_deg < _GAP_DEG <= gaps.max():
        return [order]
    return np.split(order, [int(gaps.argmax()) + 1])


def _crossed_between(context: SkyContext, first_s: float, second_s: float) -> bool:
    """Whether the Sun, up, jumps across the branch between these times of one day."""
    apart_s = (second_s - first_s) % SECONDS_PER_DAY
    length_s = min(apart_s, SECONDS_PER_DAY - apart_s)
    begin_s = second_s - apart_s if apart_s == length_s else second_s
    utc_s = begin_s + np.append(np.arange(0.0, length_s, _STEP_S), length_s)
    ax1, _, elevation = ideal_and_elevation_deg(
        context.geometry, context.site, utc_s, context.heliostat
    )
    path = np.where(elevation > 0.0, ax1, np.nan)
    return crosses_branch(path, context.geometry.ax1_centre_deg)


def _ranges(
    runs: Sequence[NDArray[np.intp]], from_centre_deg: FloatArray
) -> list[NDArray[np.intp]]:
    """Runs of points in time as ranges of the branch, the highest first: those that overlap are on
    one side."""
    ranges: list[NDArray[np.intp]] = []
    for run in sorted(runs, key=lambda run: float(from_centre_deg[run].max()), reverse=True):
        if ranges and from_centre_deg[run].max() >= from_centre_deg[ranges[-1]].min():
            ranges[-1] = np.concatenate((ranges[-1], run))
        else:
            ranges.append(run)
    return ranges


def branch_evidence(session: SessionView) -> tuple[Finding, ...]:
    """Whether one range of axis 1 can hold the day of the first point."""
    taken = session.accepted
    warning = branch_warning(session.header, parse_utc(taken[0].utc)) if taken else None
    if warning is None:
        return ()
    return (Finding(kind="branch", subject="axis 1", sentence=warning, direct=True),)


def branch_warning(header: Header, utc_s: float) -> str | None:
    """A sentence where the Sun jumps across AX1 = c +- 180 on the solar day around an instant.

    The Sun counts above 5 deg and within the limits of axis 2, where it can be reached by axis 1
    both before and after the jump. Right AT the jump axis 1 may be beyond its limits: they end
    there, and it has to turn all the way round between one side and the other. None where the path
    stays whole, or where the site's latitude or longitude is not known.
    """
    if header.unknown:
        return None
    geometry = MountGeometry(header.geometry, header.site.latitude_deg, header.ax1_centre_deg)
    # From one mean solar midnight to the next: a quarter of an hour off the apparent one at most.
    day = np.floor(utc_s / SECONDS_PER_DAY + header.site.longitude_deg / 360.0)
    return _crossing(geometry, header.site, header.unit.limits, float(day), header.unit.heliostat)


@lru_cache(maxsize=32)
def _crossing(
    geometry: MountGeometry, site: Site, limits: Limits, day: float, heliostat: Heliostat | None
) -> str | None:
    midnight_s = (day - site.longitude_deg / 360.0) * SECONDS_PER_DAY
    utc_s = midnight_s + np.arange(0.0, SECONDS_PER_DAY, _STEP_S)
    ax1, ax2, elevation = ideal_and_elevation_deg(geometry, site, utc_s, heliostat)
    high = (elevation > LOWEST_ELEVATION_DEG) & _within_limits(limits.axis2, ax2)
    path = np.where(high, ax1, np.nan)
    centre_deg = geometry.ax1_centre_deg
    if not crosses_branch(path, centre_deg):
        return None
    reached = high & _within_limits(limits.axis1, ax1)
    with np.errstate(invalid="ignore"):
        jumps = np.flatnonzero(np.abs(np.diff(wrap_deg(path, centre_deg))) > 180.0)
    jump = int(jumps[0])
    if not (reached[: jump + 1].any() and reached[jump + 1 :].any()):
        return None
    edges = f"{centre_deg + 180.0:.0f} and {centre_deg - 180.0:.0f} deg"
    return (
        f"the Sun crosses the edge of axis 1's branch (AX1 {edges} are one direction) at "
        f"{format_utc(float(utc_s[jump]), 0)}, {elevation[jump]:z.0f} deg high: axis 1 has to "
        "make a full turn there, and a scale error P5 has another effect on each side; one range "
        "of AX1 cannot cover this day, this site needs two"
    )


def _within_limits(
    limits: AxisLimits, angle_deg: FloatArray
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.asarray(limits.distance_deg(angle_deg) >= 0.0)
