"""Stop, go on, give up for today, or look what is the matter."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from solarcal.model.cross_checks import LAST_POINTS, CrossChecks, cross_check
from solarcal.model.evidence.weighing import weigh
from solarcal.model.finding import Finding
from solarcal.model.forecast import TOLERANCE_DEG, Forecast
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.shims import SHIM_FIRST_DEG, BaseTilt, Shim, base_tilt, shim_heights, wind
from solarcal.model.solution import Solution

State = Literal["done", "continue", "not_today", "does_not_fit"]

ORDER_LIMIT = 0.01
"""Residuals that chance would order like this less often are not noise."""
NOISE_LIMIT_DEG = 0.15
"""A point that scatters more was not read on a spot."""
SIGMA_FACTOR_LIMIT = 3.0
"""Noise so many times as large as the points' own sigmas say."""
BLUNDER_SHARE_LIMIT = 0.25
LEFT_OUT_FACTOR = 3.0
FEWEST_TO_STOP = 4


@dataclass(frozen=True, slots=True)
class BoltCircle:
    """The base plate's bolts, for shims."""

    diameter_mm: float
    bolts: int = 4
    first_bolt_bearing_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """The state and the sentences it rests on, the deciding one first."""

    state: State
    reasons: tuple[str, ...]
    checks: CrossChecks | None = None
    base: BaseTilt | None = None
    shims: tuple[Shim, ...] = ()

    def as_json(self) -> dict[str, Any]:
        document: dict[str, Any] = {"state": self.state, "reasons": list(self.reasons)}
        if self.shims:
            document["shims"] = [
                {"bolt_bearing_deg": shim.bolt_bearing_deg, "height_mm": shim.height_mm}
                for shim in self.shims
            ]
        return document


def judge(
    solution: Solution,
    expected: Forecast,
    *,
    tolerance_deg: float = TOLERANCE_DEG,
    best_today_deg: float | None = None,
    bolt_circle: BoltCircle | None = None,
    evidence: Sequence[Finding] = (),
) -> Verdict:
    """The verdict on a fit.

    Parameters
    ----------
    solution, expected
        The fit and its forecast.
    tolerance_deg
        Compared with the forecast's ``year_p95_deg``.
    best_today_deg
        The plan's best of the day; without it no day is called hopeless.
    bolt_circle
        For shim heights where the tower leans too much.
    evidence
        What clocks, reference checks, settings and read-outs say by themselves.
    """
    checks = cross_check(solution) if isinstance(solution, MechanismSolution) else None
    base, shims, lean_reasons = _lean(solution, tolerance_deg, bolt_circle)
    seen = weigh(evidence, set(solution.points.labels), tolerance_deg)
    wrong = [*lean_reasons, *seen.wrong, *_misfits(solution, checks)]
    p95 = expected.year_p95_deg
    forecast_reason = (
        f"over the year 95 % of the pointing is expected within {p95:.3f} deg "
        f"({'within' if p95 <= tolerance_deg else 'above'} the tolerance of {tolerance_deg:g} deg)"
    )
    waiting, told = _borne_out(solution, checks, tolerance_deg)
    waiting = [*seen.waiting, *waiting]
    told = [*seen.cautions, *told]
    state: State
    if wrong:
        state, reasons = "does_not_fit", [*wrong, *seen.waiting, forecast_reason, *told]
    elif p95 <= tolerance_deg:
        state = "continue" if waiting else "done"
        reasons = [*waiting, forecast_reason, *told]
    elif best_today_deg is not None and best_today_deg > tolerance_deg:
        state = "not_today"
        reasons = [
            f"today cannot do better than {best_today_deg:.3f} deg, the tolerance is "
            f"{tolerance_deg:g} deg",
            forecast_reason,
            *told,
        ]
    else:
        state, reasons = "continue", [forecast_reason, *waiting, *told]
    return Verdict(state, tuple(reasons), checks, base, shims)


def _lean(
    solution: Solution, tolerance_deg: float, bolt_circle: BoltCircle | None
) -> tuple[BaseTilt | None, tuple[Shim, ...], list[str]]:
    if not isinstance(solution, MechanismSolution):
        return None, (), []
    base = base_tilt(solution.posterior.mean, solution.geometry)
    mechanism = solution.mechanism
    if mechanism.lean_deg - mechanism.lean_sigma_deg <= SHIM_FIRST_DEG:
        return base, (), []
    reasons = [
        f"the controller's formula cannot hold {tolerance_deg:g} deg with a lean of "
        f"{mechanism.lean_deg:.1f} deg; shim first"
    ]
    shims: tuple[Shim, ...] = ()
    if base.tilt_deg > 0.5:
        reasons.append(
            f"the base is {base.tilt_deg:.2f} deg from level, the top towards "
            f"{base.bearing_deg:.0f} deg ({wind(base.bearing_deg)}): lift that side"
        )
        if bolt_circle is not None:
            shims = shim_heights(
                base.tilt_deg,
                base.bearing_deg,
                bolt_circle.diameter_mm,
                bolt_circle.bolts,
                bolt_circle.first_bolt_bearing_deg,
            )
            heights = ", ".join(
                f"{shim.height_mm:.1f} mm at {shim.bolt_bearing_deg:.0f} deg" for shim in shims
            )
            reasons.append(f"shims: {heights}")
    if abs(base.turn_deg) > 0.5:
        way = "clockwise" if base.turn_deg > 0.0 else "counterclockwise"
        reasons.append(
            f"the base is turned: turn it {abs(base.turn_deg):.2f} deg {way}, seen from above"
        )
    return base, shims, reasons


def _misfits(solution: Solution, checks: CrossChecks | None) -> list[str]:
    reasons = []
    if solution.message is not None:
        reasons.append(f"{solution.message}: these numbers cannot be a tracker's")
    if not isinstance(solution, MechanismSolution) or checks is None:
        return reasons
    noise, sigma = solution.noise_deg, solution.points.sigma_deg
    if sigma is None and noise > NOISE_LIMIT_DEG and solution.n_points >= FEWEST_TO_STOP:
        reasons.append(
            f"the points scatter by {noise:.2f} deg about the fit; a spot is read to 0.03 deg"
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
        reasons.append(f"{bad} of {n} points do not fit the others: more than accidents")
    if checks.order_probability is not None and checks.order_probability < ORDER_LIMIT:
        reasons.append(
            "the residuals follow each other in time; chance does so in "
            f"{100.0 * checks.order_probability:.1f} % of cases: something is not in the model"
        )
    return reasons


def _borne_out(
    solution: Solution, checks: CrossChecks | None, tolerance_deg: float
) -> tuple[list[str], list[str]]:
    """What speaks against stopping although the forecast would allow it; and the rest."""
    waiting: list[str] = []
    told: list[str] = []
    if solution.n_points < FEWEST_TO_STOP:
        waiting.append(
            f"only {solution.n_points} point{'s' if solution.n_points > 1 else ''}: fewer than "
            f"{FEWEST_TO_STOP} cannot contradict each other"
        )
    if checks is None or not isinstance(solution, MechanismSolution):
        return waiting, told
    if checks.left_out_rms_deg is not None:
        limit = max(tolerance_deg, LEFT_OUT_FACTOR * solution.noise_deg)
        (waiting if checks.left_out_rms_deg > limit else told).append(
            f"each point predicted from the others is met to {checks.left_out_rms_deg:.3f} deg rms"
        )
    if checks.last_moved_deg is not None:
        (waiting if checks.last_moved_deg > tolerance_deg / 2.0 else told).append(
            f"the last {LAST_POINTS} points moved the year by {checks.last_moved_deg:.3f} deg rms"
        )
    if checks.order_probability is not None and checks.order_probability >= ORDER_LIMIT:
        told.append(
            "the residuals look random: chance orders them so or more strongly in "
            f"{100.0 * checks.order_probability:.0f} % of cases"
        )
    return waiting, told
