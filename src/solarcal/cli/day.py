"""`solarcal day`: sunrise, transit and sunset about the transit nearest to a time.

The JSON document: ``utc`` (the time asked about), ``method`` ("precise" or "noaa"),
``altitude_deg`` (the altitude that counts as rising and setting), ``sunrise_utc``,
``transit_utc``, ``sunset_utc`` (ISO; null where there is none), ``transit_elevation_deg``
(airless), ``daylight_h`` (midnight to midnight) and ``polar`` ("day", "night" or null).
"""

import argparse

HELP = "sunrise, transit and sunset"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
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
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "JSON keys: utc, method, altitude_deg, sunrise_utc, transit_utc, sunset_utc (null where "
        "there is none), transit_elevation_deg (airless), daylight_h, polar (day, night or null)."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    from solarcal.cli.output import print_json
    from solarcal.cli.sun import asked_utc_s
    from solarcal.errors import ConfigurationError
    from solarcal.site import Site
    from solarcal.sun.day import (
        NOAA_SUNRISE_ALTITUDE_DEG,
        SUNRISE_ALTITUDE_DEG,
        day_events,
        noaa_day_events,
    )
    from solarcal.timescale import format_utc

    site = Site(args.lat, args.lon, args.elevation)
    utc_s = asked_utc_s(args.at)
    altitude_deg = args.altitude
    if altitude_deg is None:
        altitude_deg = NOAA_SUNRISE_ALTITUDE_DEG if args.method == "noaa" else SUNRISE_ALTITUDE_DEG
    if not -90.0 < altitude_deg < 90.0:
        raise ConfigurationError(f"altitude {altitude_deg:g} is not between -90 and 90 degrees")
    if args.method == "noaa":
        events = noaa_day_events(utc_s, site, altitude_deg=altitude_deg)
    else:
        events = day_events(utc_s, site, altitude_deg=altitude_deg, dut1_s=args.dut1)

    def iso(at_s: float | None) -> str | None:
        return None if at_s is None else format_utc(at_s)

    document = {
        "utc": iso(utc_s),
        "method": args.method,
        "altitude_deg": altitude_deg,
        "sunrise_utc": iso(events.sunrise_utc_s),
        "transit_utc": iso(events.transit_utc_s),
        "sunset_utc": iso(events.sunset_utc_s),
        "transit_elevation_deg": events.transit_elevation_deg,
        "daylight_h": events.daylight_s / 3600.0,
        "polar": events.polar,
    }
    if args.json:
        print_json(document)
        return 0
    print(f"The solar day nearest to {document['utc']}, by {args.method}")
    print(f"  sunrise  {document['sunrise_utc'] or 'none'}")
    print(f"  transit  {document['transit_utc']}  {events.transit_elevation_deg:+.3f} deg high")
    print(f"  sunset   {document['sunset_utc'] or 'none'}")
    if events.polar == "day":
        print(f"  polar day: the Sun stays above {altitude_deg:.3f} deg from midnight to midnight")
    elif events.polar == "night":
        print(f"  polar night: the Sun stays below {altitude_deg:.3f} deg all day")
    else:
        print(f"  {document['daylight_h']:.3f} h above {altitude_deg:.3f} deg")
    return 0
