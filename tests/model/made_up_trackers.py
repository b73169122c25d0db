"""Trackers on exact geometry for the tests of the judgement."""

import sys
from pathlib import Path

# The population of the benchmarks is the tests' too: one definition of "two hundred trackers".
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from benchmarks.judgement_trackers import (
    context_of,
    daylight_s,
    measured,
    random_mechanism,
    true_year,
)
from solarcal.model.forecast import Forecast
from solarcal.model.plan import Plan
from solarcal.model.points import Points
from solarcal.model.sky_context import Ideal, SkyContext
from solarcal.model.solution import Solution
from solarcal.model.verdict import Verdict, assess, conclude
from solarcal.mount.mechanism import Mechanism

__all__ = [
    "JUNE", "MARCH", "TRACKER", "context_of", "day_of", "judge", "measured", "random_mechanism",
    "true_year",
]  # fmt: skip

MARCH, JUNE, DECEMBER = 79, 171, 354
TRACKER = Mechanism(P1=0.7, P2=-0.5, P3=0.3, P4=1.2, P5=0.001, P6=-0.0005)


def day_of(
    geometry: str = "azel",
    n: int = 12,
    day: int = JUNE,
    *,
    mechanism: Mechanism = TRACKER,
    noise_deg: float = 0.03,
    seed: int = 1,
    ideal: Ideal = "apparent",
) -> tuple[SkyContext, Points]:
    """n points from first to last light of a day."""
    context = context_of(geometry, ideal)
    first, last = daylight_s(context, day)
    times = np.linspace(first, last, n) if n > 1 else np.array([0.5 * (first + last)])
    return context, measured(context, mechanism, times, np.random.default_rng(seed), noise_deg)


def judge(
    solution: Solution, expected: Forecast, *, planned: Plan | None = None, **beside
) -> Verdict:
    """The verdict on a fit, as an analysis comes to it."""
    return conclude(assess(solution, expected, **beside), expected, planned)
