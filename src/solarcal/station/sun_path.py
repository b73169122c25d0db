"""The Sun of a session: how it moves in the axes, where it is now, and its solar time.

Solar time is of instants, of directions, and day by day. A solar day runs from one solar midnight
to the next, at the site's own meridian: the only day on which a site near the date line agrees with
itself.
"""

from dataclasses import dataclass

import numpy as np

from solarcal.decimals import Pair
from solarcal.mount.controller import ideal_and_elevation_deg, ideal_axes_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.optics.offset_mirror import Heliostat
from solarcal.session.records import Header
from solarcal.session.view import SessionView
from solarcal.site import Site, Weather
from solarcal.station.state import LiveView
from solarcal.sun import SunPosition, sun_position
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, FloatArray, wrap_deg

SUN_STANDS_DEG_PER_S = 2e-5
"""Slower than this the Sun has no side to come from (an axis at its turning point)."""

RATE_OVER_S = 30.0
REACH_STEP_S = 300.0


def sun_moves_deg(
    geometry: MountGeometry,
    site: Site,
    from_utc_s: float,
    to_utc_s: float,
    heliostat: Heliostat | None = None,
) -> Pair:
    """How far the ideal angles of a unit at ``site`` move between two instants, degrees."""
    start = ideal_axes_deg(geometry, site, from_utc_s, heliostat)
    end = ideal_axes_deg(geometry, site, to_utc_s, heliostat)
    return float(wrap_deg(end[0] - start[0])), end[1] - start[1]


def sun_rates_deg_per_s(
    geometry: MountGeometry, site: Site, unit_utc_s: float, heliostat: Heliostat | None = None
) -> Pair:
    """How fast the unit's Sun moves in the axes, central difference."""
    half_s = 0.5 * RATE_OVER_S
    move1, move2 = sun_moves_deg(
        geometry, site, unit_utc_s - half_s, unit_utc_s + half_s, heliostat
    )
    return move1 / RATE_OVER_S, move2 / RATE_OVER_S


def forward_sense(rate_deg_per_s: float, approach: int) -> int:
    """The sense an axis comes from behind in: the Sun's, or its last where the Sun stands."""
    if abs(rate_deg_per_s) < SUN_STANDS_DEG_PER_S:
        return -1 if approach < 0 else 1
    return -1 if rate_deg_per_s < 0.0 else 1


def back_in_reach_s(
    header: Header, unit_utc_s: float, least_deg: float, elevation_deg: float
) -> float | None:
    """When a Sun that is out of reach comes back within the limits; UTC, to five minutes.

    Parameters
    ----------
    least_deg, elevation_deg : how far inside the limits the ideal angles are to be, and how high
        the Sun.

    ``None`` where they are by now, or are not within a day.
    """
    unit = header.unit
    times = unit_utc_s + REACH_STEP_S * np.arange(SECONDS_PER_DAY / REACH_STEP_S + 1.0)
    geometry = MountGeometry(header.geometry, unit.site.latitude_deg, header.ax1_centre_deg)
    ax1, ax2, elevation = ideal_and_elevation_deg(geometry, unit.site, times, unit.heliostat)
    within = (unit.limits.distance_deg(ax1, ax2) >= least_deg) & (elevation >= elevation_deg)
    first = int(np.argmax(within))
    return float(times[first]) if first else None


@dataclass(frozen=True, slots=True)
class SunNow:
    """Azimuth from north through east; degrees; ``precise`` apparent, for the laptop's UTC.

    ``unit_*`` is where the unit's ideal angles say it is, ``apart_deg`` the angle between the two;
    ``None`` without a status.
    """

    azimuth_deg: float
    elevation_deg: float
    solar_time_h: float
    unit_azimuth_deg: float | None = None
    unit_elevation_deg: float | None = None
    apart_deg: float | None = None


def sun_now(session: SessionView, live: LiveView) -> SunNow | None:
    """Both Suns; ``None`` while the laptop's clock at a status is not known."""
    if live.laptop_utc_s is None:
        return None
    header = session.header
    sun = sun_position(
        "precise", live.laptop_utc_s, header.site, refraction="hughes", weather=header.weather
    )
    azimuth, elevation = float(sun.azimuth_deg), 90.0 - float(sun.zenith_deg)
    status = live.status
    if status is None:
        return SunNow(azimuth, elevation, float(sun.solar_time_h))
    unit_azimuth, unit_zenith = session.geometry.horizontal_from_axes(
        status.ideal1_deg, status.ideal2_deg
    )
    if header.unit.heliostat is not None:
        unit_azimuth, unit_zenith = (
            float(angle) for angle in header.unit.heliostat.sun_deg(unit_azimuth, unit_zenith)
        )
    apart = session.geometry.sky_separation_deg(
        unit_azimuth, unit_zenith, azimuth, float(sun.zenith_deg)
    )
    return SunNow(
        azimuth,
        elevation,
        float(sun.solar_time_h),
        float(unit_azimuth),
        90.0 - float(unit_zenith),
        float(apart),
    )


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
