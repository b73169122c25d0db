"""The Moon from a site: place, distance, phase, and whether a tracker can use it.

Place by ERFA's `moon98` (Meeus' series, some arcseconds), precession and nutation as for the Sun,
seen from the observer on the ellipsoid: the Moon's parallax is up to a degree. Aberration and the
Earth's motion during the light's second cancel for a companion of the Earth.

References
----------
J. Meeus, Astronomical Algorithms, 2nd ed., chapters 47 and 48.
"""

import math
from dataclasses import dataclass

import erfa
import numpy as np
from numpy.typing import NDArray

from solarcal.site import Site
from solarcal.sun.day import crossing_nearest_transit
from solarcal.sun.position import require_supported_times
from solarcal.sun.precise import Frame, Instants, TrueSun, horizontal_deg, observer_m
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, FloatArray

HIGH_ENOUGH_DEG = 10.0
BRIGHT_ENOUGH = 0.4
"""Illuminated fraction from which on the disc gives a diode or a camera enough to follow."""
HORIZON_REFRACTION_DEG = 34.0 / 60.0
"""How far the air lifts what rises; the Moon rises with its upper edge."""
LUNAR_DAY_S = 89428.0
"""From one transit to the next, in the mean."""
_SAMPLE_S = 600.0
_NODE_S = 300.0
"""A degree and a quarter of turn: a spline between such nodes is good to 0.001 arcsec."""
_KM_PER_AU = erfa.DAU / 1e3
_MOON_RADIUS_KM = 1737.4


@dataclass(frozen=True, slots=True)
class MoonPosition:
    """The Moon at instants of any shape; angles in degrees, airless.

    ``phase_deg``: angle Sun - Moon - observer, 0 full, 180 new. ``waxing``: the Moon stands East
    of the Sun. ``semidiameter_deg``: of its disc as seen from the site.
    """

    azimuth_deg: FloatArray
    zenith_deg: FloatArray
    distance_km: FloatArray
    phase_deg: FloatArray
    illuminated: FloatArray
    waxing: NDArray[np.bool_]
    semidiameter_deg: FloatArray

    @property
    def elevation_deg(self) -> FloatArray:
        return np.asarray(90.0 - self.zenith_deg)

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Whether it is high and bright enough to be followed."""
        return np.asarray(
            (self.elevation_deg >= HIGH_ENOUGH_DEG) & (self.illuminated >= BRIGHT_ENOUGH)
        )


def moon_position(utc_s: FloatArray | float, site: Site, dut1_s: float = 0.0) -> MoonPosition:
    """The Moon from a site at POSIX UTC seconds."""
    instants = Instants.of_utc(np.asarray(utc_s, dtype=np.float64), dut1_s)
    moon = _moon(instants, site)
    sun = Frame.of(instants).sun(site)
    azimuth, zenith = horizontal_deg(moon, site)
    to_moon = moon.direction * moon.distance_au[..., np.newaxis]
    moon_to_sun = sun.direction * sun.distance_au[..., np.newaxis] - to_moon
    cosine = np.sum(-moon.direction * moon_to_sun, axis=-1) / np.linalg.norm(moon_to_sun, axis=-1)
    phase = np.arccos(np.clip(cosine, -1.0, 1.0)) / RAD_PER_DEG
    east_of_sun = np.cross(sun.direction, moon.direction)[..., 2] > 0.0
    distance_km = moon.distance_au * _KM_PER_AU
    return MoonPosition(
        azimuth_deg=azimuth,
        zenith_deg=zenith,
        distance_km=distance_km,
        phase_deg=phase,
        illuminated=0.5 * (1.0 + np.cos(phase * RAD_PER_DEG)),
        waxing=east_of_sun,
        semidiameter_deg=np.arcsin(_MOON_RADIUS_KM / distance_km) / RAD_PER_DEG,
    )


@dataclass(frozen=True, slots=True)
class MoonDay:
    """One passage of the Moon, half a lunar day about its transit; POSIX UTC seconds.

    ``rise_utc_s``, ``set_utc_s``: None where it does not cross the horizon. ``usable_utc_s``: from
    when to when it is high and bright enough, None where it is not.
    """

    rise_utc_s: float | None
    transit_utc_s: float
    set_utc_s: float | None
    at_transit: MoonPosition
    usable_utc_s: tuple[float, float] | None


def moon_day(
    utc_s: float, site: Site, *, altitude_deg: float | None = None, dut1_s: float = 0.0
) -> MoonDay:
    """The passage of the Moon whose transit is nearest to an instant.

    ``altitude_deg``: the airless altitude of its centre, seen from the site, that counts as rising;
    by default where its upper edge touches a refracted horizon.

    Raises
    ------
    ConfigurationError
        The time is outside 1960..2100.
    """
    require_supported_times(np.array([utc_s - LUNAR_DAY_S, utc_s + LUNAR_DAY_S]))
    transit_s = utc_s
    # Each step leaves a hundredth of the one before: the Moon's own rate is not quite the mean.
    for _ in range(5):
        moon = _moon(Instants.of_utc(np.asarray(transit_s), dut1_s), site)
        hour_angle = float(moon.hour_angle_rad(site.longitude_deg))
        transit_s -= hour_angle / (2.0 * math.pi) * LUNAR_DAY_S
    half_s = 0.5 * LUNAR_DAY_S
    times = np.linspace(transit_s - half_s, transit_s + half_s, 2 * int(half_s / _SAMPLE_S) + 1)
    at_transit = moon_position(transit_s, site, dut1_s)
    if altitude_deg is None:
        altitude_deg = -HORIZON_REFRACTION_DEG - float(at_transit.semidiameter_deg)
    path = moon_position(times, site, dut1_s)

    def crossing(lowest_deg: float, *, rising: bool) -> float | None:
        def height_deg(at_s: float) -> float:
            return float(moon_position(at_s, site, dut1_s).elevation_deg) - lowest_deg

        above = path.elevation_deg > lowest_deg
        return crossing_nearest_transit(times, above, height_deg, rising=rising)

    usable = None
    if bool(at_transit.usable):
        first, last = (crossing(HIGH_ENOUGH_DEG, rising=rising) for rising in (True, False))
        usable = (
            float(times[0]) if first is None else first,
            float(times[-1]) if last is None else last,
        )
    return MoonDay(
        rise_utc_s=crossing(altitude_deg, rising=True),
        transit_utc_s=transit_s,
        set_utc_s=crossing(altitude_deg, rising=False),
        at_transit=at_transit,
        usable_utc_s=usable,
    )


class MoonLight:
    """Where the middle of the Moon's light stands over one site between two instants, airless.

    A diode centres the light, not the disc: that of a lit part lies 4 r (1 - cos i)/(3 pi) from the
    disc's middle towards the Sun, r the semidiameter and i the phase angle (half a disc and half an
    ellipse, evenly bright).
    """

    def __init__(
        self, site: Site, start_utc_s: float, end_utc_s: float, dut1_s: float = 0.0
    ) -> None:
        # Not needed for the Sun; its import takes 0.2 s.
        from scipy.interpolate import CubicSpline  # noqa: PLC0415

        count = max(4, math.ceil((end_utc_s - start_utc_s) / _NODE_S) + 1)
        times = np.linspace(start_utc_s, end_utc_s, count)
        moon = moon_position(times, site, dut1_s)
        instants = Instants.of_utc(times, dut1_s)
        sun = Frame.of(instants).sun(site)
        towards = _enu(moon.azimuth_deg, moon.zenith_deg)
        away = _enu(*horizontal_deg(sun, site)) - towards
        across = away - np.sum(away * towards, axis=-1)[:, np.newaxis] * towards
        across /= np.maximum(np.linalg.norm(across, axis=-1), 1e-12)[:, np.newaxis]
        shift = np.tan(moon.semidiameter_deg * RAD_PER_DEG) * 4.0 / (3.0 * math.pi)
        shift *= 1.0 - np.cos(moon.phase_deg * RAD_PER_DEG)
        self._start_utc_s = start_utc_s
        self._towards = CubicSpline(times - start_utc_s, towards + shift[:, np.newaxis] * across)
        self.bright_enough = bool(np.mean(moon.illuminated) >= BRIGHT_ENOUGH)

    def horizontal_deg(self, utc_s: float) -> tuple[float, float]:
        """Azimuth (north through east) and zenith angle, degrees."""
        east, north, up = self._towards(utc_s - self._start_utc_s).tolist()
        azimuth = math.degrees(math.atan2(east, north)) % 360.0
        return azimuth, math.degrees(math.atan2(math.hypot(east, north), up))


def _enu(azimuth_deg: FloatArray, zenith_deg: FloatArray) -> FloatArray:
    azimuth, zenith = azimuth_deg * RAD_PER_DEG, zenith_deg * RAD_PER_DEG
    sine = np.sin(zenith)
    return np.stack((sine * np.sin(azimuth), sine * np.cos(azimuth), np.cos(zenith)), axis=-1)


def _moon(instants: Instants, site: Site) -> TrueSun:
    frame = Frame.of(instants)
    towards = geocentric_au(instants, frame) - observer_m(site, frame.sidereal_rad) / erfa.DAU
    distance = np.linalg.norm(towards, axis=-1)
    return TrueSun(towards / distance[..., np.newaxis], distance, frame.sidereal_rad)


def geocentric_au(instants: Instants, frame: Frame) -> FloatArray:
    """Apparent place from the Earth's centre, true equator and equinox of date, (..., 3)."""
    whole, part = instants.tt
    geometric = erfa.moon98(whole, part)["p"]
    light_days = np.linalg.norm(geometric, axis=-1) * _KM_PER_AU * 1e3 / erfa.CMPS / SECONDS_PER_DAY
    return np.asarray(erfa.rxp(frame.to_true_equator, erfa.moon98(whole, part - light_days)["p"]))
