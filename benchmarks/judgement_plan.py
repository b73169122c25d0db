"""What planning the day is worth: against equal spacing, exchange search, and a routine."""

import numpy as np

from benchmarks.judgement_trackers import NOISE_DEG, context_of, daylight_s
from solarcal.model.known_physics import SkyContext
from solarcal.model.plan import day_slots, plan, prior_knowledge
from solarcal.model.posterior import MechanismPosterior
from solarcal.model.prior import PLAIN, Prior
from solarcal.model.schedule import (
    Slots,
    after,
    best_schedule,
    cost,
    exchanged,
    with_point,
)
from solarcal.model.year_ahead import YearAhead, year_ahead
from solarcal.timescale import format_utc
from solarcal.units import FloatArray

DATES = tuple(range(5, 365, 15))
COUNTS = (5, 8, 12)
HOURS = (5.0, 24.0)
TOLERANCE_DEG = 0.1
ROUTINE_S = 37 * 60.0
RANDOM_STARTS = 10
UNIT = Prior().sigma_array()


def knowledge_after(context: SkyContext, utc_s: float) -> MechanismPosterior:
    """Prior and one point at this moment: only its covariance matters to a plan."""
    before = prior_knowledge(Prior(widths=PLAIN), NOISE_DEG)
    slots = day_slots(before, context, utc_s, UNIT, utc_s + 1.0)
    covariance = with_point(np.eye(6), slots.rows[0]) * np.outer(UNIT, UNIT)
    return MechanismPosterior(
        before.weights, before.means, covariance[np.newaxis], before.noise_deg
    )


def compared(geometry: str, day: int, count: int, hours: float) -> tuple[float, float, float]:
    """Year rms, deg, of our schedule, of the exchange-optimised, and of equal spacing."""
    context = context_of(geometry)
    first, last = daylight_s(context, day)
    until = min(last, first + 3600.0 * hours)
    posterior = knowledge_after(context, first)
    slots = day_slots(posterior, context, first, UNIT, until)
    year = year_ahead(posterior, context, UNIT)
    start = posterior.covariance / np.outer(UNIT, UNIT)

    def rms(schedule_cost: float) -> float:
        return float(np.sqrt(year.known_square + schedule_cost))

    ours = best_schedule(slots, start, year.weight, count - 1)
    searched = _exchange_search(slots, start, year.weight, count - 1)
    equal = _equal_cost(posterior, context, year, first, until, count)
    return rms(cost(slots, start, year.weight, ours)), rms(searched), rms(equal)


def _exchange_search(slots: Slots, start: FloatArray, weight: FloatArray, count: int) -> float:
    """Best of many exchange descents from random schedules that keep the gap."""
    rng = np.random.default_rng(17)
    best = np.inf
    for _ in range(RANDOM_STARTS):
        chosen: list[int] = []
        while len(chosen) < count:
            free = np.flatnonzero(slots.free(chosen))
            if not len(free):
                chosen = []
                continue
            chosen.append(int(rng.choice(free)))
        best = min(best, cost(slots, start, weight, exchanged(slots, start, weight, chosen)))
    return best


def _equal_cost(
    posterior: MechanismPosterior,
    context: SkyContext,
    year: YearAhead,
    first: float,
    until: float,
    count: int,
) -> float:
    """Equal steps from the first point to the end, to the second, whatever the slots."""
    step = (until - first) / (count - 1)
    slots = day_slots(posterior, context, first, UNIT, until + 1.0, slot_s=step, gap_s=0.0)
    start = posterior.covariance / np.outer(UNIT, UNIT)
    left = after(slots, start, range(1, len(slots)))
    return float(np.sum(year.weight * left))


def to_tolerance(geometry: str, day: int) -> tuple[tuple[float, int] | None, ...]:
    """Hours from the first point and number of points to a forecast within the tolerance: by
    plan, and every 37 min; None where the day does not reach it."""
    context = context_of(geometry)
    first, last = daylight_s(context, day)
    posterior = knowledge_after(context, first)
    planned = plan(posterior, context, first, tolerance_deg=TOLERANCE_DEG)
    ours = None
    if planned.reaches:
        times = planned.recommended.times_utc_s
        ours = ((times[-1] - first) / 3600.0, len(times) + 1)

    year = year_ahead(posterior, context, UNIT)
    slots = day_slots(posterior, context, first, UNIT, last, slot_s=ROUTINE_S, gap_s=0.0)
    left = posterior.covariance / np.outer(UNIT, UNIT)
    routine = None
    for index in range(1, len(slots)):
        left = with_point(left, slots.rows[index])
        if year.expected(left)[1] <= TOLERANCE_DEG:
            routine = ((slots.utc_s[index] - first) / 3600.0, index + 1)
            break
    return ours, routine


def run() -> list[str]:
    lines = []
    for geometry in ("azel", "tiltroll-ew"):
        for hours in HOURS:
            for count in COUNTS:
                table = np.array([compared(geometry, day, count, hours) for day in DATES])
                beside = table[:, 0] / table[:, 1]
                gain = table[:, 2] / table[:, 0]
                met = beside.max() <= 1.02 and gain.min() >= 1.0 - 1e-9
                window = "the whole day" if hours > 12 else f"{hours:g} h"
                lines.append(
                    f"{geometry}, {count} points in {window}: year rms over an exchange search's "
                    f"at most {beside.max():.4f} (goal 1.02); equal spacing's over ours "
                    f"{gain.min():.3f} to {gain.max():.3f}, median {np.median(gain):.3f}: "
                    f"{'met' if met else 'NOT MET'}"
                )
        lines += _clock_lines(geometry)
    return lines


def _clock_lines(geometry: str) -> list[str]:
    results = {day: to_tolerance(geometry, day) for day in DATES}
    both = [(a, b) for a, b in results.values() if a is not None and b is not None]
    lines = []
    if both:
        hours = np.median([[a[0], b[0]] for a, b in both], axis=0)
        points = np.median([[a[1], b[1]] for a, b in both], axis=0)
        lines.append(
            f"{geometry}: first forecast within 0.1 deg after {hours[0]:.1f} h and {points[0]:.0f} "
            f"points by plan, {hours[1]:.1f} h and {points[1]:.0f} points every 37 min (medians of "
            f"{len(both)} dates that reach it both ways)"
        )
    context = context_of(geometry)
    for index, name in ((0, "by plan"), (1, "every 37 min")):
        missing = [day for day, result in results.items() if result[index] is None]
        names = ", ".join(
            format_utc(context.first_midnight_utc_s + 86400.0 * day, 0)[5:10] for day in missing
        )
        lines.append(
            f"{geometry}, {name}: {len(missing)} of {len(DATES)} dates cannot reach 0.1 deg"
            + (f": {names}" if names else "")
        )
    return lines


if __name__ == "__main__":
    print("\n".join(run()))
