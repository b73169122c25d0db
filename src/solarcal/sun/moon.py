"""The Moon from a site: place, distance, phase, and whether a tracker can use it.

Place by ERFA's `moon98` (Meeus' series, some arcseconds), precession and nutation as for the Sun,
seen from the observer on the ellipsoid: the Moon's parallax is up to a degree. Aberration and the
Earth's motion during the light's second cancel for a companion of the Earth.

References
----------
J. Meeus, Astronomical Algorithms, 2nd ed., chapters 47 and 48.
"""

from dataclasses import dataclass

import erfa
import numpy as np
from numpy.typing import NDArray

from solarcal.site import Site
from solarcal.sun.precise import (
    EarthMotion,
    Frame,
    Instants,
    TrueSun,
    horizontal_deg,
    observer_m,
)
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, FloatArray

HIGH_ENOUGH_DEG = 10.0
BRIGHT_ENOUGH = 0.4
"""Illuminated fraction from which on the disc gives a diode or a camera enough to follow."""
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


def geocentric_moon(utc_s: FloatArray, dut1_s: float = 0.0) -> TrueSun:
    """Apparent place from the Earth's centre, true equator and equinox of date."""
    return _moon(Instants.of_utc(np.asarray(utc_s, dtype=np.float64), dut1_s), None)


def moon_position(utc_s: FloatArray | float, site: Site, dut1_s: float = 0.0) -> MoonPosition:
    """The Moon from a site at POSIX UTC seconds."""
    instants = Instants.of_utc(np.asarray(utc_s, dtype=np.float64), dut1_s)
    moon = _moon(instants, site)
    sun = Frame.of(instants, EarthMotion.at(instants)).sun(site)
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


def _moon(instants: Instants, site: Site | None) -> TrueSun:
    whole, part = instants.tt
    frame = Frame.of(instants, EarthMotion.at(instants))
    geometric = erfa.moon98(whole, part)["p"]
    light_days = np.linalg.norm(geometric, axis=-1) * _KM_PER_AU * 1e3 / erfa.CMPS / SECONDS_PER_DAY
    towards = erfa.rxp(frame.to_true_equator, erfa.moon98(whole, part - light_days)["p"])
    if site is not None:
        towards = towards - observer_m(site, frame.sidereal_rad) / erfa.DAU
    distance = np.linalg.norm(towards, axis=-1)
    return TrueSun(towards / distance[..., np.newaxis], distance, frame.sidereal_rad)
