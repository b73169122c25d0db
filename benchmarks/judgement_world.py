"""A world of its own for the judgement benchmarks: Sun, mounts, trackers, points and true years.

Nothing of solarcal is used here but what a points file holds. The Sun comes from ERFA's Earth
ephemeris, precession-nutation and sidereal time, the air from Saemundsson, the mounts from
rotations of their native frames, and the true year from the vector of the boresight: no step is
linear in the errors.
"""

from dataclasses import dataclass
from functools import lru_cache

import erfa
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOUNTS = ("azel", "tiltroll-ew", "tiltroll-ns", "polar")
LOWEST_DEG = 10.0
NOISE_DEG = 0.03
LEAN_SD_DEG, ZERO_SD_DEG, SCALE_SD = 0.7, 1.0, 0.001
NEW_YEAR_S = 1767225600.0
"""1 January 2026, POSIX."""
DAY_S = 86400.0
_POSIX_EPOCH_JD = 2440587.5
_TAI_MINUS_UTC_S = 37.0
_NAMES = ("P1", "P2", "P3", "P4", "P5", "P6")


def sun_enu(latitude_deg: float, utc_s: Array) -> Array:
    """Unit vectors (n, 3) East, North, Up to the apparent, refracted Sun, longitude 0."""
    day = utc_s / DAY_S
    tt_s = utc_s + _TAI_MINUS_UTC_S + 32.184
    helio, bary = erfa.epv00(_POSIX_EPOCH_JD, tt_s / DAY_S)
    away = -helio["p"]
    distance_au = np.linalg.norm(away, axis=-1, keepdims=True)
    # Light time of the Sun itself is a few arcseconds of its own motion over a century: nothing.
    speed = bary["v"] / 173.1446326742403
    aberrated = away / distance_au + speed
    aberrated /= np.linalg.norm(aberrated, axis=-1, keepdims=True)
    of_date = np.einsum("nij,nj->ni", erfa.pnm06a(_POSIX_EPOCH_JD, tt_s / DAY_S), aberrated)
    sidereal = erfa.gst06a(_POSIX_EPOCH_JD, day, _POSIX_EPOCH_JD, tt_s / DAY_S)
    cos_h, sin_h = np.cos(sidereal), np.sin(sidereal)
    meridian = of_date[:, 0] * cos_h + of_date[:, 1] * sin_h
    east = -of_date[:, 0] * sin_h + of_date[:, 1] * cos_h
    sin_lat, cos_lat = np.sin(np.radians(latitude_deg)), np.cos(np.radians(latitude_deg))
    north = -meridian * sin_lat + of_date[:, 2] * cos_lat
    up = meridian * cos_lat + of_date[:, 2] * sin_lat
    # Parallax of the Sun, then the air.
    elevation = np.degrees(np.arcsin(up)) - 8.794 / 3600.0 * np.sqrt(1.0 - up**2)
    bent = np.maximum(elevation, -1.0)
    elevation += 1.02 / 60.0 / np.tan(np.radians(bent + 10.3 / (bent + 5.11)))
    azimuth = np.arctan2(east, north)
    cos_el = np.cos(np.radians(elevation))
    return np.stack(
        (cos_el * np.sin(azimuth), cos_el * np.cos(azimuth), np.sin(np.radians(elevation))), axis=-1
    )


def native_frame(mount: str, latitude_deg: float) -> Array:
    """Rows x, y, z in East, North, Up."""
    sin_lat, cos_lat = np.sin(np.radians(latitude_deg)), np.cos(np.radians(latitude_deg))
    east, north, up = np.eye(3)
    return {
        "azel": np.stack((-north, east, up)),
        "tiltroll-ew": np.stack((up, -north, east)),
        "tiltroll-ns": np.stack((up, east, north)),
        "polar": np.stack(
            (np.array((0.0, -sin_lat, cos_lat)), east, np.array((0.0, cos_lat, sin_lat)))
        ),
    }[mount]


def rotation(vector: Array) -> Array:
    """Rodrigues' rotation matrix of a rotation vector, radians."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


@dataclass(frozen=True)
class Tracker:
    """What a tracker really is: degrees, scales in deg/deg.

    ``values`` P1..P6 of the exact mechanism; ``collimation_deg``, ``squareness_deg`` C and N;
    ``backlash_deg`` the play of each axis; ``clock_s`` by how much the laptop clock is ahead.
    """

    values: Array
    collimation_deg: float = 0.0
    squareness_deg: float = 0.0
    backlash_deg: float = 0.0
    clock_s: float = 0.0


@dataclass(frozen=True)
class Kind:
    """What is random about the days of a cell."""

    name: str = "clean"
    degrees_of_freedom: float | None = None
    collimation_deg: float = 0.0
    clock_s: float = 0.0
    zero_sd_deg: float = ZERO_SD_DEG
    backlash_deg: float = 0.0

    def tracker(self, rng: np.random.Generator) -> Tracker:
        sd = np.array(
            (LEAN_SD_DEG, self.zero_sd_deg, LEAN_SD_DEG, self.zero_sd_deg) + (SCALE_SD,) * 2
        )
        values = sd * rng.standard_normal(6)
        sign = 1.0 if rng.random() < 0.5 else -1.0
        return Tracker(
            values, sign * self.collimation_deg, 0.0, self.backlash_deg, sign * self.clock_s
        )

    def noise_deg(self, rng: np.random.Generator) -> Array:
        if self.degrees_of_freedom is None:
            return NOISE_DEG * rng.standard_normal(2)
        return NOISE_DEG * rng.standard_t(self.degrees_of_freedom, 2)


CLEAN = Kind()
HARD = (
    Kind("t(2.5) noise", degrees_of_freedom=2.5),
    Kind("collimation 0.2", collimation_deg=0.2),
    Kind("clock 20 s off", clock_s=20.0),
    Kind("zeros 8 deg", zero_sd_deg=8.0),
    Kind("backlash 0.1", backlash_deg=0.1),
)


@dataclass(frozen=True)
class Place:
    """A mount at a latitude, on the meridian of Greenwich."""

    mount: str
    latitude_deg: float

    @property
    def centre_deg(self) -> float:
        return 180.0 if self.mount == "azel" and self.latitude_deg < 0.0 else 0.0

    def native(self, enu: Array) -> Array:
        return enu @ native_frame(self.mount, self.latitude_deg).T

    def angles(self, native: Array) -> tuple[Array, Array]:
        """AX1 on the branch, AX2, degrees."""
        ax1 = np.degrees(np.arctan2(native[:, 1], native[:, 0]))
        ax1 = self.centre_deg + wrapped(ax1 - self.centre_deg)
        return ax1, np.degrees(np.arctan2(np.hypot(native[:, 0], native[:, 1]), native[:, 2]))


def wrapped(angle: Array) -> Array:
    return (angle + 180.0) % 360.0 - 180.0


def exact_errors(place: Place, tracker: Tracker, native: Array) -> tuple[Array, Array]:
    """E1, E2 of the mechanism at unit vectors (n, 3): reading less AX, degrees."""
    ax1, ax2 = place.angles(native)
    own = native @ rotation(np.radians((-tracker.values[2], -tracker.values[0], 0.0)))
    c, n = np.radians(tracker.collimation_deg), np.radians(tracker.squareness_deg)
    own2 = np.arccos(np.clip((own[:, 2] + np.sin(c) * np.sin(n)) / (np.cos(c) * np.cos(n)), -1, 1))
    x = np.cos(c) * np.sin(own2)
    y = -np.sin(c) * np.cos(n) - np.cos(c) * np.cos(own2) * np.sin(n)
    own1 = np.arctan2(own[:, 1], own[:, 0]) - np.arctan2(y, x)
    P = tracker.values
    return (
        wrapped(np.degrees(own1) - ax1) + P[1] - P[4] * ax1,
        np.degrees(own2) - ax2 + P[3] - P[5] * ax2,
    )


def formula_columns(ax1: Array, ax2: Array) -> Array:
    """The controller's formula: (n, 2, 6)."""
    s, c = np.sin(np.radians(ax1)), np.cos(np.radians(ax1))
    t, one, none = np.tan(np.radians(ax2)), np.ones_like(ax1), np.zeros_like(ax1)
    return np.stack(
        (
            np.stack((-s / t, one, -c / t, none, -ax1, none), axis=-1),
            np.stack((c, none, -s, one, none, -ax2), axis=-1),
        ),
        axis=1,
    )


def sky_errors_deg(place: Place, tracker: Tracker, uploaded: Array, native: Array) -> Array:
    """Angles (n,) between collector and Sun when the controller drives by its formula."""
    ax1, ax2 = place.angles(native)
    correction = formula_columns(ax1, ax2) @ uploaded
    P = tracker.values
    a1 = np.radians(ax1 + correction[:, 0] - P[1] + P[4] * ax1)
    a2 = np.radians(ax2 + correction[:, 1] - P[3] + P[5] * ax2)
    c, n = np.radians(tracker.collimation_deg), np.radians(tracker.squareness_deg)
    x = np.cos(c) * np.sin(a2)
    y = -np.sin(c) * np.cos(n) - np.cos(c) * np.cos(a2) * np.sin(n)
    z = -np.sin(c) * np.sin(n) + np.cos(c) * np.cos(a2) * np.cos(n)
    sight = np.stack((np.cos(a1) * x - np.sin(a1) * y, np.sin(a1) * x + np.cos(a1) * y, z), axis=-1)
    own = native @ rotation(np.radians((-P[2], -P[0], 0.0)))
    across = np.linalg.norm(np.cross(sight, own), axis=-1)
    return np.degrees(np.arctan2(across, np.sum(sight * own, axis=-1)))


@lru_cache(maxsize=32)
def year_of(place: Place) -> Array:
    """Unit vectors of the year's grid: every 30 min of mean solar time, every seventh day."""
    days = NEW_YEAR_S + DAY_S * 7.0 * np.arange(53)
    times = (days[:, np.newaxis] + 1800.0 * np.arange(48)).ravel()
    enu = sun_enu(place.latitude_deg, times)
    return place.native(enu[enu[:, 2] > np.sin(np.radians(LOWEST_DEG))])


def true_p95_deg(place: Place, tracker: Tracker, uploaded: Array) -> float:
    return float(np.quantile(sky_errors_deg(place, tracker, uploaded, year_of(place)), 0.95))


def true_rms_deg(place: Place, tracker: Tracker, uploaded: Array) -> float:
    sky = sky_errors_deg(place, tracker, uploaded, year_of(place))
    return float(np.sqrt(np.mean(sky**2)))


@lru_cache(maxsize=4096)
def daylight_s(place: Place, day: int) -> tuple[float, float]:
    """First and last whole minute of a day with the Sun above 10 deg; both alike without any."""
    times = NEW_YEAR_S + DAY_S * day + 60.0 * np.arange(1440.0)
    coarse = sun_enu(place.latitude_deg, times[::10])[:, 2]
    high = np.flatnonzero(
        np.interp(times, times[::10], coarse) > np.sin(np.radians(LOWEST_DEG + 0.3))
    )
    if not len(high):
        return float(times[720]), float(times[720])
    return float(times[high[0]]), float(times[high[-1]])


@dataclass(frozen=True)
class MeasuredPoint:
    """A row of a points file: the laptop's time, ideal angles, errors, approach sides."""

    utc_s: float
    ax1_deg: float
    ax2_deg: float
    err1_deg: float
    err2_deg: float


def measure(
    place: Place, tracker: Tracker, kind: Kind, utc_s: float, rng: np.random.Generator
) -> MeasuredPoint:
    """A point at this true time; stamp and ideal angles are those of the laptop's clock."""
    both = place.native(sun_enu(place.latitude_deg, np.array((utc_s, utc_s + tracker.clock_s))))
    e1, e2 = exact_errors(place, tracker, both[:1])
    ax1, ax2 = place.angles(both)
    noise = kind.noise_deg(rng)
    side1, side2 = np.where(rng.random(2) < 0.5, -0.5, 0.5) * tracker.backlash_deg
    error1 = e1[0] + wrapped(ax1[:1] - ax1[1:])[0] + side1 + noise[0] / np.sin(np.radians(ax2[0]))
    error2 = e2[0] + ax2[0] - ax2[1] + side2 + noise[1]
    return MeasuredPoint(
        utc_s + tracker.clock_s, float(ax1[1]), float(ax2[1]), float(error1), float(error2)
    )


def bayes_bound(
    place: Place, points: list[MeasuredPoint], zero_sd_deg: float = ZERO_SD_DEG
) -> Array:
    """The coefficients nobody can better: the population and the noise are known, and the best
    six numbers of the formula over the year for the most likely mechanism."""
    sd = np.array((LEAN_SD_DEG, zero_sd_deg, LEAN_SD_DEG, zero_sd_deg, SCALE_SD, SCALE_SD))
    ax1, ax2 = (np.array([getattr(p, f"ax{i}_deg") for p in points]) for i in (1, 2))
    err1, err2 = (np.array([getattr(p, f"err{i}_deg") for p in points]) for i in (1, 2))
    native = np.stack(
        (
            np.sin(np.radians(ax2)) * np.cos(np.radians(ax1)),
            np.sin(np.radians(ax2)) * np.sin(np.radians(ax1)),
            np.cos(np.radians(ax2)),
        ),
        axis=-1,
    )
    sine = np.sin(np.radians(ax2))

    def left(values: Array) -> Array:
        e1, e2 = exact_errors(place, Tracker(values), native)
        return np.concatenate((wrapped(err1 - e1) * sine, err2 - e2)) / NOISE_DEG

    values = np.zeros(6)
    for _ in range(4):
        here = left(values)
        step = 1e-4 * sd
        slopes = np.stack(
            [(left(values + step * unit) - here) / 1e-4 for unit in np.eye(6)], axis=-1
        )
        normal = slopes.T @ slopes + np.eye(6)
        values = values - sd * np.linalg.solve(normal, slopes.T @ here + values / sd)
    return best_formula(place, Tracker(values), sd)


def best_formula(place: Place, tracker: Tracker, sd: Array) -> Array:
    """Six numbers with which the formula leaves least of this mechanism over the year."""
    year = year_of(place)
    ax1, ax2 = place.angles(year)
    weights = np.stack((np.sin(np.radians(ax2)), np.ones_like(ax2)), axis=-1)
    wanted = np.stack(exact_errors(place, tracker, year), axis=-1) * weights
    rows = (formula_columns(ax1, ax2) * weights[..., np.newaxis] * sd).reshape(-1, 6)
    left = wanted.ravel() - rows @ (tracker.values / sd)
    ridge = 1e-6 * len(year) * np.eye(6)
    found: Array = tracker.values + sd * np.linalg.solve(rows.T @ rows + ridge, rows.T @ left)
    return found
