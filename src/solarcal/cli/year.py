"""`solarcal year`: the Sun of one site month by month, and what a mount and a collector make of it.

The JSON document: ``year``, ``latitude_deg``, ``longitude_deg``, ``collector``, ``months``, one for
the 21st of each month: ``date``, ``sunrise_utc``, ``transit_utc``, ``sunset_utc`` (null where there
is none), ``daylight_h``, ``transit_elevation_deg``, ``polar``, ``within_limits_h`` (null without
limits), ``energy_percent``; and ``whole_year``: ``daylight_h`` and ``within_limits_h`` (every
seventh day, scaled), ``energy_percent``.
"""

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solarcal.mount.geometry import MountGeometry
    from solarcal.mount.limits import Limits
    from solarcal.site import Site
    from solarcal.sun.day import DayEvents

HELP = "the Sun month by month: day lengths, hours within limits, a collector's energy"
_MONTH_DAY = 21
_WEEK_S = 7.0 * 86400.0


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
    from solarcal.cli.collector import collector_document, collector_of, collector_text
    from solarcal.cli.mount_limits import asked_mount
    from solarcal.cli.output import print_json
    from solarcal.clock import SystemClock
    from solarcal.errors import ConfigurationError
    from solarcal.site import Site
    from solarcal.sun.circular_orbit import CircularDay, days_after_march_equinox
    from solarcal.sun.day import day_events
    from solarcal.sun.energy import day_percent, year_percent
    from solarcal.timescale import format_utc, parse_utc

    site = Site(args.lat, args.lon, args.elevation)
    collector = collector_of(args, site.latitude_deg)
    mount = asked_mount(args, site) if args.limits1 or args.limits2 else None
    year = args.year
    if year is None:
        year = int(format_utc(SystemClock().utc_s())[:4])
    if not 1960 <= year <= 2099:
        raise ConfigurationError(f"year {year} is not between 1960 and 2099")

    def noon_utc_s(date: str) -> float:
        return parse_utc(f"{date}T12:00:00Z") - 240.0 * site.longitude_deg

    months = []
    for month in range(1, 13):
        date = f"{year}-{month:02d}-{_MONTH_DAY}"
        noon_s = noon_utc_s(date)
        events = day_events(noon_s, site)
        day = CircularDay(site.latitude_deg, days_after_march_equinox(noon_s))
        months.append(
            {
                "date": date,
                "sunrise_utc": _iso(events.sunrise_utc_s),
                "transit_utc": _iso(events.transit_utc_s),
                "sunset_utc": _iso(events.sunset_utc_s),
                "daylight_h": events.daylight_s / 3600.0,
                "transit_elevation_deg": events.transit_elevation_deg,
                "polar": events.polar,
                "within_limits_h": _reach_h(args, site, mount, events),
                "energy_percent": day_percent(collector, day),
            }
        )
    weeks = [day_events(noon_utc_s(f"{year}-01-01") + week * _WEEK_S, site) for week in range(52)]
    days = 366 if year % 4 == 0 else 365
    reaches = [_reach_h(args, site, mount, events) for events in weeks]
    document: dict[str, Any] = {
        "year": year,
        "latitude_deg": site.latitude_deg,
        "longitude_deg": site.longitude_deg,
        "collector": collector_document(collector),
        "months": months,
        "whole_year": {
            "daylight_h": sum(events.daylight_s for events in weeks) / 3600.0 * days / len(weeks),
            "within_limits_h": None
            if mount is None
            else sum(reach or 0.0 for reach in reaches) * days / len(weeks),
            "energy_percent": year_percent(collector, site.latitude_deg),
        },
    }
    if args.json:
        print_json(document)
        return 0
    print(f"{year} at latitude {site.latitude_deg:g}, longitude {site.longitude_deg:g}; times UTC")
    print("Energy in percent of full Sun all day and night")
    print(f"Collector {collector_text(collector)}")
    print()
    _print_months(document)
    return 0


def _iso(at_s: float | None) -> str | None:
    from solarcal.timescale import format_utc

    return None if at_s is None else format_utc(at_s)


def _reach_h(
    args: argparse.Namespace,
    site: "Site",
    mount: "tuple[MountGeometry, Limits] | None",
    events: "DayEvents",
) -> float | None:
    """Hours within limits of a day; None without limits."""
    from solarcal.mount.reach import reach_of_day

    if mount is None:
        return None
    return reach_of_day(site, *mount, events.transit_utc_s, lowest_deg=args.lowest).hours


def _print_months(document: dict[str, Any]) -> None:
    from solarcal.report.columns import columns, number

    def clock(iso: str | None) -> str:
        return "-" if iso is None else iso[11:16]

    lines = [
        [
            month["date"],
            clock(month["sunrise_utc"]),
            clock(month["transit_utc"]),
            clock(month["sunset_utc"]),
            number(month["daylight_h"], 2),
            number(month["transit_elevation_deg"], 2, signed=True),
            number(month["within_limits_h"], 2),
            number(month["energy_percent"], 2),
            {"day": "day", "night": "night", None: ""}[month["polar"]],
        ]
        for month in document["months"]
    ]
    whole = document["whole_year"]
    lines.append(
        [
            "whole year",
            "",
            "",
            "",
            number(whole["daylight_h"], 0),
            "",
            number(whole["within_limits_h"], 0),
            number(whole["energy_percent"], 2),
            "",
        ]
    )
    headings = ["date", "rise", "noon", "set", "day h", "high", "limits h", "energy %", "polar"]
    shown = len(headings) if any(line[-1] for line in lines) else len(headings) - 1
    rows = [line[:shown] for line in lines]
    print("\n".join(columns(headings[:shown], rows, "<<<<>>>><"[:shown])))
