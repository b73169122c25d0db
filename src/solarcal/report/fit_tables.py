"""What a fit found: coefficients with their meaning on this mount, and how far to trust them."""

from solarcal.model.comparison import ModelComparison
from solarcal.model.fit import Solution
from solarcal.model.terms import Term
from solarcal.report.columns import columns, number, wrapped
from solarcal.units import ARCSEC_PER_DEG

_LEAN = {
    "azel": ("lean of tower top to the north", "lean of tower top to the east"),
    "tiltroll-ew": ("east end of the axis down", "east end of the axis to the south"),
    "tiltroll-ns": ("north end of the axis down", "north end of the axis to the east"),
    "polar": ("pole end of the axis down", "pole end of the axis to the east"),
}
_AXES = {
    "azel": ("azimuth", "zenith angle"),
    "tiltroll-ew": ("tilt", "roll"),
    "tiltroll-ns": ("tilt", "angle from north"),
    "polar": ("hour angle", "polar distance"),
}
_DECIMALS = {"deg": 4, "deg/deg": 6, "arcsec": 2}


def meaning(term: Term, geometry: str) -> str:
    """What a term is on a mount, in the field's words (10-physics, section 2, for P1..P6)."""
    axis1, axis2 = _AXES[geometry]
    north, east = _LEAN[geometry]
    return {
        "P1": north,
        "P2": f"zero offset of axis 1 ({axis1})",
        "P3": east,
        "P4": f"zero offset of axis 2 ({axis2})",
        "P5": f"gear-ratio error of axis 1 ({axis1})",
        "P6": f"gear-ratio error of axis 2 ({axis2})",
    }.get(term.name, term.meaning)


def coefficients_table(solution: Solution) -> str:
    """Fitted terms: value, one sigma, unit, meaning."""
    sigmas = [None] * len(solution.terms) if solution.sigmas is None else solution.sigmas.tolist()
    rows = [
        [
            term.name,
            number(value, _DECIMALS[term.unit], signed=True),
            number(sigma, _DECIMALS[term.unit]),
            term.unit,
            meaning(term, solution.geometry.name),
        ]
        for term, value, sigma in zip(
            solution.model_terms, solution.values.tolist(), sigmas, strict=True
        )
    ]
    return "\n".join(columns(("", "value", "sigma", "unit", "meaning"), rows, "<>><<"))


def fit_summary(solution: Solution) -> str:
    """Residuals, rank, condition, what cannot be told apart, and every note, one sentence each."""
    condition = solution.condition_number
    spread = solution.population_sd_deg
    # A fit of TPOINT terms is compared with others in their unit.
    fine = set(solution.units) == {"arcsec"}
    unit, per_deg, decimals = ("arcsec", ARCSEC_PER_DEG, 2) if fine else ("deg", 1.0, 4)

    def shown(value_deg: float) -> str:
        return f"{value_deg * per_deg:.{decimals}f}"

    lines = [
        f"{solution.n_points} points, method {solution.method}, rank {solution.rank} of "
        f"{len(solution.terms)}, condition number "
        + (f"{condition:.3g}" if condition < 1e12 else "beyond 1e12"),
        f"residual on the sky: rms {shown(solution.sky_rms_deg)} {unit}, "
        f"largest {shown(solution.sky_max_deg)}, population SD "
        + (shown(spread) if spread is not None else "not known yet"),
        f"residual of the axes: rms {shown(solution.axis1_rms_deg)} {unit} of axis 1, "
        f"{shown(solution.axis2_rms_deg)} of axis 2",
    ]
    for sentence in (*solution.inseparable, *solution.notes):
        lines += wrapped(f"- {sentence}", hang=2)
    if solution.message is not None:
        lines.append(f"*** {solution.message} ***")
    return "\n".join(lines)


def comparison_section(comparison: ModelComparison) -> str:
    """A published model beside the fit: each term, and how far the points are from the model."""
    title = "Published model"
    rows = [
        [
            name,
            number(published, _DECIMALS[unit], signed=True),
            number(published_sigma, _DECIMALS[unit]),
            number(fitted, _DECIMALS[unit], signed=True),
            number(fitted_sigma, _DECIMALS[unit]),
            number(
                None if published is None or fitted is None else fitted - published,
                _DECIMALS[unit],
                signed=True,
            ),
            unit,
        ]
        for name, unit, published, published_sigma, fitted, fitted_sigma in comparison.rows
    ]
    published_rms = comparison.published_sky_rms_arcsec
    return "\n".join(
        [
            title,
            "-" * len(title),
            comparison.caption,
            *columns(
                ("", "published", "sigma", "fitted", "sigma", "difference", "unit"), rows, "<>>>>><"
            ),
            "these points from the published model: sky rms "
            f"{comparison.sky_rms_deg * ARCSEC_PER_DEG:.2f} arcsec, largest "
            f"{comparison.sky_max_deg * ARCSEC_PER_DEG:.2f}"
            + (
                ""
                if published_rms is None
                else f"; the model gives {published_rms:.2f} for its own points"
            ),
        ]
    )
