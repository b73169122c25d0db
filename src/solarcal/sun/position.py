"""Where is the Sun, by any of the models, as one kind of answer."""

from dataclasses import dataclass, replace
from typing import Any, Generic, cast

import numpy as np
from numpy.typing import NDArray

from solarcal.errors import ConfigurationError
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun import precise
from solarcal.sun.appendix_a import printed_sun
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY, format_utc, parse_utc
from solarcal.units import RAD_PER_DEG, Angles, FloatArray, rms, wrap_deg

SUN_MODELS = ("solartrak", "solartrak+", "noaa", "precise")

# UTC begins in 1960; the controller's Julian date loses a day on 2100-03-01.
FIRST_UTC_S = -315619200.0
LAST_UTC_S = 4107542400.0
SUN_YEARS = "1960-01-01 to 2100-02-28"
_AROUND_S, _AHEAD_S = 2.0 * SECONDS_PER_DAY, 400.0 * SECONDS_PER_DAY


@dataclass(frozen=True, slots=True)
class SunPosition(Generic[Angles]):
    """The Sun at one site: floats, or arrays of the shape of the times."""

    utc_s: Angles
    azimuth_deg: Angles
    """From North through East, [0, 360)."""
    zenith_deg: Angles
    """Airless, or as seen through the air where refraction was asked for."""
    declination_deg: Angles
    """Geocentric, of the true equator of date."""
    equation_of_time_min: Angles
    """Apparent minus mean solar time."""
    solar_time_h: Angles
    """Apparent solar time (hour angle of the Sun plus twelve hours), [0, 24)."""

    @property
    def elevation_deg(self) -> Angles:
        """Height above the horizon, degrees."""
        return 90.0 - self.zenith_deg


def sun_position(
    model: str,
    utc_s: Angles,
    site: Site,
    *,
    dut1_s: float = 0.0,
    refraction: str = "none",
    weather: Weather | None = None,
) -> SunPosition[Angles]:
    """The Sun over a site at POSIX UTC seconds (a float or an array of any shape).

    Parameters
    ----------
    model : ``solartrak``, the controller's own Sun (0.015 deg); ``solartrak+``, the same with
        aberration, equinoxes and parallax (0.005 deg); ``noaa``, a short series (0.63 deg);
        ``precise``, the truth (0.05 arcsec).
    dut1_s : UT1 - UTC in seconds; used by ``precise`` alone, 15 arcsec of rotation each.
    refraction : ``none``, ``hughes`` or ``saemundsson``, applied to the zenith angle.
    weather : of the station; by default 15 C and the mean pressure of the elevation.

    Raises
    ------
    ConfigurationError
        Unknown model or refraction, DUT1 beyond a second, a time outside 1960..2100.
    """
    times = np.asarray(utc_s, dtype=np.float64)
    require_supported_times(times)
    if not abs(dut1_s) <= 1.0:
        raise ConfigurationError(f"DUT1 {dut1_s:g} s is not between -1 and 1 second")
    if model not in SUN_MODELS:
        raise ConfigurationError(
            f"unknown Sun model {model!r}; choose one of {', '.join(SUN_MODELS)}"
        )
    if model == "precise":
        position = _precise(times, site, dut1_s)
    elif model == "noaa":
        position = _noaa(times, site)
    else:
        position = _appendix_a(times, site, plus=model == "solartrak+")
    if refraction != "none":
        air = weather or Weather(pressure_hpa=standard_pressure_hpa(site.elevation_m))
        seen = apparent_zenith_deg(position.zenith_deg, refraction, air)
        position = replace(position, zenith_deg=np.asarray(seen))
    shown: Any = position
    if not times.ndim:
        shown = SunPosition(*(float(getattr(position, name)) for name in SunPosition.__slots__))
    return cast("SunPosition[Angles]", shown)


def sun_known(utc_s: FloatArray, *, year_ahead: bool = False) -> NDArray[np.bool_]:
    """Which instants have a Sun, the solar day around them too, or all the year after; NaN no."""
    last_s = LAST_UTC_S - (_AHEAD_S if year_ahead else _AROUND_S)
    with np.errstate(invalid="ignore"):
        known: NDArray[np.bool_] = (utc_s >= FIRST_UTC_S + _AROUND_S) & (utc_s < last_s)
    return known


def require_supported_times(utc_s: FloatArray) -> None:
    """Refuse times outside the years in which the models are known to hold.

    Raises
    ------
    ConfigurationError
        A time is not finite, before 1960-01-01 or after 2100-02-28.
    """
    inside = (utc_s >= FIRST_UTC_S) & (utc_s < LAST_UTC_S)
    if not inside.all():
        bad = float(utc_s[~inside].flat[0])
        try:
            shown = format_utc(bad, 0)
        except (ValueError, OverflowError, OSError):
            shown = f"{bad:g} s"
        raise ConfigurationError(f"no Sun for {shown}: the models hold from {SUN_YEARS}")


def _appendix_a(times: FloatArray, site: Site, *, plus: bool) -> SunPosition[FloatArray]:
    sun = printed_sun(times, site.latitude_deg, site.longitude_deg, plus=plus)
    solar_time = 12.0 - sun.hour_angle_rad / RAD_PER_DEG / 15.0
    return SunPosition(
        utc_s=times,
        azimuth_deg=np.mod(180.0 - sun.azimuth_south_east_rad / RAD_PER_DEG, 360.0),
        zenith_deg=sun.zenith_rad / RAD_PER_DEG,
        declination_deg=sun.declination_rad / RAD_PER_DEG,
        equation_of_time_min=_equation_of_time_min(solar_time, times, site),
        solar_time_h=np.mod(solar_time, 24.0),
    )


def _precise(times: FloatArray, site: Site, dut1_s: float) -> SunPosition[FloatArray]:
    frame = precise.Frame.of(precise.Instants.of_utc(times, dut1_s))
    geocentric = frame.sun(None)
    azimuth, zenith = precise.horizontal_deg(frame.sun(site), site)
    solar_time = 12.0 + geocentric.hour_angle_rad(site.longitude_deg) / RAD_PER_DEG / 15.0
    return SunPosition(
        utc_s=times,
        azimuth_deg=azimuth,
        zenith_deg=zenith,
        declination_deg=geocentric.declination_rad() / RAD_PER_DEG,
        equation_of_time_min=_equation_of_time_min(solar_time, times + dut1_s, site),
        solar_time_h=np.mod(solar_time, 24.0),
    )


def _equation_of_time_min(solar_time_h: FloatArray, ut1_s: FloatArray, site: Site) -> FloatArray:
    """Apparent minus mean solar time; the mean one is UT1 turned by the longitude."""
    mean_solar_time_h = np.mod(ut1_s, SECONDS_PER_DAY) / 3600.0 + site.longitude_deg / 15.0
    return wrap_deg(15.0 * (solar_time_h - mean_solar_time_h)) * 4.0


# -- NOAA's short series (Spencer 1971, Iqbal): for planning and sunrise, never for calibration.
# Up to 0.63 deg from the truth. Two corrections to its common print: there is no minus in
# cos(180 - azimuth), and the afternoon needs a branch of its own; both are met by `atan2`.


def fractional_year_rad(utc_s: FloatArray) -> FloatArray:
    """The series' argument: 2 pi / 365 (day of year - 1 + (hour - 12)/24), any shape."""
    day = np.floor(utc_s / SECONDS_PER_DAY).astype("int64").astype("datetime64[D]")
    day_of_year_less_one = (day - day.astype("datetime64[Y]")).astype(np.float64)
    hour = np.mod(utc_s, SECONDS_PER_DAY) / 3600.0
    return np.asarray(2.0 * np.pi / 365.0 * (day_of_year_less_one + (hour - 12.0) / 24.0))


def noaa_equation_of_time_min(fractional_year: FloatArray) -> FloatArray:
    """Apparent minus mean solar time, minutes, of the fractional year in radians."""
    g = fractional_year
    return 229.18 * (
        0.000075
        + 0.001868 * np.cos(g)
        - 0.032077 * np.sin(g)
        - 0.014615 * np.cos(2 * g)
        - 0.040849 * np.sin(2 * g)
    )


def noaa_declination_rad(fractional_year: FloatArray) -> FloatArray:
    """Declination, radians, of the fractional year in radians."""
    g = fractional_year
    return (
        0.006918
        - 0.399912 * np.cos(g)
        + 0.070257 * np.sin(g)
        - 0.006758 * np.cos(2 * g)
        + 0.000907 * np.sin(2 * g)
        - 0.002697 * np.cos(3 * g)
        + 0.00148 * np.sin(3 * g)
    )


def _noaa(utc_s: FloatArray, site: Site) -> SunPosition[FloatArray]:
    g = fractional_year_rad(utc_s)
    equation = noaa_equation_of_time_min(g)
    declination = noaa_declination_rad(g)
    true_solar_min = np.mod(
        np.mod(utc_s, SECONDS_PER_DAY) / 60.0 + equation + 4.0 * site.longitude_deg, 1440.0
    )
    hour_angle = (true_solar_min / 4.0 - 180.0) * RAD_PER_DEG
    latitude = site.latitude_deg * RAD_PER_DEG
    sin_lat, cos_lat = np.sin(latitude), np.cos(latitude)
    sin_dec, cos_dec = np.sin(declination), np.cos(declination)
    east = -cos_dec * np.sin(hour_angle)
    north = cos_lat * sin_dec - sin_lat * cos_dec * np.cos(hour_angle)
    up = sin_lat * sin_dec + cos_lat * cos_dec * np.cos(hour_angle)
    return SunPosition(
        utc_s=utc_s,
        azimuth_deg=np.mod(180.0 - np.arctan2(east, -north) / RAD_PER_DEG, 360.0),
        zenith_deg=np.arctan2(np.hypot(east, north), up) / RAD_PER_DEG,
        declination_deg=declination / RAD_PER_DEG,
        equation_of_time_min=equation,
        solar_time_h=true_solar_min / 60.0,
    )


# -- two models compared ------------------------------------------------------------------------

EVERY_S = 3600.0 * 5.0
"""Not a part of a day, so that all hours come in turn."""
_MOST_YEARS = 100


@dataclass(frozen=True, eq=False, slots=True)
class ModelDifference:
    """First model minus second, where the second has the Sun above ``lowest_deg``; (n,) each.

    ``cross_deg``: azimuth times the cosine of altitude: on the sky.
    """

    utc_s: FloatArray
    altitude_deg: FloatArray
    azimuth_deg: FloatArray
    cross_deg: FloatArray

    def summary(self) -> dict[str, float]:
        """Worst and rms, degrees, and the number of positions."""
        columns = {
            "altitude": self.altitude_deg, "azimuth": self.azimuth_deg, "cross": self.cross_deg
        }  # fmt: skip
        found = {"positions": float(len(self.utc_s))}
        for name, values in columns.items():
            found[f"{name}_worst_deg"] = float(np.abs(values).max())
            found[f"{name}_rms_deg"] = rms(values)
        return found

    def by_year(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Years, and the worst altitude and azimuth of each on the sky, degrees."""
        years = self.utc_s.astype("datetime64[s]").astype("datetime64[Y]").astype(int) + 1970
        every = np.unique(years)
        return (
            every.astype(np.float64),
            np.array([np.abs(self.altitude_deg[years == year]).max() for year in every]),
            np.array([np.abs(self.cross_deg[years == year]).max() for year in every]),
        )


def compare_models(
    first: str, second: str, site: Site, from_year: int, to_year: int
) -> ModelDifference:
    """Both models from the start of one year to the end of another, every five hours.

    Raises
    ------
    ConfigurationError
        Years the wrong way round, more than a hundred of them, or a Sun that is never so high.
    """
    if not 0 <= to_year - from_year < _MOST_YEARS:
        raise ConfigurationError(
            f"the years {from_year} to {to_year} must be in order and at most {_MOST_YEARS}"
        )
    utc_s = np.arange(parse_utc(f"{from_year}-01-01"), parse_utc(f"{to_year + 1}-01-01"), EVERY_S)
    a, b = (sun_position(model, utc_s, site) for model in (first, second))
    up = b.elevation_deg > 0.0
    if not up.any():
        raise ConfigurationError("the Sun is never higher than 0 deg there")
    azimuth = np.asarray(wrap_deg(a.azimuth_deg - b.azimuth_deg))[up]
    return ModelDifference(
        utc_s=utc_s[up],
        altitude_deg=np.asarray(a.elevation_deg - b.elevation_deg)[up],
        azimuth_deg=azimuth,
        cross_deg=azimuth * np.cos(np.radians(b.elevation_deg[up])),
    )
