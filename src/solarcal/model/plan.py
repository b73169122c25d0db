"""When to take the next points, and when today is worth stopping.

Every remaining half hour is a possible end of the day. For each the best schedule is sought and
its forecast computed; the earliest end that reaches the tolerance is recommended, else the
earliest whose forecast is within a tenth of the day's best.
"""

import math
from collections.abc import Sequence

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.exact_errors import errors_and_slopes, own_sine
from solarcal.model.forecast import TOLERANCE_DEG
from solarcal.model.known_physics import SkyContext, sun_directions
from solarcal.model.planned_day import Plan, PlannedStop
from solarcal.model.posterior import MechanismPosterior
from solarcal.model.prior import Prior
from solarcal.model.schedule import (
    Slots,
    after,
    best_schedule,
    gains,
    greedy_for_each,
    with_point,
)
from solarcal.model.year_ahead import YearAhead, year_ahead
from solarcal.model.year_grid import LOWEST_FORECAST_DEG
from solarcal.timescale import SECONDS_PER_DAY, format_utc
from solarcal.units import FloatArray

SLOT_S = 300.0
GAP_S = 600.0
"""A point with its three questions takes some minutes; nobody takes two within ten."""
STOP_STEP_S = 1800.0
MOST_POINTS = 20
NEAR_BEST = 1.10
WORTH_FEWER = 1.05
"""Where the tolerance is out of reach, points that improve the forecast less than this go."""
WORTH_A_POINT = 0.005
"""Part of the mean square that one more point must save to be considered at all."""


def plan(
    posterior: MechanismPosterior,
    context: SkyContext,
    at_utc_s: float,
    *,
    until_utc_s: float | None = None,
    points: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    tolerance_deg: float = TOLERANCE_DEG,
    prior: Prior | None = None,
) -> Plan:
    """Plan the rest of the solar day that ``at_utc_s`` lies in.

    Parameters
    ----------
    posterior
        Of a fit, or ``prior_knowledge`` before the first point.
    until_utc_s
        The technician must leave then.
    points
        Exactly so many more, where the day has room; None: as many as are worth taking.
    struck
        Intervals (from, to) in which no point can be taken: cloud, lunch.
    prior
        Whose spreads are the units of the arithmetic; never changes the answer.
    """
    unit = (prior or Prior()).sigma_array()
    year = year_ahead(posterior, context, unit)
    slots = day_slots(posterior, context, at_utc_s, unit, until_utc_s, struck)
    covariance = posterior.covariance / np.outer(unit, unit)
    now = PlannedStop(at_utc_s, (), *year.expected(covariance))
    most = MOST_POINTS if points is None else points
    if len(slots) == 0 or most < 1:
        return _concluded(now, (), now, at_utc_s, tolerance_deg, year, covariance)

    ends_s = _ends(slots, at_utc_s)
    orders = greedy_for_each(
        slots,
        covariance,
        year.weight,
        most,
        np.array(ends_s),
        least_gain=WORTH_A_POINT if points is None else 0.0,
        floor=year.known_square,
    )
    stops = [
        _stop(end_s, slots, chosen, year, covariances[-1] if covariances else covariance)
        for end_s, (chosen, covariances) in zip(ends_s, orders, strict=True)
    ]
    pick = _pick([now, *stops], tolerance_deg)
    if pick == 0:
        return _concluded(now, tuple(stops), now, at_utc_s, tolerance_deg, year, covariance)
    pick -= 1
    reached = stops[pick].year_p95_deg
    aim = tolerance_deg if reached <= tolerance_deg else WORTH_FEWER * reached
    chosen, covariances = orders[pick]
    count = len(chosen) if points is not None else _fewest(covariances, year, aim)
    if count:
        shorter = _stop(stops[pick].stop_utc_s, slots, chosen[:count], year, covariances[count - 1])
        stops[pick] = _polished(slots, covariance, year, shorter, aim)
    return _concluded(now, tuple(stops), stops[pick], at_utc_s, tolerance_deg, year, covariance)


def prior_knowledge(prior: Prior, noise_deg: float = 0.03) -> MechanismPosterior:
    """What is known before the first point, as a posterior to plan with."""
    covariance = np.diag(prior.sigma_array() ** 2)
    return MechanismPosterior(
        weights=np.array([chance for _, chance in prior.widths]),
        means=np.tile(prior.mean_array(), (len(prior.widths), 1)),
        covariances=np.stack([factor**2 * covariance for factor, _ in prior.widths]),
        noise_deg=np.full(len(prior.widths), noise_deg),
    )


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
) -> Slots:
    """Every few minutes of the rest of the solar day with the Sun high enough and in reach."""
    since_s = (at_utc_s - context.first_midnight_utc_s) % SECONDS_PER_DAY
    end_s = at_utc_s + SECONDS_PER_DAY - since_s
    if until_utc_s is not None:
        if until_utc_s < at_utc_s:
            raise ConfigurationError("the plan must end after it begins")
        end_s = min(end_s, until_utc_s)
    times = at_utc_s + slot_s * np.arange(int((end_s - at_utc_s) / slot_s) + 1.0)
    sun = sun_directions(context, times)
    open_ = sun.elevation_deg > LOWEST_FORECAST_DEG
    if context.limits is not None:
        open_ &= context.limits.distance_deg(sun.ideal1_deg, sun.ideal2_deg) >= 0.0
    for from_s, to_s in struck:
        open_ &= (times < from_s) | (times > to_s)
    true1, true2 = sun.true1_deg[open_], sun.true2_deg[open_]
    rows = np.zeros((0, 2, 6))
    if len(true1):
        errors, slopes = errors_and_slopes(posterior.mean, context.geometry, true1, true2)
        sky = np.stack((own_sine(posterior.mean, true2, errors[1]), np.ones(len(true1))))
        weighted = slopes * sky * (unit / posterior.noise_rms_deg)[:, np.newaxis, np.newaxis]
        rows = np.ascontiguousarray(np.transpose(weighted, (2, 1, 0)))
    return Slots(times[open_], rows, gap_s)


def _ends(slots: Slots, at_utc_s: float) -> list[float]:
    """Every half hour of the clock from now to the last slot, and the last slot itself."""
    begin_s = max(at_utc_s, float(slots.utc_s[0]))
    first = STOP_STEP_S * math.ceil((begin_s + 1.0) / STOP_STEP_S)
    last = float(slots.utc_s[-1])
    ends = np.arange(first, last, STOP_STEP_S).tolist()
    return [*ends, last]


def _stop(
    end_s: float, slots: Slots, chosen: Sequence[int], year: YearAhead, covariance: FloatArray
) -> PlannedStop:
    times = tuple(float(slots.utc_s[i]) for i in sorted(chosen))
    return PlannedStop(end_s, times, *year.expected(covariance))


def _pick(stops: Sequence[PlannedStop], tolerance_deg: float) -> int:
    """Earliest that reaches the tolerance, else earliest within a tenth of the best."""
    limit = max(tolerance_deg, NEAR_BEST * min(stop.year_p95_deg for stop in stops))
    return next(i for i, stop in enumerate(stops) if stop.year_p95_deg <= limit)


def _fewest(covariances: Sequence[FloatArray], year: YearAhead, aim_deg: float) -> int:
    """How many of the points, added greedily, come below the aim."""
    low, high = 0, len(covariances)
    while high - low > 1:
        middle = (low + high) // 2
        if year.expected(covariances[middle - 1])[1] <= aim_deg:
            high = middle
        else:
            low = middle
    return high


def _polished(
    slots: Slots,
    covariance: FloatArray,
    year: YearAhead,
    stop: PlannedStop,
    aim_deg: float,
) -> PlannedStop:
    """The stop with its points exchanged for the best, and one fewer where that will do.

    Exchanges lower the rms; should the 95th percentile miss the aim by a hair, the stop stays.
    """
    best = stop
    for points in range(stop.points, 0, -1):
        schedule = best_schedule(slots, covariance, year.weight, points, until_s=stop.stop_utc_s)
        left = after(slots, covariance, schedule)
        found = _stop(stop.stop_utc_s, slots, schedule, year, left)
        if found.year_p95_deg > max(aim_deg, stop.year_p95_deg):
            break
        best = found
        if points < stop.points or found.year_p95_deg > aim_deg:
            break
    return best


def _concluded(
    now: PlannedStop,
    stops: tuple[PlannedStop, ...],
    recommended: PlannedStop,
    at_utc_s: float,
    tolerance_deg: float,
    year: YearAhead,
    covariance: FloatArray,
) -> Plan:
    best = min(stop.year_p95_deg for stop in (now, *stops))
    back = None
    if recommended.year_p95_deg <= tolerance_deg:
        if recommended.points:
            sentence = (
                f"{recommended.points} more point{'s' if recommended.points > 1 else ''} until "
                f"{_clock(recommended.stop_utc_s)} reach {recommended.year_p95_deg:.3f} deg; "
                f"next at {_clock(recommended.times_utc_s[0])}"
            )
        else:
            sentence = f"no more points are needed: {now.year_p95_deg:.3f} deg expected"
    else:
        back = come_back(year, covariance, at_utc_s, tolerance_deg)
        when = (
            "no later day of the year alone would reach the tolerance"
            if back is None
            else f"come back around {format_utc(back, 0)[:10]}"
        )
        sentence = f"today cannot do better than {best:.3f} deg; {when}"
    return Plan(at_utc_s, tolerance_deg, now, stops, recommended, back, sentence)


def come_back(
    year: YearAhead, covariance: FloatArray, at_utc_s: float, tolerance_deg: float
) -> float | None:
    """Mean solar noon of the next day of the year's grid whose points reach the tolerance.

    The points are the best half hours of that day added to what is known today; noise alike.
    """
    if float(np.sqrt(year.known_square)) > tolerance_deg:
        return None
    days = len(year.day_rows)
    left = np.broadcast_to(covariance, (days, 6, 6)).copy()
    free = year.day_open.copy()
    for _ in range(MOST_POINTS):
        gain = np.where(free, gains(year.day_rows, left, year.weight), -np.inf)
        best = np.argmax(gain, axis=1)
        possible = free[np.arange(days), best]
        row = np.where(
            possible[:, np.newaxis, np.newaxis], year.day_rows[np.arange(days), best], 0.0
        )
        left = with_point(left, row)
        free[np.arange(days), best] = False
    next_s = year.noons_after(at_utc_s)
    for day in np.argsort(next_s):
        if year.expected(left[day])[1] <= tolerance_deg:
            return float(next_s[day])
    return None


def _clock(utc_s: float) -> str:
    return f"{format_utc(utc_s, 0)[11:16]} UTC"
