"""Direct evidence: what stamps, clocks, checks, settings and read-outs say without any fit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from solarcal.model.evidence.branches import branch_evidence, side_evidence
from solarcal.model.evidence.clocks import clock_evidence, laptop_evidence
from solarcal.model.evidence.counts import Loss, count_evidence, real_losses
from solarcal.model.evidence.read_outs import offset_evidence, read_out_evidence
from solarcal.model.evidence.times import stamp_evidence
from solarcal.model.evidence.unit_state import held_evidence, unit_evidence
from solarcal.model.finding import Finding
from solarcal.model.sky_context import SkyContext
from solarcal.session.points import PointTable
from solarcal.session.view import SessionView

if TYPE_CHECKING:
    from solarcal.model.mechanism_solution import MechanismSolution


@dataclass(frozen=True, slots=True)
class Evidence:
    """The records a fit rests on: all that can contradict it.

    Attributes
    ----------
    table
        All attempts of all files; None where there are points only.
    sessions
        The sessions among the files.
    between
        What a comparison of several sessions has found already.
    """

    table: PointTable | None = None
    sessions: tuple[SessionView, ...] = ()
    between: tuple[Finding, ...] = ()

    @property
    def losses(self) -> tuple[Loss, ...]:
        """Counts known to have been missed; labels of several files are ambiguous."""
        return real_losses(self.sessions[0]) if self._one_session else ()

    @property
    def _one_session(self) -> bool:
        one_file = self.table is None or len(set(self.table.sources)) <= 1
        return len(self.sessions) == 1 and one_file

    def approach(self, labels: Sequence[int]) -> NDArray[np.int_] | None:
        """(n, 2) senses of the last motion of each axis at these points; None where unknown."""
        if self.table is None or len(set(self.table.sources)) > 1:
            return None
        by_label = dict(zip(self.table.labels, self.table.approach, strict=True))
        return np.array([by_label[label] for label in labels], dtype=np.int_).reshape(-1, 2)

    def findings(
        self, context: SkyContext, solution: "MechanismSolution | None", tolerance_deg: float
    ) -> tuple[Finding, ...]:
        """Everything but the residuals; the fit dates missed counts."""
        dating = solution if self._one_session else None
        stamps: tuple[Finding, ...] = ()
        sides = () if self.table is None else side_evidence(self.table)
        if self.table is not None:
            claimed = not self.sessions or any(s.header.unit.imported for s in self.sessions)
            stamps = stamp_evidence(self.table, context, tolerance_deg, kind_claimed=claimed)
        seen = (f for session in self.sessions for f in direct_findings(session, dating))
        return (*stamps, *sides, *dict.fromkeys(seen), *self.between)


NO_EVIDENCE = Evidence()


def evidence_sentences(session: SessionView) -> tuple[str, ...]:
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
        *held_evidence(session),
        *read_out_evidence(session),
        *offset_evidence(session),
        *branch_evidence(session),
        *laptop_evidence(session),
    )
