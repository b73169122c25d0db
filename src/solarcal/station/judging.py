"""Fit, forecast, plan and verdict of a session or of files, the same way everywhere."""

from collections.abc import Sequence

from solarcal.model.finding import Finding
from solarcal.model.forecast import StoppingRule
from solarcal.model.judgement import Judgement, judge_solution
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.model.solution import Solution
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.diagnosing import session_evidence
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
    table = session_table(session)
    solution = solve_table(table, method, header=session.header)
    return judge_fit(
        table,
        solution,
        session.header,
        evidence=session_evidence(session, solution),
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
    done_probability: float | None = None,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    evidence: Sequence[Finding] = (),
) -> Judgement:
    """What a table's fitted points come to.

    ``header`` is that of the session they are from, ``evidence`` what its clocks, checks, settings
    and read-outs say by themselves.
    """
    return judge_solution(
        solution,
        sky_context(table, header),
        rule=stopping_rule(header, tolerance_deg, done_probability),
        at_utc_s=newest_point_utc_s(table) if at_utc_s is None else at_utc_s,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
        evidence=evidence,
    )


def stopping_rule(
    header: Header | None,
    tolerance_deg: float | None = None,
    done_probability: float | None = None,
) -> StoppingRule:
    """The session's, with what is given instead."""
    rule = StoppingRule()
    if header is not None:
        rule = StoppingRule(header.tolerance_deg, header.done_probability)
    return StoppingRule(
        rule.tolerance_deg if tolerance_deg is None else tolerance_deg,
        rule.probability if done_probability is None else done_probability,
    )
