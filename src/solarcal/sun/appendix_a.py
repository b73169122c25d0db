"""The Sun as the SolarTrak controller computes it (Appendix A of its manual).

Because the controller steers by this Sun, it is the reference for the controller's errors. Inside
this module everything is as printed: longitude positive WEST, azimuth from South with East
positive, hour angle positive in the morning. Its public functions take longitude EAST and
give azimuth from North through East.

Four corrections to the printed text, each checked numerically: the divisions of the Julian date
are integer divisions, left to right; the obliquity, the nutation and the sum of periodic terms are
arcseconds, divided by 3600*180/pi as a whole; ST and GST are revolutions; the printed quadrant
test for the azimuth fails in the south and at the equator, so `atan2` takes its place.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, cast

import numpy as np

from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

TWO_PI = 2.0 * math.pi
_AS = math.pi / 648000.0
_JD_OF_POSIX_EPOCH = 2440587.5
_JD_OF_J2000 = 2451545.0


@dataclass(frozen=True, slots=True)
class _Elementary:
    """The functions the equations need, for floats or for arrays.

    The equations are written once. Floats go through `math`, several times faster than numpy on
    a single number: an emulated controller asks for its Sun tens of thousands of times a day.
    """

    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    atan2: Callable[[Any, Any], Any]
    hypot: Callable[[Any, Any], Any]
    floor: Callable[[Any], Any]


_FLOATS = _Elementary(math.sin, math.cos, math.atan2, math.hypot, math.floor)
_ARRAYS = _Elementary(np.sin, np.cos, np.arctan2, np.hypot, np.floor)


@dataclass(frozen=True, slots=True)
class PrintedSun(Generic[Angles]):
    """What Appendix A gives, radians, in its own conventions (see the module)."""

    declination_rad: Angles
    hour_angle_rad: Angles
    """Local, on (-pi, pi], positive in the morning."""
    azimuth_south_east_rad: Angles
    zenith_rad: Angles


def julian_date(utc_s: Angles) -> Angles:
    """The printed Julian date of POSIX UTC seconds.

    The printed form, 367Y - floor(7(Y+floor((M+9)/12))/4) + floor(275M/9) + D + 1721013.5
    + GMT/24, counts the days of the Julian calendar and so is the plain count of days for every
    date from 1900-03-01 to 2100-02-28; here the days are counted directly, which works on arrays.
    The whole and half days are exact in binary, so the one rounding is that of adding GMT/24, and
    floats and arrays agree to the last bit.
    """
    days = _library(utc_s).floor(utc_s / SECONDS_PER_DAY)
    gmt_h = (utc_s - days * SECONDS_PER_DAY) / 3600.0
    return cast(Angles, (days + _JD_OF_POSIX_EPOCH) + gmt_h / 24.0)


def printed_sun(
    utc_s: Angles, latitude_deg: float, longitude_deg: float, *, plus: bool = False
) -> PrintedSun[Angles]:
    """Evaluate Appendix A at POSIX UTC seconds (float or array), longitude positive EAST.

    With ``plus`` annual aberration, the equation of the equinoxes and parallax are added, which
    brings its worst error from 0.0146 to 0.0046 deg.
    """
    f = _library(utc_s)
    sin, cos = f.sin, f.cos
    t: Any = julian_date(utc_s) - _JD_OF_J2000
    T = 1.0 + t / 36525.0

    def ph(a: float, b: float) -> Any:
        revolutions = a + b * t
        return TWO_PI * (revolutions - f.floor(revolutions))

    Om = ph(5.347343, -0.00014709391)
    LS = ph(11.779072, 0.00273790931)
    LM = ph(150.606434, 0.03660110129)
    GS = ph(10.993126, 0.00273777850)
    G2 = ph(18.140023, 0.00445036173)
    G4 = ph(6.053856, 0.00145561327)
    G5 = ph(1.056531, 0.00023080893)

    E = (84428.0 - 47.0 * T + 9.0 * cos(Om)) * _AS
    dl = -17.0 * sin(Om) * _AS
    sin_GS, sin_2GS = sin(GS), sin(2.0 * GS)
    resonance = 4.0 * GS - 8.0 * G4 + 3.0 * G5
    PL = (
        6910.0 * sin_GS
        + 72.0 * sin_2GS
        - 17.0 * T * sin_GS
        - 7.0 * cos(GS - G5)
        + 6.0 * sin(LM - LS)
        + 5.0 * sin(resonance)
        - 5.0 * cos(2.0 * (GS - G2))
        - 4.0 * sin(GS - G2)
        + 4.0 * cos(resonance)
        + 3.0 * sin(2.0 * (GS - G2))
        - 3.0 * sin(G5)
        - 3.0 * sin(2.0 * (GS - G5))
    ) * _AS
    L = LS + PL + dl
    # t = JD - 2451545.0 is exact, and its fraction of a day from midnight is GMT/24.
    gst_rev = 0.2769194 + (1.07523148e-6 * T + 100.002136) * T + (t - 0.5 - f.floor(t - 0.5))
    if plus:
        L = L - 20.5 * _AS * (1.0 + 0.0167 * cos(GS))
        gst_rev = gst_rev + dl * cos(E) / TWO_PI

    sin_L = sin(L)
    sin_dec = sin(E) * sin_L
    y_equator = cos(E) * sin_L
    x_equator = cos(L)
    cos_dec = f.hypot(x_equator, y_equator)
    HA = f.atan2(y_equator, x_equator) - longitude_deg * RAD_PER_DEG - TWO_PI * gst_rev
    HA = HA - TWO_PI * f.floor(HA / TWO_PI + 0.5)

    latitude = latitude_deg * RAD_PER_DEG
    sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
    x = sin_lat * cos_dec * cos(HA) - cos_lat * sin_dec
    y = cos_dec * sin(HA)
    zenith = f.atan2(f.hypot(x, y), sin_lat * sin_dec + cos_lat * cos_dec * cos(HA))
    if plus:
        zenith = zenith + 8.794 * _AS * sin(zenith)
    return PrintedSun(f.atan2(sin_dec, cos_dec), HA, f.atan2(y, x), zenith)


def horizontal_deg(
    utc_s: Angles, latitude_deg: float, longitude_deg: float, *, plus: bool = False
) -> tuple[Angles, Angles]:
    """Azimuth (north through east, [0, 360)) and airless zenith angle of the controller's Sun.

    POSIX UTC seconds, float or array; longitude positive EAST; degrees.
    """
    sun = printed_sun(utc_s, latitude_deg, longitude_deg, plus=plus)
    # South through East is 180 deg minus North through East.
    azimuth = (180.0 - sun.azimuth_south_east_rad / RAD_PER_DEG) % 360.0
    return azimuth, sun.zenith_rad / RAD_PER_DEG


def _library(utc_s: float | FloatArray) -> _Elementary:
    return _ARRAYS if isinstance(utc_s, np.ndarray) else _FLOATS
