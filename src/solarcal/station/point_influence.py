"""One point of a session opened: how far it is from the others, and what the fit is without it."""

import math
from dataclasses import dataclass

from solarcal.errors import SolarcalError
from solarcal.model.forecast import Forecast
from solarcal.model.solution import Solution
from solarcal.session.reader import live_records
from solarcal.session.records import ClockSet, PointRecord, Record, RefCheck, SunOffset, Void
from solarcal.station.analysing import analyse_session
from solarcal.station.fitting import solve
from solarcal.station.point_judgement import PointJudgement, judge_point
from solarcal.station.state import SessionView, view_session


@dataclass(frozen=True, slots=True)
class PointInfluence:
    """What one accepted point does to the fit.

    Attributes
    ----------
    solution, without : the fit with all accepted points and without this one, ``None`` where the
        points are too few.
    forecast, forecast_without : the year with and without it.
    residual_deg : error minus model of all points, axis degrees, ``None`` where it is not fitted.
    judged : the point against the fit of the OTHERS, in sigmas.
    leverage : share of an error of this point that the fit would follow, 0 to 1.
    trouble : why something is missing, in a sentence.
    """

    point: PointRecord
    solution: Solution | None
    without: Solution | None
    forecast: Forecast | None
    forecast_without: Forecast | None
    residual_deg: tuple[float, float] | None
    judged: PointJudgement | None
    leverage: float | None
    trouble: str = ""


def point_influence(session: SessionView, point: PointRecord) -> PointInfluence:
    """Fit and judge with and without a point; takes some tenths of a second."""
    others = view_session(
        session.header, tuple(record for record in session.records if record.seq != point.seq)
    )
    try:
        with_it, without = analyse_session(session), analyse_session(others)
        solution, other = solve(session), solve(others)
        judged = None
        if point.error_deg is not None and point.ideal_deg is not None:
            judged = judge_point(others, point)
    except SolarcalError as error:
        return PointInfluence(point, None, None, None, None, None, None, None, str(error))
    residual = None
    if solution is not None and point.seq in solution.labels:
        at = solution.labels.index(point.seq)
        residual = (float(solution.residual1_deg[at]), float(solution.residual2_deg[at]))
    return PointInfluence(
        point=point,
        solution=solution,
        without=other,
        forecast=None if with_it is None else with_it.forecast,
        forecast_without=None if without is None else without.forecast,
        residual_deg=residual,
        judged=judged,
        leverage=_leverage(point, residual, judged),
    )


def _leverage(
    point: PointRecord,
    residual: tuple[float, float] | None,
    judged: PointJudgement | None,
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

    def last(records: tuple[Record, ...]) -> Record | None:
        return next((r for r in reversed(records) if r.seq < point.seq), None)

    check, offset, clock = (
        last(session.ref_checks), last(session.sun_offsets), last(session.clock_sets)
    )  # fmt: skip
    live = live_records(session.records)
    void = next((r for r in live if isinstance(r, Void) and r.voids == point.seq), None)
    about = [r for r in (clock, check, offset, point) if r is not None]
    about += [r for r in session.records if isinstance(r, Void) and r.voids == point.seq]
    return PointEvidence(
        check if isinstance(check, RefCheck) else None,
        offset if isinstance(offset, SunOffset) else None,
        clock if isinstance(clock, ClockSet) else None,
        void,
        tuple(sorted(about, key=lambda record: record.seq)),
    )
