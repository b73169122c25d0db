"""The Sun of a circular orbit, as D. Rusin's SUNCALC has it: for energy, never for pointing.

The Earth goes round in 365.25 days on a circle, its axis leans by 23.45 deg, and the Sun stands
still among the stars for the length of a day. Days are counted from the March equinox, hours are
solar time (12 is when the Sun is highest). No air, no size of the Sun's disc. Vectors are
North, East, Up; bearings of rising are counted from East towards North, as SUNCALC does.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from solarcal.site import Site
from solarcal.sun.position import sun_position
from solarcal.timescale import SECONDS_PER_DAY, parse_utc
from solarcal.units import RAD_PER_DEG, FloatArray

YEAR_DAYS = 365.25
OBLIQUITY_DEG = 23.45

NeverSets = Literal["day", "night"]
_DEG_PER_RAD = 1.0 / RAD_PER_DEG
_RAD_PER_H = math.pi / 12.0


@dataclass(frozen=True, slots=True)
class CircularDay:
    """The Sun's way over one latitude on one day of the circular year.

    ``day``: days after the March equinox, 0 to 366; parts of days are allowed.
    """

    latitude_deg: float
    day: float

    @property
    def _longitude_rad(self) -> float:
        return 2.0 * math.pi * self.day / YEAR_DAYS

    @property
    def _latitude_and_declination_rad(self) -> tuple[float, float]:
        return self.latitude_deg * RAD_PER_DEG, self.declination_deg * RAD_PER_DEG

    @property
    def declination_deg(self) -> float:
        """Height of the Sun above the equator."""
        lean = math.sin(OBLIQUITY_DEG * RAD_PER_DEG)
        return math.asin(lean * math.sin(self._longitude_rad)) * _DEG_PER_RAD

    @property
    def right_ascension_deg(self) -> float:
        """Angle along the equator from the March equinox to the Sun, (-180, 180]."""
        longitude = self._longitude_rad
        y = math.cos(OBLIQUITY_DEG * RAD_PER_DEG) * math.sin(longitude)
        return math.atan2(y, math.cos(longitude)) * _DEG_PER_RAD

    @property
    def _up(self) -> tuple[float, float]:
        """a and b of U = a + b cos(hour angle)."""
        latitude, declination = self._latitude_and_declination_rad
        apart = math.cos(latitude) * math.cos(declination)
        return math.sin(latitude) * math.sin(declination), apart

    def direction_neu(self, solar_time_h: ArrayLike) -> FloatArray:
        """Unit vectors to the Sun: components North, East, Up; shape (..., 3)."""
        hour_angle = (np.asarray(solar_time_h, dtype=np.float64) - 12.0) * _RAD_PER_H
        latitude, declination = self._latitude_and_declination_rad
        along = np.cos(declination) * np.cos(hour_angle)
        north = np.sin(declination) * np.cos(latitude) - np.sin(latitude) * along
        east = 0.0 - np.cos(declination) * np.sin(hour_angle)
        up = np.sin(declination) * np.sin(latitude) + np.cos(latitude) * along
        return np.stack([north, east, up], axis=-1)

    def elevation_deg(self, solar_time_h: float) -> float:
        """Height above the horizon."""
        north, east, up = self.direction_neu(solar_time_h).tolist()
        return math.atan2(up, math.hypot(north, east)) * _DEG_PER_RAD

    @property
    def never_sets(self) -> NeverSets | None:
        """The Sun shines ("day") or is hidden ("night") throughout; None: it rises and sets."""
        a, b = self._up
        if a >= b:
            return "day"
        return "night" if a <= -b else None

    @property
    def daylight_h(self) -> float:
        """Hours of Sun."""
        if self.never_sets is not None:
            return 24.0 if self.never_sets == "day" else 0.0
        a, b = self._up
        return 2.0 * math.acos(-a / b) / _RAD_PER_H

    @property
    def dawn_h(self) -> float | None:
        """Solar time of sunrise; None where the Sun neither rises nor sets."""
        return None if self.never_sets is not None else 12.0 - 0.5 * self.daylight_h

    @property
    def dusk_h(self) -> float | None:
        """Solar time of sunset; None where the Sun neither rises nor sets."""
        return None if self.never_sets is not None else 12.0 + 0.5 * self.daylight_h

    @property
    def sunrise_bearing_deg(self) -> float | None:
        """Where the Sun rises, from East towards North; None where it does not."""
        if self.never_sets is not None:
            return None
        north = math.sin(self.declination_deg * RAD_PER_DEG) / math.cos(
            self.latitude_deg * RAD_PER_DEG
        )
        return math.asin(max(-1.0, min(1.0, north))) * _DEG_PER_RAD

    @property
    def high_sun_deg(self) -> float:
        """Elevation at solar noon, the highest of the day."""
        return 90.0 - abs(self.latitude_deg - self.declination_deg)

    @property
    def low_sun_deg(self) -> float:
        """Elevation at solar midnight, the lowest of the day."""
        return abs(self.latitude_deg + self.declination_deg) - 90.0

    @property
    def due_east_h(self) -> float | None:
        """Solar time at which the Sun stands due East, above the horizon or below it.

        None where it stays on one side of the East-West line: between equator and Sun.
        """
        latitude, declination = self._latitude_and_declination_rad
        # North = 0: tan(lat) cos(hour angle) = tan(dec), written so that the pole divides nothing.
        run = math.sin(latitude) * math.cos(declination)
        rise = math.cos(latitude) * math.sin(declination)
        if rise == 0.0:
            return 6.0
        if abs(rise) > abs(run):
            return None
        return 12.0 - math.acos(rise / run) / _RAD_PER_H

    @property
    def due_west_h(self) -> float | None:
        """Solar time at which the Sun stands due West; None as for East."""
        east_h = self.due_east_h
        return None if east_h is None else 24.0 - east_h


def days_after_march_equinox(utc_s: float) -> float:
    """Days since the last March equinox (the precise Sun crossing the equator northwards).

    Raises
    ------
    ConfigurationError
        The time, or the equinox before it, is outside 1960..2100.
    """

    year = int(np.datetime64(math.floor(utc_s), "s").astype("datetime64[Y]").astype(int)) + 1970
    equinox_s = _march_equinox_utc_s(year)
    if equinox_s > utc_s:
        equinox_s = _march_equinox_utc_s(year - 1)
    return (utc_s - equinox_s) / SECONDS_PER_DAY


def _march_equinox_utc_s(year: int) -> float:
    at_s = parse_utc(f"{year:04d}-03-20T12:00:00Z")
    for _ in range(3):
        # 0.39 deg a day around the equinox; the third step is good to a second.
        declination_deg = sun_position("precise", at_s, Site(0.0, 0.0)).declination_deg
        at_s -= declination_deg / 0.3952 * SECONDS_PER_DAY
    return at_s
