"""Points judged: a new one before it is stored, one of a session against all the others.

The manual's rule: beware of 'changes in turncounts that don't match observation'.
"""

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from solarcal.errors import SolarcalError
from solarcal.model.analysis import Analysis
from solarcal.model.solution import Solution
from solarcal.mount.drive import reading_deg, register
from solarcal.session.records import (
    CheckRecord,
    ClockSet,
    PointRecord,
    Record,
    RefCheck,
    SunOffset,
    Void,
)
from solarcal.session.view import SessionView, view_session
from solarcal.session.voids import live_records
from solarcal.station.analysing import analyse_session
from solarcal.station.fitting import solve

POINT_SIGMA_DEG = 0.02
"""How well an eye centres a spot, until the points themselves give it."""

SUSPICIOUS_SIGMAS = 3.0

SUSPICIOUS_DEG = 0.25
"""Counts that disagree with the prediction by more than this (on sky, and by more than five sigmas
of the prediction) call for a reference check."""

TRUSTED_FIT_POINTS = 5

Kind = TypeVar("Kind", RefCheck, SunOffset, ClockSet)


@dataclass(frozen=True, slots=True)
class AxisJudgement:
    """One axis of a new point; ``off_deg`` is found minus predicted error, ``None`` unpredicted.

    ``sigmas``: ``off_deg`` over the standard deviation of prediction and point together.
    """

    expected_counts: float | None
    found_counts: int | None
    error_deg: float
    off_deg: float | None
    sigmas: float | None
    suspicious: bool


@dataclass(frozen=True, slots=True)
class PointJudgement:
    axes: tuple[AxisJudgement, AxisJudgement]
    sentence: str

    @property
    def suspicious(self) -> bool:
        return any(axis.suspicious for axis in self.axes)


def judge_point(session: SessionView, candidate: PointRecord) -> PointJudgement:
    """Compare a candidate that is not stored yet with what the session predicts for it."""
    assert candidate.error_deg is not None  # a gathered candidate always has one
    assert candidate.ideal_deg is not None
    on_sky = max(math.sin(math.radians(candidate.ideal_deg[1])), 1e-6)
    solution = solve(session)
    predicted, sigma = _prediction(session, solution, candidate.ideal_deg)
    axes = []
    for axis, weight in ((0, on_sky), (1, 1.0)):
        off = None if predicted is None else candidate.error_deg[axis] - predicted[axis]
        sigmas = None
        if off is not None and sigma is not None:
            sigmas = off / math.hypot(sigma[axis], _point_sigma_deg(solution) / weight)
        doubtful = sigmas is not None and abs(sigmas) > SUSPICIOUS_SIGMAS
        axes.append(
            AxisJudgement(
                expected_counts=candidate.expected_counts and candidate.expected_counts[axis],
                found_counts=candidate.found_counts and candidate.found_counts[axis],
                error_deg=candidate.error_deg[axis],
                off_deg=off,
                sigmas=sigmas,
                suspicious=doubtful,
            )
        )
    return PointJudgement((axes[0], axes[1]), _sentence(axes, solution))


def counts_doubt(session: SessionView, record: PointRecord | CheckRecord, method: str) -> str:
    """Why the counts of a gathered point do not make sense, or nothing."""
    if (
        isinstance(record, CheckRecord)
        or record.ideal_deg is None
        or record.reading_deg is None
        or record.expected_counts is None
        or record.found_counts is None
        or len(session.accepted) < TRUSTED_FIT_POINTS
    ):
        return ""
    solution = solve(session, method)
    if solution is None:
        return ""
    unit = session.header.unit
    unsure = solution.predict_sigma_deg(*record.ideal_deg)
    weights = (np.sin(np.radians(record.ideal_deg[1])), 1.0)
    drives, references = (unit.drive1, unit.drive2), (unit.reference1_deg, unit.reference2_deg)
    for axis in (0, 1):
        drive, now = drives[axis], record.reading_deg[axis]
        expected, found = record.expected_counts[axis], record.found_counts[axis]
        at = register(drive, references[axis], now) + round(expected) - found
        off = now - float(reading_deg(drive, references[axis], at))
        allowed = max(SUSPICIOUS_DEG, 5.0 * float(unsure[axis]) * weights[axis])
        if abs(off) * weights[axis] > allowed:
            return (
                f"axis {axis + 1} moved {found} counts since the last point where "
                f"{expected:.0f} were expected ({off:+z.2f} deg)"
            )
    return ""


def judge_check(check: CheckRecord, tolerance_deg: float) -> str:
    """What a check point proves, in a sentence."""
    sky = check.sky_error_deg or 0.0
    if sky <= tolerance_deg:
        return f"{sky:.3f} deg left on the sky: within the tolerance of {tolerance_deg:g} deg."
    return f"{sky:.3f} deg left on the sky: BEYOND the tolerance of {tolerance_deg:g} deg."


def _prediction(
    session: SessionView, solution: Solution | None, ideal: tuple[float, float]
) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """Predicted axis errors and their sigmas; the last point's error where there is no fit."""
    if solution is None or solution.rank < len(solution.terms):
        last = session.accepted[-1].error_deg if session.accepted else None
        return last, None
    at1, at2 = np.asarray(ideal[0]), np.asarray(ideal[1])
    e1, e2 = solution.predict_deg(at1, at2)
    s1, s2 = solution.predict_sigma_deg(at1, at2)
    return (float(e1), float(e2)), (float(s1), float(s2))


def _point_sigma_deg(solution: Solution | None) -> float:
    spread = solution.population_sd_deg if solution is not None else None
    # The population SD is of both axes together.
    return max(spread / math.sqrt(2.0), POINT_SIGMA_DEG) if spread else POINT_SIGMA_DEG


def _sentence(axes: list[AxisJudgement], solution: Solution | None) -> str:
    if axes[0].off_deg is None:
        return "The first point: nothing to compare it with yet."
    if solution is None or all(axis.sigmas is None for axis in axes):
        return "Too few points for a prediction: compared with the last point only."
    if any(axis.suspicious for axis in axes):
        worst = max(range(2), key=lambda i: abs(axes[i].sigmas or 0.0))
        return (
            f"Axis {worst + 1} does NOT match: {abs(axes[worst].sigmas or 0.0):.1f} sigmas from "
            "the prediction. Look again, or do a reference check."
        )
    return "Matches the prediction of the present fit."


@dataclass(frozen=True, slots=True)
class PointInfluence:
    """What one accepted point does to the fit.

    Attributes
    ----------
    with_it, without : all accepted points with and without this one analysed, ``None`` where
        they are too few.
    residual_deg : error minus what the coefficients fitted to all points correct, axis degrees,
        ``None`` where the point is not fitted or struck out.
    judged : the point against the fit of the OTHERS, in sigmas.
    leverage : share of an error of this point that the fit would follow, 0 to 1.
    trouble : why something is missing, in a sentence.
    """

    point: PointRecord
    with_it: Analysis | None = None
    without: Analysis | None = None
    residual_deg: tuple[float, float] | None = None
    judged: PointJudgement | None = None
    leverage: float | None = None
    trouble: str = ""


def point_influence(session: SessionView, point: PointRecord) -> PointInfluence:
    """Fit and judge with and without a point; takes some tenths of a second.

    One that is struck out is in the fit with it all the same.
    """
    void = point_evidence(session, point).void
    others = _without(session, point)
    try:
        with_it = analyse_session(session if void is None else _without(session, void))
        without = analyse_session(others)
        judged = None
        if point.error_deg is not None and point.ideal_deg is not None:
            judged = judge_point(others, point)
    except SolarcalError as error:
        return PointInfluence(point, trouble=str(error))
    residual = None
    if (
        void is None
        and with_it is not None
        and point.seq in with_it.solution.labels
        and point.error_deg is not None
        and point.ideal_deg is not None
    ):
        # As table and plot show it, and as the point is compared with the fit of the others.
        e1, e2 = with_it.solution.predict_deg(*map(np.asarray, point.ideal_deg))
        residual = (point.error_deg[0] - float(e1), point.error_deg[1] - float(e2))
    leverage = _leverage(point, residual, judged)
    return PointInfluence(point, with_it, without, residual, judged, leverage)


def _without(session: SessionView, left_out: Record) -> SessionView:
    kept = (record for record in session.records if record.seq != left_out.seq)
    return view_session(session.header, tuple(kept))


def _leverage(
    point: PointRecord, residual: tuple[float, float] | None, judged: PointJudgement | None
) -> float | None:
    """1 minus the residual with the point over the one without it, both on the sky."""
    if residual is None or judged is None or point.ideal_deg is None:
        return None
    off = [axis.off_deg for axis in judged.axes]
    if off[0] is None or off[1] is None:
        return None
    weight = math.sin(math.radians(point.ideal_deg[1]))
    left = math.hypot(weight * residual[0], residual[1])
    apart = math.hypot(weight * off[0], off[1])
    return min(max(1.0 - left / apart, 0.0), 1.0) if apart > 0.0 else None


@dataclass(frozen=True, slots=True)
class PointEvidence:
    """The newest check, offset and clock before a point, and the void that strikes it, if any."""

    ref_check: RefCheck | None
    sun_offset: SunOffset | None
    clock_set: ClockSet | None
    void: Void | None
    records: tuple[Record, ...]


def point_evidence(session: SessionView, point: PointRecord) -> PointEvidence:
    """What the session says about a point beside its own numbers."""

    def last(records: tuple[Kind, ...]) -> Kind | None:
        return next((r for r in reversed(records) if r.seq < point.seq), None)

    check, offset, clock = (
        last(session.ref_checks), last(session.sun_offsets), last(session.clock_sets)
    )  # fmt: skip
    if point.basis == "sun_offset":
        own = (r for r in session.records if isinstance(r, SunOffset))
        offset = next((r for r in own if r.instant == point.read_utc), offset)
    # A point whose offset is struck out is struck out with it.
    both = (point.seq, None if offset is None else offset.seq)
    live = live_records(session.records)
    void = next((r for r in live if isinstance(r, Void) and r.voids in both), None)
    about: list[Record] = [r for r in (clock, check, offset, point) if r is not None]
    about += [r for r in session.records if isinstance(r, Void) and r.voids in both]
    return PointEvidence(
        check, offset, clock, void, tuple(sorted(about, key=lambda record: record.seq))
    )
