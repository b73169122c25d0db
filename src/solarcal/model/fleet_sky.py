"""Where the Sun really stood at the points of many sessions: ``sky_context`` for a fleet."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solarcal.model.sky_context import TruePoints
from solarcal.site import Site, Weather
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, FloatArray

BLOCK_S = 366.0 * SECONDS_PER_DAY
"""The Sun is prepared in the same blocks as for a single session, so that answers agree."""
_STANDARD = Weather(pressure_hpa=1013.25, temperature_c=10.0)


@dataclass(frozen=True, eq=False, slots=True)
class FleetPoints:
    """m points of any number of sessions, with what their sessions say of each.

    ``basis`` (m, 3, 3) of the mounts; ``kind`` (m,) ``apparent``, ``airless`` or ``solartrak``;
    ``block`` (m,) the block of a year in which the session begins; ``utc_s`` finite where the
    kind is ``solartrak``; the others (m,).
    """

    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    utc_s: FloatArray
    block: FloatArray
    kind: NDArray[np.str_]
    basis: FloatArray
    centre_deg: FloatArray
    latitude_deg: FloatArray
    longitude_deg: FloatArray
    elevation_m: FloatArray
    pressure_hpa: FloatArray
    temperature_c: FloatArray


def block_of(first_utc_s: FloatArray) -> FloatArray:
    """In which block of a year a session begins."""
    return first_utc_s // BLOCK_S


def fleet_true_points(points: FleetPoints) -> TruePoints:
    """``sky_context.true_points`` of every point under its own sky, (m,)."""
    ax1, ax2 = points.ax1_deg * RAD_PER_DEG, points.ax2_deg * RAD_PER_DEG
    native = np.stack((np.sin(ax2) * np.cos(ax1), np.sin(ax2) * np.sin(ax1), np.cos(ax2)), axis=1)
    east, north, up = np.einsum("mij,mi->jm", points.basis, native)
    azimuth = np.arctan2(east, north) / RAD_PER_DEG
    zenith = np.arctan2(np.hypot(east, north), up) / RAD_PER_DEG
    own_sun = points.kind == "solartrak"
    for block in np.unique(points.block[own_sun]):
        chosen = np.flatnonzero(own_sun & (points.block == block))
        azimuth[chosen], zenith[chosen] = _sun_deg(points, chosen, float(block))
    moved = points.kind != "apparent"
    lift = zenith - apparent_zenith_deg(zenith, "hughes", _STANDARD)
    density = points.pressure_hpa / 1013.25 * (283.0 / (273.0 + points.temperature_c))
    zenith = zenith - np.where(moved, lift * density, 0.0)
    true1, true2 = _axes_deg(points, azimuth, zenith)
    true1 = np.where(moved, true1, points.ax1_deg)
    true2 = np.where(moved, true2, points.ax2_deg)
    step1 = (points.ax1_deg - true1 + 180.0) % 360.0 - 180.0
    return TruePoints(
        true1,
        true2,
        points.err1_deg + step1,
        points.err2_deg + (points.ax2_deg - true2),
        90.0 - zenith,
    )


def _sun_deg(
    points: FleetPoints, chosen: NDArray[np.intp], block: float
) -> tuple[FloatArray, FloatArray]:
    times = points.utc_s[chosen]
    last_block = float(times.max()) // BLOCK_S
    sun = SiteEphemeris(
        Site(0.0, 0.0),
        max(block * BLOCK_S, FIRST_UTC_S),
        min((last_block + 1.0) * BLOCK_S, LAST_UTC_S - 1.0),
    )
    return sun.horizontal_elsewhere_deg(
        times,
        points.latitude_deg[chosen],
        points.longitude_deg[chosen],
        points.elevation_m[chosen],
    )


def _axes_deg(
    points: FleetPoints, azimuth_deg: FloatArray, zenith_deg: FloatArray
) -> tuple[FloatArray, FloatArray]:
    azimuth, zenith = azimuth_deg * RAD_PER_DEG, zenith_deg * RAD_PER_DEG
    across = np.sin(zenith)
    enu = np.stack((across * np.sin(azimuth), across * np.cos(azimuth), np.cos(zenith)), axis=1)
    x, y, z = np.einsum("mij,mj->im", points.basis, enu)
    ax1: FloatArray = np.arctan2(y, x) / RAD_PER_DEG
    ax1 = ax1 - 360.0 * np.ceil((ax1 - points.centre_deg - 180.0) / 360.0)
    return ax1, np.arctan2(np.hypot(x, y), z) / RAD_PER_DEG
