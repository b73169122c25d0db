"""A year of Sun for one tracker, computed once: where forecasts look and P1..P6 are chosen.

The grid is the contract's: every 30 minutes of the Sun above 10 deg and within limits, every
seventh day, all moments alike.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.prior import Prior
from solarcal.model.sky_context import SkyContext, SunDirections, sun_directions
from solarcal.model.terms import CONTROLLER_TERMS, TERMS, NativeAngles, design_matrix
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Linearised, Mechanism
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray, wrap_deg

DAYS_APART = 7
SLOT_S = 1800.0
SLOTS = 48
LOWEST_FORECAST_DEG = 10.0
"""Elevation above which pointing counts."""

RIDGE_DEG = 1e-3
"""A coefficient that moves the year by less than this per prior sigma stays with the mechanism."""

_TERMS = tuple(TERMS[name] for name in CONTROLLER_TERMS)


def formula_slopes(geometry: MountGeometry, ax1_deg: FloatArray, ax2_deg: FloatArray) -> FloatArray:
    """E1, E2 of the controller's formula per unit of P1..P6 at ideal angles: (6, 2, n)."""
    return design_matrix(_TERMS, NativeAngles.at(geometry, ax1_deg, ax2_deg))


# No slots: cached properties live in the instance's dictionary.
@dataclass(frozen=True, eq=False)
class SunGrid:
    """Moments of Sun, with what the controller's formula can do there.

    ``sun`` holds (g,) arrays; ``day``, ``slot`` (g,) index the day and the half hour of mean
    solar time; ``days_utc_s`` the mean solar midnights the days begin with.
    """

    context: SkyContext
    utc_s: FloatArray
    sun: SunDirections
    day: np.ndarray[tuple[int], np.dtype[np.intp]]
    slot: np.ndarray[tuple[int], np.dtype[np.intp]]
    days_utc_s: FloatArray

    @cached_property
    def formula(self) -> FloatArray:
        """``formula_slopes`` at the ideal angles, (6, 2, g)."""
        return formula_slopes(self.geometry, self.sun.ideal1_deg, self.sun.ideal2_deg)

    @cached_property
    def gap_deg(self) -> FloatArray:
        """True minus ideal angle, (2, g)."""
        sun = self.sun
        gap1_deg = wrap_deg(sun.true1_deg - sun.ideal1_deg)
        return np.stack((gap1_deg, sun.true2_deg - sun.ideal2_deg))

    @cached_property
    def sky(self) -> FloatArray:
        """Sine of true AX2, and one, (2, g)."""
        return np.stack((np.sin(np.radians(self.sun.true2_deg)), np.ones(len(self))))

    @property
    def geometry(self) -> MountGeometry:
        return self.context.geometry

    def __len__(self) -> int:
        return len(self.utc_s)

    def linearised(self, values: FloatArray) -> Linearised:
        """The exact mechanism of six numbers (6,) at the true directions."""
        return Mechanism.linearised(values, self.geometry, self.sun.true1_deg, self.sun.true2_deg)


def sun_grid(context: SkyContext, days_utc_s: FloatArray) -> SunGrid:
    """Every half hour of these days with the Sun high enough and in reach."""
    times = (days_utc_s[:, np.newaxis] + SLOT_S * np.arange(SLOTS)).ravel()
    day, slot = np.divmod(np.arange(len(times)), SLOTS)
    sun = sun_directions(context, times)
    seen = sun.elevation_deg > LOWEST_FORECAST_DEG
    if context.limits is not None:
        seen &= context.limits.distance_deg(sun.ideal1_deg, sun.ideal2_deg) >= 0.0
    return SunGrid(
        context=context,
        utc_s=times[seen],
        sun=SunDirections(*(column[seen] for column in sun)),
        day=day[seen],
        slot=slot[seen],
        days_utc_s=days_utc_s,
    )


@lru_cache(maxsize=32)
def year_grid(context: SkyContext) -> SunGrid:
    """The contract's grid for the year of the context; kept, so that asking again is free.

    ConfigurationError where the Sun is never within limits and high enough.
    """
    days: FloatArray = SECONDS_PER_DAY * np.arange(0.0, 365.0, DAYS_APART)
    grid = sun_grid(context, context.first_midnight_utc_s + days)
    if not len(grid):
        raise ConfigurationError(
            f"the Sun is never above {LOWEST_FORECAST_DEG:g} deg and within the limits; "
            "check site, limits and the centre of the branch of axis 1"
        )
    return grid


@lru_cache(maxsize=32)
def _best_fit(context: SkyContext, prior: Prior) -> FloatArray:
    """(6, 2g): from what the formula leaves on sky to the change of P1..P6 that is best."""
    grid = year_grid(context)
    sigma = prior.sigma_array()
    rows = (grid.formula * grid.sky).reshape(6, -1) * sigma[:, np.newaxis]
    normal = rows @ rows.T + len(grid) * RIDGE_DEG**2 * np.eye(6)
    best: FloatArray = sigma[:, np.newaxis] * np.linalg.solve(normal, rows)
    return best


def controller_coefficients(
    values: FloatArray, context: SkyContext, prior: Prior, errors_deg: FloatArray | None = None
) -> FloatArray:
    """The six numbers (6,) with which the controller's formula does best over the year.

    Starts from the mechanism's own six and adds, by least squares on sky in units of the prior,
    what makes up for the second order of the lean, for refraction and for the controller's Sun.
    ``errors_deg`` (2, g): the mechanism's over the year, where they are computed already.
    """
    grid = year_grid(context)
    if errors_deg is None:
        true = grid.sun.true1_deg, grid.sun.true2_deg
        errors_deg = np.stack(Mechanism.of(values).errors_deg(grid.geometry, *true))
    missing = errors_deg + grid.gap_deg - np.einsum("k,kag->ag", values, grid.formula)
    missing[0] = wrap_deg(missing[0])
    found: FloatArray = values + _best_fit(context, prior) @ (missing * grid.sky).reshape(-1)
    return found


_MOST_STEPS = 50
_NEAR = 1e-12


def mechanism_of(uploaded: Coefficients, context: SkyContext) -> FloatArray:
    """The six numbers (6,) of the mechanism whose ``controller_coefficients`` are these.

    Coefficients in a unit hold refraction, the controller's Sun and the second order of the lean
    as well; those of no possible tracker are returned as they are.
    """
    given = np.array(uploaded.as_tuple())
    values = given
    for _ in range(_MOST_STEPS):
        step = given - controller_coefficients(values, context, Prior())
        values = values + step
        if not np.isfinite(values).all():
            return given
        if np.abs(step).max() < _NEAR:
            break
    return values


def coefficients_jacobian(slopes: FloatArray, context: SkyContext, prior: Prior) -> FloatArray:
    """d(P1..P6 uploaded) / d(mechanism), (6, 6), from exact slopes (6, 2, g) over the year."""
    grid = year_grid(context)
    change = ((slopes - grid.formula) * grid.sky).reshape(6, -1)
    jacobian: FloatArray = np.eye(6) + _best_fit(context, prior) @ change.T
    return jacobian
