"""Done, continue, not today, or does not fit: what a fit and its forecast come to.

The rule is the forecast's ``StoppingRule``. ``assess`` gathers what speaks against a fit before the
day is planned, ``conclude`` adds what the plan makes of the rest of the day: so that verdict, plan
and next step never contradict one another.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from solarcal.decimals import counted
from solarcal.model.cross_checks import (
    FEWEST_TO_STOP,
    LAST_POINTS,
    CrossChecks,
    cross_check,
    out_of_order,
    sigmas_too_large,
)
from solarcal.model.evidence.direct import weigh
from solarcal.model.finding import Finding
from solarcal.model.forecast import Forecast
from solarcal.model.gears import unseen_gears, wrong_ratios
from solarcal.model.mechanism_solution import (
    SHIM_FIRST_DEG,
    BaseTilt,
    MechanismSolution,
    Shim,
    base_tilt,
    shim_heights,
    wind,
)
from solarcal.model.plan import Plan
from solarcal.model.solution import Solution
from solarcal.site import BoltCircle
from solarcal.stopping_rule import StoppingRule, apart_from

State = Literal["done", "continue", "not_today", "does_not_fit"]
STATE_WORDS: dict[State, str] = {
    "done": "DONE: within the tolerance all year",
    "continue": "CONTINUE: more points",
    "not_today": "NOT TODAY: this day cannot reach the tolerance",
    "does_not_fit": "DOES NOT FIT: find the cause first",
}

NOISE_LIMIT_DEG = 0.15
"""A point that scatters more was not read on a spot."""
SIGMA_FACTOR_LIMIT = 3.0
"""Noise so many times as large as the points' own sigmas say."""
BLUNDER_SHARE_LIMIT = 0.25
LEFT_OUT_FACTOR = 3.0
NORMAL_95 = 2.448
"""Of errors normal in two directions 95 % are within so many sigmas of one: sqrt(-2 ln 0.05)."""
LEAST_SHARE = 0.01
"""Of the posterior: what is less likely is not worth a sentence."""
STILL_SURE = 0.8
"""With an error that the points do not exclude: below it the verdict names the error."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """The state and the sentences it rests on, the deciding one first; ``first``: what to do before
    more points can help."""

    state: State
    reasons: tuple[str, ...]
    first: str = ""
    checks: CrossChecks | None = None
    base: BaseTilt | None = None
    shims: tuple[Shim, ...] = ()

    @property
    def words(self) -> str:
        """The state, and what it means for what comes next."""
        if self.state == "continue" and self.first:
            return "CONTINUE: first settle what is named"
        return STATE_WORDS[self.state]

    def as_json(self) -> dict[str, Any]:
        document: dict[str, Any] = {"state": self.state, "reasons": list(self.reasons)}
        if self.shims:
            document["shims"] = [
                {"bolt_bearing_deg": shim.bolt_bearing_deg, "height_mm": shim.height_mm}
                for shim in self.shims
            ]
            if self.base is not None:
                document["base"] = {
                    "tilt_deg": self.base.tilt_deg, "bearing_deg": self.base.bearing_deg
                }  # fmt: skip
        return document


@dataclass(frozen=True, slots=True)
class Assessment:
    """What is known of a fit before the day is planned.

    ``wrong`` says that it does not fit, ``reservations`` what keeps it from being done although
    the forecast would allow it, ``doubts`` those of them that more points do not settle,
    ``remarks`` the rest.
    """

    wrong: tuple[str, ...]
    doubts: tuple[str, ...]
    reservations: tuple[str, ...]
    remarks: tuple[str, ...]
    checks: CrossChecks | None
    base: BaseTilt | None
    shims: tuple[Shim, ...]

    @property
    def first(self) -> str:
        """What more points alone do not settle."""
        if self.wrong:
            return "first find why the points do not fit"
        return "first settle what the verdict names" if self.doubts else ""

    @property
    def clear(self) -> bool:
        """Nothing known speaks against the fit."""
        return not self.wrong and not self.reservations


def assess(
    solution: Solution,
    expected: Forecast,
    *,
    bolt_circle: BoltCircle | None = None,
    evidence: Sequence[Finding] = (),
) -> Assessment:
    """What speaks against a fit.

    Parameters
    ----------
    solution, expected : the fit and its forecast, with the rule it is held to.
    bolt_circle : for shim heights.
    evidence : what clocks, reference checks, settings and read-outs show directly.
    """
    tolerance_deg = expected.rule.tolerance_deg
    checks = cross_check(solution) if isinstance(solution, MechanismSolution) else None
    base, shims, lean_reasons = _lean(solution, tolerance_deg, bolt_circle)
    seen = weigh(evidence, set(solution.points.labels), tolerance_deg)
    wrong = [*lean_reasons, *seen.wrong, *_misfits(solution, checks, expected.rule)]
    waiting, remarks = _borne_out(solution, checks, tolerance_deg)
    # Few points hardly know their scatter; while they are not sure anyway, it is no news.
    doubts = (*seen.waiting, *(_scatter(solution, expected.rule) if expected.sure else ()))
    if expected.sure and isinstance(solution, MechanismSolution):
        remarks = [*unseen_gears(solution, expected), *remarks]
    return Assessment(
        wrong=tuple(wrong),
        doubts=doubts,
        reservations=(*doubts, *waiting),
        remarks=(*seen.cautions, *remarks),
        checks=checks,
        base=base,
        shims=shims,
    )


def conclude(assessment: Assessment, expected: Forecast, planned: Plan | None = None) -> Verdict:
    """The verdict; without a plan no day is called hopeless."""
    state: State
    sure = sure_sentence(expected)
    if assessment.wrong:
        state = "does_not_fit"
        reasons = [*assessment.wrong, *assessment.doubts, sure, *assessment.remarks]
    elif expected.sure:
        state = "continue" if assessment.reservations else "done"
        reasons = [*assessment.reservations, sure, *_large_cross_axis(expected)]
        reasons += assessment.remarks
    elif planned is not None and planned.hopeless:
        state = "not_today"
        reasons = [planned.sentence, sure, *assessment.reservations, *assessment.remarks]
    else:
        state = "continue"
        reasons = [sure, *assessment.reservations, *assessment.remarks]
    first = assessment.first if expected.sure or assessment.wrong else ""
    return Verdict(
        state, tuple(reasons), first, assessment.checks, assessment.base, assessment.shims
    )


def sure_sentence(expected: Forecast) -> str:
    """How sure one can be of the year, and how sure one is asked to be."""
    rule = expected.rule
    return (
        f"{expected.sure_words} that "
        f"95 % of the year's pointing is within {rule.tolerance_deg:g} deg; expected: 95 % within "
        f"{rule.within_deg(expected.year_p95_deg)} deg"
    )


def _large_cross_axis(expected: Forecast) -> list[str]:
    """What the probability does not say: it is smaller where such an error is really there."""
    return [
        f"not excluded: {large.what} above {large.above_deg:g} deg ({100 * large.share:.0f} %); "
        f"with it only about {10 * round(10 * large.within)} % sure"
        for large in expected.large_cross_axis
        if large.share >= LEAST_SHARE and large.within <= STILL_SURE
    ]


def _lean(
    solution: Solution, tolerance_deg: float, bolt_circle: BoltCircle | None
) -> tuple[BaseTilt | None, tuple[Shim, ...], list[str]]:
    if not isinstance(solution, MechanismSolution):
        return None, (), []
    base, shims = base_and_shims(solution, bolt_circle)
    mechanism = solution.mechanism
    if mechanism.lean_deg - mechanism.lean_sigma_deg <= SHIM_FIRST_DEG:
        return base, shims, []
    reasons = [
        f"the controller's formula cannot hold {tolerance_deg:g} deg with a lean of "
        f"{mechanism.lean_deg:.1f} deg; shim first"
    ]
    if base.tilt_deg > 0.5:
        reasons.append(
            f"the base is {base.tilt_deg:.2f} deg from level, the top towards "
            f"{base.bearing_deg:.0f} deg ({wind(base.bearing_deg)}): lift that side"
        )
        if shims:
            reasons.append(f"shims: {shims_words(shims)}")
    if abs(base.turn_deg) > 0.5:
        way = "clockwise" if base.turn_deg > 0.0 else "counterclockwise"
        reasons.append(
            f"the base is turned: turn it {abs(base.turn_deg):.2f} deg {way}, seen from above"
        )
    return base, shims, reasons


def base_and_shims(
    solution: MechanismSolution, bolt_circle: BoltCircle | None
) -> tuple[BaseTilt, tuple[Shim, ...]]:
    """How the base stands, and what levels it; no shims where its bolts are not known."""
    base = base_tilt(solution.posterior.mean, solution.geometry)
    if bolt_circle is None:
        return base, ()
    return base, shim_heights(base.tilt_deg, base.bearing_deg, bolt_circle)


def shims_words(shims: Sequence[Shim]) -> str:
    """Heights and bearings, on one line."""
    return ", ".join(
        f"{shim.height_mm:.1f} mm at {shim.bolt_bearing_deg:.0f} deg" for shim in shims
    )


def _misfits(solution: Solution, checks: CrossChecks | None, rule: StoppingRule) -> list[str]:
    reasons, spot_deg = [], rule.unmodelled.spot_deg
    if solution.message is not None:
        reasons.append(f"{solution.message}: these numbers cannot be a tracker's")
    if not isinstance(solution, MechanismSolution) or checks is None:
        return reasons
    noise, sigma = solution.noise_deg, solution.points.sigma_deg
    if (
        sigma is None
        and noise > max(NOISE_LIMIT_DEG, SIGMA_FACTOR_LIMIT * spot_deg)
        and solution.n_points >= FEWEST_TO_STOP
    ):
        reasons.append(
            f"the points scatter by {noise:.2f} deg about the fit; a spot is read to "
            f"{spot_deg:g} deg"
        )
    if sigma is not None:
        expected = float((sigma**2).mean() ** 0.5)
        if noise > SIGMA_FACTOR_LIMIT * expected:
            reasons.append(
                f"the points scatter by {noise:.3f} deg, {noise / expected:.1f} times as much as "
                "their sigmas say"
            )
    bad, n = len(solution.outliers), solution.n_points
    if bad > 1 and bad > BLUNDER_SHARE_LIMIT * n:
        or_sigmas = "" if sigma is None else ", or sigmas that are too small"
        reasons.append(
            f"{bad} of {n} points do not fit the others: more than single blunders{or_sigmas}"
        )
    if out_of_order(checks, rule.tolerance_deg):
        reasons.append(
            f"trend in the residuals (p = {checks.order_probability:.2g}, limit "
            f"{checks.order_limit:.2g} for {n} points): "
            f"{sigmas_too_large(solution, checks) or 'the model lacks an effect'}"
        )
    return [*wrong_ratios(solution), *reasons] if reasons else []


def _scatter(solution: Solution, rule: StoppingRule) -> list[str]:
    """What the points scatter by beyond how well a spot is read may be the tracker's own."""
    if not isinstance(solution, MechanismSolution):
        return []
    sigma, noise = solution.points.sigma_deg, solution.noise_deg
    read_deg = rule.unmodelled.spot_deg if sigma is None else float((sigma**2).mean() ** 0.5)
    own_deg = NORMAL_95 * max(noise**2 - read_deg**2, 0.0) ** 0.5
    if own_deg <= rule.tolerance_deg:
        return []
    return [
        f"the points scatter by {noise:.3f} deg about the fit, and a spot is read to "
        f"{read_deg:.2g} deg: if the rest is the tracker's own, 95 % of its pointing is within "
        f"{own_deg:.2f} deg only; read one spot ten times to find out (--unmodelled spot_deg=)"
    ]


def _borne_out(
    solution: Solution, checks: CrossChecks | None, tolerance_deg: float
) -> tuple[list[str], list[str]]:
    """What speaks against stopping although the forecast would allow it; and the rest."""
    waiting: list[str] = []
    told: list[str] = []
    if solution.n_points < FEWEST_TO_STOP:
        waiting.append(
            f"only {counted(solution.n_points, 'point')}: at least "
            f"{FEWEST_TO_STOP} points are needed for a consistency check"
        )
    if checks is None or not isinstance(solution, MechanismSolution):
        return waiting, told
    if checks.left_out_rms_deg is not None:
        limit = max(tolerance_deg, LEFT_OUT_FACTOR * solution.noise_deg)
        (waiting if checks.left_out_rms_deg > limit else told).append(
            f"leave-one-out rms {apart_from(checks.left_out_rms_deg, limit)} deg (limit "
            f"{limit:.3g} deg)"
        )
    if checks.last_moved_deg is not None:
        most = tolerance_deg / 2.0
        (waiting if checks.last_moved_deg > most else told).append(
            f"the last {LAST_POINTS} points changed the forecast by "
            f"{apart_from(checks.last_moved_deg, most)} deg rms (limit {most:.3g} deg)"
        )
    if checks.order_probability is not None and not out_of_order(checks, tolerance_deg):
        told.append(
            f"no trend in the residuals (p = {checks.order_probability:.2g}, limit "
            f"{checks.order_limit:.2g})"
        )
    too_large = sigmas_too_large(solution, checks)
    if too_large and not out_of_order(checks, tolerance_deg):
        told.append(too_large)
    return waiting, told
