"""Do the bands hold what they promise? A thousand trackers, the noise scale unknown."""

import numpy as np

from benchmarks.judgement_trackers import (
    PLANS,
    POPULATION_PRIOR,
    context_of,
    measured,
    random_mechanism,
    random_times,
    true_year,
)
from solarcal.model.forecast import forecast
from solarcal.model.methods import DEFAULT_PRIOR, fit
from solarcal.model.prior import Prior
from solarcal.units import FloatArray

TRACKERS = 1000
LEVELS = (0.68, 0.95)
OWN_GOAL = ((0.60, 0.76), (0.91, 0.98))
DEFAULT_GOAL = ((0.60, 0.90), (0.90, 0.995))
WHAT = ("across", "along", "year rms", "year rms between two quantiles")


def coverage(
    geometry: str, n: int, hours: float, prior: Prior, *, trackers: int = TRACKERS, seed: int = 9
) -> FloatArray:
    """Share of trackers within the bands: (2 levels, 4), in the order of ``WHAT``.

    The error across and along at one random moment of the year lies in its central band; the
    year's rms, which has no lower side to be wrong on, below its quantile; the last column asks
    for both sides all the same.
    """
    context = context_of(geometry)
    held = np.zeros((2, 4))
    for index in range(trackers):
        rng = np.random.default_rng([seed, index])
        mechanism = random_mechanism(rng)
        points = measured(context, mechanism, random_times(context, rng, n, hours), rng)
        solution = fit(points, context, prior=prior)
        expected = forecast(solution)
        truth = true_year(context, mechanism, solution.coefficients())
        moment = int(rng.integers(len(truth.sky_deg)))
        draws = expected.errors.of()[:, :, moment]
        for row, level in zip(held, LEVELS, strict=True):
            low, high = np.quantile(draws, (0.5 - level / 2, 0.5 + level / 2), axis=0)
            actual = truth.axes_deg[:, moment]
            row[:2] += (low <= actual) & (actual <= high)
            tail = 0.5 - level / 2
            row[3] += (
                expected.year_rms_below_deg(tail)
                <= truth.rms_deg
                <= expected.year_rms_below_deg(1 - tail)
            )
            row[2] += truth.rms_deg <= expected.year_rms_below_deg(level)
    return held / trackers


def run(trackers: int = TRACKERS) -> list[str]:
    lines = []
    for name, prior, goals in (
        ("own prior", POPULATION_PRIOR, OWN_GOAL),
        ("default prior", DEFAULT_PRIOR, DEFAULT_GOAL),
    ):
        for geometry in ("azel", "tiltroll-ew"):
            for n, hours in PLANS:
                held = coverage(geometry, n, hours, prior, trackers=trackers)
                for shares, level, (low, high) in zip(held, LEVELS, goals, strict=True):
                    cells = ", ".join(
                        f"{what} {100 * share:.1f}{'' if low <= share <= high else ' (NOT MET)'}"
                        for what, share in zip(WHAT, shares.tolist(), strict=True)
                    )
                    lines.append(
                        f"{geometry}, {name}, {n} points: {100 * level:.0f} % bands hold "
                        f"{cells} % (goal {100 * low:.0f} to {100 * high:g})"
                    )
    return lines


if __name__ == "__main__":
    print("\n".join(run()))
