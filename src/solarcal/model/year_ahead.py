"""The year's error as a function of what will be known: the yardstick of every plan."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solarcal.model.forecast import known_and_slopes, upper_quantile
from solarcal.model.known_physics import SkyContext
from solarcal.model.posterior import MechanismPosterior, standard_normals
from solarcal.model.prior import Prior
from solarcal.model.year_grid import SLOTS, controller_coefficients, year_grid
from solarcal.mount.formula import Coefficients
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

_MOMENTS = 250
_DRAWS = 96


@dataclass(frozen=True, eq=False, slots=True)
class YearAhead:
    """A year of moments, linearised about the mechanism as known now; units of the prior.

    ``weight`` (6, 6): mean over the year of the squared sky slopes. ``known_square``: mean square
    of what the formula, refraction and ephemeris leave, deg^2. ``known`` (2, m), ``slopes``
    (6, 2 m) at a sample of moments. ``day_rows`` (days, 48, 2, 6): slopes over the noise of every
    half hour of the grid's days, zero where not ``day_open``.
    """

    weight: FloatArray
    known_square: float
    known: FloatArray
    slopes: FloatArray
    day_rows: FloatArray
    day_open: NDArray[np.bool_]
    days_utc_s: FloatArray

    def expected(self, covariance: FloatArray) -> tuple[float, float]:
        """Year rms and 95th percentile, degrees, if the mechanism were known to a covariance."""
        # Rounding can leave a variance of almost nothing below nothing.
        left = max(float(np.sum(self.weight * covariance)), 0.0)
        rms = float(np.sqrt(self.known_square + left))
        values, vectors = np.linalg.eigh(covariance)
        factor = vectors * np.sqrt(np.maximum(values, 0.0))
        errors = (standard_normals(_DRAWS) @ factor.T) @ self.slopes
        square = np.sum((errors.reshape(_DRAWS, 2, -1) + self.known) ** 2, axis=1).reshape(-1)
        return rms, float(np.sqrt(upper_quantile(square, 0.95)))

    def noons_after(self, utc_s: float) -> FloatArray:
        """For each day of the grid its next mean solar noon after that day's end, (days,)."""
        noon_s = self.days_utc_s + SECONDS_PER_DAY / 2.0
        year_s = 365.2422 * SECONDS_PER_DAY
        ahead_s = (noon_s - utc_s - SECONDS_PER_DAY / 2.0) % year_s
        # Whole days keep it at noon.
        days = np.ceil((utc_s + SECONDS_PER_DAY / 2.0 + ahead_s - noon_s) / SECONDS_PER_DAY - 0.01)
        result: FloatArray = noon_s + days * SECONDS_PER_DAY
        return result


def year_ahead(posterior: MechanismPosterior, context: SkyContext, unit: FloatArray) -> YearAhead:
    """The year about the posterior's mean, with the best coefficients for that mean uploaded."""
    grid = year_grid(context)
    uploaded = Coefficients(*controller_coefficients(posterior.mean, context, Prior()).tolist())
    known, slopes = known_and_slopes(posterior.mean, uploaded, grid)
    slopes = slopes * unit[:, np.newaxis, np.newaxis]
    flat = slopes.reshape(6, -1)
    days = len(grid.days_utc_s)
    rows = np.zeros((days, SLOTS, 2, 6))
    rows[grid.day, grid.slot] = np.transpose(slopes, (2, 1, 0)) / posterior.noise_rms_deg
    is_open = np.zeros((days, SLOTS), dtype=np.bool_)
    is_open[grid.day, grid.slot] = True
    # Every k-th moment; k is kept odd so that the sample does not favour an hour of the day.
    step = max(1, len(grid) // _MOMENTS) | 1
    return YearAhead(
        weight=flat @ flat.T / len(grid),
        known_square=float(np.mean(np.sum(known**2, axis=0))),
        known=known[:, ::step],
        slopes=slopes[:, :, ::step].reshape(6, -1),
        day_rows=rows,
        day_open=is_open,
        days_utc_s=grid.days_utc_s,
    )
