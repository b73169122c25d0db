"""`solarcal day`: sunrise, transit, sunset, the solar clock; when the Sun is within limits.

The JSON document: ``utc`` (the time asked about), ``method`` ("precise" or "noaa"),
``altitude_deg`` (the altitude that counts as rising and setting), ``sunrise_utc``,
``transit_utc``, ``sunset_utc`` (ISO; null where there is none), ``transit_elevation_deg``
(airless), ``daylight_h`` (midnight to midnight), ``polar`` ("day", "night" or null),
``solar_time`` and ``equation_of_time_min`` at the time asked about; with limits
``within_limits`` {``hours``, ``spans_utc``, ``crosses_branch``}, with ``--table`` ``table``.
"""

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solarcal.mount.reach import AxisPath
    from solarcal.site import Site
    from solarcal.sun.day import DayEvents

HELP = "sunrise, noon and sunset, solar time, when the Sun is within limits"
LARGEST_CHART = (100, 30)


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
    from solarcal.cli.output import print_json
    from solarcal.cli.sun import asked_utc_s, clock_face
    from solarcal.errors import ConfigurationError
    from solarcal.mount.reach import reach_of_day
    from solarcal.site import Site
    from solarcal.sun import sun_position
    from solarcal.timescale import format_utc

    site = Site(args.lat, args.lon, args.elevation)
    utc_s = asked_utc_s(args.at)
    if not 1.0 <= args.every <= 720.0:
        raise ConfigurationError(f"--every {args.every:g} is not between 1 and 720 minutes")
    altitude_deg, events = _events(args, utc_s, site)
    geometry, limits = asked_mount(args, site)
    now = sun_position(args.method, utc_s, site, dut1_s=args.dut1)
    limited = bool(args.limits1 or args.limits2)

    def iso(at_s: float | None) -> str | None:
        return None if at_s is None else format_utc(at_s)

    document: dict[str, Any] = {
        "utc": iso(utc_s),
        "method": args.method,
        "altitude_deg": altitude_deg,
        "sunrise_utc": iso(events.sunrise_utc_s),
        "transit_utc": iso(events.transit_utc_s),
        "sunset_utc": iso(events.sunset_utc_s),
        "transit_elevation_deg": events.transit_elevation_deg,
        "daylight_h": events.daylight_s / 3600.0,
        "polar": events.polar,
        "solar_time": clock_face(now.solar_time_h),
        "equation_of_time_min": now.equation_of_time_min,
    }
    if limited:
        reach = reach_of_day(
            site,
            geometry,
            limits,
            events.transit_utc_s,
            lowest_deg=args.lowest,
            dut1_s=args.dut1,
        )
        document["within_limits"] = {
            "hours": reach.hours,
            "spans_utc": [[iso(first), iso(last)] for first, last in reach.spans_utc_s],
            "crosses_branch": reach.crosses_branch,
        }
    if args.table:
        document["table"] = _rows(args, site, events)
    if args.json:
        print_json(document)
        return 0
    _print_events(document, events)
    if limited:
        _print_reach(document["within_limits"], args.geometry)
    if args.table:
        print()
        _print_table(document["table"], args.geometry, limited)
    if args.chart:
        print()
        _print_chart(args, site, events, limited)
    return 0


def _events(args: argparse.Namespace, utc_s: float, site: "Site") -> "tuple[float, DayEvents]":
    from solarcal.errors import ConfigurationError
    from solarcal.sun.day import (
        NOAA_SUNRISE_ALTITUDE_DEG,
        SUNRISE_ALTITUDE_DEG,
        day_events,
        noaa_day_events,
    )

    altitude_deg = args.altitude
    if altitude_deg is None:
        altitude_deg = NOAA_SUNRISE_ALTITUDE_DEG if args.method == "noaa" else SUNRISE_ALTITUDE_DEG
    if not -90.0 < altitude_deg < 90.0:
        raise ConfigurationError(f"altitude {altitude_deg:g} is not between -90 and 90 degrees")
    if args.method == "noaa":
        return altitude_deg, noaa_day_events(utc_s, site, altitude_deg=altitude_deg)
    return altitude_deg, day_events(utc_s, site, altitude_deg=altitude_deg, dut1_s=args.dut1)


def _path(
    args: argparse.Namespace, site: "Site", first_s: float, last_s: float, step_s: float
) -> "AxisPath":
    """The Sun from one instant to another, at whole multiples of the step in UTC."""
    import math

    import numpy as np

    from solarcal.cli.mount_limits import asked_mount
    from solarcal.mount.reach import axis_path

    geometry, limits = asked_mount(args, site)
    count = math.floor(last_s / step_s) - math.ceil(first_s / step_s) + 1
    times = (math.ceil(first_s / step_s) + np.arange(max(count, 1), dtype=np.float64)) * step_s
    return axis_path(site, geometry, limits, times, lowest_deg=args.lowest, dut1_s=args.dut1)


def _rows(args: argparse.Namespace, site: "Site", events: "DayEvents") -> list[dict[str, Any]]:
    from solarcal.cli.sun import clock_face
    from solarcal.sun import sun_position
    from solarcal.timescale import format_utc

    span = events.span_utc_s
    if span is None:
        return []
    path = _path(args, site, *span, 60.0 * args.every)
    solar_h = sun_position("precise", path.utc_s, site, dut1_s=args.dut1).solar_time_h
    return [
        {
            "utc": format_utc(float(path.utc_s[i])),
            "solar_time": clock_face(float(solar_h[i])),
            "azimuth_deg": float(path.azimuth_deg[i]),
            "elevation_deg": float(path.elevation_deg[i]),
            "ax1_deg": float(path.ax1_deg[i]),
            "ax2_deg": float(path.ax2_deg[i]),
            "within_limits": bool(path.margin_deg[i] >= 0.0),
        }
        for i in range(path.utc_s.size)
    ]


def _print_events(document: dict[str, Any], events: "DayEvents") -> None:
    altitude_deg = document["altitude_deg"]
    print(f"The solar day nearest to {document['utc']}, by {document['method']}")
    print(f"  sunrise  {document['sunrise_utc'] or 'none'}")
    print(f"  transit  {document['transit_utc']}  {events.transit_elevation_deg:+.3f} deg high")
    print(f"  sunset   {document['sunset_utc'] or 'none'}")
    if events.polar == "day":
        print(f"  polar day: the Sun stays above {altitude_deg:.3f} deg from midnight to midnight")
    elif events.polar == "night":
        print(f"  polar night: the Sun stays below {altitude_deg:.3f} deg all day")
    else:
        print(f"  {document['daylight_h']:.3f} h above {altitude_deg:.3f} deg")
    print(
        f"  solar time {document['solar_time']} at the time asked about "
        f"(equation of time {document['equation_of_time_min']:+.3f} min)"
    )


def _print_reach(within: dict[str, Any], geometry: str) -> None:
    if not within["spans_utc"]:
        print(f"  {geometry}: the Sun is never within the limits that day")
        return
    print(f"  {geometry}: {within['hours']:.3f} h within limits")
    for first, last in within["spans_utc"]:
        print(f"    {first} to {last}")
    if within["crosses_branch"]:
        print("    axis 1 crosses the edge of its branch: one range cannot hold this day")


def _print_table(rows: list[dict[str, Any]], geometry: str, limited: bool) -> None:
    from solarcal.report.columns import columns, number

    if not rows:
        print("The Sun is not up that day: no table.")
        return
    headings = ["UTC", "solar", "azimuth", "elevation", "AX1", "AX2"]
    lines = [
        [
            row["utc"][:16].replace("T", " "),
            row["solar_time"],
            number(row["azimuth_deg"], 3),
            number(row["elevation_deg"], 3, signed=True),
            number(row["ax1_deg"], 3, signed=True),
            number(row["ax2_deg"], 3),
            *(["" if row["within_limits"] else "beyond"] if limited else []),
        ]
        for row in rows
    ]
    align = "<<>>>>" + ("<" if limited else "")
    headings += ["limits"] if limited else []
    print(f"Airless Sun, degrees; AX1 and AX2 of {geometry}")
    print("\n".join(columns(headings, lines, align)))


def _print_chart(
    args: argparse.Namespace, site: "Site", events: "DayEvents", limited: bool
) -> None:
    import shutil
    import sys

    import numpy as np

    from solarcal.report.day_chart import SMALLEST_HEIGHT, DayTrack, day_chart
    from solarcal.sun import sun_position

    transit_s = events.transit_utc_s
    path = _path(args, site, transit_s - 43200.0, transit_s + 43200.0, 300.0)
    now_h = sun_position("precise", path.utc_s, site, dut1_s=args.dut1).solar_time_h
    # Nearly midnight at either end: the clock must not jump over it.
    solar_h = 12.0 + np.mod(now_h - 12.0 - (path.utc_s - transit_s) / 3600.0 + 12.0, 24.0) - 12.0
    track = DayTrack(
        solar_time_h=solar_h + (path.utc_s - transit_s) / 3600.0,
        azimuth_deg=path.azimuth_deg,
        elevation_deg=path.elevation_deg,
        within_limits=path.margin_deg >= 0.0 if limited else None,
        latitude_deg=site.latitude_deg,
    )
    columns, rows = shutil.get_terminal_size((80, 24))
    width = min(max(columns, 40), LARGEST_CHART[0])
    height = min(max(rows - 2, SMALLEST_HEIGHT), LARGEST_CHART[1])
    print(day_chart(track, width, height, colour=sys.stdout.isatty()))
