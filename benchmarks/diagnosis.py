"""What a diagnosis finds, how small, and how often it cries wolf; exact geometry, fixed seeds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.judgement_trackers import (
    NOISE_DEG,
    context_of,
    daylight_s,
    measured,
    random_mechanism,
)
from solarcal.model.earlier_sessions import Merged, merge_sessions
from solarcal.model.evidence.clocks import ClockSetting, clock_findings
from solarcal.model.evidence.read_outs import Loss, missed_counts_finding, undo_losses
from solarcal.model.evidence.residuals import diagnose
from solarcal.model.f_tests import PointsTested, f_probability, norms_beside
from solarcal.model.finding import Finding
from solarcal.model.methods import fit_exact
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.model.terms import TERMS
from solarcal.mount.mechanism import Mechanism
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray, wrap_deg

SEEDS = 100
POINTS = 12
EQUINOX, JUNE, DECEMBER = 79, 171, 354
DAYS: dict[str, tuple[int, ...]] = {
    "June": (JUNE,),
    "equinox": (EQUINOX,),
    "December": (DECEMBER,),
    "June + December": (JUNE, DECEMBER),
}
COUNTS_PER_DEG = 1000.0
GEOMETRIES = ("azel", "tiltroll-ew")
GOAL = 1.5
COLLIMATION, SQUARENESS, SAG, AIR = "C", "N", "SAG", "REFRACTION"
LARGEST = {COLLIMATION: 2.0, SQUARENESS: 2.0, SAG: 3.0, AIR: 10.0}
"""No mount has more; where even the ideal test needs more, there is nothing to be found."""


def kind_of(cause: str) -> str:
    """The kind of finding a term makes."""
    tested = TERMS[cause].tested
    assert tested is not None
    return tested.finding


@dataclass(frozen=True)
class MadeUpDay:
    """Points of one made-up tracker and the sides its axes came from."""

    context: SkyContext
    points: Points
    approach: NDArray[np.int_]

    def diagnose(self, losses: Sequence[Loss] = ()) -> tuple[Finding, ...]:
        return diagnose(fit_exact(self.points, self.context), self.approach, losses=losses)

    def found(self) -> list[Finding]:
        return [finding for finding in self.diagnose() if finding.certainty == "found"]


def changed(points: Points, more1_deg: FloatArray, more2_deg: FloatArray) -> Points:
    """The points with axis errors added."""
    return Points(
        geometry=points.geometry,
        ax1_deg=points.ax1_deg,
        ax2_deg=points.ax2_deg,
        err1_deg=points.err1_deg + more1_deg,
        err2_deg=points.err2_deg + more2_deg,
        labels=points.labels,
        utc_s=points.utc_s,
    )


def made_up_day(
    geometry: str,
    days: Sequence[int],
    seed: int,
    *,
    cause: str = "",
    amount: float = 0.0,
    backlash_deg: float = 0.0,
    noise_deg: float = NOISE_DEG,
) -> MadeUpDay:
    """POINTS from first to last light of each day, by a random tracker with one thing wrong.

    With backlash a third of the points, chosen at random, is approached from the wrong side.
    """
    context, rng = context_of(geometry), np.random.default_rng([17, seed])
    times = np.concatenate([np.linspace(*daylight_s(context, day), POINTS) for day in days])
    exact = TERMS[cause].exact if cause in (COLLIMATION, SQUARENESS, SAG) else None
    extra = {} if exact is None else {exact: amount}
    mechanism: Mechanism = msgspec.structs.replace(random_mechanism(rng), **extra)
    points = measured(context, mechanism, times, rng, noise_deg)
    if cause == AIR:
        points = changed(points, *missing_air(context, mechanism, points, amount))
    approach = np.ones((len(points), 2), dtype=np.int_)
    if backlash_deg:
        approach[rng.choice(len(points), len(points) // 3, replace=False)] = -1
        points = changed(points, *(0.5 * backlash_deg * approach.T))
    return MadeUpDay(context, points, approach)


def missing_air(
    context: SkyContext, mechanism: Mechanism, points: Points, amount: float
) -> tuple[FloatArray, FloatArray]:
    """What axis errors become when the Sun stands higher by so many standard atmospheres."""
    geometry = context.geometry
    azimuth, zenith = geometry.horizontal_from_axes(points.ax1_deg, points.ax2_deg)
    air = zenith - apparent_zenith_deg(zenith, "hughes", context.air)
    ax1, ax2 = geometry.axes_from_horizontal(azimuth, zenith - amount * air)
    there = mechanism.errors_deg(geometry, ax1, ax2)
    here = mechanism.errors_deg(geometry, points.ax1_deg, points.ax2_deg)
    return (
        wrap_deg(there[0] + ax1 - here[0] - points.ax1_deg),
        there[1] + ax2 - here[1] - points.ax2_deg,
    )


def rate(test: Callable[[int], bool], seeds: int = SEEDS) -> float:
    return sum(test(seed) for seed in range(seeds)) / seeds


def clean_fires(geometry: str, days: Sequence[int], seeds: int = SEEDS) -> float:
    """Share of clean runs in which anything at all is found."""
    return rate(lambda seed: bool(made_up_day(geometry, days, seed).found()), seeds)


def backlash_found(geometry: str, days: Sequence[int], seed: int) -> bool:
    day = made_up_day(geometry, days, seed, backlash_deg=0.15)
    return any(finding.kind == "backlash" for finding in day.found())


def bad_point_found(geometry: str, days: Sequence[int], seed: int) -> bool:
    day = made_up_day(geometry, days, seed)
    rng = np.random.default_rng([19, seed])
    index, way = int(rng.integers(len(day.points))), rng.uniform(0.0, 2.0 * np.pi)
    more = np.zeros((2, len(day.points)))
    more[:, index] = 0.5 * np.cos(way), 0.5 * np.sin(way)
    more[0] /= np.sin(np.radians(day.points.ax2_deg))
    spoiled = MadeUpDay(day.context, changed(day.points, *more), day.approach)
    return any(f.kind == "bad_point" and f.labels == (index + 1,) for f in spoiled.found())


def missed_counts_found(geometry: str, days: Sequence[int], seed: int) -> tuple[bool, bool]:
    """0.3 deg lost between the check before the first point and one after the last: whether it is
    named with its axis; whether nothing else is found and its moment is not wrong by a point."""
    day = made_up_day(geometry, days, seed)
    rng = np.random.default_rng([23, seed])
    axis, first = int(rng.integers(2)), int(rng.integers(1, len(day.points)))
    more = np.zeros((2, len(day.points)))
    more[axis, first:] = 0.3
    counts = round(0.3 * COUNTS_PER_DEG + rng.integers(-2, 3))
    loss = Loss(axis + 1, counts / COUNTS_PER_DEG, day.points.labels)
    spoiled = MadeUpDay(day.context, changed(day.points, *more), day.approach)
    place = fit_exact(spoiled.points, day.context).posterior.mean
    _, when = undo_losses(spoiled.points, day.context, place, [loss])
    finding = missed_counts_finding(2, counts, loss, when[0])
    named = finding.subject == f"axis {axis + 1}"
    others = [f for f in spoiled.diagnose([loss]) if f.certainty == "found"]
    told = when[0].first_after
    dated = not when[0].sure or (told is not None and abs(told - (first + 1)) <= 1)
    return named, dated and not others


def drift_found(seed: int, drift_s_per_day: float = 40.0) -> bool:
    """A clock set in the morning, compared at 12 points of 9 hours with 20 ms of scatter."""
    rng = np.random.default_rng([29, seed])
    times = np.linspace(0.0, 9 * 3600.0, POINTS)
    difference = drift_s_per_day * times / SECONDS_PER_DAY + 0.02 * rng.standard_normal(POINTS)
    setting = ClockSetting(-600.0, 7.0, float(-0.2 + 0.02 * rng.standard_normal()))
    kinds = [f.kind for f in clock_findings(times.tolist(), (difference).tolist(), [setting])]
    return ("clock_drift" in kinds) == bool(drift_s_per_day) and "clock_step" not in kinds


def ideal_amount(geometry: str, days: Sequence[int], cause: str) -> float:
    """The amount a single F-test at 5 % finds with 90 % power, knowing what to look for."""
    day = made_up_day(geometry, days, 0, noise_deg=1e-9)
    model = PointsTested.of(day.points, day.context)
    rows = model.rows(np.zeros(6), {})
    spare = 2 * len(day.points) - 7
    return (
        NOISE_DEG / float(norms_beside(rows.six, rows.columns([cause]))[0]) * noncentrality(spare)
    )


def noncentrality(spare: int, level: float = 0.05, power: float = 0.9) -> float:
    """By chance draws, seeded: |t| of so many degrees of freedom beyond its limit."""
    rng = np.random.default_rng(31)
    normal = rng.standard_normal(400_000)
    scale = np.sqrt(rng.chisquare(spare, 400_000) / spare)
    low, high = 0.0, 30.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f_probability(middle**2, 1, spare) > level else (low, middle)
    limit = low
    # |normal + d| > limit * scale in 90 of 100 draws: the other tail is negligible.
    return float(np.quantile(limit * scale - normal, power))


def smallest_found(geometry: str, days: Sequence[int], cause: str, ideal: float) -> float:
    """Amount found with 90 % power, alone or among the causes named; inf beyond 1.6 ideals."""

    def power(amount: float) -> float:
        return rate(
            lambda seed: any(
                kind_of(cause) in finding.causes
                for finding in made_up_day(geometry, days, seed, cause=cause, amount=amount).found()
            )
        )

    low, high = 0.9, 1.6
    if power(high * ideal) < 0.9:
        return float("inf")
    for _ in range(5):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if power(middle * ideal) >= 0.9 else (middle, high)
    return high * ideal


def cross_axis_named(cause: str, amount: float, seed: int) -> tuple[bool, bool]:
    """On an azel June day: by its own name, and as a cross-axis term that could be either."""
    found = made_up_day("azel", (JUNE,), seed, cause=cause, amount=amount).found()
    kinds = {finding.kind for finding in found}
    return kind_of(cause) in kinds, "cross_axis" in kinds


def merged(
    seed: int, *, lean_deg: float = 0.0, zero_deg: float = 0.0, geometry: str = "azel"
) -> Merged:
    """Ten points in June and six in July; lean to the north and zero of axis 1 changed between."""
    context, rng = context_of(geometry), np.random.default_rng([37, seed])
    after = random_mechanism(rng)
    before = msgspec.structs.replace(after, P1=after.P1 - lean_deg, P2=after.P2 - zero_deg)
    parts = [
        measured(context, mechanism, np.linspace(*daylight_s(context, day), n), rng)
        for mechanism, day, n in ((before, JUNE, 10), (after, JUNE + 30, 6))
    ]
    return merge_sessions(parts, context)


def _met(met: bool) -> str:
    return "met" if met else "NOT MET"


def run() -> list[str]:
    return [*named(), *powers(), *merges()]


def named() -> list[str]:
    """Clean runs, and what is fired and named with one thing wrong."""
    lines = []
    for geometry in GEOMETRIES:
        for season, days in DAYS.items():
            fired = clean_fires(geometry, days)
            lines.append(
                f"{geometry}, {season}, clean: anything found in {100 * fired:.0f} of 100 runs "
                f"(goal at most 5: {_met(fired <= 0.05)})"
            )
    for geometry in GEOMETRIES:
        for season, days in DAYS.items():
            shares = {
                "backlash 0.15 deg": rate(lambda s, g=geometry, d=days: backlash_found(g, d, s)),
                "one point off by 0.5 deg": rate(
                    lambda s, g=geometry, d=days: bad_point_found(g, d, s)
                ),
            }
            counts = np.mean(
                [missed_counts_found(geometry, days, seed) for seed in range(SEEDS)], axis=0
            )
            shares["0.3 deg of missed counts"] = float(counts[0])
            for what, share in shares.items():
                lines.append(
                    f"{geometry}, {season}, {what}: named in {100 * share:.0f} of 100 "
                    f"(goal 90: {_met(share >= 0.9)})"
                )
            lines.append(
                f"{geometry}, {season}: missed counts not dated wrongly and nothing else found in "
                f"{100 * counts[1]:.0f} of 100"
            )
    drift, still = rate(drift_found), rate(lambda seed: drift_found(seed, 0.0))
    lines.append(
        f"unit drift 40 s/day: named in {100 * drift:.0f} of 100 (goal 90: {_met(drift >= 0.9)}); "
        f"a steady clock left alone in {100 * still:.0f}"
    )
    for cause, name in ((COLLIMATION, "collimation"), (SQUARENESS, "axes not square")):
        for amount in (0.6, 0.3):
            own, either = np.mean(
                [cross_axis_named(cause, amount, seed) for seed in range(SEEDS)], axis=0
            )
            share = own if amount == 0.6 else either
            lines.append(
                f"azel, June, {name} {amount:g} deg: by name in {100 * own:.0f}, as 'cross-axis "
                f"term' in {100 * either:.0f} of 100 (goal 90 "
                f"{'by name' if amount == 0.6 else 'cross-axis'}: {_met(share >= 0.9)})"
            )
    return lines


def merges() -> list[str]:
    """Two sessions of one unit, with and without a change between them."""
    lines = []
    for geometry in GEOMETRIES:
        for what, lean, zero, goal in (
            ("unchanged", 0.0, 0.0, "same"),
            ("lean changed by 0.2 deg", 0.2, 0.0, "tower"),
            ("zero changed by 0.2 deg", 0.0, 0.2, "zeros"),
        ):
            share = rate(
                lambda s, g=geometry, a=lean, z=zero, c=goal: (
                    merged(s, lean_deg=a, zero_deg=z, geometry=g).change == c
                )
            )
            lines.append(
                f"{geometry}, two sessions, {what}: judged '{goal}' in {100 * share:.0f} of 100"
            )
    return lines


def powers() -> list[str]:
    """The smallest amount of each cause found with 90 % power, beside the ideal single F-test's."""
    lines = []
    for geometry in GEOMETRIES:
        for season, days in DAYS.items():
            for cause, name in (
                (COLLIMATION, "collimation"),
                (SQUARENESS, "axes not square"),
                (SAG, "gravity sag"),
                (AIR, "refraction"),
            ):
                unit = "standard air" if cause == AIR else "deg"
                ideal = ideal_amount(geometry, days, cause)
                start = f"{geometry}, {season}, {name}: "
                if ideal > LARGEST[cause]:
                    lines.append(
                        f"{start}not to be found: an ideal F-test needs {ideal:.3g} {unit}"
                    )
                    continue
                found = smallest_found(geometry, days, cause, ideal)
                lines.append(
                    f"{start}{found:.3g} {unit} found with 90 % power, ideal F-test {ideal:.3g} "
                    f"(ratio {found / ideal:.2f}, goal {GOAL}: {_met(found <= GOAL * ideal)})"
                )
    return lines


if __name__ == "__main__":
    print("\n".join(run()))
