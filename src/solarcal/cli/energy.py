"""`solarcal energy`: what a collector catches at a moment, over a day, over a year.

In the manner of Rusin's SUNCALC: a circular orbit, no air, days counted from the March equinox,
percent of an equal surface that faces the Sun in space all the time. Without options it answers
SUNCALC's own question: latitude 42, day 91, noon, a level collector.
"""

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solarcal.sun.circular_orbit import CircularDay

HELP = "what a collector catches at a moment, over a day, over a year"

SEASON_DAYS = (0, 91, 182, 273)
SEASONS = ("March equinox", "June solstice", "September equinox", "December solstice")


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
    from solarcal.cli.collector import collector_document, collector_of, collector_text
    from solarcal.cli.output import print_json
    from solarcal.errors import ConfigurationError
    from solarcal.sun.circular_orbit import CircularDay
    from solarcal.sun.energy import (
        day_percent,
        disc_percent,
        moment_percent,
        pointing_loss,
        suncalc_day_percent,
        year_percent,
    )

    if args.acceptance is not None and args.pointing_error is None:
        raise ConfigurationError("--acceptance asks what an error costs: give --pointing-error too")
    day = CircularDay(args.lat, _asked_day(args))
    collector = collector_of(args, args.lat)
    moment = moment_percent(collector, day, args.time)
    north, east, up = day.direction_neu(args.time).tolist()
    pointing = None
    if args.pointing_error is not None:
        loss = pointing_loss(collector, day, args.pointing_error)
        pointing = {
            "error_deg": loss.error_deg,
            "lost_percent": loss.lost_percent,
            "worst_bearing_deg": loss.worst_bearing_deg,
            "disc_percent": None
            if args.acceptance is None
            else disc_percent(args.acceptance, args.pointing_error),
        }
    document: dict[str, Any] = {
        "latitude_deg": args.lat,
        "day": day.day,
        "solar_time_h": args.time,
        "collector": collector_document(collector),
        "sun": {
            "north": north,
            "east": east,
            "up": up,
            "elevation_deg": day.elevation_deg(args.time),
            "high_sun_deg": day.high_sun_deg,
            "sunrise_bearing_deg": day.sunrise_bearing_deg,
            "never_sets": day.never_sets,
        },
        "daylight_h": day.daylight_h,
        "dawn_h": day.dawn_h,
        "dusk_h": day.dusk_h,
        "due_east_h": day.due_east_h,
        "due_west_h": day.due_west_h,
        "percent": {
            "moment": moment,
            "day": suncalc_day_percent(collector, day),
            "day_integrated": day_percent(collector, day),
            "year": year_percent(collector, args.lat),
            "seasons": {
                str(number): suncalc_day_percent(collector, CircularDay(args.lat, number))
                for number in SEASON_DAYS
            },
        },
        "pointing": pointing,
    }
    if args.json:
        print_json(document)
        return 0
    print(f"Latitude {args.lat:g}, {day.day:g} days after the March equinox, {args.time:g} h solar")
    print(f"Collector {collector_text(collector)}")
    print()
    lines = [
        ("Sun towards", f"N {north:+.6f}  E {east:+.6f}  U {up:+.6f}"),
        ("elevation", f"{day.elevation_deg(args.time):.6f} deg"),
        ("highest", f"{day.high_sun_deg:.6f} deg at noon"),
        *_horizon_lines(day),
        ("due east, due west", _due_text(day)),
        ("caught now", f"{moment:.6f} % of full Sun"),
        ("over the day", f"{document['percent']['day']:.6f} % (SUNCALC's 100 steps)"),
        ("", f"{document['percent']['day_integrated']:.6f} % (integrated)"),
        ("over the year", f"{document['percent']['year']:.6f} %"),
    ]
    for number, name in zip(SEASON_DAYS, SEASONS, strict=True):
        share = document["percent"]["seasons"][str(number)]
        lines.append((f"day {number}", f"{share:.6f} % ({name})"))
    lines += _pointing_lines(pointing, args.acceptance)
    for label, text in lines:
        print(f"  {label:<20}{text}")
    return 0


def _asked_day(args: argparse.Namespace) -> float:
    from solarcal.sun.circular_orbit import days_after_march_equinox
    from solarcal.timescale import parse_utc

    if args.date is None:
        return 91.0 if args.day is None else float(args.day)
    noon = args.date if "T" in args.date else f"{args.date}T12:00Z"
    return days_after_march_equinox(parse_utc(noon))


def _horizon_lines(day: "CircularDay") -> list[tuple[str, str]]:
    if day.never_sets == "day":
        return [("daylight", f"24 h: the Sun shines all day, lowest {day.low_sun_deg:.3f} deg")]
    if day.dawn_h is None or day.dusk_h is None or day.sunrise_bearing_deg is None:
        return [("daylight", "none: the Sun is hidden all day")]
    bearing = day.sunrise_bearing_deg
    return [
        ("rises", f"{bearing:.6f} deg from East towards North"),
        ("dawn, dusk", f"{day.dawn_h:.6f} h, {day.dusk_h:.6f} h solar time"),
        ("daylight", f"{day.daylight_h:.6f} h"),
    ]


def _due_text(day: "CircularDay") -> str:
    if day.due_east_h is None or day.due_west_h is None:
        side = "North" if day.declination_deg > day.latitude_deg else "South"
        return f"never: the Sun stays in the {side}"
    times = f"{day.due_east_h:.6f} h, {day.due_west_h:.6f} h solar time"
    height = day.elevation_deg(day.due_east_h)
    where = "below the horizon" if height < -1e-9 else f"{abs(height):.3f} deg high"
    return f"{times}, {where}"


def _pointing_lines(
    pointing: dict[str, float | None] | None, acceptance_deg: float | None
) -> list[tuple[str, str]]:
    if pointing is None:
        return []
    bearing = pointing["worst_bearing_deg"]
    lines = [
        (
            "pointing error",
            f"{pointing['error_deg']:g} deg costs {pointing['lost_percent']:.6f} % "
            "of the day's energy",
        )
    ]
    if bearing is not None:
        lines.append(("", f"at worst: tipped towards azimuth {bearing:.1f}"))
    if acceptance_deg is not None:
        lines.append(
            (
                "concentrator",
                f"accepting {acceptance_deg:g} deg sees {pointing['disc_percent']:.3f} % "
                "of the Sun's disc",
            )
        )
    return lines
