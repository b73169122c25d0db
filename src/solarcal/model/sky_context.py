"""What the unit's ideal angles leave out although it is known: the air, and a better Sun.

A controller without refraction aims below the Sun; a controller with its own small ephemeris aims
a little beside it. Neither is an error of the mount, so neither belongs into a fit of the mount:
the fit uses the Sun's true position.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple, get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from solarcal.errors import ConfigurationError, FitError
from solarcal.model.points import Points
from solarcal.mount.geometry import (
    Limits,
    MountGeometry,
    axes_of_horizontal_deg,
    horizontal_of_axes_deg,
)
from solarcal.optics.offset_mirror import Heliostat
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun.appendix_a import horizontal_deg
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S, SUN_YEARS
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

Ideal = Literal["apparent", "airless", "solartrak"]
"""What ideal angles are: nothing missing, refraction missing, refraction and ephemeris missing."""

LOWEST_ELEVATION_DEG = 5.0
"""Points lower than this are never fitted: the air there is not known well enough."""

BLOCK_S = 366.0 * SECONDS_PER_DAY
"""The Sun is prepared in blocks of a year, of one session and of a fleet, so that answers agree."""
_DEFAULT_YEAR = "2026-01-01"
_FIRST_YEAR, _LAST_YEAR = "1961-01-01", "2099-01-01"
"""The first and the last that the Sun models cover from end to end."""


class SkyContext(msgspec.Struct, frozen=True):
    """Where a tracker stands and what its controller knows of the Sun.

    Hashable, so that what is computed from it once (a year of Sun) is kept.

    Parameters
    ----------
    site : its latitude is that of the mount.
    geometry : the mount.
    limits : software limits; None: the whole sky.
    ideal : what the controller's ideal angles are.
    weather : station pressure and temperature; None: the standard atmosphere at the site's
        elevation.
    refraction : ``hughes`` or ``saemundsson``.
    year : first day of the year looked at, ``YYYY-01-01``.
    heliostat : target and mirror where the axes turn a mirror's normal: all angles are then the
        normal's.

    Raises
    ------
    ConfigurationError
        An unknown kind of ideal angles.
    """

    site: Site
    geometry: MountGeometry
    limits: Limits | None = None
    ideal: Ideal = "apparent"
    weather: Weather | None = None
    refraction: str = "hughes"
    year: str = _DEFAULT_YEAR
    heliostat: Heliostat | None = None

    def __post_init__(self) -> None:
        if self.ideal not in get_args(Ideal):
            raise ConfigurationError(
                f"unknown kind of ideal angles {self.ideal!r}; choose {', '.join(get_args(Ideal))}"
            )

    @classmethod
    def for_points(
        cls,
        points: Points,
        site: Site | None = None,
        limits: Limits | None = None,
        ideal: Ideal = "apparent",
        weather: Weather | None = None,
        heliostat: Heliostat | None = None,
    ) -> "SkyContext":
        """The context of these points, in the year of the first dated one.

        Of points dated before or after the years of the Sun models it is the nearest such year.

        Without a site the mount's latitude on the meridian of Greenwich serves for the year:
        longitude only says what the clock shows.
        """
        if site is None:
            if ideal == "solartrak":
                raise ConfigurationError(
                    "ideal angles of kind 'solartrak' need the site: give latitude and longitude"
                )
            site = Site(points.geometry.latitude_deg, 0.0)
        year = _DEFAULT_YEAR
        if points.utc_s is not None and np.isfinite(points.utc_s).any():
            first_s = float(np.nanmin(points.utc_s))
            year = str(np.datetime64(int(first_s), "s").astype("datetime64[Y]")) + "-01-01"
            year = min(max(year, _FIRST_YEAR), _LAST_YEAR)
        return cls(site, points.geometry, limits, ideal, weather, year=year, heliostat=heliostat)

    def true_axes_deg(
        self, azimuth_deg: FloatArray, zenith_deg: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Where the axes belong for a Sun: on it, or on the normal that reflects it."""
        if self.heliostat is not None:
            azimuth_deg, zenith_deg = self.heliostat.true_normal_deg(azimuth_deg, zenith_deg)
        return self.geometry.axes_from_horizontal(azimuth_deg, zenith_deg)

    def believed_axes_deg(
        self, azimuth_deg: FloatArray, zenith_deg: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The same as the controller computes it: the mirror's offset to first order."""
        if self.heliostat is not None:
            azimuth_deg, zenith_deg = self.heliostat.controller_normal_deg(azimuth_deg, zenith_deg)
        return self.geometry.axes_from_horizontal(azimuth_deg, zenith_deg)

    def sun_of_axes_deg(
        self, ax1_deg: FloatArray, ax2_deg: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """(azimuth, zenith angle) of the Sun these axes belong to."""
        azimuth, zenith = self.geometry.horizontal_from_axes(ax1_deg, ax2_deg)
        return (
            (azimuth, zenith) if self.heliostat is None else self.heliostat.sun_deg(azimuth, zenith)
        )

    def lifted(
        self, ax1_deg: FloatArray, ax2_deg: FloatArray
    ) -> Callable[[float], tuple[FloatArray, FloatArray]]:
        """Of so much more of the assumed air: the axes that belong to the Sun of these (n,)."""
        azimuth, zenith = self.sun_of_axes_deg(ax1_deg, ax2_deg)
        air = zenith - apparent_zenith_deg(zenith, self.refraction, self.air)

        def axes_deg(amount: float) -> tuple[FloatArray, FloatArray]:
            return self.true_axes_deg(azimuth, zenith - amount * air)

        return axes_deg

    @property
    def air(self) -> Weather:
        return self.weather or Weather(standard_pressure_hpa(self.site.elevation_m))

    @property
    def first_midnight_utc_s(self) -> float:
        """Mean solar midnight that begins the year at this site, POSIX UTC seconds."""
        new_year_s = float(np.datetime64(self.year, "s").astype(int))
        return new_year_s - self.site.longitude_deg / 360.0 * SECONDS_PER_DAY


class SunDirections(NamedTuple):
    """The Sun as the controller computes it and as observed; all arrays of one shape, degrees."""

    ideal1_deg: FloatArray
    ideal2_deg: FloatArray
    true1_deg: FloatArray
    """Apparent: refracted, precise; AX1 on the branch."""
    true2_deg: FloatArray
    elevation_deg: FloatArray
    """Apparent."""


def sun_directions(context: SkyContext, utc_s: FloatArray) -> SunDirections:
    """The controller's ideal angles and the true apparent ones at POSIX UTC seconds (n,)."""
    first_s = float(utc_s.min()) if utc_s.size else context.first_midnight_utc_s
    last_s = float(utc_s.max()) if utc_s.size else first_s
    ephemeris = _ephemeris(context.site, first_s // BLOCK_S, last_s // BLOCK_S)
    azimuth, zenith = ephemeris.horizontal_deg(utc_s)
    apparent = apparent_zenith_deg(zenith, context.refraction, context.air)
    true1, true2 = context.true_axes_deg(azimuth, apparent)
    if context.ideal == "apparent":
        ideal1, ideal2 = true1, true2
    elif context.ideal == "airless":
        ideal1, ideal2 = context.believed_axes_deg(azimuth, zenith)
    else:
        site = context.site
        believed = horizontal_deg(utc_s, site.latitude_deg, site.longitude_deg)
        ideal1, ideal2 = context.believed_axes_deg(*believed)
    return SunDirections(ideal1, ideal2, true1, true2, 90.0 - apparent)


@lru_cache(maxsize=8)
def _ephemeris(site: Site, first_block: float, last_block: float) -> SiteEphemeris:
    # A time beyond the models' years is refused by the ephemeris itself, with its own words.
    start_s = max(first_block * BLOCK_S, FIRST_UTC_S)
    end_s = min((last_block + 1.0) * BLOCK_S, LAST_UTC_S - 1.0)
    return SiteEphemeris(site, start_s, end_s)


class TruePoints(NamedTuple):
    """Points seen from where the Sun really stood; arrays (n,), degrees."""

    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    """Reading minus TRUE angle: the error of the mount alone."""
    err2_deg: FloatArray
    elevation_deg: FloatArray


def true_points(points: Points, context: SkyContext) -> TruePoints:
    """The points' true apparent directions, and their errors counted from there.

    Raises
    ------
    FitError
        ``solartrak`` ideals of a point without a time, or of one the Sun models do not cover.
    """
    ideal1, ideal2 = points.ax1_deg, points.ax2_deg
    true1, true2 = ideal1, ideal2
    azimuth, zenith = context.sun_of_axes_deg(ideal1, ideal2)
    if context.ideal == "airless":
        zenith = apparent_zenith_deg(zenith, context.refraction, context.air)
        true1, true2 = context.true_axes_deg(azimuth, zenith)
    elif context.ideal == "solartrak":
        if points.utc_s is None or not np.isfinite(points.utc_s).all():
            times = np.full(len(points), np.nan) if points.utc_s is None else points.utc_s
            label = points.labels[int(np.argmin(np.isfinite(times)))]
            raise FitError(
                f"point {label} has no time, so the true position of the Sun is unknown; give utc "
                "or ideal=airless"
            )
        known = (points.utc_s >= FIRST_UTC_S) & (points.utc_s < LAST_UTC_S)
        if not known.all():
            raise FitError(
                f"point {points.labels[int(np.argmin(known))]} is dated outside {SUN_YEARS}, the "
                "years of the controller's Sun, so the true position of the Sun is unknown; "
                "correct utc or give ideal=airless"
            )
        sun = sun_directions(context, points.utc_s)
        true1, true2, zenith = sun.true1_deg, sun.true2_deg, 90.0 - sun.elevation_deg
    return _seen_from(points, true1, true2, zenith)


_STANDARD = Weather(pressure_hpa=1013.25, temperature_c=10.0)


@dataclass(frozen=True, eq=False, slots=True)
class FleetPoints:
    """m points of any number of sessions, with what their sessions say of each.

    ``basis`` (m, 3, 3) of the mounts; ``kind`` (m,) ``apparent``, ``airless`` or ``solartrak``;
    ``block`` (m,) the block of ``BLOCK_S`` in which the session begins; ``utc_s`` finite where the
    kind is ``solartrak``; the others (m,).
    """

    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    utc_s: FloatArray
    block: FloatArray
    kind: NDArray[np.str_]
    basis: FloatArray
    centre_deg: FloatArray
    latitude_deg: FloatArray
    longitude_deg: FloatArray
    elevation_m: FloatArray
    pressure_hpa: FloatArray
    temperature_c: FloatArray


def fleet_true_points(points: FleetPoints) -> TruePoints:
    """``sky_context.true_points`` of every point under its own sky, (m,)."""
    x, y, z = (tuple(row) for row in np.moveaxis(points.basis, 0, -1))
    azimuth, zenith = horizontal_of_axes_deg((x, y, z), points.ax1_deg, points.ax2_deg)
    own_sun = points.kind == "solartrak"
    for block in np.unique(points.block[own_sun]):
        chosen = np.flatnonzero(own_sun & (points.block == block))
        azimuth[chosen], zenith[chosen] = _sun_deg(points, chosen, float(block))
    moved = points.kind != "apparent"
    lift = zenith - apparent_zenith_deg(zenith, "hughes", _STANDARD)
    density = points.pressure_hpa / 1013.25 * (283.0 / (273.0 + points.temperature_c))
    zenith = zenith - np.where(moved, lift * density, 0.0)
    true1, true2 = axes_of_horizontal_deg((x, y, z), points.centre_deg, azimuth, zenith)
    true1 = np.where(moved, true1, points.ax1_deg)
    true2 = np.where(moved, true2, points.ax2_deg)
    return _seen_from(points, true1, true2, zenith)


def _seen_from(
    points: Points | FleetPoints, true1: FloatArray, true2: FloatArray, zenith: FloatArray
) -> TruePoints:
    # Both angles may straddle the end of the branch; the difference is a small one.
    err1 = points.err1_deg + ((points.ax1_deg - true1 + 180.0) % 360.0 - 180.0)
    err2 = points.err2_deg + (points.ax2_deg - true2)
    return TruePoints(true1, true2, err1, err2, 90.0 - zenith)


def _sun_deg(
    points: FleetPoints, chosen: NDArray[np.intp], block: float
) -> tuple[FloatArray, FloatArray]:
    times = points.utc_s[chosen]
    sun = _ephemeris(Site(0.0, 0.0), block, float(times.max()) // BLOCK_S)
    return sun.horizontal_elsewhere_deg(
        times, points.latitude_deg[chosen], points.longitude_deg[chosen], points.elevation_m[chosen]
    )
