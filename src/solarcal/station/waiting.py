"""Waiting for the Sun: until it is high enough and within reach, and how far points are apart."""

import numpy as np

from solarcal.errors import ProcedureRefused
from solarcal.mount.controller import ideal_axes_deg
from solarcal.station.core import StationCore
from solarcal.sun.day import daylight
from solarcal.timescale import format_utc

MIN_POINT_ELEVATION_DEG = 10.0
TRACKED_ELEVATION_DEG = 0.5


def wait_until(station: StationCore, utc_s: float) -> None:
    station.clock.wait(max(0.0, round(utc_s - station.clock.utc_s(), 3)))


def sun_up(station: StationCore) -> bool:
    """High enough that the unit, with its own Sun, does not refuse to track it."""
    return station.sun_elevation_deg() >= TRACKED_ELEVATION_DEG


def sun_usable(station: StationCore) -> bool:
    """High enough, and the place it would send the axes to is within the limits."""
    if station.sun_elevation_deg() < MIN_POINT_ELEVATION_DEG:
        return False
    header = station.session.header
    ax1, ax2 = ideal_axes_deg(
        station.geometry, header.site, station.clock.utc_s(), header.unit.heliostat
    )
    return float(header.unit.limits.distance_deg(ax1, ax2)) > 1.0


def wait_for_sun(station: StationCore) -> None:
    """Wait, in quarter hours, until the Sun is usable; polar nights have an end too."""
    for _ in range(4 * 24 * 2):
        if sun_usable(station):
            return
        station.clock.wait(900.0)
    raise ProcedureRefused(
        "the Sun did not come within reach for two days; check site, date and limits "
        f"({format_utc(station.clock.utc_s(), 0)})"
    )


def spread_min(station: StationCore, points: int) -> float:
    """Minutes between so many points from now to the evening."""
    now = station.clock.utc_s()
    interval = daylight(station.session.header.site, now, MIN_POINT_ELEVATION_DEG)
    left_min = (interval[1] - now) / 60.0 if interval is not None else 0.0
    return spread_every_min(points, left_min - 10.0)


def spread_every_min(points: int, daylight_left_min: float) -> float:
    """Minutes between points that use the daylight left: 20 at least, 60 at most."""
    return float(np.clip(daylight_left_min / max(points - 1, 1), 20.0, 60.0))
