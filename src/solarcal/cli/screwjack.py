"""`solarcal screwjack`: SJP#1-3 from measured lengths, its dead points, what a wrong R1 does.

JSON: ``SJP1, SJP2, SJP3, beta_deg, betas_deg, beta_sigma_deg, spread_deg, consistent,
length_residuals, angle_residuals_deg, explanations`` (list of ``name, change, rms``),
``dead_points_deg, reach_deg, drive`` (in the notation of the unit's parameters; null without
``--counts``), ``curve`` (``angle_deg, length, counts``) and ``wrong_R1`` (``change, error_max_deg,
left_max_deg, offset_deg, scale, angle_deg, error_deg, left_deg``).
"""

import argparse

HELP = "a screwjack's SJP#1-3 from measured lengths"


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
    from solarcal.cli.output import print_answer, require
    from solarcal.mount.screwjack_setup import measured
    from solarcal.report.field.screwjack import Asked, screwjack

    R3 = require(args.R3, "--R3")
    return print_answer(
        screwjack(
            Asked(
                R1=require(args.R1, "--R1"),
                R2=require(args.R2, "--R2"),
                R3=R3,
                observations=[
                    measured(require(angle, "--at ANGLE"), length, R3, pin_to_pin=args.pin_to_pin)
                    for angle, length in args.at
                ],
                grows=args.sense == "grows",
                counts=None if args.counts is None else require(args.counts, "--counts"),
                limits=None if args.limits is None else (args.limits[0], args.limits[1]),
                reference_deg=args.reference,
                unit=args.unit,
                wrong_R1=None if args.wrong_R1 is None else require(args.wrong_R1, "--wrong-R1"),
            )
        ),
        args.json,
    )
