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
    import math

    from solarcal.cli.output import print_json, require, terminal_size
    from solarcal.optics.sunspot import spot_error_deg, two_position_check
    from solarcal.units import format_degrees

    height = require(args.height, "--height")
    hole = require(args.hole, "--hole")
    spot = require(args.spot, "--spot")
    edge = require(args.edge, "--edge")
    error = spot_error_deg(height, hole, spot, edge)
    up = None if args.edge_up is None else spot_error_deg(height, hole, spot, args.edge_up)
    check = None
    if args.turned is not None:
        check = two_position_check(error, spot_error_deg(height, hole, spot, args.turned))
    rim = 0.5 * (spot - hole)
    document = {
        "error_deg": error,
        "error_up_deg": up,
        "sky_error_deg": math.hypot(error, up or 0.0),
        "even_rim": rim,
        "device_deg": None if check is None else check.device_deg,
        "tracker_deg": None if check is None else check.tracker_deg,
    }
    if args.json:
        print_json(document)
        return 0
    print(f"  error towards that edge  {format_degrees(error, 4)} deg")
    if up is not None:
        print(f"  error upwards            {format_degrees(up, 4)} deg")
        print(f"  on the sky               {document['sky_error_deg']:8.4f} deg")
    print(f"  E without an error       {rim:8.4g} on every side")
    if check is not None:
        print(f"  of this the device's own {format_degrees(check.device_deg, 4)} deg")
        print(f"  and the tracker's        {format_degrees(check.tracker_deg, 4)} deg")
    from solarcal.report.instrument_plots import plate_drawing

    width, colour = terminal_size()
    above = 0.0 if args.edge_up is None else args.edge_up - rim
    print(plate_drawing(hole, spot, edge - rim, above, width, 15, colour))
    return 0


def _design(args: argparse.Namespace) -> int:
    from solarcal.cli.output import print_json, require
    from solarcal.optics.sunspot import design_for, design_from_size

    hole = require(args.hole, "--hole")
    if args.resolution is not None or args.range is not None:
        resolution = require(args.resolution, "--resolution")
        device = design_for(resolution, require(args.range, "--range"), hole, args.shift)
    else:
        height, plate = require(args.height, "--height"), require(args.plate, "--plate")
        device = design_from_size(height, hole, plate, args.shift)
    document = {
        "height": device.height,
        "hole": device.hole_diameter,
        "plate": device.plate_diameter,
        "spot": device.spot_diameter,
        "even_rim": device.even_rim,
        "smallest_shift": device.smallest_shift,
        "resolution_deg": device.resolution_deg,
        "range_deg": device.range_deg,
    }
    if args.json:
        print_json(document)
        return 0
    for name, value, unit in (
        ("height H of the plate", device.height, ""),
        ("hole Do", device.hole_diameter, ""),
        ("plate, diameter", device.plate_diameter, ""),
        ("spot Ds", device.spot_diameter, ""),
        ("E without an error", device.even_rim, ""),
        ("resolution", device.resolution_deg, "deg"),
        ("range, either side", device.range_deg, "deg"),
    ):
        print(f"  {name:<24}{value:>10.4g} {unit}".rstrip())
    return 0
