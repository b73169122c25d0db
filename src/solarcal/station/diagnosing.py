"""What is the matter with a tracker: the records of its session brought to the tests.

Direct evidence first, then what the residuals ask for once counts known to be missed are undone.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solarcal.model.evidence.counts import real_losses
from solarcal.model.evidence.direct import direct_findings
from solarcal.model.evidence.residuals import diagnose
from solarcal.model.finding import Finding
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.merging import Merged, merge_sessions
from solarcal.model.methods import fit
from solarcal.model.prior import Prior
from solarcal.model.solution import Solution
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.fitting import point_set, session_table, sky_context
from solarcal.station.known_lean import prior_of
from solarcal.station.state import SessionView


def session_evidence(session: SessionView, solution: Solution) -> tuple[Finding, ...]:
    """What clocks, checks, settings and read-outs of a session say by themselves.

    The fit, or one of the exact mechanism in its place, tells when counts were missed.
    """
    exact = None
    if real_losses(session):
        exact = exact_solution(solution, session_table(session), session.header)
    return direct_findings(session, exact)


def diagnose_session(session: SessionView, solution: Solution) -> tuple[Finding, ...]:
    """Everything found about the unit of a session, direct evidence first.

    ``solution`` is the fit of the session's points; where it is not of the exact mechanism, they
    are fitted so once more for the tests.
    """
    table = session_table(session)
    exact = exact_solution(solution, table, session.header)
    return (
        *direct_findings(session, exact),
        *diagnose(
            exact,
            approaches(table, exact.points.labels),
            losses=real_losses(session),
            tolerance_deg=session.header.tolerance_deg,
        ),
    )


def diagnose_table(
    table: PointTable, solution: Solution, header: Header | None = None
) -> tuple[Finding, ...]:
    """The same for points of a CSV or TPOINT file, which bring no direct evidence but the sides
    their axes came from."""
    exact = exact_solution(solution, table, header)
    if len(set(table.sources)) > 1:
        # Labels are unique in their own file only.
        return diagnose(exact)
    return diagnose(exact, approaches(table, exact.points.labels))


def exact_solution(
    solution: Solution, table: PointTable, header: Header | None = None
) -> MechanismSolution:
    """The solution itself where it is of the exact mechanism, else a robust one of its points."""
    if isinstance(solution, MechanismSolution):
        return solution
    fitted = fit(point_set(table), sky_context(table, header), prior=prior_of(header))
    assert isinstance(fitted, MechanismSolution)
    return fitted


def approaches(table: PointTable, labels: Sequence[int]) -> NDArray[np.int_]:
    """(n, 2) senses of the last motion of each axis at the points with these labels."""
    by_label = dict(zip(table.labels, table.approach, strict=True))
    return np.array([by_label[label] for label in labels], dtype=np.int_).reshape(-1, 2)


def solve_merged(
    tables: Sequence[PointTable], header: Header | None = None, prior: Prior | None = None
) -> Merged:
    """Several sessions of one unit in order of time, with the test whether the tower moved.

    ``tables`` must be of one unit (``session.points.merge_tables`` refuses others); the context is
    the first one's, and the prior is where none is given.
    """
    ordered = sorted(tables, key=_first_instant)
    context = sky_context(ordered[0], header)
    parts = [point_set(_without_sigma(t, ordered)) for t in ordered]
    names = [t.sources[0] if t.sources else f"session {k + 1}" for k, t in enumerate(ordered)]
    return merge_sessions(parts, context, prior=prior or prior_of(header), names=names)


def _first_instant(table: PointTable) -> float:
    known = table.utc_s[np.isfinite(table.utc_s)]
    return float(known.min()) if len(known) else 0.0


def _without_sigma(table: PointTable, all_tables: Sequence[PointTable]) -> PointTable:
    """Sigmas count only where every table gives them."""
    if all(other.sigma_deg is not None for other in all_tables):
        return table
    return replace(table, sigma_deg=None)
