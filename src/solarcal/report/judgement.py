"""What a fit found and what it is worth: coefficients with their meaning, forecast, plan, verdict.

Angles in degrees on the sky.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from solarcal.decimals import counted
from solarcal.model.analysis import Analysis
from solarcal.model.forecast import Forecast
from solarcal.model.mechanism_solution import BaseTilt, MechanismSolution, Shim, wind
from solarcal.model.plan import Plan, PlannedStop
from solarcal.model.points import Points
from solarcal.model.solution import Solution
from solarcal.model.terms import Term
from solarcal.model.verdict import Verdict, shims_words
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS
from solarcal.report.blocks import Block, Blocks, Facts, Prose, Sentences, Table, number
from solarcal.session.points import PointTable
from solarcal.station.published_model import ModelComparison
from solarcal.station.uploading import UploadOffer
from solarcal.stopping_rule import percent
from solarcal.timescale import format_utc, time_of_day
from solarcal.units import ARCSEC_PER_DEG, RAD_PER_DEG, FloatArray, rms

_LEAN = {
    "azel": ("lean of tower top to the north", "lean of tower top to the east"),
    "tiltroll-ew": ("east end of the axis down", "east end of the axis to the south"),
    "tiltroll-ns": ("north end of the axis down", "north end of the axis to the east"),
    "polar": ("pole end of the axis down", "pole end of the axis to the east"),
}
_AXIS2 = {
    "azel": " (zenith angle)",
    "tiltroll-ns": " (angle from north)",
    "polar": " (polar distance)",
}
"""What the controller counts there, where the axis is called by another angle."""

DECIMALS = {"deg": 4, "deg/deg": 6, "arcsec": 3}
"""How many a coefficient is shown with, by its unit."""


def meaning(term: Term, geometry: str) -> str:
    """What a term is on a mount, in the field's words (10-physics, section 2, for P1..P6)."""
    north, east = _LEAN[geometry]
    called = term.called.get(geometry, term.meaning)
    return {
        "P1": north,
        "P2": f"{called} of axis 1",
        "P3": east,
        "P4": f"{called} of axis 2{_AXIS2.get(geometry, '')}",
        "P5": f"{called}, gear-ratio error of axis 1",
        "P6": f"{called}, gear-ratio error of axis 2",
    }.get(term.name, term.meaning)


def values_table(
    headings: tuple[str, ...],
    rows: Iterable[tuple[str, str, *tuple[float | None, ...]]],
    more: int = 0,
) -> Table:
    """Rows of name, unit and values; the unit last.

    As many decimals as the unit asks for, and ``more``.
    """
    return Table(
        headings,
        tuple(
            (name, *(number(value, DECIMALS[unit] + more, True) for value in values), unit)
            for name, unit, *values in rows
        ),
        f"<{'>' * (len(headings) - 2)}<",
    )


def coefficients_table(solution: Solution) -> Table:
    """Fitted terms: value, one sigma, unit, meaning."""
    geometry = solution.geometry.name
    rows = tuple(
        (
            term.name,
            number(value, DECIMALS[term.unit], signed=True),
            number(sigma, DECIMALS[term.unit]),
            term.unit,
            meaning(term, geometry),
        )
        for term, value, sigma in zip(
            solution.model_terms, solution.values.tolist(), solution.sigma_list(), strict=True
        )
    )
    return Table(("", "value", "sigma", "unit", "meaning"), rows, "<>><<")


def formula_residuals_deg(solution: Solution, points: Points | PointTable) -> FloatArray:
    """What the controller's formula leaves of each point on the sky, (n,); NaN where not known.

    Of an earlier session's points with what moved after it put back; those of a solution are.
    """
    if isinstance(points, PointTable):
        e1, e2 = solution.predict_of_deg(points.sources, points.ax1_deg, points.ax2_deg)
    else:
        e1, e2 = solution.predict_deg(points.ax1_deg, points.ax2_deg)
    cross = (points.err1_deg - e1) * np.sin(points.ax2_deg * RAD_PER_DEG)
    return np.hypot(cross, points.err2_deg - e2)


def fit_summary(solution: Solution) -> Blocks:
    """Residuals, rank, condition, inseparable parameters, and every note, one sentence each."""
    condition = solution.condition_number
    spread = solution.population_sd_deg
    # A fit of TPOINT terms is compared with others in their unit.
    fine = set(solution.units) == {"arcsec"}
    unit, per_deg, decimals = ("arcsec", ARCSEC_PER_DEG, 3) if fine else ("deg", 1.0, 4)

    def shown(value_deg: float) -> str:
        return f"{value_deg * per_deg:.{decimals}f}"

    of_formula: tuple[str, ...] = ()
    if isinstance(solution, MechanismSolution):
        left_deg = formula_residuals_deg(solution, solution.points)
        of_formula = (
            "residual of the formula, as beside each point: rms "
            f"{shown(rms(left_deg))} {unit}, largest {shown(float(left_deg.max()))}",
        )
    said = Prose(
        (
            f"{counted(solution.n_points, 'point')}, method {solution.method}, rank "
            f"{solution.rank} of {len(solution.terms)}, condition number "
            + (f"{condition:.3g}" if condition < 1e12 else "beyond 1e12"),
            f"residual on the sky: rms {shown(solution.sky_rms_deg)} {unit}, "
            f"largest {shown(solution.sky_max_deg)}, population SD "
            + (shown(spread) if spread is not None else "not known yet"),
            *of_formula,
            f"residual of the axes: rms {shown(solution.axis1_rms_deg)} {unit} of axis 1, "
            f"{shown(solution.axis2_rms_deg)} of axis 2",
        )
    )
    blocks: list[Block] = [said]
    if notes := (*solution.inseparable, *solution.notes):
        blocks.append(Sentences(notes))
    if solution.message is not None:
        blocks.append(Prose((f"*** {solution.message} ***",)))
    return tuple(blocks)


def comparison_blocks(comparison: ModelComparison) -> Blocks:
    """A published model beside the fit: each term, and how far the points are from the model."""
    rows = []
    for name, unit, published, published_sigma, fitted, fitted_sigma in comparison.rows:
        off = None if published is None or fitted is None else fitted - published
        decimals = DECIMALS[unit]
        rows.append(
            (
                name,
                number(published, decimals, signed=True),
                number(published_sigma, decimals),
                number(fitted, decimals, signed=True),
                number(fitted_sigma, decimals),
                number(off, decimals, signed=True),
                unit,
            )
        )
    headings = ("", "published", "sigma", "fitted", "sigma", "difference", "unit")
    published_rms = comparison.published_sky_rms_arcsec
    return (
        Prose((comparison.caption,)),
        Table(headings, tuple(rows), "<>>>>><"),
        Prose(
            (
                "these points from the published model: sky rms "
                f"{comparison.sky_rms_deg * ARCSEC_PER_DEG:.2f} arcsec, largest "
                f"{comparison.sky_max_deg * ARCSEC_PER_DEG:.2f}"
                + (
                    ""
                    if published_rms is None
                    else f"; the model gives {published_rms:.2f} for its own points"
                ),
            )
        ),
    )


def forecast_facts(forecast: Forecast, tolerance_deg: float) -> Facts:
    """What is expected over the year, and what it is made of: name, degrees."""
    rule, p = forecast.rule, forecast.probability_within_tolerance
    return Facts(
        (
            (
                f"sure that 95 % are within {tolerance_deg:g}",
                f"{percent(p, rule.probability)}  {'enough' if forecast.sure else 'NOT ENOUGH'}: "
                f"{100 * rule.probability:g} % needed",
            ),
            ("95 % of the pointing is better than", rule.within_deg(forecast.year_p95_deg)),
            ("root mean square over the year", f"{forecast.year_rms_deg:.3f}"),
            ("  68 % sure to be below", f"{forecast.year_rms_below_deg(0.68):.3f}"),
            ("  95 % sure to be below", f"{forecast.year_rms_below_deg(0.95):.3f}"),
            ("largest of the year (95 % sure)", f"{forecast.year_max_deg:.3f}"),
            ("part that more points can remove", f"{forecast.parameters_rms_deg:.3f}"),
            ("part that the formula leaves", f"{forecast.known_rms_deg:.3f}"),
        )
    )


def verdict_blocks(verdict: Verdict) -> Blocks:
    """The state in words, then every reason as a sentence."""
    return Prose((verdict.words,)), Sentences(verdict.reasons)


def mechanism_facts(solution: Solution) -> Facts:
    """What is wrong with the mount, one sigma each; empty for ``linear``."""
    if not isinstance(solution, MechanismSolution):
        return Facts(())
    m = solution.mechanism
    rows = [("lean", f"{m.lean_deg:.3f} +- {m.lean_sigma_deg:.3f} deg")]
    if m.lean_deg > m.lean_sigma_deg:
        what = "lean towards bearing" if solution.geometry.name == "azel" else "lean bearing"
        rows.append((what, f"{m.lean_bearing_deg:.0f} +- {m.lean_bearing_sigma_deg:.0f} deg"))
    for axis in (0, 1):
        rows.append(
            (
                f"zero offset of axis {axis + 1}",
                f"{m.offsets_deg[axis]:+z.3f} +- {m.offset_sigmas_deg[axis]:.3f} deg",
            )
        )
    for axis in (0, 1):
        rows.append(
            (
                f"scale error of axis {axis + 1}",
                f"{m.scales[axis]:+z.5f} +- {m.scale_sigmas[axis]:.5f} deg/deg",
            )
        )
    rows.append(("noise of one point", f"{m.noise_deg:.3f} deg on the sky, per axis"))
    return Facts(tuple(rows))


def shim_sentence(base: BaseTilt, shims: Sequence[Shim]) -> str:
    """What levels the base, on one line."""
    return (
        f"shims: {shims_words(shims)}: they level the base, {base.tilt_deg:.2f} deg low towards "
        f"{base.bearing_deg:.0f} deg ({wind(base.bearing_deg)})"
    )


def shims_blocks(base: BaseTilt | None, shims: Sequence[Shim]) -> Blocks:
    """Height at each bolt; nothing where the bolts are not known."""
    if base is None or not shims:
        return ()
    rows = tuple((number(shim.bolt_bearing_deg, 0), number(shim.height_mm, 1)) for shim in shims)
    return (
        Prose(
            (
                f"The base is {base.tilt_deg:.2f} deg from level, low towards "
                f"{base.bearing_deg:.0f} deg ({wind(base.bearing_deg)}). Put under it, at each "
                "bolt:",
            )
        ),
        Table(("bolt at, deg", "shim, mm"), rows, ">>"),
    )


PLAN_HEADINGS = ("stop, UTC", "points", "year rms", "95 %", "P", "")
PLAN_ALIGNMENT = "<>>>><"


def plan_table(plan: Plan) -> Table:
    """What stopping at each remaining half hour would give; the advised one is marked."""
    rows = [plan_row(plan, "now", plan.now)]
    rows += [plan_row(plan, time_of_day(stop.stop_utc_s), stop) for stop in plan.stops]
    return Table(PLAN_HEADINGS, tuple(rows), PLAN_ALIGNMENT)


def plan_row(
    plan: Plan, when: str, stop: PlannedStop | None, remarks: Sequence[str] = ()
) -> tuple[str, ...]:
    """Of stopping then: the points until then and their forecast; blank where no one stops.

    The remarks stand before what the plan says of it.
    """
    if stop is None:
        return (when, "", "", "", "", ", ".join(remarks))
    advised = ["<- advised"] if stop is plan.recommended else []
    done = ["done"] if plan.reached_by(stop) else []
    return (
        when,
        str(stop.points),
        number(stop.year_rms_deg, 3),
        number(stop.year_p95_deg, 3),
        number(stop.probability, 2),
        ", ".join([*remarks, *advised, *done]),
    )


def plan_blocks(judgement: Analysis) -> Blocks:
    """The advice in one sentence, the schedule it means, and the table it rests on."""
    plan = judgement.plan
    assert plan is not None
    advice = [
        f"Planned from {format_utc(plan.at_utc_s, 0)[:16].replace('T', ' ')} UTC for a tolerance "
        f"of {plan.tolerance_deg:g} deg",
        "",
        _sentence(plan.sentence),
    ]
    if plan.recommended.times_utc_s:
        times = ", ".join(time_of_day(time) for time in plan.recommended.times_utc_s)
        advice.append(f"Points at {times} UTC.")
    gap = Prose(("",))
    return Prose((*advice, "")), plan_table(plan), gap, *verdict_blocks(judgement.verdict)


def rounding_blocks(offer: UploadOffer) -> Blocks:
    """What the unit's resolution makes of a fit, and what that does to the year."""
    values = offer.fitted.as_tuple(), offer.rounded.as_tuple()
    rows = zip(COEFFICIENT_NAMES, COEFFICIENT_UNITS, *values, strict=True)
    exact, kept_year = offer.judgement.forecast, offer.kept
    return (
        values_table(
            ("", "fitted", "as the unit stores it", "rounding", "unit"),
            ((*row, row[3] - row[2]) for row in rows),
            more=1,
        ),
        Prose(
            (
                *(
                    f"over the year, {what}: {before:.4f} deg as fitted, {after:.4f} as stored"
                    for what, before, after in (
                        ("95 %", exact.year_p95_deg, kept_year.year_p95_deg),
                        ("rms ", exact.year_rms_deg, kept_year.year_rms_deg),
                    )
                ),
                f"probability of the tolerance: {exact.probability_within_tolerance:.3f} as "
                f"fitted, {kept_year.probability_within_tolerance:.3f} as stored",
            )
        ),
    )


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."
