"""`solarcal sun`: where the Sun is, and which way that turns the axes."""

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solarcal.site import Site

HELP = "where the Sun is"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    add_place_and_time(parser)
    parser.add_argument(
        "--model",
        default="precise",
        metavar="MODEL",
        help="solartrak, solartrak+, noaa or precise (default)",
    )
    parser.add_argument(
        "--geometry",
        default="azel",
        metavar="NAME",
        help="azel (default), tiltroll-ew, tiltroll-ns or polar",
    )
    parser.add_argument(
        "--ax1-centre",
        type=float,
        metavar="DEG",
        help="centre of the branch of AX1 (default 0; 180 for azel south of the equator)",
    )
    parser.add_argument(
        "--refraction",
        default="none",
        metavar="FORMULA",
        help="none (default), hughes or saemundsson",
    )
    parser.add_argument(
        "--pressure",
        type=float,
        metavar="HPA",
        help="STATION pressure for the refraction (default: the mean at that elevation)",
    )
    parser.add_argument(
        "--temperature",
        type=float,
        default=15.0,
        metavar="C",
        help="air temperature for the refraction (default 15)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def add_place_and_time(parser: argparse.ArgumentParser) -> None:
    """The options that `sun` and `day` share."""
    parser.add_argument(
        "--lat", type=float, required=True, metavar="DEG", help="latitude, positive north"
    )
    parser.add_argument(
        "--lon", type=float, required=True, metavar="DEG", help="longitude, positive EAST"
    )
    parser.add_argument(
        "--elevation", type=float, default=0.0, metavar="M", help="metres above sea (default 0)"
    )
    parser.add_argument(
        "--at",
        metavar="ISO",
        help="date and time like 2026-06-21T15:30:00Z or with an offset like -07:00; "
        "UTC where it has none (default: now by this computer's clock)",
    )
    parser.add_argument(
        "--dut1",
        type=float,
        default=0.0,
        metavar="S",
        help="UT1 - UTC in seconds, for the precise model (default 0)",
    )


def asked_utc_s(at: str | None) -> float:
    """The instant of ``--at``, POSIX UTC seconds; now where it was not given."""
    from solarcal.clock import SystemClock
    from solarcal.timescale import parse_utc

    return SystemClock().utc_s() if at in (None, "now") else parse_utc(str(at))


def asked_day_utc_s(at: str | None, site: "Site") -> float:
    """The same for a whole day: a date alone is the site's own day, as in the workstation."""
    from solarcal.clock import SystemClock
    from solarcal.site import day_utc_s

    return SystemClock().utc_s() if at in (None, "now") else day_utc_s(str(at), site)


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    from solarcal.cli.output import print_answer
    from solarcal.mount.geometry import MountGeometry, default_ax1_centre
    from solarcal.report.field.sun import sun
    from solarcal.site import Site, Weather, standard_pressure_hpa

    site = Site(args.lat, args.lon, args.elevation)
    centre_deg = args.ax1_centre
    if centre_deg is None:
        centre_deg = default_ax1_centre(args.geometry, site.latitude_deg)
    pressure_hpa = args.pressure
    if pressure_hpa is None:
        pressure_hpa = standard_pressure_hpa(site.elevation_m)
    answer = sun(
        asked_utc_s(args.at),
        site,
        MountGeometry(args.geometry, site.latitude_deg, centre_deg),
        model=args.model,
        refraction=args.refraction,
        weather=Weather(pressure_hpa, args.temperature),
        dut1_s=args.dut1,
    )
    return print_answer(answer, args.json)
