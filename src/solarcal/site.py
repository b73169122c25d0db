"""Where the tracker stands, how its tower leans, and which day it has."""

import math
from datetime import date

import msgspec

from solarcal.decimals import decimal, require_between, shortened, shortest, whole
from solarcal.errors import ConfigurationError
from solarcal.timescale import SECONDS_PER_SUN_DEG, parse_utc

HALF_DAY_S = 43200.0


class Site(msgspec.Struct, frozen=True):
    """A place on Earth. Longitude is positive EAST, elevation in metres above the ellipsoid."""

    latitude_deg: float
    longitude_deg: float
    elevation_m: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        require_between("latitude", self.latitude_deg, -90.0, 90.0)
        require_between("longitude (positive east)", self.longitude_deg, -180.0, 360.0)
        require_between("elevation in metres", self.elevation_m, -500.0, 9000.0)


def longitude_apart_deg(one_deg: float, other_deg: float) -> float:
    """How far east of the other the one is, -180 to 180: 253.5 is -106.5, and -180 is 180."""
    return math.remainder(one_deg - other_deg, 360.0)


def day_utc_s(text: str, site: Site) -> float:
    """An instant of the day meant, POSIX UTC seconds: a date alone is the site's own day, at its
    noon; else the instant itself.

    Raises
    ------
    ConfigurationError
        The text is neither.
    """
    instant_s = parse_utc(text)
    try:
        date.fromisoformat(text.strip())
    except ValueError:
        return instant_s
    return instant_s + HALF_DAY_S - SECONDS_PER_SUN_DEG * math.remainder(site.longitude_deg, 360.0)


class Weather(msgspec.Struct, frozen=True):
    """Air at the station, for refraction: STATION pressure (not reduced to sea level)."""

    pressure_hpa: float = 1013.25
    temperature_c: float = 15.0

    def __post_init__(self) -> None:
        # No air at all is an emulated world without refraction.
        if self.pressure_hpa != 0.0 and not 300.0 <= self.pressure_hpa <= 1100.0:
            raise ConfigurationError(
                f"pressure {self.pressure_hpa:g} hPa is not between 300 and 1100; "
                "give the station pressure, not the one reduced to sea level"
            )
        require_between("temperature", self.temperature_c, -60.0, 70.0, " C")


def standard_pressure_hpa(elevation_m: float) -> float:
    """Mean station pressure at an elevation (ICAO standard atmosphere, troposphere)."""
    return float(1013.25 * (1.0 - 2.25577e-5 * elevation_m) ** 5.25588)


class Inclinometer(msgspec.Struct, frozen=True, kw_only=True):
    """A reading of the tower's lean, degrees: its top to the north and to the east, one sigma."""

    lean_north_deg: float
    lean_east_deg: float
    sigma_deg: float

    def words(self) -> str:
        return (
            f"inclinometer: lean to the north {self.lean_north_deg:+z.3f} deg, "
            f"to the east {self.lean_east_deg:+z.3f} deg, sigma {self.sigma_deg:.3f} deg"
        )


class BoltCircle(msgspec.Struct, frozen=True):
    """The equally spaced bolts of a base plate, for shims.

    Raises
    ------
    ConfigurationError
        A diameter, a number of bolts or a bearing that no base plate has.
    """

    diameter_mm: float
    bolts: int
    first_bolt_bearing_deg: float = 0.0
    """Compass bearing of one of them, from North through East."""

    def __post_init__(self) -> None:
        require_between("diameter of the bolt circle, mm:", self.diameter_mm, 1.0, 20000.0)
        require_between("number of bolts:", self.bolts, 3, 72)
        bearing_deg = self.first_bolt_bearing_deg
        require_between("bearing of the first bolt, deg:", bearing_deg, -360.0, 360.0)

    def words(self) -> str:
        """As ``parse_bolt_circle`` reads it."""
        first = f",{shortest(self.first_bolt_bearing_deg)}" if self.first_bolt_bearing_deg else ""
        return f"{shortest(self.diameter_mm)},{self.bolts}{first}"


def parse_bolt_circle(text: str) -> BoltCircle:
    """DIAMETER_MM,BOLTS[,AZIMUTH_OF_FIRST]; spaces do for the commas.

    Raises
    ------
    ConfigurationError
        It is not that.
    """
    parts = text.replace(",", " ").split()
    if len(parts) not in (2, 3):
        raise ConfigurationError(
            f"{shortened(text)} is not DIAMETER_MM,BOLTS[,AZIMUTH_OF_FIRST], e.g. 400,4,45"
        )
    return BoltCircle(decimal(parts[0]), whole(parts[1]), *map(decimal, parts[2:]))
