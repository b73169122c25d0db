"""`solarcal screwjack`: SJP#1-3 from measured lengths, its dead points, what a wrong R1 does.

JSON: ``SJP1, SJP2, SJP3, beta_deg, betas_deg, beta_sigma_deg, spread_deg, consistent,
length_residuals, angle_residuals_deg, explanations`` (list of ``name, change, rms``),
``dead_points_deg, reach_deg, drive`` (in the notation of the unit's parameters; null without
``--counts``), ``curve`` (``angle_deg, length, counts``) and ``wrong_R1`` (``change, error_max_deg,
left_max_deg, offset_deg, scale, angle_deg, error_deg, left_deg``).
"""

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solarcal.mount.screwjack_setup import Measured, ScrewjackSetup, WrongLength
    from solarcal.units import FloatArray

HELP = "a screwjack's SJP#1-3 from measured lengths"

_MM_PER_INCH = 25.4
_CURVE_POINTS = 61


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    add = parser.add_argument
    add("--R1", type=float, metavar="LENGTH", help="axis to one pivot")
    add("--R2", type=float, metavar="LENGTH", help="axis to the other pivot")
    add("--R3", type=float, default=0.0, metavar="LENGTH", help="offset of the jack tube (0)")
    add(
        "--at",
        type=float,
        nargs=2,
        action="append",
        default=[],
        metavar=("ANGLE", "LENGTH"),
        help="axis angle and the jack's length there; once for beta, twice to check it",
    )
    add("--pin-to-pin", action="store_true", help="the lengths are between the pins")
    add(
        "--sense",
        choices=("grows", "shrinks"),
        default="grows",
        help="the axis angle grows (default) or shrinks with the jack's length",
    )
    add("--counts", type=float, metavar="N", help="counts per unit of length, signed")
    add(
        "--limits", type=float, nargs=2, metavar=("LOW", "HIGH"),
        help="axis angles of interest (default: all between the dead points, 5 deg inside)",
    )  # fmt: skip
    add(
        "--reference", type=float, metavar="DEG",
        help="axis angle of the reference switch, where counts begin (default: the high limit)",
    )  # fmt: skip
    add("--unit", choices=("in", "mm", "cm", "m"), default="in", help="of the lengths (in)")
    add(
        "--wrong-R1", type=float, metavar="LENGTH",
        help="show what R1 longer by this than told does (default 5 mm)",
    )  # fmt: skip
    add("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "JSON keys: SJP1, SJP2, SJP3, beta_deg, betas_deg, beta_sigma_deg, spread_deg, consistent, "
        "length_residuals, angle_residuals_deg, explanations, dead_points_deg, reach_deg, drive, "
        "curve, wrong_R1."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    import msgspec
    import numpy as np

    from solarcal.cli.output import print_json, require
    from solarcal.errors import ConfigurationError
    from solarcal.mount.drive import ScrewjackDrive, format_drive
    from solarcal.mount.screwjack_setup import (
        dead_points_deg,
        fit_beta,
        measured,
        reach_deg,
        wrong_length,
    )

    unset = ScrewjackDrive(
        R1=require(args.R1, "--R1"),
        R2=require(args.R2, "--R2"),
        R3=require(args.R3, "--R3"),
        beta_deg=0.0,
        counts_per_length=1.0 if args.counts is None else require(args.counts, "--counts"),
        sign=-1 if args.sense == "grows" else 1,
    )
    observations = [
        measured(require(angle, "--at ANGLE"), length, unset.R3, pin_to_pin=args.pin_to_pin)
        for angle, length in args.at
    ]
    setup = fit_beta(unset, observations)
    jack = setup.drive
    lowest, highest = reach_deg(jack)
    low, high = args.limits or (lowest + 5.0, highest - 5.0)
    if not low < high:
        raise ConfigurationError(f"--limits: {low:g} is not below {high:g}")
    reference = high if args.reference is None else args.reference
    angles = np.linspace(low, high, _CURVE_POINTS)
    per_mm = {"in": 1.0 / _MM_PER_INCH, "mm": 1.0, "cm": 0.1, "m": 0.001}[args.unit]
    change = 5.0 * per_mm if args.wrong_R1 is None else require(args.wrong_R1, "--wrong-R1")
    true = msgspec.structs.replace(jack, R1=jack.R1 + change)
    wrong = wrong_length(true, jack, reference, angles)
    if args.json:
        print_json(
            {
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
                "explanations": [
                    {"name": one.name, "change": one.change, "rms": one.rms}
                    for one in setup.explanations
                ],
                "dead_points_deg": dead_points_deg(jack),
                "reach_deg": (lowest, highest),
                "drive": None if args.counts is None else format_drive(jack),
                "curve": _curve(jack.length(angles), angles, args.counts),
                "wrong_R1": _wrong_document(change, wrong),
            }
        )
        return 0
    _print_setup(args, setup, observations)
    _print_curves(args, setup, angles, change, wrong)
    return 0


def _curve(length: "FloatArray", angles: "FloatArray", counts: float | None) -> dict[str, Any]:
    return {
        "angle_deg": angles,
        "length": length,
        "counts": None if counts is None else counts * length,
    }


def _wrong_document(change: float, wrong: "WrongLength") -> dict[str, Any]:
    return {
        "change": change,
        "error_max_deg": float(abs(wrong.error_deg).max()),
        "left_max_deg": float(abs(wrong.left_deg).max()),
        "offset_deg": wrong.offset_deg,
        "scale": wrong.scale,
        "angle_deg": wrong.angle_deg,
        "error_deg": wrong.error_deg,
        "left_deg": wrong.left_deg,
    }


def _print_setup(
    args: argparse.Namespace, setup: "ScrewjackSetup", observations: list["Measured"]
) -> None:
    from solarcal.mount.drive import format_drive
    from solarcal.mount.screwjack_setup import dead_points_deg
    from solarcal.units import format_degrees

    jack = setup.drive
    sigma = "" if setup.beta_sigma_deg is None else f"  (sigma {setup.beta_sigma_deg:.3f})"
    print(f"  SJP#1  {jack.SJP1:12.4f} deg  (beta){sigma}")
    print(f"  SJP#2  {jack.SJP2:12.4f} {args.unit}^2")
    print(f"  SJP#3  {jack.SJP3:12.4f} {args.unit}^2")
    if args.counts is not None:
        print(f"  drive  {format_drive(jack)}")
    print(f"  {'angle':>9} {'L':>10} {'its beta':>10} {'off by':>10} {'which is':>11}")
    for one, beta, length, angle in zip(
        observations, setup.betas_deg, setup.length_residuals, setup.angle_residuals_deg,
        strict=True,
    ):  # fmt: skip
        print(
            f"  {one.angle_deg:9.3f} {one.length:10.4f} {beta:10.4f} {length:+10.4f} "
            f"{format_degrees(angle, 3):>7} deg"
        )
    if setup.consistent is None:
        print("  One angle only: measure the length at a second one to check beta.")
    elif setup.consistent:
        print(f"  The betas agree within {setup.spread_deg:.3f} deg.")
    else:
        print(f"  The betas lie {setup.spread_deg:.3f} deg apart: a length or the sense is wrong.")
        for why in setup.explanations:
            what = "the other sense" if why.name == "sense" else f"{why.name} {why.change:+.4f}"
            print(f"    {what} would leave {why.rms:.4f} {args.unit} rms")
    low, high = dead_points_deg(jack)
    print(f"  dead points at {low:.3f} and {high:.3f} deg")


def _print_curves(
    args: argparse.Namespace,
    setup: "ScrewjackSetup",
    angles: "FloatArray",
    change: float,
    wrong: "WrongLength",
) -> None:
    from solarcal.cli.output import terminal_size
    from solarcal.mount.screwjack_setup import dead_points_deg
    from solarcal.report.instrument_plots import Curve, curve_plot

    width, colour = terminal_size()
    dead = [(angle, "dead point") for angle in dead_points_deg(setup.drive)]
    length = setup.drive.length(angles)
    print()
    print(
        curve_plot(
            f"length L, {args.unit}", angles, [Curve("L", length, "●")], "axis angle, deg",
            width, 16, colour, marks=dead,
        )
    )  # fmt: skip
    if args.counts is not None:
        slope = abs(args.counts * (length[1:] - length[:-1]) / (angles[1:] - angles[:-1]))
        print(f"  counts a degree: {slope.min():.0f} to {slope.max():.0f}")
    print()
    print(
        curve_plot(
            f"R1 {change:+.4g} {args.unit}: error, deg",
            angles,
            [Curve("read-out", wrong.error_deg, "●"), Curve("left", wrong.left_deg, "+")],
            "axis angle, deg",
            width,
            14,
            colour,
        )
    )
    print(
        f"  R1 {change:+.4g} {args.unit} from what was told: up to "
        f"{abs(wrong.error_deg).max():.3f} deg of tracking error;\n"
        f"  offset and scale (P2 and P5, or P4 and P6) leave {abs(wrong.left_deg).max():.3f} deg."
    )
