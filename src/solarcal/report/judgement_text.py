"""Forecast, plan and verdict as text of at most 80 columns. Angles in degrees on the sky."""

from solarcal.model.analysis import Analysis
from solarcal.model.forecast import Forecast, percent
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.plan import Plan, PlannedStop
from solarcal.model.solution import Solution
from solarcal.model.verdict import Verdict
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS
from solarcal.report.columns import columns, number, wrapped
from solarcal.station.uploading import UploadOffer
from solarcal.timescale import format_utc

STATE_WORDS = {
    "done": "DONE: within the tolerance all year",
    "continue": "CONTINUE: more points",
    "not_today": "NOT TODAY: this day cannot reach the tolerance",
    "does_not_fit": "DOES NOT FIT: find the cause first",
}


def forecast_rows(forecast: Forecast, tolerance_deg: float) -> list[tuple[str, str]]:
    """What is expected over the year, and what it is made of: name, degrees."""
    rule, p = forecast.rule, forecast.probability_within_tolerance
    return [
        (
            f"sure that 95 % are within {tolerance_deg:g}",
            f"{percent(p, rule.probability)}  "
            f"{'enough' if forecast.sure else 'NOT ENOUGH'}: {100 * rule.probability:g} % is asked",
        ),
        ("95 % of the pointing is better than", rule.within_deg(forecast.year_p95_deg)),
        ("root mean square over the year", f"{forecast.year_rms_deg:.3f}"),
        ("  68 % sure to be below", f"{forecast.year_rms_below_deg(0.68):.3f}"),
        ("  95 % sure to be below", f"{forecast.year_rms_below_deg(0.95):.3f}"),
        ("largest of the year (95 % sure)", f"{forecast.year_max_deg:.3f}"),
        ("part that more points can remove", f"{forecast.parameters_rms_deg:.3f}"),
        ("part that the formula leaves", f"{forecast.known_rms_deg:.3f}"),
    ]


def forecast_table(forecast: Forecast, tolerance_deg: float) -> str:
    rows = forecast_rows(forecast, tolerance_deg)
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows)


def verdict_text(verdict: Verdict) -> str:
    """The state in words, then every reason as a sentence."""
    lines = [STATE_WORDS[verdict.state]]
    for reason in verdict.reasons:
        lines += wrapped(f"- {reason}", hang=2)
    return "\n".join(lines)


def mechanism_rows(solution: Solution) -> list[tuple[str, str]]:
    """What is wrong with the mount, one sigma each; empty for ``linear``."""
    if not isinstance(solution, MechanismSolution):
        return []
    m = solution.mechanism
    rows = [("lean", f"{m.lean_deg:.3f} +- {m.lean_sigma_deg:.3f} deg")]
    if m.lean_deg > m.lean_sigma_deg:
        what = "lean towards bearing" if solution.geometry.name == "azel" else "lean bearing"
        rows.append((what, f"{m.lean_bearing_deg:.0f} +- {m.lean_bearing_sigma_deg:.0f} deg"))
    for axis in (0, 1):
        rows.append(
            (
                f"zero offset of axis {axis + 1}",
                f"{m.offsets_deg[axis]:+.3f} +- {m.offset_sigmas_deg[axis]:.3f} deg",
            )
        )
    for axis in (0, 1):
        rows.append(
            (
                f"scale error of axis {axis + 1}",
                f"{m.scales[axis]:+.5f} +- {m.scale_sigmas[axis]:.5f} deg/deg",
            )
        )
    rows.append(("noise of one point", f"{m.noise_deg:.3f} deg on the sky, per axis"))
    return rows


def mechanism_table(solution: Solution) -> str:
    rows = mechanism_rows(solution)
    width = max((len(name) for name, _ in rows), default=0)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows)


def plan_table(plan: Plan) -> str:
    """What stopping at each remaining half hour would give; the advised one is marked."""
    rows = [_stop_row("now", plan.now, plan)]
    rows += [_stop_row(_time(stop.stop_utc_s), stop, plan) for stop in plan.stops]
    return "\n".join(columns(("stop, UTC", "points", "year rms", "95 %", "P", ""), rows, "<>>>><"))


def _stop_row(when: str, stop: PlannedStop, plan: Plan) -> list[str]:
    said = "done" if plan.reached_by(stop) else ""
    if stop is plan.recommended:
        said = f"<- advised{', ' + said if said else ''}"
    return [
        when,
        str(stop.points),
        number(stop.year_rms_deg, 3),
        number(stop.year_p95_deg, 3),
        number(stop.probability, 2),
        said,
    ]


def plan_text(judgement: Analysis) -> str:
    """The advice in one sentence, the schedule it means, and the table it rests on."""
    plan = judgement.plan
    assert plan is not None
    lines = [
        f"Planned from {format_utc(plan.at_utc_s, 0)[:16].replace('T', ' ')} UTC for a tolerance "
        f"of {plan.tolerance_deg:g} deg",
        "",
        *wrapped(_sentence(plan.sentence)),
    ]
    if plan.recommended.times_utc_s:
        times = ", ".join(_time(time) for time in plan.recommended.times_utc_s)
        lines += wrapped(f"Points at {times} UTC.", hang=2)
    return "\n".join([*lines, "", plan_table(plan), "", verdict_text(judgement.verdict)])


def rounding_table(offer: UploadOffer) -> str:
    """What the unit's resolution makes of a fit, and what that does to the year."""
    rows = []
    for name, unit, fitted, kept in zip(
        COEFFICIENT_NAMES,
        COEFFICIENT_UNITS,
        offer.fitted.as_tuple(),
        offer.rounded.as_tuple(),
        strict=True,
    ):
        decimals = 7 if unit == "deg/deg" else 5
        rows.append(
            [name, *(number(v, decimals, True) for v in (fitted, kept, kept - fitted)), unit]
        )
    exact, kept_year = offer.judgement.forecast, offer.kept
    return "\n".join(
        [
            *columns(("", "fitted", "as the unit keeps it", "rounding", "unit"), rows, "<>>><"),
            *(
                f"over the year, {what}: {before:.4f} deg as fitted, {after:.4f} as kept"
                for what, before, after in (
                    ("95 %", exact.year_p95_deg, kept_year.year_p95_deg),
                    ("rms ", exact.year_rms_deg, kept_year.year_rms_deg),
                )
            ),
            "probability of the tolerance: "
            f"{exact.probability_within_tolerance:.3f} as fitted, "
            f"{kept_year.probability_within_tolerance:.3f} as kept",
        ]
    )


def _time(utc_s: float) -> str:
    return format_utc(utc_s, 0)[11:16]


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."
