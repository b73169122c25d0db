"""How much of the Sun a collector catches: at a moment, over a day, over a year.

Percent of what an equal surface would catch in space that faces the Sun all the time, 24 h a day:
no air, no clouds, no shade (Rusin's SUNCALC). A collector of 36.7 % over a day gets 0.367 x 24 h of
full Sun. Normals and axes are (North, East, Up) vectors of any length.

Through clear air the direct beam is Ineichen and Perez's, with the Linke turbidity as the one
number that says how clear the air is (2 very clean and cold, 3 clean and warm, 5 hazy), and the
relative air mass of Kasten and Young. SUNCALC itself counts 1.40 kW/m2 outside the air.

References
----------
P. Ineichen and R. Perez, Solar Energy 73 (2002) 151. F. Kasten and A. T. Young, Applied Optics 28
(1989) 4735. Both as in pvlib-python (`clearsky.ineichen`, `atmosphere.get_relative_airmass`).
"""

import math
from dataclasses import dataclass

import numpy as np

from solarcal.decimals import require_between
from solarcal.errors import ConfigurationError
from solarcal.sun.circular_orbit import YEAR_DAYS, CircularDay
from solarcal.units import RAD_PER_DEG, SUN_RADIUS_DEG, FloatArray

Vector = tuple[float, float, float]

SUNCALC_STEPS = 100
_STEPS = 720
_YEAR_STEPS = 365
_BEARINGS = 16


def _unit(vector: Vector, what: str) -> FloatArray:
    array = np.asarray(vector, dtype=np.float64)
    length = float(np.linalg.norm(array))
    if not math.isfinite(length):
        raise ConfigurationError(f"{what} must be three finite numbers: North, East, Up")
    if length == 0.0:
        raise ConfigurationError(f"{what} is zero: it has no direction; give North, East, Up")
    return array / length


@dataclass(frozen=True, slots=True)
class FixedCollector:
    """A flat collector that does not move, facing ``normal_neu``.

    Raises
    ------
    ConfigurationError
        The normal is zero or not finite.
    """

    normal_neu: Vector = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        _unit(self.normal_neu, "the collector's normal")

    def share(self, sun_neu: FloatArray) -> FloatArray:
        """Cosine of incidence, 0 on the back; (...,) of unit vectors (..., 3)."""
        facing: FloatArray = sun_neu @ _unit(self.normal_neu, "the collector's normal")
        return np.maximum(facing, 0.0)


@dataclass(frozen=True, slots=True)
class OneAxisCollector:
    """A collector turned about one axis so as to face the Sun as well as that allows.

    The surface holds the axis: (1, 0, 0) is the horizontal North-South trough.

    Raises
    ------
    ConfigurationError
        The axis is zero or not finite.
    """

    axis_neu: Vector

    def __post_init__(self) -> None:
        _unit(self.axis_neu, "the collector's axis")

    def share(self, sun_neu: FloatArray) -> FloatArray:
        """Cosine of incidence; (...,) of unit vectors (..., 3)."""
        along: FloatArray = sun_neu @ _unit(self.axis_neu, "the collector's axis")
        return np.sqrt(np.maximum(1.0 - along * along, 0.0))


@dataclass(frozen=True, slots=True)
class TrackingCollector:
    """A collector on two axes that faces the Sun exactly."""

    def share(self, sun_neu: FloatArray) -> FloatArray:
        """One for every direction; (...,) of (..., 3)."""
        return np.ones(sun_neu.shape[:-1])


Collector = FixedCollector | OneAxisCollector | TrackingCollector


def _caught(collector: Collector, sun_neu: FloatArray) -> FloatArray:
    """Share of the flux, 0 while the Sun is below the horizon."""
    return np.where(sun_neu[..., 2] > 0.0, collector.share(sun_neu), 0.0)


def moment_percent(collector: Collector, day: CircularDay, solar_time_h: float) -> float:
    """Percent of the flux at one moment, solar time in hours [0, 24].

    Raises
    ------
    ConfigurationError
        The hour is not one of a day.
    """
    require_between("solar time", solar_time_h, 0.0, 24.0, " h")
    return 100.0 * float(_caught(collector, day.direction_neu(solar_time_h)))


def suncalc_day_percent(collector: Collector, day: CircularDay) -> float:
    """Percent over a day by SUNCALC's own sum, to all its digits.

    100 equal steps of the Earth's turning. They are counted from the direction of the March
    equinox, so they meet noon anew every day and the sum wavers around ``day_percent``: by some
    0.01 for a level collector, by up to one percent for one that faces the rising Sun.
    """
    turned_deg = np.arange(SUNCALC_STEPS) * (360.0 / SUNCALC_STEPS)
    hours = 12.0 + (turned_deg - day.right_ascension_deg) / 15.0
    return 100.0 * float(np.mean(_caught(collector, day.direction_neu(hours))))


def day_percent(collector: Collector, day: CircularDay) -> float:
    """Percent over a day of 24 h, integrated from sunrise to sunset."""
    daylight_h = day.daylight_h
    middle = (np.arange(_STEPS) + 0.5) / _STEPS - 0.5
    sun = day.direction_neu(12.0 + daylight_h * middle)
    return 100.0 * float(np.mean(collector.share(sun))) * daylight_h / 24.0


def year_percent(collector: Collector, latitude_deg: float) -> float:
    """Percent over a whole circular year, at the given latitude."""
    days = np.arange(_YEAR_STEPS) * (YEAR_DAYS / _YEAR_STEPS)
    return float(
        np.mean([day_percent(collector, CircularDay(latitude_deg, float(day))) for day in days])
    )


@dataclass(frozen=True, slots=True)
class PointingLoss:
    """What a pointing error costs over a day, in percent of a day's full Sun."""

    error_deg: float
    percent: float
    """With perfect pointing."""
    worst_percent: float
    """With the error, in the direction in which it costs most."""
    worst_bearing_deg: float | None
    """Fixed collector: azimuth towards which its normal is then tipped; None where it tracks."""

    @property
    def lost_percent(self) -> float:
        """Share of the energy that is lost, percent of what perfect pointing gives."""
        return 0.0 if self.percent == 0.0 else 100.0 * (1.0 - self.worst_percent / self.percent)


def pointing_loss(collector: Collector, day: CircularDay, error_deg: float) -> PointingLoss:
    """Energy a FLAT collector loses in a day by a constant pointing error.

    A tracking collector loses 1 - cos(error) whatever the direction; a fixed one is tipped towards
    16 bearings and the worst counts (tipping a badly placed one may also gain). What a
    concentrator loses is a matter of its acceptance: ``disc_percent``.

    Raises
    ------
    ConfigurationError
        The error is not between 0 and 90 deg.
    """
    _require_error(error_deg)
    full = day_percent(collector, day)
    if not isinstance(collector, FixedCollector):
        return PointingLoss(error_deg, full, full * math.cos(error_deg * RAD_PER_DEG), None)
    normal = _unit(collector.normal_neu, "the collector's normal")
    # Two directions square to the normal; for a level collector they are North and East.
    first = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    first -= (first @ normal) * normal
    first /= np.linalg.norm(first)
    second = np.cross(normal, first) if normal[2] < 0.0 else np.cross(first, normal)
    error_rad = error_deg * RAD_PER_DEG
    worst, bearing_deg = math.inf, 0.0
    for turn in np.arange(_BEARINGS) * (2.0 * math.pi / _BEARINGS):
        sideways = math.cos(turn) * first + math.sin(turn) * second
        tipped = math.cos(error_rad) * normal + math.sin(error_rad) * sideways
        got = day_percent(FixedCollector((tipped[0], tipped[1], tipped[2])), day)
        if got < worst - 1e-9:
            worst = got
            bearing_deg = math.degrees(math.atan2(sideways[1], sideways[0])) % 360.0
    return PointingLoss(error_deg, full, worst, bearing_deg)


def disc_percent(acceptance_deg: float, error_deg: float) -> float:
    """How much of the Sun's disc a concentrator still sees, percent.

    Its acceptance is a cone of half angle ``acceptance_deg`` around where it points, the Sun an
    even disc of 0.2666 deg radius, ``error_deg`` away from the middle.

    Raises
    ------
    ConfigurationError
        The acceptance is not greater than zero, or the error not between 0 and 90 deg.
    """
    _require_error(error_deg)
    if not 0.0 < acceptance_deg <= 90.0:
        raise ConfigurationError(
            f"acceptance half angle {acceptance_deg:g} deg is not between 0 and 90"
        )
    return 100.0 * disc_share(error_deg, SUN_RADIUS_DEG, acceptance_deg)


def disc_share(apart: float, radius: float, field_radius: float) -> float:
    """Part of an even disc that a round field lets through, their centres so far apart."""
    if apart >= radius + field_radius:
        return 0.0
    if apart <= abs(field_radius - radius):
        return min(1.0, (field_radius / radius) ** 2)
    # Lens of two circles: two sectors less the kite between their centres.
    r, big, d = radius, field_radius, apart
    at_disc = math.acos((d * d + r * r - big * big) / (2.0 * d * r))
    at_field = math.acos((d * d + big * big - r * r) / (2.0 * d * big))
    lens = r * r * at_disc + big * big * at_field - d * r * math.sin(at_disc)
    return lens / (math.pi * r * r)


def _require_error(error_deg: float) -> None:
    if not 0.0 <= error_deg < 90.0:
        raise ConfigurationError(f"pointing error {error_deg:g} deg is not between 0 and 90")


SUNCALC_W_M2 = 1400.0
"""SUNCALC's flux outside the air."""
SOLAR_CONSTANT_W_M2 = 1361.0
CLEAN_TURBIDITY = 3.0


def air_mass(zenith_deg: FloatArray) -> FloatArray:
    """Relative air mass at an apparent zenith angle, infinite below the horizon; (...)."""
    z = np.minimum(zenith_deg, 90.0)
    mass = 1.0 / (np.cos(z * RAD_PER_DEG) + 0.50572 * (96.07995 - z) ** -1.6364)
    return np.where(np.asarray(zenith_deg) > 90.0, np.inf, mass)


def direct_w_m2(
    zenith_deg: FloatArray, turbidity: float = CLEAN_TURBIDITY, elevation_m: float = 0.0
) -> FloatArray:
    """Direct beam on a surface that faces the Sun, W/m2; 0 below the horizon; (...)."""
    up = np.asarray(zenith_deg) < 90.0
    z = np.where(up, zenith_deg, 89.0)
    # Air mass at the site's own pressure, of a standard atmosphere.
    pressure = (1.0 - 2.25577e-5 * elevation_m) ** 5.25588
    mass = air_mass(z) * pressure
    cos_z = np.maximum(np.cos(z * RAD_PER_DEG), 1e-6)
    fh1, fh2 = np.exp(-elevation_m / 8000.0), np.exp(-elevation_m / 1250.0)
    cg1, cg2 = 5.09e-5 * elevation_m + 0.868, 3.92e-5 * elevation_m + 0.0387
    level = cg1 * cos_z * np.exp(-cg2 * mass * (fh1 + fh2 * (turbidity - 1.0)))
    beam = (0.664 + 0.163 / fh1) * np.exp(-0.09 * mass * (turbidity - 1.0))
    # Never more than the level flux less the least diffuse light leaves.
    least = 1.0 - (0.1 - 0.2 * np.exp(-turbidity)) / (0.1 + 0.882 / fh1)
    share = np.minimum(beam, np.maximum(level * least / cos_z, 0.0))
    return np.where(up, SOLAR_CONSTANT_W_M2 * share, 0.0)


def moment_w_m2(
    collector: Collector,
    day: CircularDay,
    solar_time_h: float,
    turbidity: float = CLEAN_TURBIDITY,
    elevation_m: float = 0.0,
) -> float:
    """Direct beam that a collector catches at one moment under a clear sky, W/m2."""
    sun = day.direction_neu(solar_time_h)
    beam = direct_w_m2(_zenith_deg(sun), turbidity, elevation_m)
    return float(collector.share(sun) * beam)


def day_kwh_m2(
    collector: Collector,
    day: CircularDay,
    turbidity: float = CLEAN_TURBIDITY,
    elevation_m: float = 0.0,
) -> float:
    """Direct beam that a collector catches over a clear day, kWh/m2."""
    middle = (np.arange(_STEPS) + 0.5) / _STEPS - 0.5
    sun = day.direction_neu(12.0 + day.daylight_h * middle)
    beam = direct_w_m2(_zenith_deg(sun), turbidity, elevation_m)
    return float(np.mean(collector.share(sun) * beam)) * day.daylight_h / 1e3


def _zenith_deg(sun_neu: FloatArray) -> FloatArray:
    return np.asarray(np.arccos(np.clip(sun_neu[..., 2], -1.0, 1.0)) / RAD_PER_DEG)
