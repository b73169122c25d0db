"""Sunrise, transit, sunset: by root finding on the precise Sun, or by NOAA's formulas."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solarcal.site import Site
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.position import (
    fractional_year_rad,
    noaa_declination_rad,
    noaa_equation_of_time_min,
    require_supported_times,
    sun_position,
)
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, Angles, FloatArray, wrap_deg

SUNRISE_ALTITUDE_DEG = -50.0 / 60.0
"""Airless altitude of the Sun's centre at sunrise: 34' of refraction and 16' of radius."""

NOAA_SUNRISE_ALTITUDE_DEG = -0.833

Polar = Literal["day", "night"]
_HALF_DAY_S = SECONDS_PER_DAY / 2.0
_SUN_DEG_PER_S = 360.0 / SECONDS_PER_DAY
_SAMPLE_S, _SLOPE_S = 600.0, 10.0


@dataclass(frozen=True, slots=True)
class DayEvents:
    """One solar day, from midnight to midnight about a transit; POSIX UTC seconds."""

    sunrise_utc_s: float | None
    transit_utc_s: float
    sunset_utc_s: float | None
    polar: Polar | None
    """The Sun stays up ("day") or down ("night") from midnight to midnight."""
    transit_elevation_deg: float
    """Airless."""

    @property
    def span_utc_s(self) -> tuple[float, float] | None:
        """When the Sun is up, at most from midnight to midnight; None where it never is."""
        if self.polar == "night":
            return None
        rise_s, set_s = self.sunrise_utc_s, self.sunset_utc_s
        return (
            self.transit_utc_s - _HALF_DAY_S if rise_s is None else rise_s,
            self.transit_utc_s + _HALF_DAY_S if set_s is None else set_s,
        )

    @property
    def daylight_s(self) -> float:
        """How long the Sun is up between midnight and midnight."""
        span = self.span_utc_s
        return 0.0 if span is None else span[1] - span[0]


# A year's table is asked for again with another collector, and has the same days.
@functools.lru_cache(maxsize=256)
def day_events(
    utc_s: float, site: Site, *, altitude_deg: float = SUNRISE_ALTITUDE_DEG, dut1_s: float = 0.0
) -> DayEvents:
    """The solar day about the transit nearest to an instant, from the precise Sun.

    Sunrise and sunset are where the airless altitude of the centre passes ``altitude_deg``, to a
    hundredth of a second. At the edge of a polar season one of them can be missing alone.

    Raises
    ------
    ConfigurationError
        The time is outside 1960..2100.
    """
    transit_s = _transit_utc_s(utc_s, site, dut1_s)
    first_s, last_s = transit_s - _HALF_DAY_S, transit_s + _HALF_DAY_S
    ephemeris = SiteEphemeris(site, first_s, last_s, dut1_s)

    def height_deg(at_s: Angles) -> Angles:
        return 90.0 - ephemeris.horizontal_deg(at_s)[1] - altitude_deg

    times = np.linspace(first_s, last_s, 2 * int(_HALF_DAY_S / _SAMPLE_S) + 1)
    above = height_deg(times) > 0.0
    crossings = [
        crossing_nearest_transit(times, above, height_deg, rising=rising)
        for rising in (True, False)
    ]
    found_s = [s for s in crossings if s is not None]
    elevation_deg = sun_position(
        "precise", np.array([transit_s, *found_s]), site, dut1_s=dut1_s
    ).elevation_deg
    # The fast path is a tenth of an arcsecond off: a step of Newton's takes that away.
    around_s = np.clip(np.add.outer([-_SLOPE_S, _SLOPE_S], found_s), first_s, last_s)
    slopes = np.diff(height_deg(around_s), axis=0)[0] / np.diff(around_s, axis=0)[0]
    steps_s = np.clip((altitude_deg - elevation_deg[1:]) / slopes, -_SLOPE_S, _SLOPE_S)
    true_s = iter((found_s + steps_s).tolist())
    sunrise_s, sunset_s = (None if s is None else next(true_s) for s in crossings)
    polar: Polar | None = None
    if sunrise_s is None and sunset_s is None:
        polar = "day" if above.all() else "night"
    return DayEvents(
        sunrise_utc_s=sunrise_s,
        transit_utc_s=transit_s,
        sunset_utc_s=sunset_s,
        polar=polar,
        transit_elevation_deg=float(elevation_deg[0]),
    )


def daylight(site: Site, utc_s: float, min_elevation_deg: float) -> tuple[float, float] | None:
    """When the Sun is above an airless elevation about the transit nearest to an instant.

    POSIX UTC seconds of the first and last moment, at most the solar day from midnight to
    midnight; None where the Sun does not get so high.
    """
    return day_events(utc_s, site, altitude_deg=min_elevation_deg).span_utc_s


def noaa_day_events(
    utc_s: float, site: Site, *, altitude_deg: float = NOAA_SUNRISE_ALTITUDE_DEG
) -> DayEvents:
    """The same by NOAA's formulas: good to a few minutes, up to the polar circles.

    Noon is 720 - 4 lon - eqtime minutes UTC, sunrise and sunset lie the hour angle
    acos(cos z/(cos lat cos dec) - tan lat tan dec) away from it, z = 90.833 deg.

    Raises
    ------
    ConfigurationError
        The time is outside 1960..2100.
    """
    require_supported_times(np.asarray(utc_s))
    longitude_deg = wrap_deg(site.longitude_deg)
    days = math.floor(utc_s / SECONDS_PER_DAY) + np.arange(-1.0, 2.0)
    mean_noon_s = days * SECONDS_PER_DAY + 60.0 * (720.0 - 4.0 * longitude_deg)
    noons_s = mean_noon_s - 60.0 * noaa_equation_of_time_min(fractional_year_rad(mean_noon_s))
    noon_s = float(noons_s[np.argmin(np.abs(noons_s - utc_s))])

    declination = float(noaa_declination_rad(fractional_year_rad(np.asarray(noon_s))))
    latitude = site.latitude_deg * RAD_PER_DEG
    zenith = (90.0 - altitude_deg) * RAD_PER_DEG
    cosine = math.cos(zenith) / (math.cos(latitude) * math.cos(declination)) - math.tan(
        latitude
    ) * math.tan(declination)
    highest_deg = 90.0 - abs(latitude - declination) / RAD_PER_DEG
    if abs(cosine) > 1.0:
        polar: Polar = "day" if cosine < 0.0 else "night"
        return DayEvents(None, noon_s, None, polar, highest_deg)
    half_day_s = 60.0 * 4.0 * math.acos(cosine) / RAD_PER_DEG
    return DayEvents(noon_s - half_day_s, noon_s, noon_s + half_day_s, None, highest_deg)


def _transit_utc_s(utc_s: float, site: Site, dut1_s: float) -> float:
    """The upper transit nearest to an instant."""
    transit_s = utc_s
    # The equation of time drifts by 30 s a day at most: the second step is good to 0.01 s.
    for _ in range(3):
        solar_time_h = sun_position("precise", transit_s, site, dut1_s=dut1_s).solar_time_h
        transit_s -= 15.0 * (solar_time_h - 12.0) / _SUN_DEG_PER_S
    return transit_s


def crossing_nearest_transit(
    times: FloatArray,
    above: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    height_deg: Callable[[float], float],
    *,
    rising: bool,
) -> float | None:
    """Root of the height between the samples where it changes sign; None where it never does."""
    brackets = np.flatnonzero((above[1:] != above[:-1]) & (above[1:] == rising))
    if not brackets.size:
        return None
    # Within a degree of the poles the declination can carry the Sun over the horizon twice.
    nearest = brackets[np.argmin(np.abs(brackets - times.size // 2))]
    return _root(height_deg, float(times[nearest]), float(times[nearest + 1]))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root within a bracket, to a hundredth of a second."""
    # Half a second that a command without sunrise does not wait for.
    from scipy.optimize import brentq  # noqa: PLC0415

    # The ends of the bracket are asked for twice.
    function = functools.cache(function)
    at_low, at_high = function(low), function(high)
    # Where the fast path and the precise Sun disagree about a sample's sign, that sample is
    # the root to within its last digits.
    if at_low * at_high >= 0.0:
        return low if abs(at_low) < abs(at_high) else high
    return float(brentq(function, low, high, xtol=0.005))
