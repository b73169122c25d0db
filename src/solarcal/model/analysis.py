"""From points to the verdict: fit, findings, forecast, plan and verdict in one call.

Live sessions, replays, files, certificates and screens all come through ``analyse``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from solarcal.model.evidence.direct import NO_EVIDENCE, Evidence, not_one_tracker_of_the_sun
from solarcal.model.evidence.residuals import (
    MOST_TESTED,
    NOT_TESTED,
    diagnose,
    solution_to_test,
    thinned,
    thinning,
)
from solarcal.model.finding import Finding
from solarcal.model.forecast import Forecast, forecast
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_METHOD, DEFAULT_PRIOR, fit
from solarcal.model.plan import Plan
from solarcal.model.planner import plan, times_of
from solarcal.model.points import Points
from solarcal.model.prior import Prior
from solarcal.model.repeats import contradicted
from solarcal.model.sky_context import SkyContext
from solarcal.model.solution import Solution
from solarcal.model.verdict import Verdict, assess, conclude
from solarcal.site import BoltCircle
from solarcal.stopping_rule import DEFAULT_RULE, TOLERANCE_DEG, StoppingRule


@dataclass(frozen=True, slots=True)
class Analysis:
    """What a set of points comes to.

    Attributes
    ----------
    solution, forecast : the fit, and the year with what it would upload.
    plan : None where no time was given to plan from.
    findings : everything found, excluded or not determinable, direct evidence first.
    verdict : what all of that together says.
    """

    solution: Solution
    forecast: Forecast
    plan: Plan | None
    findings: tuple[Finding, ...]
    verdict: Verdict

    def as_json(self) -> dict[str, Any]:
        """The fit's document with forecast, findings and verdict, and the plan if there is one."""
        return {
            **self.solution.as_json(),
            "forecast": self.forecast.as_json(),
            "findings": [finding.as_json() for finding in self.findings],
            "verdict": self.verdict.as_json(),
            **({} if self.plan is None else {"plan": self.plan.as_json()}),
        }


def analyse(
    points: Points,
    context: SkyContext,
    evidence: Evidence = NO_EVIDENCE,
    at_utc_s: float | None = None,
    *,
    method: str = DEFAULT_METHOD,
    prior: Prior = DEFAULT_PRIOR,
    solution: Solution | None = None,
    rule: StoppingRule = DEFAULT_RULE,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    bolt_circle: BoltCircle | None = None,
) -> Analysis:
    """Fit, weigh the evidence, forecast, plan the rest of the day, and judge.

    Parameters
    ----------
    points, context : what was measured, and under which sky.
    evidence : what the records say beside the points.
    at_utc_s : the moment to plan from; None: nothing is planned.
    method, prior : as in ``fit``.
    solution : the fit, where it is made already (merged sessions).
    rule : when a calibration is done, and what may be there beside P1..P6.
    until_utc_s, points_left, struck : as in ``plan``.
    bolt_circle : for shim heights.

    Raises
    ------
    FitError
        Points that allow no fit.
    """
    if solution is None:
        solution = fit(points, context, method=method, prior=prior)
    expected = forecast(solution, context, rule=rule)
    findings = findings_of(
        solution, context, evidence, prior=prior, tolerance_deg=rule.tolerance_deg
    )
    assessment = assess(solution, expected, bolt_circle=bolt_circle, evidence=findings)
    planned = None
    if at_utc_s is not None:
        # What more points can tell is that of the fit, without what may be there beside it.
        posterior = (
            solution.posterior if isinstance(solution, MechanismSolution) else expected.posterior
        )
        planned = plan(
            posterior,
            context,
            at_utc_s,
            rule=rule,
            expected=expected,
            clear=assessment.clear,
            first=assessment.first,
            taken_utc_s=times_of(solution.points),
            until_utc_s=until_utc_s,
            points=points_left,
            struck=struck,
        )
    verdict = conclude(assessment, expected, planned)
    return Analysis(solution, expected, planned, findings, verdict)


def findings_of(
    solution: Solution,
    context: SkyContext,
    evidence: Evidence = NO_EVIDENCE,
    *,
    prior: Prior = DEFAULT_PRIOR,
    tolerance_deg: float = TOLERANCE_DEG,
) -> tuple[Finding, ...]:
    """Direct evidence first, then what the residuals ask for once missed counts are undone."""
    count = len(solution.points)
    many = count > MOST_TESTED
    tested = (
        thinned(solution, context, prior) if many else solution_to_test(solution, context, prior)
    )
    direct = (
        *evidence.findings(context, tested, tolerance_deg, solution.points),
        *contradicted(solution.points.copies),
    )
    if not_one_tracker_of_the_sun(direct, solution.points.labels):
        return (*direct, NOT_TESTED)
    return (
        *direct,
        *diagnose(
            tested,
            evidence.approach(tested.points.labels),
            losses=evidence.losses,
            tolerance_deg=tolerance_deg,
        ),
        *((thinning(count),) if many else ()),
    )
