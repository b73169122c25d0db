"""Apparent solar time as an axis: of instants, of directions, and day by day.

A solar day runs from one solar midnight to the next, at the site's own meridian: the only day on
which a site near the date line agrees with itself.
"""

from dataclasses import dataclass

import numpy as np

from solarcal.session.records import Header
from solarcal.site import Site, Weather
from solarcal.sun import SunPosition, sun_position
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, FloatArray

STEP_H = 1.0 / 6.0
"""The original's curve: a computed dot every ten minutes."""

STEPS_PER_DAY = 144


@dataclass(frozen=True, slots=True)
class SunModel:
    """The Sun the ideal angles were computed with."""

    name: str = "solartrak"
    refraction: str = "none"
    weather: Weather | None = None

    @classmethod
    def of_session(cls, header: Header) -> "SunModel":
        """The Sun of a session; an import names the kind of its ideal angles, which is none."""
        name = "precise" if header.sun_model in ("apparent", "airless") else header.sun_model
        return cls(name, header.refraction, header.weather)

    def position(self, utc_s: FloatArray, site: Site) -> SunPosition[FloatArray]:
        """The Sun over a site at instants of any shape."""
        return sun_position(
            self.name, utc_s, site, refraction=self.refraction, weather=self.weather
        )

    def solar_time_h(self, utc_s: FloatArray, site: Site) -> FloatArray:
        """Apparent solar time of instants, hours in [0, 24), shape of ``utc_s``."""
        return sun_position(self.name, utc_s, site).solar_time_h


def solar_time_from_direction_h(
    azimuth_deg: FloatArray, elevation_deg: FloatArray, latitude_deg: float
) -> FloatArray:
    """Apparent solar time of directions to the Sun, for points that carry no time; [0, 24).

    Azimuth from north through east. The hour angle of the direction, plus twelve hours.
    """
    azimuth, elevation = azimuth_deg * RAD_PER_DEG, elevation_deg * RAD_PER_DEG
    latitude = latitude_deg * RAD_PER_DEG
    west = -np.cos(elevation) * np.sin(azimuth)
    up, north = np.sin(elevation), np.cos(elevation) * np.cos(azimuth)
    towards_meridian = up * np.cos(latitude) - north * np.sin(latitude)
    return np.asarray((12.0 + np.arctan2(west, towards_meridian) / RAD_PER_DEG / 15.0) % 24.0)


def solar_day(utc_s: FloatArray, solar_h: FloatArray, site: Site) -> FloatArray:
    """Whole number of the apparent solar day of each instant, shape of ``utc_s``."""
    mean_days = utc_s / SECONDS_PER_DAY + site.longitude_deg / 360.0
    # The difference is whole but for the equation of time (at most 17 minutes).
    return np.rint(mean_days - solar_h / 24.0)


def day_grid(day: float, site: Site, sun: SunModel) -> tuple[FloatArray, FloatArray]:
    """UTC and apparent solar time of every ten minutes of a solar day, from 00:00; (144,) each."""
    nominal_h = np.arange(STEPS_PER_DAY, dtype=np.float64) * STEP_H
    mean_day = day - site.longitude_deg / 360.0
    utc_s = mean_day * SECONDS_PER_DAY + nominal_h * 3600.0
    # The equation of time moves by 30 s a day at most: one correction leaves 0.3 s.
    lag_h = (sun.solar_time_h(utc_s, site) - nominal_h + 12.0) % 24.0 - 12.0
    return utc_s - lag_h * 3600.0, nominal_h
