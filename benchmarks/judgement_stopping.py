"""Days looked at after every point: is `done` true, and when does it come?

Days of made-up trackers in a world that shares nothing with the program (``judgement_world``), each
walked through three times: points when ``plan`` says, every 37 minutes, every 20 minutes. After
each point the program is asked as on the screen, and the true year of the first ``done`` is looked
up. A second table compares the year's error with the Bayes bound.

Hard days are half as many, at 45 N. Two hundred days take half an hour on two cores.

    python -m benchmarks.judgement_stopping [--days N] [--latitudes 52,12] [--mounts azel,polar]
        [--only clean|hard|bound] [--processes 2]
"""

import argparse
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from statistics import median

import numpy as np

from benchmarks.judgement_world import (
    CLEAN,
    HARD,
    MOUNTS,
    Array,
    Kind,
    MeasuredPoint,
    Place,
    Tracker,
    bayes_bound,
    daylight_s,
    exact_errors,
    measure,
    sun_enu,
    true_p95_deg,
    true_rms_deg,
    wrapped,
)
from benchmarks.timing import table
from solarcal.errors import SolarcalError
from solarcal.model.analysis import Analysis, analyse
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.mount.formula import correction_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.site import Site
from solarcal.stopping_rule import StoppingRule

TOLERANCE_DEG = 0.1
RULE = StoppingRule(TOLERANCE_DEG)
FEWEST = 3
LATITUDES = (52.0, 12.0, -33.0)
HARD_LATITUDE = 45.0
PLANNED = "plan"
EVERY_MIN = {"37 min": 37.0, "20 min": 20.0}
BOUND_PLANS = ((5, 3.0), (13, 9.0))
FALSE_GOAL, MISFIT_GOAL, BANDS_GOAL, BOUND_GOAL = 0.05, 0.05, (0.60, 0.90), 1.10


@dataclass(frozen=True)
class Day:
    """How one walk through a day went; hours from the first point, None where never done."""

    hours: float | None
    points: int
    false: bool
    misfit: bool
    within: tuple[bool, bool] | None
    reasons: str = ""


def context_of(place: Place) -> SkyContext:
    mount = MountGeometry(place.mount, place.latitude_deg, place.centre_deg)
    return SkyContext(Site(place.latitude_deg, 0.0), mount)


def points_of(place: Place, points: Sequence[MeasuredPoint]) -> Points:
    columns = np.array([(p.ax1_deg, p.ax2_deg, p.err1_deg, p.err2_deg, p.utc_s) for p in points]).T
    return Points(
        geometry=context_of(place).geometry,
        ax1_deg=columns[0],
        ax2_deg=columns[1],
        err1_deg=columns[2],
        err2_deg=columns[3],
        utc_s=columns[4],
    )


def day_of(place: Place, seed: Sequence[int]) -> tuple[int, np.random.Generator]:
    """A random day with four hours of Sun at least, and what is random of it."""
    rng = np.random.default_rng(seed)
    while True:
        day = int(rng.integers(365))
        first, last = daylight_s(place, day)
        if last - first > 4 * 3600.0:
            return day, rng


def walk(place: Place, kind: Kind, schedule: str, seed: Sequence[int]) -> Day:
    """A day until the first ``done``, or until it is over."""
    day, rng = day_of(place, seed)
    tracker = kind.tracker(rng)
    first, last = daylight_s(place, day)
    # A point at the same minute has the same noise whichever schedule asks for it.
    grain = int(rng.integers(1 << 30))
    context = context_of(place)
    # A clock that may be off by seconds is known to be: the system says it is not synchronised.
    beliefs = RULE.unmodelled.with_clock(kind.clock_s) if kind.clock_s else RULE.unmodelled
    rule = StoppingRule(TOLERANCE_DEG, unmodelled=beliefs)
    points: list[MeasuredPoint] = []
    judged: Analysis | None = None
    now: float | None = first
    misfit, why = False, ""
    while now is not None and now <= last:
        noise = np.random.default_rng([grain, int(now - first) // 60])
        points.append(measure(place, tracker, kind, now, noise))
        taken = points_of(place, points)
        at = points[-1].utc_s if schedule == PLANNED else None
        if len(points) >= FEWEST or schedule == PLANNED:
            judged = analyse(taken, context, rule=rule, at_utc_s=at)
            state = judged.verdict.state if len(points) >= FEWEST else "continue"
            if state == "does_not_fit" and not misfit:
                misfit, why = True, judged.verdict.reasons[0]
            if state == "done":
                uploaded = np.array(judged.solution.coefficients().as_tuple())
                return Day(
                    (now - first) / 3600.0,
                    len(points),
                    true_p95_deg(place, tracker, uploaded) > TOLERANCE_DEG,
                    misfit,
                    _within(place, tracker, judged, rng),
                    why,
                )
        now = _next(schedule, now, judged, tracker)
    within = None if judged is None else _within(place, tracker, judged, rng)
    return Day(None, len(points), False, misfit, within, why)


def _next(schedule: str, now: float, judged: Analysis | None, tracker: Tracker) -> float | None:
    if schedule != PLANNED:
        return now + 60.0 * EVERY_MIN[schedule]
    assert judged is not None
    assert judged.plan is not None
    due = judged.plan.next_point_utc_s
    # The plan is in the laptop's time.
    return None if due is None else max(due - tracker.clock_s, now + 60.0)


def _within(
    place: Place, tracker: Tracker, judged: Analysis, rng: np.random.Generator
) -> tuple[bool, bool]:
    """Whether the error along each of a few moments lies in the 68 % and the 95 % band."""
    expected = judged.forecast
    moment = int(rng.integers(len(expected.grid)))
    native = place.native(sun_enu(place.latitude_deg, expected.grid.utc_s[moment : moment + 1]))
    ax1, ax2 = place.angles(native)
    driven = correction_deg(judged.solution.coefficients(), ax1, ax2)
    e1, e2 = exact_errors(place, tracker, native)
    own2 = np.radians(ax2 + e2 - tracker.values[3] + tracker.values[5] * ax2)
    actual = np.array((wrapped(driven[0] - e1)[0] * np.sin(own2[0]), (driven[1] - e2)[0]))
    axis = int(rng.integers(2))
    held = []
    for level in (0.68, 0.95):
        tail = 0.5 * (1.0 - level)
        low, high = np.quantile(expected.errors.of()[:, axis, moment], (tail, 1.0 - tail))
        held.append(bool(low <= actual[axis] <= high))
    return held[0], held[1]


@dataclass(frozen=True)
class Cell:
    """One kind of day at one place, walked by one schedule."""

    place: Place
    kind: Kind
    schedule: str
    days: tuple[Day, ...]

    @property
    def name(self) -> str:
        side = "S" if self.place.latitude_deg < 0 else "N"
        return f"{self.place.mount} {abs(self.place.latitude_deg):g} {side}"

    @property
    def done(self) -> list[Day]:
        return [day for day in self.days if day.hours is not None]

    @property
    def false(self) -> float:
        return sum(day.false for day in self.days) / len(self.days)

    @property
    def misfit(self) -> float:
        return sum(day.misfit for day in self.days) / len(self.days)

    @property
    def within(self) -> tuple[float, float]:
        held = [day.within for day in self.days if day.within is not None]
        return tuple(np.mean(held, axis=0).tolist())  # type: ignore[return-value]

    def row(self) -> tuple[str, ...]:
        done = self.done
        hours = f"{median(d.hours for d in done if d.hours is not None):.2f}" if done else "-"
        count = f"{median(d.points for d in done):g}" if done else "-"
        clean = self.kind == CLEAN
        missed = [
            "false" if self.false > FALSE_GOAL else "",
            "misfit" if clean and self.misfit > MISFIT_GOAL else "",
            "bands"
            if not clean and any(a < b for a, b in zip(self.within, BANDS_GOAL, strict=True))
            else "",
        ]
        return (
            self.kind.name,
            self.name,
            self.schedule,
            f"{100 * len(done) / len(self.days):.0f}",
            f"{100 * self.false:.1f}",
            f"{100 * self.misfit:.1f}",
            hours,
            count,
            " / ".join(f"{100 * share:.0f}" for share in self.within),
            " ".join(word for word in missed if word) or "met",
        )


HEAD = (
    "days", "place", "points", "done %", "false %", "misfit %", "hours", "n", "bands %", "goals",
)  # fmt: skip


def _cell(job: tuple[Place, Kind, str, int]) -> Cell:
    place, kind, schedule, days = job
    seeds = [(23, MOUNTS.index(place.mount), int(place.latitude_deg) + 90, i) for i in range(days)]
    return Cell(place, kind, schedule, tuple(walk(place, kind, schedule, seed) for seed in seeds))


def paired_line(cells: Iterable[Cell]) -> str:
    """Days that both ways reach: how plan compares with every 20 min, tracker by tracker."""
    by = {cell.schedule: cell for cell in cells}
    if PLANNED not in by or "20 min" not in by:
        return ""
    pairs = [
        (a, b)
        for a, b in zip(by[PLANNED].days, by["20 min"].days, strict=True)
        if a.hours is not None and b.hours is not None
    ]
    if not pairs:
        return f"{by[PLANNED].name}: no day reached both ways"
    hours = np.array([(a.hours, b.hours) for a, b in pairs], dtype=float)
    points = np.array([(a.points, b.points) for a, b in pairs])
    gain = hours[:, 0] - hours[:, 1]
    return (
        f"{by[PLANNED].name}: of {len(pairs)} days reached both ways plan takes "
        f"{np.mean(gain):+.2f} h (median {np.median(gain):+.2f}) and {np.mean(points[:, 0]):.1f} "
        f"points against {np.mean(points[:, 1]):.1f}"
    )


def bound(job: tuple[Place, int, float, int]) -> tuple[str, ...]:
    """Median true year rms of the robust fit over that of the Bayes bound."""
    place, n, length, days = job
    errors: list[tuple[float, float]] = []
    for index in range(days):
        day, rng = day_of(place, (29, MOUNTS.index(place.mount), n, index))
        first, last = daylight_s(place, day)
        tracker = CLEAN.tracker(rng)
        stretch = min(3600.0 * length, last - first)
        begin = first + rng.random() * (last - first - stretch)
        times: Array = begin + np.linspace(0.0, stretch, n)
        points = [measure(place, tracker, CLEAN, float(t), rng) for t in times]
        try:
            judged = analyse(points_of(place, points), context_of(place))
        except SolarcalError:
            continue
        ours = np.array(judged.solution.coefficients().as_tuple())
        best = bayes_bound(place, points)
        errors.append((true_rms_deg(place, tracker, ours), true_rms_deg(place, tracker, best)))
    ours_deg, best_deg = np.median(errors, axis=0).tolist()
    ratio = ours_deg / best_deg
    name = f"{place.mount} {place.latitude_deg:g}"
    return (
        name, f"{n}", f"{length:g}", f"{ours_deg:.4f}", f"{best_deg:.4f}", f"{ratio:.3f}",
        "met" if ratio <= BOUND_GOAL else "NOT MET",
    )  # fmt: skip


def run(
    days: int = 200,
    latitudes: Sequence[float] = LATITUDES,
    mounts: Sequence[str] = MOUNTS,
    only: str | None = None,
    processes: int = 2,
    schedules: Sequence[str] = (PLANNED, *EVERY_MIN),
    hard: Sequence[str] = tuple(kind.name for kind in HARD),
) -> list[str]:
    lines: list[str] = []
    clean_places = [Place(mount, latitude) for latitude in latitudes for mount in mounts]
    hard_places = [Place(mount, HARD_LATITUDE) for mount in mounts]
    jobs: list[tuple[Place, Kind, str, int]] = []
    if only in (None, "clean"):
        jobs += [(place, CLEAN, way, days) for place in clean_places for way in schedules]
    if only in (None, "hard"):
        kinds = [kind for kind in HARD if kind.name in hard]
        jobs += [
            (place, kind, way, max(days // 2, 1))
            for kind in kinds
            for place in hard_places
            for way in schedules
            if way != "20 min"
        ]
    with ProcessPoolExecutor(processes) as pool:
        cells = list(pool.map(_cell, jobs))
        rows = [cell.row() for cell in cells]
        lines += table(HEAD, rows) if rows else []
        for place in clean_places:
            alike = [c for c in cells if c.kind == CLEAN and c.place == place]
            lines += [line] if (line := paired_line(alike)) else []
        for way in schedules:
            lines += _totals(way, [c for c in cells if c.schedule == way])
        why = [day.reasons for c in cells if c.kind == CLEAN for day in c.days if day.misfit]
        lines += [f"clean day does_not_fit: {reason}" for reason in why[:8]]
        if only in (None, "bound"):
            # The ratio of two medians of 200 days scatters by more than the goal leaves.
            plans = [(p, n, h, 3 * days) for p in clean_places for n, h in BOUND_PLANS]
            lines += table(
                ("year rms", "points", "hours", "ours", "Bayes bound", "ratio", "goal 1.10"),
                list(pool.map(bound, plans)),
            )
    return lines


def _totals(way: str, cells: Sequence[Cell]) -> list[str]:
    lines = []
    for name, those in (
        ("clean", [c for c in cells if c.kind == CLEAN]),
        ("hard", [c for c in cells if c.kind != CLEAN]),
    ):
        if not those:
            continue
        days = [day for cell in those for day in cell.days]
        done = [day for day in days if day.hours is not None]
        lines.append(
            f"{name}, {way}: {len(days)} days, done {100 * len(done) / len(days):.1f} %, false "
            f"{100 * sum(d.false for d in days) / len(days):.2f} % of days "
            f"({100 * sum(d.false for d in done) / max(len(done), 1):.1f} % of done), misfit "
            f"{100 * sum(d.misfit for d in days) / len(days):.2f} %"
        )
    return lines


if __name__ == "__main__":
    ask = argparse.ArgumentParser()
    ask.add_argument("--days", type=int, default=200)
    ask.add_argument("--latitudes", default=",".join(f"{one:g}" for one in LATITUDES))
    ask.add_argument("--mounts", default=",".join(MOUNTS))
    ask.add_argument("--only", choices=("clean", "hard", "bound"))
    ask.add_argument("--processes", type=int, default=2)
    ask.add_argument("--schedules", default=",".join((PLANNED, *EVERY_MIN)))
    ask.add_argument("--hard", default=",".join(kind.name for kind in HARD))
    given = ask.parse_args()
    print(
        "\n".join(
            run(
                given.days,
                [float(one) for one in given.latitudes.split(",")],
                given.mounts.split(","),
                given.only,
                given.processes,
                given.schedules.split(","),
                given.hard.split(","),
            )
        )
    )
