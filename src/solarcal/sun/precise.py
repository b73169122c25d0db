"""The true airless Sun, from pyerfa: 0.015 arcsec of the JPL ephemeris DE421.

Earth and Sun from VSOP2000 (`epv00`), precession and nutation IAU 2000B (`pn00b`), light time,
annual and diurnal aberration, the observer on the WGS84 ellipsoid. Polar motion is left out: it
moves the site by 0.3 arcsec (9 m) at most, less than the uncertainty of the vertical there.
"""

import math
import warnings
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solarcal.site import Site
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

_WGS84 = 1
_MANY = 1000
"""Fewer instants are always computed by the theory itself: they take no time worth saving."""
_WORTH_NODES = 2
"""Instants for each midnight from which on it pays to evaluate the theory at midnights only."""


@cache
def _erfa() -> Any:
    """erfa takes 70 ms to import: only when the first precise Sun is computed."""
    import erfa  # noqa: PLC0415

    return erfa


@dataclass(frozen=True, slots=True)
class Instants:
    """The same instants in the three time scales the theory needs (two-part Julian dates)."""

    ut1: tuple[FloatArray, FloatArray]
    tt: tuple[FloatArray, FloatArray]

    @classmethod
    def of_utc(cls, utc_s: FloatArray, dut1_s: float = 0.0) -> "Instants":
        """POSIX UTC seconds (any shape) and DUT1 = UT1 - UTC in seconds."""
        days = np.floor(utc_s / SECONDS_PER_DAY)
        second_of_day = utc_s - days * SECONDS_PER_DAY
        minute_of_day = np.floor(second_of_day / 60.0)
        date = days.astype("int64").astype("datetime64[D]")
        month = date.astype("datetime64[M]")
        year = date.astype("datetime64[Y]")
        with warnings.catch_warnings():
            # The leap seconds of coming years are not announced yet. That none is assumed costs
            # 0.04 arcsec of Sun for each one to come, and is no news to anybody in the field.
            warnings.filterwarnings("ignore", ".*dubious year", _erfa().ErfaWarning)
            utc = _erfa().dtf2d(
                "UTC",
                year.astype("int64") + 1970,
                (month - year.astype("datetime64[M]")).astype("int64") + 1,
                (date - month.astype("datetime64[D]")).astype("int64") + 1,
                (minute_of_day // 60.0).astype("int64"),
                (minute_of_day % 60.0).astype("int64"),
                second_of_day - 60.0 * minute_of_day,
            )
            ut1 = _erfa().utcut1(*utc, dut1_s)
            tt = _erfa().taitt(*_erfa().utctai(*utc))
        return cls(ut1=ut1, tt=tt)


@dataclass(frozen=True, slots=True)
class TrueSun:
    """The Sun referred to the true equator and equinox of date, and where Greenwich stands."""

    direction: FloatArray
    """Apparent unit vector, (..., 3)."""
    distance_au: FloatArray
    """From the observer (or the geocentre), (...)."""
    sidereal_rad: FloatArray
    """Greenwich apparent sidereal time, (...)."""

    def hour_angle_rad(self, longitude_deg: float) -> FloatArray:
        """Local hour angle, positive in the AFTERNOON, on [-pi, pi)."""
        right_ascension = np.arctan2(self.direction[..., 1], self.direction[..., 0])
        angle = self.sidereal_rad + longitude_deg * RAD_PER_DEG - right_ascension
        return np.asarray(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)

    def declination_rad(self) -> FloatArray:
        x, y, z = np.moveaxis(self.direction, -1, 0)
        return np.asarray(np.arctan2(z, np.hypot(x, y)))


@dataclass(frozen=True, slots=True)
class EarthMotion:
    """Earth and Sun in the frame of the barycentre, au and au per day, each (..., 3)."""

    earth_to_sun: FloatArray
    earth_velocity: FloatArray
    sun_velocity: FloatArray

    @classmethod
    def at(cls, instants: Instants) -> "EarthMotion":
        """By VSOP2000; nine tenths of the time that a precise position takes.

        Of many instants within few days the theory is evaluated at midnights only, with cubics
        between them: 0.0001 arcsec.
        """
        whole, part = instants.tt
        midnight = np.floor(whole + part - 0.5) + 0.5
        if midnight.size >= _MANY:
            nodes = np.unique(np.concatenate((midnight.ravel(), midnight.ravel() + 1.0)))
            if _WORTH_NODES * nodes.size <= midnight.size:
                place = np.searchsorted(nodes, midnight)
                return cls._by_theory(nodes, np.zeros_like(nodes))._between(
                    place, (whole - midnight) + part
                )
        return cls._by_theory(whole, part)

    @classmethod
    def _by_theory(cls, whole: FloatArray, part: FloatArray) -> "EarthMotion":
        with warnings.catch_warnings():
            # `sun_position` has its own, narrower range; terrestrial time is a minute ahead of it.
            warnings.filterwarnings("ignore", ".*date outside", _erfa().ErfaWarning)
            heliocentric, barycentric = _erfa().epv00(whole, part)
        velocity = barycentric["v"]
        return cls(-heliocentric["p"], velocity, velocity - heliocentric["v"])

    def _between(self, node: NDArray[np.intp], x: FloatArray) -> "EarthMotion":
        """At x days (...) after these nodes, each a day before the next one."""
        # Hermite's cubics; velocities are their slopes, and the Sun's own is as good as even.
        x = x[..., np.newaxis]
        rate = self.sun_velocity - self.earth_velocity
        begin, end = self.earth_to_sun[node], self.earth_to_sun[node + 1]
        slope0, slope1 = rate[node], rate[node + 1]
        rise = end - begin
        second, third = 3.0 * rise - 2.0 * slope0 - slope1, slope0 + slope1 - 2.0 * rise
        sun0 = self.sun_velocity[node]
        sun = sun0 + x * (self.sun_velocity[node + 1] - sun0)
        towards = begin + x * (slope0 + x * (second + x * third))
        return EarthMotion(towards, sun - (slope0 + x * (2.0 * second + 3.0 * x * third)), sun)


def horizontal_deg(true_sun: TrueSun, site: Site) -> tuple[FloatArray, FloatArray]:
    """Azimuth (north through east, [0, 360)) and zenith angle of an apparent place."""
    angle = true_sun.sidereal_rad + site.longitude_deg * RAD_PER_DEG
    x, y, z = np.moveaxis(true_sun.direction, -1, 0)
    meridian = np.cos(angle) * x + np.sin(angle) * y
    east = np.cos(angle) * y - np.sin(angle) * x
    latitude = site.latitude_deg * RAD_PER_DEG
    sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
    north = cos_lat * z - sin_lat * meridian
    up = sin_lat * z + cos_lat * meridian
    # From South, so that a hair's breadth west of North is not rounded to 360.
    azimuth = np.mod(180.0 - np.arctan2(east, -north) / RAD_PER_DEG, 360.0)
    return azimuth, np.asarray(np.arctan2(np.hypot(east, north), up) / RAD_PER_DEG)


@dataclass(frozen=True, slots=True)
class Frame:
    """Earth and Sun, and the way to the true equator and equinox of date."""

    motion: EarthMotion
    to_true_equator: FloatArray
    sidereal_rad: FloatArray

    @classmethod
    def of(cls, instants: Instants, motion: EarthMotion | None = None) -> "Frame":
        """At these instants; ``motion`` where it is known for them already."""
        dpsi, _, obliquity, _, _, _, _, to_true_equator = _erfa().pn00b(*instants.tt)
        sidereal = _erfa().gmst00(*instants.ut1, *instants.tt) + _erfa().ee00(
            *instants.tt, obliquity, dpsi
        )
        return cls(motion or EarthMotion.at(instants), to_true_equator, np.asarray(sidereal))

    def sun(self, site: Site | None) -> TrueSun:
        """Apparent place from the site; without one from the geocentre, which varies slowly."""
        # The Sun moves 7 km about the barycentre while its light is on the way: 0.01 arcsec.
        geometric_au = self.motion.earth_to_sun
        light_days = np.linalg.norm(geometric_au, axis=-1) / _erfa().DC
        seen_au = geometric_au - light_days[..., None] * self.motion.sun_velocity
        towards = _erfa().rxp(self.to_true_equator, seen_au)
        velocity = _erfa().rxp(self.to_true_equator, self.motion.earth_velocity) / _erfa().DC
        if site is not None:
            observer = _observer(site, self.sidereal_rad)
            towards = towards - observer["p"] / _erfa().DAU
            velocity = velocity + observer["v"] / _erfa().CMPS
        distance = np.linalg.norm(towards, axis=-1)
        inverse_lorentz = np.sqrt(1.0 - np.sum(velocity**2, axis=-1))
        direction = _erfa().ab(towards / distance[..., None], velocity, distance, inverse_lorentz)
        return TrueSun(direction, distance, self.sidereal_rad)


def observer_m(site: Site, sidereal_rad: FloatArray) -> FloatArray:
    """Vector from the geocentre to the site in the true equator and equinox of date, metres."""
    return np.asarray(_observer(site, sidereal_rad)["p"])


def _observer(site: Site, sidereal_rad: FloatArray) -> Any:
    """Position and velocity of the site (m, m/s) in the true equator and equinox of date."""
    return _erfa().pvtob(
        site.longitude_deg * RAD_PER_DEG,
        site.latitude_deg * RAD_PER_DEG,
        site.elevation_m,
        *(0.0, 0.0, 0.0),  # no polar motion
        sidereal_rad,
    )


def places_m(latitude_deg: Angles, elevation_m: Angles) -> FloatArray:
    """Vectors from the geocentre on the meridian of Greenwich, (..., 3) metres; z to the pole."""
    return np.asarray(_erfa().gd2gc(_WGS84, 0.0, latitude_deg * RAD_PER_DEG, elevation_m))
