"""The TRUE error: how far from the apparent Sun the controller's formula would put the collector.

Both axes are taken to stand exactly where the formula with the unit's clock puts them: no update
step, no backlash, no lost count, no reading noise.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from solarcal.emulator.controller import Controller
from solarcal.emulator.world import World
from solarcal.sun import sun_position
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray, wrap_deg

STEP_S = 300.0
MIN_ELEVATION_DEG = 10.0
DAYS_APART = 7
DAYS_OF_YEAR = 53
"""Every seventh day of a year."""


class _SunPath(NamedTuple):
    """Times (true UTC) with the Sun high enough, and its ideal axis angles; each (n,)."""

    utc_s: FloatArray
    ax1_deg: FloatArray
    ax2_deg: FloatArray


class TrueError:
    """True errors of one emulated tracker; the Sun's paths are computed once a day and year."""

    def __init__(self, world: World, controller: Controller) -> None:
        self._world = world
        self._controller = controller
        self._path = cache(self._computed_path)

    def day_deg(self, now_s: float) -> FloatArray:
        """Angles on sky every 5 min of the solar day about the transit nearest to ``now_s``.

        The clock drifts on as it does; before it was last set, it counts as just set.
        """
        path = self._path(self._day_begins_utc_s(now_s), 1)
        clock_s = self._controller.model.clock_error_s(
            path.utc_s - self._world.start_utc_s, self._world.start_utc_s
        )
        return self._errors_deg(path, clock_s)

    def year_deg(self, now_s: float) -> FloatArray:
        """The same over every seventh day of this calendar year, with the clock error of now."""
        world = self._world
        instant = np.datetime64(math.floor(world.true_utc_s(now_s)), "s")
        new_year_s = float(instant.astype("datetime64[Y]").astype("datetime64[s]").astype(int))
        mean_midnight_s = new_year_s - world.site.longitude_deg / 360.0 * SECONDS_PER_DAY
        path = self._path(round(mean_midnight_s / STEP_S) * STEP_S, DAYS_OF_YEAR)
        clock_s = self._controller.model.utc_s(now_s) - world.true_utc_s(now_s)
        return self._errors_deg(path, np.full_like(path.utc_s, clock_s))

    def _day_begins_utc_s(self, now_s: float) -> float:
        """Solar midnight before the transit nearest to now, on the 5-minute grid."""
        utc_s = self._world.true_utc_s(now_s)
        sun = sun_position("solartrak", utc_s, self._world.site)
        since_transit_h = float(wrap_deg((sun.solar_time_h - 12.0) * 15.0)) / 15.0
        midnight_s = utc_s - since_transit_h * 3600.0 - SECONDS_PER_DAY / 2.0
        return round(midnight_s / STEP_S) * STEP_S

    def _computed_path(self, begins_utc_s: float, days: int) -> _SunPath:
        of_day = np.arange(0.0, SECONDS_PER_DAY, STEP_S)
        of_year = np.arange(days) * DAYS_APART * SECONDS_PER_DAY
        times = begins_utc_s + (of_year[:, np.newaxis] + of_day).ravel()
        ax1, ax2, elevation = self._world.sky.sun_path_deg(times)
        high = elevation > MIN_ELEVATION_DEG
        return _SunPath(times[high], ax1[high], ax2[high])

    def _errors_deg(self, path: _SunPath, clock_error_s: FloatArray) -> FloatArray:
        readings, room = self._controller.model.readings_deg(path.utc_s + clock_error_s)
        within = room >= 0.0
        counts = [
            axis.drive.counts(readings[index, within]) - axis.drive.counts(axis.reference_deg)
            for index, axis in enumerate(self._controller.axes)
        ]
        looks1, looks2 = self._world.pointing_deg(counts[0], counts[1])
        return self._world.geometry.sky_separation_deg(
            path.ax1_deg[within], path.ax2_deg[within], looks1, looks2
        )
