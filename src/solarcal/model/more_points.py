"""What more points would give: the times at which today could end, and the year ahead of each."""

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
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
from solarcal.model.plan import PlannedStop
from solarcal.model.prior import MechanismPosterior, Prior, standard_normals, symmetric_root
from solarcal.model.schedule import (
    MOST_POINTS,
    Slots,
    after,
    best_schedule,
    gains,
    greedy_for_each,
    slope_products,
    with_point,
)
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


STOP_STEP_S = 1800.0
PACE_S = 1200.0
"""A technician without a plan takes a point every 20 minutes at most; a plan asks for fewer."""
WORTH_A_POINT = 0.002
"""Part of the mean square that one more point must save to be considered at all."""

Candidate = tuple[PlannedStop, list[int], list[FloatArray]]
"""A stop, the slots of its points in the order of their worth, and what is known after each."""


@dataclass(frozen=True, eq=False, slots=True)
class DayStops:
    """The times at which a day of ``slots`` could end.

    ``covariance``: what is known before, in units of the prior; ``today``: when points were taken
    today; ``points``: exactly so many more, or as many as are worth taking.
    """

    slots: Slots
    covariance: FloatArray
    year: YearAhead
    rule: StoppingRule
    today: Sequence[float] = ()
    points: int | None = None

    @property
    def ends_s(self) -> list[float]:
        """Every half hour of the clock from the first slot to the last, and the last slot."""
        first = STOP_STEP_S * math.ceil((float(self.slots.utc_s[0]) + 1.0) / STOP_STEP_S)
        last = float(self.slots.utc_s[-1])
        return [*np.arange(first, last, STOP_STEP_S).tolist(), last]

    def allowed(self, end_s: float) -> int:
        """Fewer points than one every ``PACE_S`` since the first of the day; one at least."""
        if self.points is not None:
            return self.points
        first_s = self.today[0] if self.today else float(self.slots.utc_s[0])
        return min(max(int((end_s - first_s) / PACE_S) - len(self.today), 1), MOST_POINTS)

    def schedules(self, ends_s: Sequence[float], *, dense: bool = False) -> Iterator[Candidate]:
        """The greedy schedule of every end; ``dense``: with as many points as there is room for."""
        allowed = [len(self.slots) if dense else self.allowed(end_s) for end_s in ends_s]
        orders = greedy_for_each(
            self.slots,
            self.covariance,
            self.year.weight,
            allowed,
            np.array(ends_s),
            least_gain=WORTH_A_POINT if self.points is None else 0.0,
            floor=self.year.known_square,
        )
        for end_s, (chosen, covariances) in zip(ends_s, orders, strict=True):
            left = covariances[-1] if covariances else self.covariance
            yield self.stop(end_s, chosen, left), chosen, covariances

    def stop(self, end_s: float, chosen: Sequence[int], covariance: FloatArray) -> PlannedStop:
        times = tuple(float(self.slots.utc_s[i]) for i in sorted(chosen))
        return PlannedStop(end_s, times, *self.year.expected(covariance, self.rule.tolerance_deg))

    def meets(self, stop: PlannedStop) -> bool:
        return stop.points > 0 and stop.probability >= self.rule.probability

    def earliest(self, begin_s: float, found: Candidate) -> PlannedStop:
        """The first slot of the last half hour that will do, with as few points as will do."""
        last_s = found[0].stop_utc_s
        inside = [time for time in self.slots.utc_s.tolist() if begin_s < time < last_s]
        if inside:
            earlier = self.schedules(inside, dense=len(found[1]) > self.allowed(last_s))
            found = next((one for one in earlier if self.meets(one[0])), found)
        stop, chosen, covariances = found

        def with_first(points: int) -> PlannedStop:
            return self.stop(stop.stop_utc_s, chosen[:points], covariances[points - 1])

        count = len(chosen)
        if self.points is None:
            count = bisect_left(range(count), True, key=lambda few: self.meets(with_first(few)))
        return self.polished(with_first(count), count, self.rule.probability)

    def first_dense(self, ends_s: Sequence[float]) -> int:
        """Which end is the first that points as dense as can be taken will do for."""

        def will_do(end_s: float) -> bool:
            dense, *_ = next(self.schedules([end_s], dense=True))
            return self.meets(dense)

        return bisect_left(ends_s, True, hi=len(ends_s) - 1, key=will_do)

    def polished(self, stop: PlannedStop, count: int, aim: float | None) -> PlannedStop:
        """The stop with its points exchanged for better ones, and one fewer where that will do.

        Exchanges lower the rms; should the probability suffer by a hair, the stop stays.
        """
        best = stop
        for points in range(count, 0, -1):
            schedule = best_schedule(
                self.slots, self.covariance, self.year.weight, points, until_s=stop.stop_utc_s
            )
            left = after(self.slots, self.covariance, schedule)
            found = self.stop(stop.stop_utc_s, schedule, left)
            if found.probability < (stop.probability if aim is None else aim):
                break
            best = found
            if aim is None or self.points is not None or points < count:
                break
        return best
