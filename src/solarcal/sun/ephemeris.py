"""The fast path: very many precise positions at one site.

What the stars do to the Sun's place is slow: its hour angle less the mean Sun's, its declination
and its distance are computed by `precise` at nodes four days apart and interpolated by cubics. What
the Earth does is exact: the turn of the day, the parallax and the diurnal aberration of the site.
"""

import math
from dataclasses import dataclass
from typing import Generic

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.site import Site
from solarcal.sun import precise
from solarcal.sun.position import require_supported_times
from solarcal.timescale import SECONDS_PER_DAY, format_utc
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

# The fastest terms that matter (nutation of 13.7 d, Earth about the barycentre of 27 d) leave a
# few hundredths of an arcsecond between cubics of this length.
_STEP_DAYS = 4.0
_STEP_S = _STEP_DAYS * SECONDS_PER_DAY
_MEAN_SUN_RAD_PER_S = 2.0 * math.pi / SECONDS_PER_DAY
_EARTH_RAD_PER_S = 7.292115e-5
_AU_M = 149597870700.0
_LIGHT_M_PER_S = 299792458.0
_DEG_PER_RAD = 180.0 / math.pi
# A block's dozen temporaries stay in the processor's cache.
_BLOCK = 8192


@dataclass(frozen=True, slots=True)
class _Place(Generic[Angles]):
    """The observer's place: one, or one for each instant (n,).

    ``north_au``, ``up_au`` of the vector from the geocentre, ``east_aberration`` by the turn of
    the Earth, ``east_rad`` of the prepared site.
    """

    sin_lat: Angles
    cos_lat: Angles
    north_au: Angles
    up_au: Angles
    east_aberration: Angles
    east_rad: Angles

    @classmethod
    def at(cls, latitude_deg: Angles, elevation_m: Angles, east_rad: Angles) -> "_Place[Angles]":
        latitude = latitude_deg * RAD_PER_DEG
        sin_lat, cos_lat = np.sin(latitude), np.cos(latitude)
        # Nothing of the vector from the geocentre points east: an ellipsoid of revolution.
        x, _, z = np.moveaxis(precise.places_m(latitude_deg, elevation_m), -1, 0)
        north_m, up_m = cos_lat * z - sin_lat * x, sin_lat * z + cos_lat * x
        axis_m = cos_lat * up_m - sin_lat * north_m
        aberration = _EARTH_RAD_PER_S * axis_m / _LIGHT_M_PER_S
        return cls(sin_lat, cos_lat, north_m / _AU_M, up_m / _AU_M, aberration, east_rad)

    def rows(self, part: slice) -> "_Place[Angles]":
        """Those of a block; one place serves all."""
        if not isinstance(self.east_rad, np.ndarray):
            return self
        return _Place(*(getattr(self, name)[part] for name in self.__slots__))


class SiteEphemeris:
    """Airless topocentric Sun of one site between two instants, for any number of positions.

    Within 0.1 arcsec of ``sun_position("precise", ...)`` with the same DUT1.

    Parameters
    ----------
    start_utc_s, end_utc_s : POSIX UTC seconds between which positions will be asked for, both
        included.
    dut1_s : UT1 - UTC in seconds.

    Raises
    ------
    ConfigurationError
        The interval is empty or outside 1960..2100.
    """

    def __init__(
        self, site: Site, start_utc_s: float, end_utc_s: float, dut1_s: float = 0.0
    ) -> None:
        require_supported_times(np.array([start_utc_s, end_utc_s]))
        if end_utc_s < start_utc_s:
            raise ConfigurationError(
                f"the interval of the Sun ends at {format_utc(end_utc_s, 0)}, "
                f"before it begins at {format_utc(start_utc_s, 0)}"
            )
        self.site = site
        self.start_utc_s = float(start_utc_s)
        self.end_utc_s = float(end_utc_s)
        self._count = max(1, math.ceil((self.end_utc_s - self.start_utc_s) / _STEP_S))

        # Two nodes more on either side give the slopes of the first and the last cubic.
        node_s = _STEP_S * np.arange(-2.0, self._count + 3.0)
        nodes = precise.Instants.of_utc(self.start_utc_s + node_s, dut1_s)
        sun = precise.Frame.of(nodes, self._motion_at(node_s)).sun(None)
        ahead = sun.hour_angle_rad(site.longitude_deg) - _MEAN_SUN_RAD_PER_S * node_s
        self._hour_angle = _cubics(np.unwrap(ahead))
        self._sin_declination = _cubics(sun.direction[:, 2])
        # 1/r changes by 0.0003 a day, and so the parallax by 0.003 arcsec.
        self._inverse_distance = 0.5 * (1.0 / sun.distance_au[2:-3] + 1.0 / sun.distance_au[3:-2])

        # Plain numbers for the path of a single position.
        here = _Place.at(site.latitude_deg, site.elevation_m, 0.0)
        self._here = _Place(*(float(getattr(here, name)) for name in _Place.__slots__))
        self._cubics = [
            (*hour_angle, *sin_declination, inverse_distance)
            for hour_angle, sin_declination, inverse_distance in zip(
                self._hour_angle.T.tolist(),
                self._sin_declination.T.tolist(),
                self._inverse_distance.tolist(),
                strict=True,
            )
        ]

    def horizontal_deg(self, utc_s: Angles) -> tuple[Angles, Angles]:
        """Azimuth (north through east, [0, 360)) and zenith angle, degrees.

        POSIX UTC seconds, a float or an array of any shape.

        Raises
        ------
        ConfigurationError
            A time outside the interval.
        """
        if not isinstance(utc_s, np.ndarray):
            return self._one(float(utc_s))
        times = np.ascontiguousarray(utc_s, dtype=np.float64).reshape(-1)
        azimuth, zenith = self._seen_from(self._here, times)
        return azimuth.reshape(utc_s.shape), zenith.reshape(utc_s.shape)

    def horizontal_elsewhere_deg(
        self,
        utc_s: FloatArray,
        latitude_deg: FloatArray,
        longitude_deg: FloatArray,
        elevation_m: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """The same for one instant (n,) at each of n other places, all arrays (n,).

        What is prepared is the Sun seen from the centre of the Earth; only the last step, the turn
        to the horizon, depends on the place. Raises as ``horizontal_deg``.
        """
        east_rad = (longitude_deg - self.site.longitude_deg) * RAD_PER_DEG
        places = _Place.at(latitude_deg, elevation_m, east_rad)
        return self._seen_from(places, np.ascontiguousarray(utc_s, dtype=np.float64))

    def _seen_from(
        self, place: _Place[float] | _Place[FloatArray], times: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        if times.size:
            self._require_inside(float(times.min()), float(times.max()))
        azimuth, zenith = np.empty_like(times), np.empty_like(times)
        for low in range(0, times.size, _BLOCK):
            part = slice(low, low + _BLOCK)
            self._block(place.rows(part), times[part], azimuth[part], zenith[part])
        return azimuth, zenith

    def _motion_at(self, node_s: FloatArray) -> precise.EarthMotion:
        """Earth and Sun at the nodes, computed at every other one."""
        pairs = node_s.size // 2
        coarse_s = node_s[0] + 2.0 * _STEP_S * np.arange(-1.0, pairs + 2.0)
        coarse = precise.EarthMotion.at(precise.Instants.of_utc(self.start_utc_s + coarse_s))
        position, velocity = coarse.earth_to_sun, coarse.earth_velocity
        relative = coarse.sun_velocity - velocity
        return precise.EarthMotion(
            earth_to_sun=_with_halfway(position, relative * _STEP_DAYS)[: node_s.size],
            earth_velocity=_with_halfway(velocity)[: node_s.size],
            sun_velocity=_with_halfway(coarse.sun_velocity)[: node_s.size],
        )

    def _require_inside(self, first_s: float, last_s: float) -> None:
        # Written so that a NaN is outside.
        if not (first_s >= self.start_utc_s and last_s <= self.end_utc_s):
            raise ConfigurationError(
                f"the Sun was prepared from {format_utc(self.start_utc_s, 0)} to "
                f"{format_utc(self.end_utc_s, 0)}; a position outside was asked for"
            )

    def _block(
        self,
        place: _Place[float] | _Place[FloatArray],
        utc_s: FloatArray,
        azimuth_deg: FloatArray,
        zenith_deg: FloatArray,
    ) -> None:
        since_s = utc_s - self.start_utc_s
        x = since_s * (1.0 / _STEP_S)
        # The end of the interval may be the last node, where no cubic begins.
        index = np.minimum(x.astype(np.intp), self._count - 1)
        x -= index
        if index[0] == index[-1] and index.min() == index.max():
            # A block that lies within one cubic, as most do, needs no table look-up.
            index = index[:1]

        hour_angle = _evaluate(self._hour_angle[:, index], x)
        since_s *= _MEAN_SUN_RAD_PER_S
        hour_angle += since_s
        hour_angle += place.east_rad
        sin_dec = _evaluate(self._sin_declination[:, index], x)
        inverse_au = self._inverse_distance[index]

        cos_dec = np.sqrt(1.0 - sin_dec * sin_dec)
        meridian = np.cos(hour_angle) * cos_dec
        west = np.sin(hour_angle) * cos_dec
        west -= place.east_aberration
        south = place.sin_lat * meridian
        south -= place.cos_lat * sin_dec
        south += place.north_au * inverse_au
        up = place.cos_lat * meridian
        up += place.sin_lat * sin_dec
        up -= place.up_au * inverse_au

        np.arctan2(west, south, out=azimuth_deg)
        azimuth_deg *= _DEG_PER_RAD
        azimuth_deg += 180.0
        azimuth_deg[azimuth_deg >= 360.0] = 0.0
        np.arctan2(np.sqrt(west * west + south * south), up, out=zenith_deg)
        zenith_deg *= _DEG_PER_RAD

    def _one(self, utc_s: float) -> tuple[float, float]:
        self._require_inside(utc_s, utc_s)
        since_s = utc_s - self.start_utc_s
        index = min(int(since_s / _STEP_S), self._count - 1)
        x = since_s / _STEP_S - index
        a0, a1, a2, a3, d0, d1, d2, d3, inverse_au = self._cubics[index]
        hour_angle = a0 + x * (a1 + x * (a2 + x * a3)) + _MEAN_SUN_RAD_PER_S * since_s
        sin_dec = d0 + x * (d1 + x * (d2 + x * d3))
        cos_dec = math.sqrt(1.0 - sin_dec * sin_dec)
        here = self._here
        meridian = math.cos(hour_angle) * cos_dec
        west = math.sin(hour_angle) * cos_dec - here.east_aberration
        south = here.sin_lat * meridian - here.cos_lat * sin_dec + here.north_au * inverse_au
        up = here.cos_lat * meridian + here.sin_lat * sin_dec - here.up_au * inverse_au
        azimuth = math.atan2(west, south) * _DEG_PER_RAD + 180.0
        zenith = math.atan2(math.hypot(west, south), up) * _DEG_PER_RAD
        return (azimuth if azimuth < 360.0 else 0.0), zenith


def _with_halfway(nodes: FloatArray, rates: FloatArray | None = None) -> FloatArray:
    """Rows (n, 3) at equidistant nodes, the first and last left out, and rows halfway between.

    Hermite interpolation of the seventh degree in four nodes with their ``rates`` per half step,
    or Lagrange's cubic without: a few hundredths of an arcsecond over eight days.
    """
    outer, inner = nodes[:-3] + nodes[3:], nodes[1:-2] + nodes[2:-1]
    if rates is None:
        halfway = (9.0 * inner - outer) / 16.0
    else:
        inner_bend, outer_bend = rates[1:-2] - rates[2:-1], rates[:-3] - rates[3:]
        halfway = (243.0 * inner + 13.0 * outer + 162.0 * inner_bend + 6.0 * outer_bend) / 512.0
    rows = np.empty((2 * len(halfway) + 1, nodes.shape[1]))
    rows[0::2], rows[1::2] = nodes[1:-1], halfway
    return rows


def _cubics(at_nodes: FloatArray) -> FloatArray:
    """Hermite cubics (4, n) over the n inner steps of n + 5 equidistant nodes.

    The slopes are five-point differences, which makes the cubics as good as with exact ones.
    """
    value = at_nodes[2:-2]
    slope = (8.0 * (at_nodes[3:-1] - at_nodes[1:-3]) - (at_nodes[4:] - at_nodes[:-4])) / 12.0
    rise = value[1:] - value[:-1]
    return np.stack(
        [
            value[:-1],
            slope[:-1],
            3.0 * rise - 2.0 * slope[:-1] - slope[1:],
            slope[:-1] + slope[1:] - 2.0 * rise,
        ]
    )


def _evaluate(cubic: FloatArray, x: FloatArray) -> FloatArray:
    """Horner on coefficients (4, n) or (4, 1) at (n,) places within their steps."""
    result: FloatArray = cubic[3] * x
    result += cubic[2]
    result *= x
    result += cubic[1]
    result *= x
    result += cubic[0]
    return result
