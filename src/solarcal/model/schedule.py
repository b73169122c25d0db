"""Which moments tell most: schedules that minimise what a posterior leaves of the year's error.

With the mechanism known to a covariance S, a point at slot i adds the information J_i' J_i / s^2;
the year's mean square error is the trace of M S, M being the mean over the year of the squared
sky slopes. Points are added greedily and then exchanged one for one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from solarcal.model.least_squares import inverse
from solarcal.model.prior import MechanismPosterior
from solarcal.model.sky_context import SkyContext, sun_directions
from solarcal.model.year_grid import LOWEST_FORECAST_DEG
from solarcal.mount.mechanism import Mechanism
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

SLOT_S = 300.0
GAP_S = 600.0
"""A point with its three questions takes some minutes; ten is the least between two."""

_ROUNDS = 8
MOST_POINTS = 30


@dataclass(frozen=True, eq=False)
class Slots:
    """Moments at which a point can be taken.

    ``utc_s`` (c,) rising; ``rows`` (c, 2, 6) sky slopes over the noise, in units of the prior;
    ``gap_s``: points stand at least so far apart.
    """

    utc_s: FloatArray
    rows: FloatArray
    gap_s: float

    def __len__(self) -> int:
        return len(self.utc_s)

    @cached_property
    def products(self) -> FloatArray:
        """What ``gains`` needs of them, (21, 3 c)."""
        return slope_products(self.rows)

    def too_near(self) -> NDArray[np.bool_]:
        """Which slots stand too near to each for both to be taken: (c, c)."""
        # A second of grace: times are sums of floating-point seconds.
        near: NDArray[np.bool_] = np.abs(self.utc_s - self.utc_s[:, np.newaxis]) < self.gap_s - 1.0
        return near


_ROW, _COLUMN = np.triu_indices(6)


def slope_products(rows: FloatArray) -> FloatArray:
    """J1 J1, J1 J2 and J2 J2 of points with sky slopes ``rows`` (..., c, 2, 6): (..., 21, 3 c).

    The upper triangle of a symmetric S times them is the three different elements of J S J' of
    each point.
    """
    slopes = np.moveaxis(rows, (-2, -1), (0, 1))
    of_pairs = np.stack(
        [
            slopes[i][_ROW] * slopes[j][_COLUMN] + slopes[i][_COLUMN] * slopes[j][_ROW]
            for i, j in ((0, 0), (0, 1), (1, 1))
        ],
        axis=-2,
    )
    # What stands on the diagonal of S was counted twice.
    of_pairs[_ROW == _COLUMN] *= 0.5
    of_pairs = np.moveaxis(of_pairs, 0, -3)
    return of_pairs.reshape(*of_pairs.shape[:-2], -1)


def gains(products: FloatArray, covariance: FloatArray, weight: FloatArray) -> FloatArray:
    """By how much a point at each slot would lower trace(weight @ covariance): (..., c).

    ``products`` are the ``slope_products`` of the slots, (..., 21, 3 c); ``covariance`` is
    (..., 6, 6). With A = 1 + J S J' and B = J S M S J' the gain is the trace of A^-1 B, written out
    for two by two.
    """
    felt = covariance @ weight @ covariance
    both = np.stack((covariance[..., _ROW, _COLUMN], felt[..., _ROW, _COLUMN]), axis=-2)
    # One product of tall matrices: much faster than thousands of two by six.
    elements = both @ products
    a, b = np.moveaxis(elements.reshape(*elements.shape[:-1], 3, -1), -3, 0)
    a11, a12, a22 = 1.0 + a[..., 0, :], a[..., 1, :], 1.0 + a[..., 2, :]
    gain: FloatArray = a22 * b[..., 0, :] - 2.0 * a12 * b[..., 1, :] + a11 * b[..., 2, :]
    gain /= a11 * a22 - a12 * a12
    return gain


def with_point(covariance: FloatArray, row: FloatArray) -> FloatArray:
    """Covariance (..., 6, 6) after one more point with sky slopes ``row`` (..., 2, 6)."""
    spread = row @ covariance
    inner = spread @ np.swapaxes(row, -1, -2)
    a11, a22, a12 = 1.0 + inner[..., 0, 0], 1.0 + inner[..., 1, 1], inner[..., 0, 1]
    across = np.empty_like(inner)
    across[..., 0, 0], across[..., 1, 1] = a22, a11
    across[..., 0, 1] = across[..., 1, 0] = -a12
    across /= (a11 * a22 - a12 * a12)[..., np.newaxis, np.newaxis]
    after: FloatArray = covariance - np.swapaxes(spread, -1, -2) @ (across @ spread)
    return after


def greedy_for_each(
    slots: Slots,
    covariance: FloatArray,
    weight: FloatArray,
    most: Sequence[int],
    ends_s: FloatArray,
    *,
    least_gain: float,
    floor: float = 0.0,
) -> list[tuple[list[int], list[FloatArray]]]:
    """Best slots one after the other, and the covariance after each, for every end (e,) at which
    the schedule could be over, side by side.

    Each stops at ``most`` (e,) points, when no slot is free, or when the best one lowers the mean
    square by less than the part ``least_gain``. ``floor``: the part of it that no points change.
    """
    schedules: list[tuple[list[int], list[FloatArray]]] = [([], []) for _ in ends_s]
    free = slots.utc_s <= ends_s[:, np.newaxis]
    left = np.broadcast_to(covariance, (len(ends_s), *covariance.shape)).copy()
    going = np.arange(len(ends_s))
    limit = np.asarray(most)
    for turn in range(max(most)):
        going = going[free[going].any(axis=1) & (turn < limit[going])]
        if not going.size:
            break
        gain = np.where(free[going], gains(slots.products, left[going], weight), -np.inf)
        best = np.argmax(gain, axis=1)
        square = np.sum(weight * left[going], axis=(1, 2)) + floor
        worth = gain[np.arange(len(going)), best] >= least_gain * square
        # One point is worth taking however much is known: it may tell of more than P1..P6.
        worth |= turn == 0
        going, best = going[worth], best[worth]
        left[going] = with_point(left[going], slots.rows[best])
        away_s = np.abs(slots.utc_s - slots.utc_s[best, np.newaxis])
        free[going] &= away_s >= slots.gap_s - 1.0
        for end, slot in zip(going.tolist(), best.tolist(), strict=True):
            schedules[end][0].append(slot)
            schedules[end][1].append(left[end].copy())
    return schedules


def exchanged(
    slots: Slots,
    covariance: FloatArray,
    weight: FloatArray,
    chosen: Sequence[int],
    *,
    until_s: float = np.inf,
) -> list[int]:
    """The schedule after moving single points to better slots until none is better; sorted."""
    schedule = list(chosen)
    start = inverse(covariance)
    too_near = slots.too_near()
    within = slots.utc_s <= until_s
    # By how many points each slot is blocked.
    blocked = too_near[schedule].sum(axis=0)
    for _ in range(_ROUNDS):
        first = 0
        while first < len(schedule):
            # What each point from here on would gain elsewhere, good until one of them is moved.
            here = schedule[first:]
            information = _information(slots.rows[schedule])
            without = start + information.sum(axis=0) - information[first:]
            gain = gains(slots.products, inverse(without), weight)
            now = gain[np.arange(len(here)), here]
            free = within & (blocked == too_near[here])
            gain = np.where(free, gain, -np.inf)
            better = np.flatnonzero(gain.max(axis=1) > now * (1.0 + 1e-6))
            if not better.size:
                break
            place = first + int(better[0])
            best = int(np.argmax(gain[better[0]]))
            blocked += too_near[best]
            blocked -= too_near[schedule[place]]
            schedule[place] = best
            first = place + 1
        if first == 0:
            break
    return sorted(schedule)


def cost(
    slots: Slots, covariance: FloatArray, weight: FloatArray, schedule: Sequence[int]
) -> float:
    """trace(weight @ covariance) after the points of a schedule."""
    return float(np.sum(weight * after(slots, covariance, schedule)))


def after(slots: Slots, covariance: FloatArray, schedule: Sequence[int]) -> FloatArray:
    """Covariance after the points of a schedule, (6, 6)."""
    information = _information(slots.rows[list(schedule)])
    return inverse(inverse(covariance) + information.sum(axis=0))


def best_schedule(
    slots: Slots, covariance: FloatArray, weight: FloatArray, count: int, *, until_s: float = np.inf
) -> list[int]:
    """The best of the greedy and the equally spaced schedule, each after exchanges.

    Starting from equal spacing too, the answer is never worse than that.
    """
    eligible = np.flatnonzero(slots.utc_s <= until_s)
    count = min(count, len(eligible))
    if count == 0:
        return []
    ends_s = np.array([until_s])
    ((chosen, _),) = greedy_for_each(slots, covariance, weight, [count], ends_s, least_gain=-np.inf)
    starts = [chosen]
    equal = equally_spaced(slots, count, until_s)
    # In a short window equal spacing may come closer than a point takes.
    if (np.diff(slots.utc_s[equal]) >= slots.gap_s - 1.0).all():
        starts.append(equal)
    schedules = [exchanged(slots, covariance, weight, s, until_s=until_s) for s in starts]
    most = max(len(s) for s in schedules)
    return min(
        (s for s in schedules if len(s) == most), key=lambda s: cost(slots, covariance, weight, s)
    )


def equally_spaced(slots: Slots, count: int, until_s: float = np.inf) -> list[int]:
    """Slots nearest to ``count`` equal steps that end with the last slot not after ``until_s``."""
    eligible = np.flatnonzero(slots.utc_s <= until_s)
    first, last = slots.utc_s[eligible[0]], slots.utc_s[eligible[-1]]
    steps = (last - first) / count
    wanted = [first + steps * i for i in range(1, count + 1)]
    return [int(eligible[np.argmin(np.abs(slots.utc_s[eligible] - time))]) for time in wanted]


def _information(rows: FloatArray) -> FloatArray:
    """What points with sky slopes (..., 2, 6) tell each, (..., 6, 6)."""
    return np.swapaxes(rows, -1, -2) @ rows


def day_slots(
    posterior: MechanismPosterior,
    context: SkyContext,
    at_utc_s: float,
    unit: FloatArray,
    until_utc_s: float | None = None,
    struck: Sequence[tuple[float, float]] = (),
    *,
    slot_s: float = SLOT_S,
    gap_s: float = GAP_S,
    on_the_clock: bool = False,
) -> Slots:
    """Every few minutes of the rest of the solar day with the Sun high enough and in reach.

    From ``at_utc_s``, or ``on_the_clock`` from the next full step after it.
    """
    since_s = (at_utc_s - context.first_midnight_utc_s) % SECONDS_PER_DAY
    end_s = at_utc_s + SECONDS_PER_DAY - since_s
    if until_utc_s is not None:
        end_s = min(end_s, until_utc_s)
    first_s = slot_s * math.ceil(at_utc_s / slot_s) if on_the_clock else at_utc_s
    times = first_s + slot_s * np.arange(max(int((end_s - first_s) / slot_s) + 1.0, 0.0))
    sun = sun_directions(context, times)
    open_ = sun.elevation_deg > LOWEST_FORECAST_DEG
    if context.limits is not None:
        open_ &= context.limits.distance_deg(sun.ideal1_deg, sun.ideal2_deg) >= 0.0
    for from_s, to_s in struck:
        open_ &= (times < from_s) | (times > to_s)
    true1, true2 = sun.true1_deg[open_], sun.true2_deg[open_]
    rows = np.zeros((0, 2, 6))
    if len(true1):
        at = Mechanism.linearised(posterior.mean, context.geometry, true1, true2)
        weighted = at.sky_slopes * (unit / posterior.noise_rms_deg)[:, np.newaxis, np.newaxis]
        rows = np.ascontiguousarray(np.transpose(weighted, (2, 1, 0)))
    return Slots(times[open_], rows, gap_s)
