"""From many sessions' points to the arrays of a batched fit, grouped by their number."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solarcal.model.fleet_fit import ManyPoints
from solarcal.model.points import POLE_MARGIN_DEG, SIGMA_HIGH_DEG, SIGMA_LOW_DEG
from solarcal.model.repeats import SAME_S
from solarcal.model.sky_context import (
    BLOCK_S,
    LOWEST_ELEVATION_DEG,
    FleetPoints,
    fleet_true_points,
)
from solarcal.mount.geometry import MountGeometry
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.fitting import prior_of
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S
from solarcal.units import RAD_PER_DEG, FloatArray


@dataclass(frozen=True, slots=True)
class PlainSession:
    """A session the batched fit can take: a mount with a site, looking at the Sun itself."""

    header: Header
    points: PointTable
    geometry: MountGeometry


def plain_session(header: Header, points: PointTable) -> PlainSession | None:
    """The session made ready, or None where it has to go the ordinary way.

    Raises
    ------
    ConfigurationError
        A mount there is not.
    """
    if not len(points) or header.unknown or header.unit.heliostat is not None:
        return None
    if header.last_coefficients is not None:
        return None
    if (np.diff(np.sort(points.utc_s)) <= SAME_S).any():
        return None
    geometry = MountGeometry(header.geometry, header.site.latitude_deg, header.ax1_centre_deg)
    return PlainSession(header, points, geometry)


Group = tuple[list[PlainSession], ManyPoints, FloatArray, list[tuple[int, ...]]]
"""Sessions of the same number of points, these, the sine of ideal AX2 (s, n), and their labels."""


def seen_points(sessions: Sequence[PlainSession]) -> tuple[list[Group], list[PlainSession]]:
    """Groups ready to be fitted, and the sessions with a point that no fit takes."""
    if not sessions:
        return [], []
    counts = np.array([len(session.points) for session in sessions])
    first = np.concatenate(([0], np.cumsum(counts)))
    owner = np.repeat(np.arange(len(sessions)), counts)
    points, sigma = _columns(sessions, owner, first)
    good = np.logical_and.reduceat(_usable(points, sigma), first[:-1])
    refused = [session for session, well in zip(sessions, good, strict=True) if not well]
    if refused:
        kept = [session for session, well in zip(sessions, good, strict=True) if well]
        fitting, more = seen_points(kept)
        return fitting, refused + more
    seen = fleet_true_points(points)
    high = seen.elevation_deg >= LOWEST_ELEVATION_DEG
    used = np.add.reduceat(high.astype(np.intp), first[:-1])
    members: dict[int, list[int]] = defaultdict(list)
    for index in np.flatnonzero(used).tolist():
        members[int(used[index])].append(index)
    priors = [prior_of(session.header) for session in sessions]
    mean = np.array([prior.means for prior in priors])
    spread = np.array([prior.sigmas for prior in priors])
    groups: list[Group] = []
    for n, chosen in members.items():
        rows = np.concatenate(
            [first[i] + np.flatnonzero(high[first[i] : first[i + 1]]) for i in chosen]
        ).reshape(-1, n)
        groups.append(
            (
                [sessions[i] for i in chosen],
                ManyPoints(
                    seen.ax1_deg[rows],
                    seen.ax2_deg[rows],
                    seen.err1_deg[rows],
                    seen.err2_deg[rows],
                    sigma[rows],
                    mean[chosen],
                    spread[chosen],
                ),
                np.sin(points.ax2_deg[rows] * RAD_PER_DEG),
                [
                    tuple(sessions[i].points.labels[row] for row in (found - first[i]).tolist())
                    for i, found in zip(chosen, rows, strict=True)
                ],
            )
        )
    return groups, [session for session, n in zip(sessions, used, strict=True) if not n]


def _columns(
    sessions: Sequence[PlainSession], owner: NDArray[np.intp], first: NDArray[np.intp]
) -> tuple[FleetPoints, FloatArray]:
    """All points of all sessions, and their sigmas (NaN where a session gives none)."""
    read = [session.points for session in sessions]
    ax1, ax2, err1, err2, utc_s = (
        np.concatenate([getattr(p, name) for p in read])
        for name in ("ax1_deg", "ax2_deg", "err1_deg", "err2_deg", "utc_s")
    )
    sigma = np.concatenate(
        [np.full(len(p), np.nan) if p.sigma_deg is None else p.sigma_deg for p in read]
    )
    site = np.array(
        [
            (
                session.header.site.latitude_deg,
                session.header.site.longitude_deg,
                session.header.site.elevation_m,
                session.header.weather.pressure_hpa,
                session.header.weather.temperature_c,
                session.header.ax1_centre_deg,
            )
            for session in sessions
        ]
    )[owner]
    centre = site[:, 5]
    begins = np.minimum.reduceat(utc_s, first[:-1]) // BLOCK_S
    points = FleetPoints(
        ax1_deg=np.where(
            np.abs(ax1) <= 720.0, ax1 - 360.0 * np.ceil((ax1 - centre - 180.0) / 360.0), np.nan
        ),
        ax2_deg=ax2,
        err1_deg=err1,
        err2_deg=err2,
        utc_s=utc_s,
        block=begins[owner],
        kind=np.array([p.ideal for p in read])[owner],
        basis=np.array([session.geometry.basis() for session in sessions])[owner],
        centre_deg=centre,
        latitude_deg=site[:, 0],
        longitude_deg=site[:, 1],
        elevation_m=site[:, 2],
        pressure_hpa=site[:, 3],
        temperature_c=site[:, 4],
    )
    return points, sigma


def _usable(points: FleetPoints, sigma_deg: FloatArray) -> NDArray[np.bool_]:
    """Which points ``Points`` would take, and whose Sun is known."""
    ax2 = points.ax2_deg
    usable = np.isfinite(points.ax1_deg)
    usable &= (ax2 >= POLE_MARGIN_DEG) & (ax2 <= 180.0 - POLE_MARGIN_DEG)
    usable &= (np.abs(points.err1_deg) <= 180.0) & (np.abs(points.err2_deg) <= 180.0)
    usable &= np.isnan(sigma_deg) | ((sigma_deg >= SIGMA_LOW_DEG) & (sigma_deg <= SIGMA_HIGH_DEG))
    # Years the Sun's models do not know are refused alone, not with the whole fleet.
    known = (points.utc_s > FIRST_UTC_S) & (points.utc_s < LAST_UTC_S - 2.0 * BLOCK_S)
    usable &= (points.kind != "solartrak") | (known & np.isfinite(points.block))
    return usable
