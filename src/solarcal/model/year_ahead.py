"""The year from now on, as far as the points still to be taken decide it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solarcal.model.forecast import (
    SHARE_WITHIN,
    Forecast,
    known_and_slopes,
    thinning,
    upper_quantile,
)
from solarcal.model.prior import MechanismPosterior, Prior, standard_normals, symmetric_root
from solarcal.model.schedule import MOST_POINTS, gains, slope_products, with_point
from solarcal.model.sky_context import SkyContext
from solarcal.model.year_grid import SLOTS, controller_coefficients, year_grid
from solarcal.mount.formula import Coefficients
from solarcal.stopping_rule import StoppingRule
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

_MOMENTS = 150
USUAL_SHARE = 0.7
"""What is left of the draws without the large cross-axis terms of a day that excludes none."""
_DRAWS = 128
_BLUR = 0.05
"""Relative width over which a percentile of one draw counts as within: the probability of few draws
then has no steps."""


@dataclass(frozen=True, eq=False, slots=True)
class YearAhead:
    """A year of moments, linearised about the mechanism as known now; units of the prior.

    ``weight`` (6, 6): mean over the year of the squared sky slopes. ``known_square``: mean square
    of what the formula, refraction and ephemeris leave, deg^2; ``plain`` (1, 2, m) the same at a
    sample of moments, ``known`` (1 or d, 2, m) with what is there beside P1..P6, of each draw;
    ``slopes`` (6, 2 m) there. ``day_rows`` (days, 48, 2, 6): slopes over the noise of every half
    hour of the grid's days, zero where not ``day_open``.
    """

    weight: FloatArray
    known_square: float
    known: FloatArray
    plain: FloatArray
    slopes: FloatArray
    day_rows: FloatArray
    day_open: NDArray[np.bool_]
    days_utc_s: FloatArray

    def expected(self, covariance: FloatArray, tolerance_deg: float) -> tuple[float, float, float]:
        """Year rms, 95th percentile, degrees, and probability of the tracker's own percentile
        within the tolerance, if the mechanism were known to a covariance."""
        # Rounding can leave a variance of almost nothing below nothing.
        left = max(float(np.sum(self.weight * covariance)), 0.0)
        rms = float(np.sqrt(self.known_square + left))
        factor = symmetric_root(*np.linalg.eigh(covariance))
        errors = (standard_normals(_DRAWS) @ factor) @ self.slopes
        errors = errors.reshape(_DRAWS, 2, -1) + self.known
        square = np.einsum("mag,mag->mg", errors, errors)
        rank = math.ceil(SHARE_WITHIN * square.shape[1]) - 1
        own = np.partition(square, rank, axis=1)[:, rank]
        room = 0.5 * np.log(tolerance_deg**2 / np.maximum(own, 1e-12)) / _BLUR
        within = float(np.mean(1.0 / (1.0 + np.exp(-np.clip(1.7 * room, -50.0, 50.0)))))
        return rms, float(np.sqrt(upper_quantile(square.reshape(-1), 0.95))), within

    def noons_after(self, utc_s: float) -> FloatArray:
        """For each day of the grid its next mean solar noon after that day's end, (days,)."""
        noon_s = self.days_utc_s + SECONDS_PER_DAY / 2.0
        year_s = 365.2422 * SECONDS_PER_DAY
        ahead_s = (noon_s - utc_s - SECONDS_PER_DAY / 2.0) % year_s
        # Whole days keep it at noon.
        days = np.ceil((utc_s + SECONDS_PER_DAY / 2.0 + ahead_s - noon_s) / SECONDS_PER_DAY - 0.01)
        result: FloatArray = noon_s + days * SECONDS_PER_DAY
        return result

    def come_back(
        self, covariance: FloatArray, at_utc_s: float, rule: StoppingRule
    ) -> float | None:
        """Mean solar noon of the next day of the year's grid whose points meet the rule.

        The points are the best half hours of that day added to what is known today; noise alike.
        """
        if float(np.sqrt(self.known_square)) > rule.tolerance_deg:
            return None
        # Another day tells of what is there beside P1..P6, too; how much, nobody knows before.
        plainly = replace(self, known=self.plain)
        days = len(self.day_rows)
        left = np.broadcast_to(covariance, (days, 6, 6)).copy()
        free = self.day_open.copy()
        products = slope_products(self.day_rows)
        for _ in range(MOST_POINTS):
            if not free.any():
                break
            gain = np.where(free, gains(products, left, self.weight), -np.inf)
            best = np.argmax(gain, axis=1)
            possible = free[np.arange(days), best]
            row = np.where(
                possible[:, np.newaxis, np.newaxis], self.day_rows[np.arange(days), best], 0.0
            )
            left = with_point(left, row)
            free[np.arange(days), best] = False
        next_s = self.noons_after(at_utc_s)
        square = np.einsum("ij,dij->d", self.weight, left) + self.known_square
        for day in np.argsort(next_s):
            # A year rms near the tolerance leaves no room for 95 %: not worth a closer look.
            if square[day] > (0.8 * rule.tolerance_deg) ** 2:
                continue
            if plainly.expected(left[day], rule.tolerance_deg)[2] >= rule.probability:
                return float(next_s[day])
        return None


def year_ahead(
    posterior: MechanismPosterior,
    context: SkyContext,
    unit: FloatArray,
    expected: Forecast | None = None,
) -> YearAhead:
    """The year about the posterior's mean, with the best coefficients for that mean uploaded.

    ``expected``: a forecast with what may be there beside P1..P6.
    """
    grid = year_grid(context)
    at = grid.linearised(posterior.mean)
    best = controller_coefficients(posterior.mean, context, Prior(), at.errors)
    known, slopes = known_and_slopes(posterior.mean, Coefficients(*best.tolist()), grid, at)
    slopes = slopes * unit[:, np.newaxis, np.newaxis]
    flat = slopes.reshape(6, -1)
    days = len(grid.days_utc_s)
    rows = np.zeros((days, SLOTS, 2, 6))
    rows[grid.day, grid.slot] = np.transpose(slopes, (2, 1, 0)) / posterior.noise_rms_deg
    is_open = np.zeros((days, SLOTS), dtype=np.bool_)
    is_open[grid.day, grid.slot] = True
    step = thinning(len(grid), _MOMENTS)
    return YearAhead(
        weight=flat @ flat.T / len(grid),
        known_square=float(np.mean(np.sum(known**2, axis=0))),
        known=_known_of_draws(known, expected, step),
        plain=known[np.newaxis, :, ::step],
        slopes=slopes[:, :, ::step].reshape(6, -1),
        day_rows=rows,
        day_open=is_open,
        days_utc_s=grid.days_utc_s,
    )


def _known_of_draws(known: FloatArray, expected: Forecast | None, step: int) -> FloatArray:
    """Sky errors (1 or d, 2, m) that no points of P1..P6 remove: what the formula leaves and, of
    each draw, what the amounts beside the six leave although the fit follows them.

    The largest amounts are left out, as a plan wants them: more points find or exclude those.
    """
    thin = known[np.newaxis, :, ::step]
    if expected is None:
        return thin
    posterior = expected.posterior
    slopes = expected.errors.slopes.reshape(len(posterior.mean), 2, -1)
    covariance = posterior.covariance
    follows = np.linalg.solve(covariance[6:, 6:], covariance[6:, :6])
    effect = slopes[6:] + np.einsum("mk,kag->mag", follows, slopes[:6])
    draws = posterior.samples(_DRAWS)[:, 6:]
    weight = np.einsum("mag,lag->ml", effect, effect)
    order = np.argsort(np.einsum("nm,ml,nl->n", draws, weight, draws), kind="stable")
    usual = draws[order[: round(_DRAWS * USUAL_SHARE)]]
    return np.asarray(
        thin - np.einsum("nm,mag->nag", np.resize(usual, draws.shape), effect[:, :, ::step])
    )
