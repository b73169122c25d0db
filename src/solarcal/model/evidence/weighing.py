"""What direct evidence means for the verdict: a fit can be smooth and its points still wrong."""

from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from typing import NamedTuple

from solarcal.model.evidence.times import UNIT_CLOCK
from solarcal.model.finding import Finding
from solarcal.timescale import SECONDS_PER_SUN_DEG

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
    wrong
        The unit, its settings or its read-outs are not what the fit takes them for.
    waiting
        Points to be struck out or taken again before the end.
    cautions
        The coefficients are right, but the unit will not point by them unless this is seen to; or
        something has changed since the last ones.
    """

    wrong: tuple[str, ...]
    waiting: tuple[str, ...]
    cautions: tuple[str, ...]


def weigh(evidence: Iterable[Finding], used: AbstractSet[int], tolerance_deg: float) -> Weighed:
    """Sort findings.

    Parameters
    ----------
    evidence
        Everything found: seen, or asked for by the residuals.
    used
        Labels of the fitted points: points already struck out no longer matter.
    tolerance_deg
        What is smaller, in degrees of axis or of Sun, is no reason against anything.
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
            case "time_stamps" | "site" | "geometry" | "ideal_kind":
                # Struck out already, they speak of nothing that is fitted.
                if not used.isdisjoint(finding.labels):
                    # The laptop's time is the truth of a fit; the unit's must follow before it
                    # points by the coefficients.
                    own = finding.kind == "time_stamps" and finding.subject == UNIT_CLOCK
                    (waiting if own else wrong).append(finding.sentence)
            case "offsets":
                if not used.isdisjoint(finding.labels):
                    wrong.append(finding.sentence)
            case "branch" if not used.isdisjoint(finding.labels):
                waiting.append(finding.sentence)
            case "not_held":
                waiting.append(finding.sentence)
            case "unit_sun" if number > tolerance_deg:
                wrong.append(finding.sentence)
            case "laptop_clock" if number > tolerance_deg * SECONDS_PER_SUN_DEG:
                wrong.append(finding.sentence)
            case "missed_counts" if number > tolerance_deg / 2.0:
                if not used.isdisjoint(finding.labels):
                    waiting.append(f"{finding.sentence}; take others, then strike these out")
            case "last_coefficients":
                cautions.append(finding.sentence)
            case "clock_drift" | "clock_step" if number > tolerance_deg * SECONDS_PER_SUN_DEG:
                cautions.append(finding.sentence)
    return Weighed(tuple(wrong), tuple(waiting), tuple(cautions))
