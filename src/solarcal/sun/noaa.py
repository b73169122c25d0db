"""NOAA's short series (Spencer 1971, Iqbal): for planning and sunrise, never for calibration.

Up to 0.63 deg from the truth. Two corrections to its common print: there is no minus in
cos(180 - azimuth), and the afternoon needs a branch of its own; both are met by `atan2`.
"""

import numpy as np

from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, FloatArray


def fractional_year_rad(utc_s: FloatArray) -> FloatArray:
    """The series' argument: 2 pi / 365 (day of year - 1 + (hour - 12)/24), any shape."""
    day = np.floor(utc_s / SECONDS_PER_DAY).astype("int64").astype("datetime64[D]")
    day_of_year_less_one = (day - day.astype("datetime64[Y]")).astype(np.float64)
    hour = np.mod(utc_s, SECONDS_PER_DAY) / 3600.0
    return np.asarray(2.0 * np.pi / 365.0 * (day_of_year_less_one + (hour - 12.0) / 24.0))


def equation_of_time_min(fractional_year: FloatArray) -> FloatArray:
    """Apparent minus mean solar time, minutes, of the fractional year in radians."""
    g = fractional_year
    return 229.18 * (
        0.000075
        + 0.001868 * np.cos(g)
        - 0.032077 * np.sin(g)
        - 0.014615 * np.cos(2 * g)
        - 0.040849 * np.sin(2 * g)
    )


def declination_rad(fractional_year: FloatArray) -> FloatArray:
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


def noaa_sun(
    utc_s: FloatArray, latitude_deg: float, longitude_deg: float
) -> tuple[FloatArray, ...]:
    """The Sun at POSIX UTC seconds (any shape), longitude positive EAST.

    Azimuth (north through east), zenith angle, declination; equation of time, minutes; apparent
    solar time, hours.
    """
    g = fractional_year_rad(utc_s)
    equation = equation_of_time_min(g)
    declination = declination_rad(g)
    true_solar_min = np.mod(
        np.mod(utc_s, SECONDS_PER_DAY) / 60.0 + equation + 4.0 * longitude_deg, 1440.0
    )
    hour_angle = (true_solar_min / 4.0 - 180.0) * RAD_PER_DEG
    latitude = latitude_deg * RAD_PER_DEG
    sin_lat, cos_lat = np.sin(latitude), np.cos(latitude)
    sin_dec, cos_dec = np.sin(declination), np.cos(declination)
    east = -cos_dec * np.sin(hour_angle)
    north = cos_lat * sin_dec - sin_lat * cos_dec * np.cos(hour_angle)
    up = sin_lat * sin_dec + cos_lat * cos_dec * np.cos(hour_angle)
    return (
        np.mod(180.0 - np.arctan2(east, -north) / RAD_PER_DEG, 360.0),
        np.arctan2(np.hypot(east, north), up) / RAD_PER_DEG,
        declination / RAD_PER_DEG,
        equation,
        true_solar_min / 60.0,
    )
