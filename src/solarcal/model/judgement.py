"""All of it at once: fit, forecast, plan and verdict of one set of points."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from solarcal.model.finding import Finding
from solarcal.model.forecast import DEFAULT_RULE, Forecast, StoppingRule, forecast
from solarcal.model.known_physics import SkyContext
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_METHOD, DEFAULT_PRIOR, fit, posterior_without_prior
from solarcal.model.plan import Plan, Standing, plan, times_of
from solarcal.model.points import PointSet
from solarcal.model.prior import Prior
from solarcal.model.solution import Solution
from solarcal.model.terms import CONTROLLER_TERMS
from solarcal.model.verdict import BoltCircle, Verdict, assess, conclude


@dataclass(frozen=True, slots=True)
class Judgement:
    """What a set of points comes to; ``plan`` is None where no time was given to plan from."""

    solution: Solution
    forecast: Forecast
    plan: Plan | None
    verdict: Verdict

    def as_json(self) -> dict[str, Any]:
        """The fit's document with forecast and verdict in it, and the plan where there is one."""
        return {
            **self.solution.as_json(),
            "forecast": self.forecast.as_json(),
            "verdict": self.verdict.as_json(),
            **({} if self.plan is None else {"plan": self.plan.as_json()}),
        }


def judge_points(
    points: PointSet,
    context: SkyContext | None = None,
    *,
    method: str = DEFAULT_METHOD,
    prior: Prior = DEFAULT_PRIOR,
    terms: Iterable[str] = CONTROLLER_TERMS,
    rule: StoppingRule = DEFAULT_RULE,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    bolt_circle: BoltCircle | None = None,
) -> Judgement:
    """Fit, forecast, plan the rest of the day from ``at_utc_s`` (where given), and judge.

    Parameters and errors as in ``fit``, ``plan`` and ``assess``.
    """
    if context is None:
        context = SkyContext.for_points(points)
    solution = fit(points, context, method=method, prior=prior, terms=terms)
    return judge_solution(
        solution,
        context,
        rule=rule,
        at_utc_s=at_utc_s,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
        bolt_circle=bolt_circle,
    )


def judge_solution(
    solution: Solution,
    context: SkyContext,
    *,
    rule: StoppingRule = DEFAULT_RULE,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    bolt_circle: BoltCircle | None = None,
    evidence: Sequence[Finding] = (),
) -> Judgement:
    """The same for points already fitted, with what was seen beside them (``assess``)."""
    expected = forecast(solution, context, rule=rule)
    assessment = assess(solution, expected, bolt_circle=bolt_circle, evidence=evidence)
    planned = None
    if at_utc_s is not None:
        posterior = (
            solution.posterior
            if isinstance(solution, MechanismSolution)
            else posterior_without_prior(solution.points, context)
        )
        planned = plan(
            posterior,
            context,
            at_utc_s,
            rule=rule,
            standing=Standing.of(expected, clear=assessment.clear),
            taken_utc_s=times_of(solution.points),
            until_utc_s=until_utc_s,
            points=points_left,
            struck=struck,
        )
    return Judgement(solution, expected, planned, conclude(assessment, expected, planned))
