"""The unit's clock against the laptop's: offset, step and drift, without any fit of pointing."""

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.model.finding import Finding
from solarcal.session.view import SessionView
from solarcal.stopping_rule import SYNCHRONISED_S
from solarcal.timescale import SECONDS_PER_DAY, SECONDS_PER_SUN_DEG, parse_many_utc, parse_utc
from solarcal.units import FloatArray

CLOCK_SCATTER_S = 0.05
"""Differences are read to the millisecond over a line that takes tens of them."""
CLOCK_TOLERANCE_S = 1.0
"""By so much unit and laptop may differ before it is reported."""
STEP_LIMIT_S = 0.5
DRIFT_LIMIT_S_PER_DAY = 2.0

_STEP_SIGMAS = 5.0
_DRIFT_SIGMAS = 3.0
_SHORTEST_S = 1800.0
_MOST_STEPS = 3


@dataclass(frozen=True, slots=True)
class ClockSetting:
    """The unit's clock was set: unit minus laptop before and after, seconds."""

    utc_s: float
    before_s: float
    after_s: float


@dataclass(frozen=True, slots=True)
class ClockBehaviour:
    """Drift between settings, its sigma, and steps as (utc_s before, utc_s after, seconds)."""

    drift_s_per_day: float
    sigma_s_per_day: float
    steps: tuple[tuple[float, float, float], ...]


def clock_behaviour(
    utc_s: Sequence[float], unit_minus_laptop_s: Sequence[float], settings: Sequence[ClockSetting]
) -> ClockBehaviour | None:
    """One drift through all readings, a fresh start at every setting, and steps where needed.

    Steps are taken in one at a time, the largest first, while it stands out by five sigma and half
    a second. ``None`` with fewer than three readings between settings or less than half an hour.
    """
    readings = zip(utc_s, unit_minus_laptop_s, strict=True)
    rows = [(t, d, sum(s.utc_s <= t for s in settings)) for t, d in readings]
    rows += [(s.utc_s, s.before_s, i) for i, s in enumerate(settings)]
    rows += [(s.utc_s, s.after_s, i + 1) for i, s in enumerate(settings)]
    rows.sort(key=lambda row: (row[2], row[0]))
    counts = {row[2]: sum(other[2] == row[2] for other in rows) for row in rows}
    rows = [row for row in rows if counts[row[2]] > 1]
    if len(rows) < 3:
        return None
    times = np.array([row[0] for row in rows])
    difference = np.array([row[1] for row in rows])
    stretch = np.array([row[2] for row in rows])
    stretches = np.unique(stretch)
    if max(float(np.ptp(times[stretch == one])) for one in stretches) < _SHORTEST_S:
        return None
    base = [(times - times.mean()) / SECONDS_PER_DAY]
    base += [np.asarray(stretch == one, dtype=np.float64) for one in stretches]
    found: list[int] = []
    gaps = [i for i in range(len(rows) - 1) if stretch[i] == stretch[i + 1]]
    while len(found) < _MOST_STEPS and len(rows) - len(base) > 1:
        trials = [(i, _step_column(stretch, i)) for i in gaps if i not in found]
        fits = [(_left(np.column_stack((*base, column)), difference), i) for i, column in trials]
        if not fits:
            break
        best = min(fits)[1]
        column = _step_column(stretch, best)
        values, sigmas = _solved(np.column_stack((*base, column)), difference)
        if abs(values[-1]) < max(STEP_LIMIT_S, _STEP_SIGMAS * sigmas[-1]):
            break
        found.append(best)
        base.append(column)
    values, sigmas = _solved(np.column_stack(base), difference)
    steps = values[len(values) - len(found) :]
    return ClockBehaviour(
        float(values[0]),
        float(sigmas[0]),
        tuple(
            (float(times[i]), float(times[i + 1]), float(step))
            for i, step in zip(found, steps, strict=True)
        ),
    )


def _step_column(stretch: FloatArray, after: int) -> FloatArray:
    later = np.arange(len(stretch)) > after
    return np.asarray(later & (stretch == stretch[after]), dtype=np.float64)


def _left(columns: FloatArray, measured: FloatArray) -> float:
    values = np.linalg.lstsq(columns, measured, rcond=None)[0]
    rest = measured - columns @ values
    return float(rest @ rest)


def _solved(columns: FloatArray, measured: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values and sigmas; the scatter is never believed to be below that of the line."""
    values = np.linalg.lstsq(columns, measured, rcond=None)[0]
    spare = len(measured) - columns.shape[1]
    rest = measured - columns @ values
    scatter = max(np.sqrt(rest @ rest / spare) if spare > 0 else 0.0, CLOCK_SCATTER_S)
    sigmas = scatter * np.sqrt(np.diag(np.linalg.pinv(columns.T @ columns)))
    return np.asarray(values, dtype=np.float64), np.asarray(sigmas, dtype=np.float64)


def clock_findings(
    utc_s: Sequence[float],
    unit_minus_laptop_s: Sequence[float],
    settings: Sequence[ClockSetting] = (),
    labels: Sequence[int] = (),
) -> tuple[Finding, ...]:
    """Drift, steps and offset of the unit's clock at the points (any order of time).

    Parameters
    ----------
    utc_s, unit_minus_laptop_s : laptop instant of each point and what the unit's clock showed more,
        seconds.
    settings : in order of time.
    labels : the points' labels, in the same order.
    """
    behaviour = clock_behaviour(utc_s, unit_minus_laptop_s, settings)
    said = [] if behaviour is None else _changes(behaviour, utc_s, labels)
    worst = max(unit_minus_laptop_s, key=abs, default=0.0)
    if abs(worst) > CLOCK_TOLERANCE_S:
        hours = round(worst / 3600.0)
        whole = hours != 0 and abs(worst - 3600.0 * hours) < 120.0
        said.append(
            Finding(
                kind="clock_offset",
                subject="unit clock",
                sentence=f"unit and laptop clocks differed by up to {worst:+z.1f} s at a point "
                f"({abs(worst) / SECONDS_PER_SUN_DEG:.3f} deg of Sun)"
                + (f": {hours:+d} h, an hour or a zone is wrong" if whole else ""),
                number=worst,
                sigma=CLOCK_SCATTER_S,
                unit="s",
                direct=True,
            )
        )
    return tuple(said)


def _changes(
    behaviour: ClockBehaviour, utc_s: Sequence[float], labels: Sequence[int]
) -> list[Finding]:
    said: list[Finding] = []
    drift, sigma = behaviour.drift_s_per_day, behaviour.sigma_s_per_day
    if abs(drift) > max(_DRIFT_SIGMAS * sigma, DRIFT_LIMIT_S_PER_DAY):
        said.append(
            Finding(
                kind="clock_drift",
                subject="unit clock",
                sentence=f"the unit's clock drifts {drift:+z.1f} +- {sigma:.1f} s/day against "
                f"the laptop's: {abs(drift) / SECONDS_PER_SUN_DEG:.3f} deg of Sun after a day; "
                "set it every morning, or have it repaired",
                number=drift,
                sigma=sigma,
                unit="s/day",
                direct=True,
            )
        )
    for before_s, after_s, step in behaviour.steps:
        label = next((n for t, n in sorted(zip(utc_s, labels, strict=False)) if t >= after_s), None)
        where = f" before point {label}" if label is not None else ""
        said.append(
            Finding(
                kind="clock_step",
                subject="unit clock",
                sentence=f"the unit's clock stepped by {step:+z.1f} s{where}, within "
                f"{(after_s - before_s) / 60.0:.0f} minutes: "
                f"{abs(step) / SECONDS_PER_SUN_DEG:.3f} deg of Sun",
                number=step,
                sigma=CLOCK_SCATTER_S,
                unit="s",
                direct=True,
                labels=() if label is None else (label,),
            )
        )
    return said


def clock_sigma_s(session: SessionView) -> float:
    """How well the laptop's clock was known when the points were taken, one sigma, seconds.

    By the time signal, what it was found to be off included: the points were taken with that. What
    the session was begun with where no signal says more.
    """
    signal = _time_signal(session)
    return session.header.rule.unmodelled.clock_s if signal is None else math.hypot(*signal)


def _time_signal(session: SessionView) -> tuple[float, float] | None:
    """The worst time signal minus laptop, and its sigma, seconds, that the points were taken with.

    Each point was taken between two signals, or after the last: the clock was as at either, for it
    may have been corrected in between. Without a point it is the newest.
    """
    signals = [
        (c.seq, c.tick_minus_laptop_s, 0.5 if c.tick_sigma_s is None else c.tick_sigma_s)
        for c in session.clock_sets
        if c.tick_minus_laptop_s is not None
    ]
    if not signals:
        return None
    places = {bisect_left(signals, (point.seq,)) for point in session.accepted} or {len(signals)}
    beside = {at for place in places for at in (place - 1, place) if 0 <= at < len(signals)}
    return max((signals[at][1:] for at in beside), key=lambda one: abs(one[0]))


def laptop_finding(
    tick_minus_laptop_s: float | None, sigma_s: float | None, assumed_s: float = SYNCHRONISED_S
) -> Finding:
    """The laptop's own clock: compared with a time signal, or not to be known from points."""
    if tick_minus_laptop_s is None:
        cure = "compare the laptop with a time signal"
        if assumed_s > SYNCHRONISED_S:
            cure = (
                f"its assumed uncertainty is {assumed_s:g} s (one sigma), which widens every "
                f"band: {cure}"
            )
        return Finding(
            kind="laptop_clock",
            subject="laptop clock",
            sentence="a constant error of the laptop's own clock cannot be found from points: "
            "24 s rotate the points by 0.1 deg about the celestial pole, which goes into the "
            f"coefficients; {cure}",
            certainty="not_determinable",
            direct=True,
        )
    sigma = 0.5 if sigma_s is None else sigma_s
    off_deg = abs(tick_minus_laptop_s) / SECONDS_PER_SUN_DEG
    slow = abs(tick_minus_laptop_s) > max(CLOCK_TOLERANCE_S, _DRIFT_SIGMAS * sigma)
    return Finding(
        kind="laptop_clock",
        subject="laptop clock",
        sentence=(
            f"the time signal was {tick_minus_laptop_s:+z.1f} +- {sigma:.1f} s from the laptop's "
            f"clock when points were taken: {off_deg:.3f} deg of Sun are in the coefficients; "
            "correct the laptop's clock and begin again"
            if slow
            else "an error of the laptop's own clock below the time signal's: the signal was "
            f"{tick_minus_laptop_s:+z.1f} +- {sigma:.1f} s from it"
        ),
        certainty="found" if slow else "not_determinable",
        number=tick_minus_laptop_s,
        sigma=sigma,
        unit="s",
        direct=True,
    )


def clock_evidence(session: SessionView) -> tuple[Finding, ...]:
    """The unit's clock at the points and settings of a session."""
    timed = [p for p in session.accepted if p.unit_minus_laptop_s is not None]
    return clock_findings(
        parse_many_utc([p.utc for p in timed]),
        [p.unit_minus_laptop_s for p in timed if p.unit_minus_laptop_s is not None],
        [ClockSetting(parse_utc(c.utc), c.before_s, c.after_s) for c in session.clock_sets],
        [p.seq for p in timed],
    )


def laptop_evidence(session: SessionView) -> tuple[Finding, ...]:
    """The laptop's own clock, as far as a time signal was entered."""
    if not session.accepted:
        return ()
    tick_s, sigma_s = _time_signal(session) or (None, None)
    return (laptop_finding(tick_s, sigma_s, session.header.rule.unmodelled.clock_s),)
