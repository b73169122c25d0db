"""True year errors of 200 random trackers: manual, robust, and the bound for any method."""

import numpy as np

from benchmarks.judgement_trackers import (
    PLANS,
    context_of,
    measured,
    oracle,
    random_mechanism,
    random_times,
    true_year,
)
from solarcal.model.methods import fit
from solarcal.model.sky_context import Ideal
from solarcal.units import FloatArray

TRACKERS = 200
BESIDE_ORACLE_AT_5 = {"azel": 1.25, "tiltroll-ew": 1.45}
BELOW_MANUAL_AT_5 = {"azel": 2.5, "tiltroll-ew": 6.0}
AT_NOON_DEG = {"azel": 0.08, "tiltroll-ew": 0.25}


def year_errors(
    geometry: str,
    n: int,
    hours: float,
    *,
    trackers: int = TRACKERS,
    seed: int = 5,
    ideal: Ideal = "apparent",
    at_noon: bool = False,
) -> FloatArray:
    """(trackers, 3) true year rms in degrees of manual, robust, oracle."""
    context = context_of(geometry, ideal)
    rows = []
    for index in range(trackers):
        rng = np.random.default_rng([seed, index])
        mechanism = random_mechanism(rng)
        times = random_times(context, rng, n, hours, at_noon=at_noon)
        points = measured(context, mechanism, times, rng)
        answers = (
            fit(points, context, method="linear").coefficients(),
            fit(points, context).coefficients(),
            oracle(points, context),
        )
        rows.append([true_year(context, mechanism, answer).rms_deg for answer in answers])
    return np.array(rows)


def run() -> list[str]:
    lines = []
    for ideal in ("apparent", "solartrak"):
        for geometry in ("azel", "tiltroll-ew"):
            for n, hours in PLANS:
                errors = year_errors(geometry, n, hours, ideal=ideal)  # type: ignore[arg-type]
                lines.append(_line(f"{geometry}, {ideal}, {n} points in {hours:g} h", errors))
                lines += _goals(geometry, n, errors) if ideal == "apparent" else []
    for geometry in ("azel", "tiltroll-ew"):
        errors = year_errors(geometry, 5, 3.0, at_noon=True)
        goal = AT_NOON_DEG[geometry]
        lines.append(_line(f"{geometry}, 5 points in 3 h about noon", errors))
        lines.append(_said("median at most", float(np.median(errors[:, 1])), goal))
    return lines


def _line(name: str, errors: FloatArray) -> str:
    median, p95 = np.median(errors, axis=0), np.quantile(errors, 0.95, axis=0)
    cells = ", ".join(
        f"{method} {m:.4f} / {p:.4f}"
        for method, m, p in zip(("linear", "robust", "oracle"), median, p95, strict=True)
    )
    return f"{name}: median / 95 % of the true year rms, deg: {cells}"


def _goals(geometry: str, n: int, errors: FloatArray) -> list[str]:
    manual, robust, best = np.median(errors, axis=0)
    if n == 5:
        return [
            _said("  robust over oracle at most", robust / best, BESIDE_ORACLE_AT_5[geometry]),
            _said("  robust over manual at most", robust / manual, 1 / BELOW_MANUAL_AT_5[geometry]),
        ]
    if n == 13:
        p95 = np.quantile(errors, 0.95, axis=0)
        return [
            _said("  robust over oracle at most", robust / best, 1.15),
            _said("  median over manual's at most", robust / manual, 1.0),
            _said("  95 % over manual's at most", p95[1] / p95[0], 1.0),
        ]
    return []


def _said(what: str, value: float, goal: float) -> str:
    return f"{what} {goal:.3g}: {value:.3f} {'met' if value <= goal else 'NOT MET'}"


if __name__ == "__main__":
    print("\n".join(run()))
