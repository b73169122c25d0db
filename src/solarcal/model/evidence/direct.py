"""Direct evidence: what clocks, reference checks, settings and read-outs say without any fit."""

from typing import TYPE_CHECKING

from solarcal.model.evidence.branches import branch_evidence
from solarcal.model.evidence.clocks import clock_evidence, laptop_evidence
from solarcal.model.evidence.counts import count_evidence
from solarcal.model.evidence.read_outs import read_out_evidence
from solarcal.model.evidence.unit_state import unit_evidence
from solarcal.model.finding import Finding
from solarcal.session.view import SessionView

if TYPE_CHECKING:
    from solarcal.model.mechanism_solution import MechanismSolution


def evidence(session: SessionView) -> tuple[str, ...]:
    """Sentences, each with its number; empty where nothing stands out."""
    return tuple(finding.sentence for finding in direct_findings(session))


def direct_findings(
    session: SessionView, solution: "MechanismSolution | None" = None
) -> tuple[Finding, ...]:
    """Clocks, counts, site and Sun, read-outs; a fit of the points dates missed counts."""
    if session.header.unit.imported:
        return ()
    return (
        *clock_evidence(session),
        *count_evidence(session, solution),
        *unit_evidence(session),
        *read_out_evidence(session),
        *branch_evidence(session),
        *laptop_evidence(session),
    )
