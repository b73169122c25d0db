"""Fit, forecast, plan and verdict of a session or of files, the same way everywhere."""

from collections.abc import Sequence

from solarcal.model.forecast import TOLERANCE_DEG
from solarcal.model.judgement import Judgement, judge_solution
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.model.solution import Solution
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.fitting import (
    fewest_points,
    newest_point_utc_s,
    session_table,
    sky_context,
    solve_table,
)
from solarcal.station.state import SessionView


def judge_session(
    session: SessionView,
    method: str = DEFAULT_METHOD,
    *,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
) -> Judgement | None:
    """What a session's points come to; ``None`` while there are too few for ``method``.

    ``at_utc_s`` is the moment to plan from; the newest point's when ``None``.
    """
    if len(session.accepted) < fewest_points(method):
        return None
    return judge_table(
        session_table(session),
        session.header,
        method,
        at_utc_s=at_utc_s,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
    )


def judge_table(
    table: PointTable,
    header: Header | None = None,
    method: str = DEFAULT_METHOD,
    *,
    tolerance_deg: float | None = None,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
) -> Judgement:
    """What a table's accepted points come to; ``header`` is that of the session they are from."""
    return judge_fit(
        table,
        solve_table(table, method, header=header),
        header,
        tolerance_deg=tolerance_deg,
        at_utc_s=at_utc_s,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
    )


def judge_fit(
    table: PointTable,
    solution: Solution,
    header: Header | None = None,
    *,
    tolerance_deg: float | None = None,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
) -> Judgement:
    """The same for a table already fitted."""
    if tolerance_deg is None:
        tolerance_deg = TOLERANCE_DEG if header is None else header.tolerance_deg
    return judge_solution(
        solution,
        sky_context(table, header),
        tolerance_deg=tolerance_deg,
        at_utc_s=newest_point_utc_s(table) if at_utc_s is None else at_utc_s,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
    )
