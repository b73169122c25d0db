"""A screwjack's SJP#1-3 from measured lengths, its dead points, what a wrong R1 does."""

from collections.abc import Sequence
from dataclasses import asdict

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.instruments.form import Answer, Drawing, Form
from solarcal.mount.drive import ScrewjackDrive, format_drive
from solarcal.mount.screwjack_setup import (
    Measured,
    ScrewjackSetup,
    dead_points_deg,
    fit_beta,
    measured,
    reach_deg,
    wrong_length,
)
from solarcal.report.instrument_plots import Curve, curve_plot
from solarcal.report.scales import Sheet
from solarcal.units import format_degrees

LENGTH_UNITS = {"in": 1.0 / 25.4, "mm": 1.0, "cm": 0.1, "m": 0.001}
"""Units of the lengths, each with how many of it a millimetre is."""

_CURVE_POINTS = 61
_WRONG_R1_MM = 5.0
_INSIDE_DEG = 5.0
"""How far inside the dead points the axis is looked at when no limits are given."""


def _observations(form: Form, R3: float) -> list[Measured]:
    pins = form.choice("pins") == "pin to pin"
    rows = form.filled_rows("at")
    if not rows:
        raise form.error("at", "measure the length at one axis angle at least")
    pairs = [pair for row in rows if (pair := form.pair(row)) is not None]
    return [measured(*pair, R3, pin_to_pin=pins) for pair in pairs]


def screwjack(form: Form) -> Answer:
    """Parameters, their consistency, and both curves."""
    R1, R2, R3 = (form.number(name) for name in ("R1", "R2", "R3"))
    observations = _observations(form, R3)
    grows = form.choice("sense") == "grows"
    counts, limits, reference = (
        form.optional("counts"),
        form.pair("limits"),
        form.optional("reference"),
    )
    unit, change = form.choice("unit"), form.optional("wrong_R1")
    unset = ScrewjackDrive(
        R1=R1,
        R2=R2,
        R3=R3,
        beta_deg=0.0,
        counts_per_length=1.0 if counts is None else counts,
        sign=-1 if grows else 1,
    )
    setup = fit_beta(unset, observations)
    jack = setup.drive
    lowest, highest = reach_deg(jack)
    low, high = limits or (lowest + _INSIDE_DEG, highest - _INSIDE_DEG)
    if not low < high:
        raise ConfigurationError(f"limits: {low:g} is not below {high:g}")
    angles = np.linspace(low, high, _CURVE_POINTS)
    if change is None:
        change = _WRONG_R1_MM * LENGTH_UNITS[unit]
    true = msgspec.structs.replace(jack, R1=jack.R1 + change)
    wrong = wrong_length(true, jack, high if reference is None else reference, angles)
    length = jack.length(angles)
    dead = dead_points_deg(jack)
    drive = None if counts is None else format_drive(jack)
    document = {
        "SJP1": jack.SJP1,
        "SJP2": jack.SJP2,
        "SJP3": jack.SJP3,
        "beta_deg": jack.beta_deg,
        "betas_deg": setup.betas_deg,
        "beta_sigma_deg": setup.beta_sigma_deg,
        "spread_deg": setup.spread_deg,
        "consistent": setup.consistent,
        "length_residuals": setup.length_residuals,
        "angle_residuals_deg": setup.angle_residuals_deg,
        "explanations": [asdict(one) for one in setup.explanations],
        "dead_points_deg": dead,
        "reach_deg": (lowest, highest),
        "drive": drive,
        "curve": {
            "angle_deg": angles,
            "length": length,
            "counts": None if counts is None else counts * length,
        },
        "wrong_R1": {
            "change": change,
            "error_max_deg": float(abs(wrong.error_deg).max()),
            "left_max_deg": float(abs(wrong.left_deg).max()),
            "offset_deg": wrong.offset_deg,
            "scale": wrong.scale,
            "angle_deg": wrong.angle_deg,
            "error_deg": wrong.error_deg,
            "left_deg": wrong.left_deg,
        },
    }
    slopes = []
    if counts is not None:
        slope = abs(counts * (length[1:] - length[:-1]) / (angles[1:] - angles[:-1]))
        slopes = [f"  counts a degree: {slope.min():.0f} to {slope.max():.0f}"]

    def length_plot(sheet: Sheet) -> str:
        curves, marks = [Curve("L", length, "●")], [(angle, "dead point") for angle in dead]
        return curve_plot(
            f"length L, {unit}", angles, curves, "axis angle, deg", sheet, marks=marks
        )

    def wrong_plot(sheet: Sheet) -> str:
        curves = [Curve("read-out", wrong.error_deg, "●"), Curve("left", wrong.left_deg, "+")]
        title = f"R1 {change:+z.4g} {unit}: error, deg"
        return curve_plot(title, angles, curves, "axis angle, deg", sheet)

    return Answer(
        document,
        (
            "\n".join([*_setup_lines(setup, observations, unit, drive), ""]),
            Drawing("length", length_plot, 16),
            "\n".join([*slopes, ""]),
            Drawing("wrong R1", wrong_plot, 14),
            f"  R1 {change:+z.4g} {unit} from the given value: up to "
            f"{abs(wrong.error_deg).max():.3f} deg of tracking error;\n"
            "  offset and scale (P2 and P5, or P4 and P6) leave "
            f"{abs(wrong.left_deg).max():.3f} deg.",
        ),
    )


def _setup_lines(
    setup: ScrewjackSetup, observations: Sequence[Measured], unit: str, drive: str | None
) -> list[str]:
    jack = setup.drive
    sigma = "" if setup.beta_sigma_deg is None else f"  (sigma {setup.beta_sigma_deg:.3f})"
    lines = [
        f"  SJP#1  {jack.SJP1:z12.4f} deg  (beta){sigma}",
        f"  SJP#2  {jack.SJP2:12.4f} {unit}^2",
        f"  SJP#3  {jack.SJP3:12.4f} {unit}^2",
    ]
    if drive is not None:
        lines.append(f"  drive  {drive}")
    lines.append(f"  {'angle':>9} {'L':>10} {'its beta':>10} {'residual':>10} {'as angle':>11}")
    for one, beta, length, angle in zip(
        observations, setup.betas_deg, setup.length_residuals, setup.angle_residuals_deg,
        strict=True,
    ):  # fmt: skip
        lines.append(
            f"  {one.angle_deg:9.3f} {one.length:10.4f} {beta:z10.4f} {length:+z10.4f} "
            f"{format_degrees(angle, 3):>7} deg"
        )
    if setup.consistent is None:
        lines.append("  One angle only: measure the length at a second one to check beta.")
    elif setup.consistent:
        lines.append(f"  The betas agree within {setup.spread_deg:.3f} deg.")
    else:
        lines.append(
            f"  The betas differ by {setup.spread_deg:.3f} deg: a length or the sense is wrong."
        )
        for why in setup.explanations:
            what = "the other sense" if why.name == "sense" else f"{why.name} {why.change:+z.4f}"
            lines.append(f"    {what} would leave {why.rms:.4f} {unit} rms")
    low, high = dead_points_deg(jack)
    lines.append(f"  dead points at {low:.3f} and {high:.3f} deg")
    return lines
