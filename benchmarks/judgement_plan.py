"""What a schedule is worth: against equal spacing and against an exchange search.

How soon planned days are done is measured by ``judgement_stopping``.
"""

import numpy as np

from benchmarks.judgement_trackers import NOISE_DEG, context_of, daylight_s
from solarcal.model.more_points import YearAhead, year_ahead
from solarcal.model.prior import PLAIN, MechanismPosterior, Prior
from solarcal.model.schedule import (
    Slots,
    after,
    best_schedule,
    cost,
    day_slots,
    exchanged,
    with_point,
)
from solarcal.model.sky_context import SkyContext
from solarcal.units import FloatArray

DATES = tuple(range(5, 365, 15))
COUNTS = (5, 8, 12)
HOURS = (5.0, 24.0)
RANDOM_STARTS = 10
UNIT = Prior().sigma_array()


def prior_knowledge(prior: Prior, noise_deg: float = 0.03) -> MechanismPosterior:
    """What is known before the first point, as a posterior to plan with."""
    covariance = np.diag(prior.sigma_array() ** 2)
    return MechanismPosterior(
        weights=np.array([chance for _, chance in prior.widths]),
        means=np.tile(prior.mean_array(), (len(prior.widths), 1)),
        covariances=np.stack([factor**2 * covariance for factor, _ in prior.widths]),
        noise_deg=np.full(len(prior.widths), noise_deg),
    )


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
            free = np.flatnonzero(~slots.too_near()[chosen].any(axis=0))
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
    return lines


if __name__ == "__main__":
    print("\n".join(run()))
