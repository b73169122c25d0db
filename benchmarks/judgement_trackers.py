"""Made-up trackers on exact geometry, and how wrong they really are over the year."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from solarcal.model.points import Points
from solarcal.model.prior import PLAIN, Prior, sigmas_of
from solarcal.model.sky_context import Ideal, SkyContext, sun_directions
from solarcal.model.year_grid import formula_slopes, year_grid
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.site import Site
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

LATITUDE_DEG = 35.0
LEAN_SD_DEG, OFFSET_SD_DEG, SCALE_SD = 0.7, 1.0, 0.001
NOISE_DEG = 0.03
LOWEST_DEG = 10.0
PLANS = ((5, 3.0), (7, 6.0), (13, 9.0))
"""Points, and the hours they are spread over."""

POPULATION_PRIOR = Prior(sigmas=sigmas_of(LEAN_SD_DEG, OFFSET_SD_DEG, SCALE_SD), widths=PLAIN)


def context_of(geometry: str, ideal: Ideal = "apparent") -> SkyContext:
    return SkyContext(Site(LATITUDE_DEG, 0.0), MountGeometry(geometry, LATITUDE_DEG), ideal=ideal)


@lru_cache(maxsize=4096)
def daylight_s(context: SkyContext, day: int) -> tuple[float, float]:
    """First and last second of day 0..364 with the Sun above 10 deg, to five minutes."""
    start = context.first_midnight_utc_s + day * SECONDS_PER_DAY
    times = start + 300.0 * np.arange(288.0)
    high = np.flatnonzero(sun_directions(context, times).elevation_deg > LOWEST_DEG)
    return float(times[high[0]]), float(times[high[-1]])


def random_mechanism(rng: np.random.Generator) -> Mechanism:
    lean = LEAN_SD_DEG * rng.standard_normal(2)
    offset = OFFSET_SD_DEG * rng.standard_normal(2)
    scale = SCALE_SD * rng.standard_normal(2)
    return Mechanism(lean[0], offset[0], lean[1], offset[1], scale[0], scale[1])


def random_times(
    context: SkyContext, rng: np.random.Generator, n: int, hours: float, *, at_noon: bool = False
) -> FloatArray:
    """n equal steps over a stretch of a random day; shorter where the day has no such stretch."""
    first, last = daylight_s(context, int(rng.integers(365)))
    length = min(3600.0 * hours, last - first)
    begin = first + (0.5 if at_noon else rng.random()) * (last - first - length)
    return begin + np.linspace(0.0, length, n)


def measured(
    context: SkyContext,
    mechanism: Mechanism,
    utc_s: FloatArray,
    rng: np.random.Generator,
    noise_deg: float = NOISE_DEG,
) -> Points:
    """Points of this mechanism with normal noise on sky."""
    sun = sun_directions(context, utc_s)
    e1, e2 = mechanism.errors_deg(context.geometry, sun.true1_deg, sun.true2_deg)
    noise = noise_deg * rng.standard_normal((2, len(utc_s)))
    return Points(
        geometry=context.geometry,
        ax1_deg=sun.ideal1_deg,
        ax2_deg=sun.ideal2_deg,
        err1_deg=e1 + sun.true1_deg - sun.ideal1_deg + noise[0] / np.sin(np.radians(sun.true2_deg)),
        err2_deg=e2 + sun.true2_deg - sun.ideal2_deg + noise[1],
        utc_s=utc_s,
    )


@dataclass(frozen=True)
class TrueYear:
    """Angles between collector and Sun over the contract's grid, degrees."""

    sky_deg: FloatArray
    axes_deg: FloatArray
    """(2, g) on sky: across and along."""

    @property
    def rms_deg(self) -> float:
        return float(np.sqrt(np.mean(self.sky_deg**2)))


def true_year(context: SkyContext, mechanism: Mechanism, uploaded: Coefficients) -> TrueYear:
    grid = year_grid(context)
    sun, geometry = grid.sun, context.geometry
    e1, e2 = correction_deg(uploaded, sun.ideal1_deg, sun.ideal2_deg)
    n1, n2 = mechanism.errors_deg(geometry, sun.true1_deg, sun.true2_deg)
    beside1 = (sun.ideal1_deg + e1 - sun.true1_deg - n1 + 180.0) % 360.0 - 180.0
    beside2 = sun.ideal2_deg + e2 - sun.true2_deg - n2
    # Separated in the mechanism's own angles, which are the read-outs less offset and scale: the
    # inverse kinematics find no direction where a bad fit drives beyond the primary axis.
    own2 = sun.true2_deg + n2 - mechanism.P4 + mechanism.P6 * sun.true2_deg
    sky = geometry.sky_separation_deg(0.0 * own2, own2, beside1, own2 + beside2)
    return TrueYear(sky, np.stack((beside1 * np.sin(np.radians(own2)), beside2)))


def oracle(points: Points, context: SkyContext, noise_deg: float = NOISE_DEG) -> Coefficients:
    """Linear Bayes with the population's own prior and known noise: as good as it gets."""
    sin2 = np.sin(np.radians(points.ax2_deg))
    rows = formula_slopes(context.geometry, points.ax1_deg, points.ax2_deg)
    rows[:, 0] *= sin2
    rows = rows.reshape(6, -1) / noise_deg
    data = np.concatenate((points.err1_deg * sin2, points.err2_deg)) / noise_deg
    precision = np.diag(POPULATION_PRIOR.sigma_array() ** -2.0)
    return Coefficients(*np.linalg.solve(rows @ rows.T + precision, rows @ data).tolist())
