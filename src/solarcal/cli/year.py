"""`solarcal year`: the Sun of one site month by month, and what a mount and a collector make of it.

The JSON document: ``year``, ``latitude_deg``, ``longitude_deg``, ``collector``, ``months``, one for
the 21st of each month: ``date``, ``sunrise_utc``, ``transit_utc``, ``sunset_utc`` (null where there
is none), ``daylight_h``, ``transit_elevation_deg``, ``polar``, ``within_limits_h`` (null without
limits), ``energy_percent``; and ``whole_year``: ``daylight_h`` and ``within_limits_h`` (every
seventh day, scaled), ``energy_percent``.
"""

import argparse

HELP = "the Sun month by month: day lengths, hours within limits, a collector's energy"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    from solarcal.cli.collector import add_collector_options
    from solarcal.cli.mount_limits import add_limits_options

    parser.add_argument(
        "--lat", type=float, required=True, metavar="DEG", help="latitude, positive north"
    )
    parser.add_argument(
        "--lon", type=float, required=True, metavar="DEG", help="longitude, positive EAST"
    )
    parser.add_argument(
        "--elevation", type=float, default=0.0, metavar="M", help="metres above sea (default 0)"
    )
    parser.add_argument("--year", type=int, help="1960 to 2099 (default: this year)")
    add_limits_options(parser)
    add_collector_options(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "JSON keys: year, latitude_deg, longitude_deg, collector, months (date, sunrise_utc, "
        "transit_utc, sunset_utc, daylight_h, transit_elevation_deg, polar, within_limits_h, "
        "energy_percent), whole_year (daylight_h, within_limits_h, energy_percent)."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    from solarcal.cli.collector import collector_of
    from solarcal.cli.mount_limits import asked_mount
    from solarcal.cli.output import print_answer
    from solarcal.clock import SystemClock
    from solarcal.report.field.year import year
    from solarcal.site import Site
    from solarcal.timescale import format_utc

    site = Site(args.lat, args.lon, args.elevation)
    collector = collector_of(args, site.latitude_deg)
    mount = asked_mount(args, site) if args.limits1 or args.limits2 else None
    asked = args.year
    if asked is None:
        asked = int(format_utc(SystemClock().utc_s())[:4])
    return print_answer(year(asked, site, collector, mount, lowest_deg=args.lowest), args.json)
