"""Do the counts of a new point make sense? Judged before it is stored, against the fit without it.

The manual's rule: beware of 'changes in turncounts that don't match observation'.
"""

import math
from dataclasses import dataclass

import numpy as np

from solarcal.model.fit import Solution
from solarcal.session.records import CheckRecord, PointRecord
from solarcal.station.fitting import solve
from solarcal.station.state import SessionView

POINT_SIGMA_DEG = 0.02
"""How well an eye centres a spot, until the points themselves give it."""

SUSPICIOUS_SIGMAS = 3.0
SUSPICIOUS_DEG = 0.15
"""Without a sigma, counts off by more than this on the sky call for a second look."""


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
        if off is not None and sigma is not None and math.isfinite(sigma[axis]):
            sigmas = off / math.hypot(sigma[axis], _point_sigma_deg(solution) / weight)
        doubtful = sigmas is not None and abs(sigmas) > SUSPICIOUS_SIGMAS
        if sigmas is None and off is not None and sigma is not None:
            doubtful = abs(off) * weight > SUSPICIOUS_DEG
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
