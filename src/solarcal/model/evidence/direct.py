"""Direct evidence: what stamps, clocks, checks, settings and read-outs say without any fit.

And what it means for the verdict: a fit can be smooth and its points still wrong.
"""

from collections.abc import Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solarcal.model.evidence.branch import branch_evidence, side_evidence
from solarcal.model.evidence.clocks import clock_evidence, laptop_evidence
from solarcal.model.evidence.read_outs import (
    Loss,
    count_evidence,
    losses,
    offset_evidence,
    read_out_evidence,
)
from solarcal.model.evidence.recorded_twice import point_contradictions, session_contradictions
from solarcal.model.evidence.sun_path import (
    IDEAL_ANGLES,
    UNIT_CLOCK,
    stamp_evidence,
)
from solarcal.model.evidence.unit_state import check_evidence, held_evidence, unit_evidence
from solarcal.model.finding import Finding, listed
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.session.points import PointTable
from solarcal.session.view import SessionView
from solarcal.timescale import SECONDS_PER_SUN_DEG

if TYPE_CHECKING:
    from solarcal.model.mechanism_solution import MechanismSolution


@dataclass(frozen=True, slots=True)
class Evidence:
    """The records a fit rests on: all that can contradict it.

    Attributes
    ----------
    table : all attempts of all files; None where there are points only.
    sessions : the sessions among the files.
    between : what a comparison of several sessions has found already.
    """

    table: PointTable | None = None
    sessions: tuple[SessionView, ...] = ()
    between: tuple[Finding, ...] = ()

    @property
    def losses(self) -> tuple[Loss, ...]:
        """Counts known to have been missed; labels of several files are ambiguous."""
        if not self._one_session:
            return ()
        return tuple(loss for _, _, loss in losses(self.sessions[0]))

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
        self,
        context: SkyContext,
        solution: "MechanismSolution | None",
        tolerance_deg: float,
        fitted: Points | None = None,
    ) -> tuple[Finding, ...]:
        """Everything but the residuals.

        ``solution`` dates missed counts; read-outs are those of the ``fitted`` points (None: of all
        accepted ones).
        """
        dating = solution if self._one_session else None
        used = None if fitted is None else set(zip(fitted.labels, fitted.ax2_deg, strict=True))
        stamps: tuple[Finding, ...] = ()
        sides = () if self.table is None else side_evidence(self.table, context, used)
        if self.table is not None:
            claimed = not self.sessions or any(s.header.unit.imported for s in self.sessions)
            stamps = stamp_evidence(self.table, context, tolerance_deg, kind_claimed=claimed)
            if stamps and not claimed:
                stamps = self._of_the_units_clock(stamps, context, tolerance_deg)
            if not_one_tracker_of_the_sun(stamps, self.table.accepted().labels):
                sides = ()
        noise_deg = 0.0 if solution is None else solution.noise_deg
        found: dict[Finding, list[str]] = {}
        for session in self.sessions:
            for finding in direct_findings(session, dating, used, noise_deg):
                found.setdefault(finding, []).append(session.path)
        seen = (
            finding
            if len(where) == len(self.sessions)
            else replace(finding, sentence=f"{listed(where)}: {finding.sentence}")
            for finding, where in found.items()
        )
        return (*stamps, *sides, *seen, *held_evidence(self.sessions), *self.between)

    def _of_the_units_clock(
        self, stamps: tuple[Finding, ...], context: SkyContext, tolerance_deg: float
    ) -> tuple[Finding, ...]:
        """What the laptop's stamps say, where the unit's own clock does not explain it all."""
        assert self.table is not None
        ahead_s = {
            (session.path, point.seq): point.unit_minus_laptop_s
            for session in self.sessions
            for point in session.accepted
        }
        places = zip(self.table.sources, self.table.labels, strict=True)
        by_unit_s = np.array([ahead_s.get(place) or 0.0 for place in places])
        shown = replace(self.table, utc_s=self.table.utc_s + by_unit_s)
        if stamp_evidence(shown, context, tolerance_deg, kind_claimed=False):
            return stamps
        worst_s = float(by_unit_s[np.argmax(np.abs(by_unit_s))])
        apart_deg = abs(worst_s) / SECONDS_PER_SUN_DEG
        return (
            replace(
                stamps[0],
                kind="time_stamps",
                subject=UNIT_CLOCK,
                sentence=f"the unit's clock was up to {worst_s:+z.1f} s from the laptop's at the "
                f"points, {apart_deg:.3f} deg of Sun, which explains that its ideal angles are not "
                "those of the laptop's time: compare both clocks, and set the wrong one right",
                number=worst_s,
                unit="s",
            ),
        )


NO_EVIDENCE = Evidence()


def not_one_tracker_of_the_sun(found: Iterable[Finding], labels: Sequence[int]) -> bool:
    """Whether most of these points are not what a fit takes them for.

    Then their residuals are those of a wrong place, and no cause in them is one of the tracker.
    """
    for finding in found:
        if finding.kind == "contradiction" and not finding.labels:
            return True
        elsewhere = finding.kind in ("time_stamps", "site") and finding.subject == IDEAL_ANGLES
        concerned = set(labels).intersection(finding.labels)
        if (elsewhere or finding.kind == "geometry") and 2 * len(concerned) > len(labels):
            return True
    return False


def evidence_sentences(session: SessionView) -> tuple[str, ...]:
    """Sentences, each with its number; empty where nothing stands out."""
    found = (*direct_findings(session), *held_evidence([session]))
    return tuple(finding.sentence for finding in found)


def direct_findings(
    session: SessionView,
    solution: "MechanismSolution | None" = None,
    used: AbstractSet[tuple[int, float]] | None = None,
    noise_deg: float = 0.0,
) -> tuple[Finding, ...]:
    """Clocks, counts, site and Sun, read-outs; a fit of the points dates missed counts.

    ``used``: label and AX2 of the points whose read-outs count; None: all accepted ones.
    ``noise_deg``: of one check point, per axis on sky.
    """
    if session.header.unit.imported:
        return ()
    points = [
        p for p in session.accepted
        if used is None or (p.ideal_deg and (p.seq, p.ideal_deg[1]) in used)
    ]  # fmt: skip
    return (
        *clock_evidence(session),
        *count_evidence(session, solution),
        *unit_evidence(session),
        *check_evidence(session, noise_deg),
        *read_out_evidence(points),
        *offset_evidence(session, points),
        *point_contradictions(session.header.unit, points),
        *session_contradictions(session),
        *branch_evidence(session),
        *laptop_evidence(session),
    )


CAUSES = (
    "collimation", "nonperpendicularity", "cross_axis", "sag", "refraction", "backlash",
    "unmodelled",
)  # fmt: skip
"""What residuals can ask for that P1..P6 do not have."""
CAUSE_SHARE = 0.1
"""An effect below this part of the tolerance, added to it in squares, is half a percent of it."""


class Weighed(NamedTuple):
    """Sentences by what they ask for.

    Attributes
    ----------
    wrong : the unit, its settings or its read-outs are not what the fit takes them for.
    waiting : points to be struck out or taken again before the end.
    cautions : the coefficients are right, but the unit will not point by them unless this is seen
        to; or something has changed since the last ones.
    """

    wrong: tuple[str, ...]
    waiting: tuple[str, ...]
    cautions: tuple[str, ...]


def weigh(evidence: Iterable[Finding], used: AbstractSet[int], tolerance_deg: float) -> Weighed:
    """Sort findings.

    Parameters
    ----------
    evidence : everything found: seen, or asked for by the residuals.
    used : labels of the fitted points: points already struck out no longer matter.
    tolerance_deg : what is smaller, in degrees of axis or of Sun, is no reason against anything.
    """
    wrong: list[str] = []
    waiting: list[str] = []
    cautions: list[str] = []
    for finding in evidence:
        if finding.certainty != "found":
            continue
        number = abs(finding.number or 0.0)
        if finding.kind in CAUSES and (finding.effect_deg or 0.0) > CAUSE_SHARE * tolerance_deg:
            # The formula cannot hold it: what the forecast makes of it is not known.
            waiting.append(finding.sentence)
        if finding.kind == "step" and not used.isdisjoint(finding.labels):
            wrong.append(finding.sentence)
        if not finding.direct:
            continue
        match finding.kind:
            case "frozen":
                wrong.append(finding.sentence)
            case "another_unit" if not finding.labels or not used.isdisjoint(finding.labels):
                wrong.append(finding.sentence)
            case "time_stamps" | "site" | "geometry" | "ideal_kind":
                # The laptop's time is the truth of a fit; the unit's must follow before it points
                # by the coefficients. That a point is fitted does not matter: a wrong stamp may be
                # why it seems too low for that.
                own = finding.kind == "time_stamps" and finding.subject == UNIT_CLOCK
                (waiting if own else wrong).append(finding.sentence)
            case "offsets" | "counts" | "limits" if not used.isdisjoint(finding.labels):
                wrong.append(finding.sentence)
            case "branch" | "answers" | "restarted" if not used.isdisjoint(finding.labels):
                waiting.append(finding.sentence)
            case "contradiction" if number > tolerance_deg / 2.0:
                if not finding.labels:
                    wrong.append(finding.sentence)
                elif not used.isdisjoint(finding.labels):
                    waiting.append(finding.sentence)
            case "not_held" | "upload" | "check_point" | "not_proven":
                waiting.append(finding.sentence)
            case "unit_sun" if number > tolerance_deg:
                wrong.append(finding.sentence)
            case "laptop_clock" if number > 0.5 * tolerance_deg * SECONDS_PER_SUN_DEG:
                wrong.append(finding.sentence)
            case "missed_counts" if number > tolerance_deg / 2.0:
                if used.isdisjoint(finding.labels):
                    cautions.append(finding.sentence)
                else:
                    waiting.append(f"{finding.sentence}; take others, then strike these out")
            case "last_coefficients" | "inclinometer":
                cautions.append(finding.sentence)
            case "clock_drift" | "clock_step" if number > tolerance_deg * SECONDS_PER_SUN_DEG:
                cautions.append(finding.sentence)
    return Weighed(tuple(wrong), tuple(waiting), tuple(cautions))
