"""`solarcal day`: sunrise, transit, sunset, the solar clock; when the Sun is within limits.

The JSON document: ``utc`` (the time asked about), ``method`` ("precise" or "noaa"),
``altitude_deg`` (the altitude that counts as rising and setting), ``sunrise_utc``,
``transit_utc``, ``sunset_utc`` (ISO; null where there is none), ``transit_elevation_deg``
(airless), ``daylight_h`` (midnight to midnight), ``polar`` ("day", "night" or null),
``solar_time`` and ``equation_of_time_min`` at the time asked about; with limits
``within_limits`` {``hours``, ``spans_utc``, ``crosses_branch``}, with ``--table`` ``table``.
"""

import argparse

HELP = "sunrise, noon and sunset, solar time, when the Sun is within limits"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    from solarcal.cli.mount_limits import add_limits_options
    from solarcal.cli.sun import add_place_and_time

    add_place_and_time(parser)
    parser.add_argument(
        "--method",
        choices=("precise", "noaa"),
        default="precise",
        help="root finding on the precise Sun (default), or NOAA's formulas (some minutes)",
    )
    parser.add_argument(
        "--altitude",
        type=float,
        metavar="DEG",
        help="airless altitude of the Sun's centre that counts as rising and setting "
        "(default -0.8333; noaa -0.833)",
    )
    add_limits_options(parser)
    parser.add_argument("--table", action="store_true", help="a table of the Sun through the day")
    parser.add_argument(
        "--every", type=float, default=30.0, metavar="MIN", help="rows of the table (default 30)"
    )
    parser.add_argument(
        "--chart", action="store_true", help="a text chart of elevation and azimuth"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "JSON keys: utc, method, altitude_deg, sunrise_utc, transit_utc, sunset_utc (null where "
        "there is none), transit_elevation_deg (airless), daylight_h, polar (day, night or null), "
        "solar_time, equation_of_time_min; with limits: within_limits (hours, spans_utc, "
        "crosses_branch); with --table: table."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    from solarcal.cli.mount_limits import asked_mount
    from solarcal.cli.output import print_answer
    from solarcal.cli.sun import asked_day_utc_s
    from solarcal.errors import ConfigurationError
    from solarcal.report.field.day import AskedDay, day
    from solarcal.site import Site

    site = Site(args.lat, args.lon, args.elevation)
    utc_s = asked_day_utc_s(args.at, site)
    if not 1.0 <= args.every <= 720.0:
        raise ConfigurationError(f"--every {args.every:g} is not between 1 and 720 minutes")
    geometry, limits = asked_mount(args, site)
    asked = AskedDay(
        utc_s,
        site,
        geometry,
        limits,
        limited=bool(args.limits1 or args.limits2),
        method=args.method,
        altitude_deg=args.altitude,
        lowest_deg=args.lowest,
        dut1_s=args.dut1,
        table_every_min=args.every if args.table else None,
        chart=args.chart,
    )
    return print_answer(day(asked), args.json)
