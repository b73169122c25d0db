"""`solarcal energy`: what a collector catches at a moment, over a day, over a year.

In the manner of Rusin's SUNCALC: a circular orbit, no air, days counted from the March equinox,
percent of an equal surface that faces the Sun in space all the time. Without options it answers
SUNCALC's own question: latitude 42, day 91, noon, a level collector.
"""

import argparse

HELP = "what a collector catches at a moment, over a day, over a year"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    from solarcal.cli.collector import add_collector_options

    parser.add_argument(
        "--lat", type=float, default=42.0, metavar="DEG", help="latitude, north positive (42)"
    )
    when = parser.add_mutually_exclusive_group()
    when.add_argument("--day", type=float, metavar="DAYS", help="days after the March equinox (91)")
    when.add_argument(
        "--date", metavar="YYYY-MM-DD", help="that date, counted from the March equinox before it"
    )
    parser.add_argument(
        "--time", type=float, default=12.0, metavar="H", help="solar time in hours (12, noon)"
    )
    add_collector_options(parser)
    parser.add_argument(
        "--pointing-error", type=float, metavar="DEG", help="what this error costs over the day"
    )
    parser.add_argument(
        "--acceptance",
        type=float,
        metavar="DEG",
        help="half angle a concentrator accepts: the share of the Sun's disc it still sees "
        "with --pointing-error",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "JSON keys: latitude_deg, day, solar_time_h, collector, sun (north, east, up, "
        "elevation_deg, high_sun_deg, sunrise_bearing_deg from East towards North, never_sets), "
        "daylight_h, dawn_h, dusk_h, due_east_h, due_west_h, percent (moment, day in SUNCALC's "
        "100 steps, day_integrated, year, seasons), pointing (null without --pointing-error)."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    from solarcal.cli.collector import collector_of
    from solarcal.cli.output import print_answer
    from solarcal.errors import ConfigurationError
    from solarcal.report.field.energy import energy

    if args.acceptance is not None and args.pointing_error is None:
        raise ConfigurationError("--acceptance asks what an error costs: give --pointing-error too")
    answer = energy(
        args.lat,
        _asked_day(args),
        args.time,
        collector_of(args, args.lat),
        pointing_error_deg=args.pointing_error,
        acceptance_deg=args.acceptance,
    )
    return print_answer(answer, args.json)


def _asked_day(args: argparse.Namespace) -> float:
    from solarcal.sun.circular_orbit import days_after_march_equinox
    from solarcal.timescale import parse_utc

    if args.date is None:
        return 91.0 if args.day is None else float(args.day)
    noon = args.date if "T" in args.date else f"{args.date}T12:00Z"
    return days_after_march_equinox(parse_utc(noon))
