"""`solarcal sunspot`: pointing error from the spot, the device for a wish, its own misalignment.

``--height --hole --spot --edge`` give the error along one direction; ``--edge-up`` a second one.
``--turned`` is the same edge after turning the device by 180 deg on its seat.

JSON: ``error_deg``, ``error_up_deg`` (null where not asked), ``sky_error_deg``, ``even_rim``,
``device_deg`` and ``tracker_deg`` (null without ``--turned``). With ``--design``: ``height, hole,
plate, spot, even_rim, smallest_shift, resolution_deg, range_deg``.
"""

import argparse

HELP = "the sunspot device: error, design, its own misalignment"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    add = parser.add_argument
    add("--height", type=float, metavar="H", help="orifice plate above the mirror")
    add("--hole", type=float, metavar="DO", help="diameter of the hole")
    add("--spot", type=float, metavar="DS", help="diameter of the spot")
    add("--edge", type=float, metavar="E", help="edge of the hole to edge of the spot")
    add("--edge-up", type=float, metavar="E", help="the same towards the plate's upper mark")
    add(
        "--turned",
        type=float,
        metavar="E",
        help="E at the same mark of the device after turning it by 180 deg: its own misalignment",
    )
    add("--design", action="store_true", help="what a device shows, or which one shows a wish")
    add("--plate", type=float, metavar="D", help="--design: diameter of the plate")
    add("--shift", type=float, default=0.5, metavar="E", help="--design: E is read to (0.5)")
    add("--resolution", type=float, metavar="DEG", help="--design: wanted, instead of --height")
    add("--range", type=float, metavar="DEG", help="--design: wanted, instead of --plate")
    add("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "All lengths in one unit, whichever. JSON keys: error_deg, error_up_deg, sky_error_deg, "
        "even_rim, device_deg, tracker_deg; with --design: height, hole, plate, spot, even_rim, "
        "smallest_shift, resolution_deg, range_deg."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    return _design(args) if args.design else _error(args)


def _error(args: argparse.Namespace) -> int:
    from solarcal.cli.output import print_answer, require
    from solarcal.report.field.sunspot import error

    return print_answer(
        error(
            require(args.height, "--height"),
            require(args.hole, "--hole"),
            require(args.spot, "--spot"),
            require(args.edge, "--edge"),
            args.edge_up,
            args.turned,
        ),
        args.json,
    )


def _design(args: argparse.Namespace) -> int:
    from solarcal.cli.output import print_answer, require
    from solarcal.optics.sunspot import design_for, design_from_size
    from solarcal.report.field.sunspot import design

    hole = require(args.hole, "--hole")
    if args.resolution is not None or args.range is not None:
        resolution = require(args.resolution, "--resolution")
        device = design_for(resolution, require(args.range, "--range"), hole, args.shift)
    else:
        height, plate = require(args.height, "--height"), require(args.plate, "--plate")
        device = design_from_size(height, hole, plate, args.shift)
    return print_answer(design(device), args.json)
