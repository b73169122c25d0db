"""When is the Sun within a mount's limits? Its daily path as axis angles, and when in reach."""

from dataclasses import dataclass

import numpy as np

from solarcal.mount.geometry import Limits, MountGeometry, crosses_branch
from solarcal.site import Site
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

STEP_S = 60.0
"""Dense enough that axis 1 turns less than half round per step unless the Sun hits the pole."""

_EDGE_S = 0.05
_HALF_DAY_S = 0.5 * SECONDS_PER_DAY


@dataclass(frozen=True, slots=True)
class AxisPath:
    """The airless precise Sun as a mount sees it, (n,) arrays: seconds, degrees, AX1 on its branch.

    ``margin_deg`` is the distance to the nearest of limits and lowest elevation, negative outside.
    """

    utc_s: FloatArray
    azimuth_deg: FloatArray
    elevation_deg: FloatArray
    ax1_deg: FloatArray
    ax2_deg: FloatArray
    margin_deg: FloatArray


@dataclass(frozen=True, slots=True)
class Reach:
    """When the Sun is within limits from one solar midnight to the next."""

    spans_utc_s: tuple[tuple[float, float], ...]
    crosses_branch: bool
    """The path in reach jumps across the edge of axis 1's branch: one range cannot hold it."""

    @property
    def hours(self) -> float:
        """Hours within limits, all spans together."""
        return sum(last - first for first, last in self.spans_utc_s) / 3600.0


def axis_path(
    site: Site,
    geometry: MountGeometry,
    limits: Limits,
    utc_s: FloatArray,
    *,
    lowest_deg: float,
    dut1_s: float = 0.0,
) -> AxisPath:
    """The Sun at instants (n,) in order, POSIX UTC seconds, as axis angles with their margin."""
    # erfa, which the precise Sun needs, takes 70 ms to import.
    ephemeris = SiteEphemeris(site, float(utc_s[0]), float(utc_s[-1]), dut1_s)
    azimuth, zenith = ephemeris.horizontal_deg(utc_s)
    ax1, ax2 = geometry.axes_from_horizontal(azimuth, zenith)
    margin = np.minimum(limits.distance_deg(ax1, ax2), 90.0 - zenith - lowest_deg)
    return AxisPath(utc_s, azimuth, 90.0 - zenith, ax1, ax2, margin)


def reach_of_day(
    site: Site,
    geometry: MountGeometry,
    limits: Limits,
    transit_utc_s: float,
    *,
    lowest_deg: float = 0.0,
    dut1_s: float = 0.0,
) -> Reach:
    """When the Sun is above an elevation and within the limits, half a day around its transit.

    The limits are taken of the IDEAL angles: a unit holds its readings to them, which errors and
    offsets move by as much. Edges are found to a tenth of a second.

    Parameters
    ----------
    transit_utc_s : upper transit of the day, POSIX UTC seconds (``day_events``).
    lowest_deg : airless elevation below which the Sun does not count.

    Raises
    ------
    ConfigurationError
        The time is outside 1960..2100.
    """
    first_s, last_s = transit_utc_s - _HALF_DAY_S, transit_utc_s + _HALF_DAY_S
    times = np.arange(first_s, last_s + 0.5 * STEP_S, STEP_S)

    def path(utc_s: FloatArray) -> AxisPath:
        return axis_path(site, geometry, limits, utc_s, lowest_deg=lowest_deg, dut1_s=dut1_s)

    day = path(times)
    inside = day.margin_deg >= 0.0
    changes = np.flatnonzero(inside[1:] != inside[:-1])
    low, high, rising = times[changes], times[changes + 1], inside[changes + 1]
    while changes.size and float(np.max(high - low)) > _EDGE_S:
        middle = 0.5 * (low + high)
        reached = (path(middle).margin_deg >= 0.0) == rising
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    edges = (0.5 * (low + high)).tolist()
    if inside[0]:
        edges.insert(0, float(times[0]))
    if inside[-1]:
        edges.append(float(times[-1]))
    return Reach(
        spans_utc_s=tuple(zip(edges[::2], edges[1::2], strict=True)),
        crosses_branch=crosses_branch(
            np.where(inside, day.ax1_deg, np.nan), geometry.ax1_centre_deg
        ),
    )
