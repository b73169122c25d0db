"""``solarcal track``: follow the Sun with a rotator, coefficients applied."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solarcal.cli.calibrate import add_emulator_arguments, tracker_for
from solarcal.cli.fit import add_method_option
from solarcal.cli.plan import next_time
from solarcal.cli.process import print_json, say
from solarcal.cli.unit_options import PORT_HELP, add_driver_options, port
from solarcal.decimals import number_option
from solarcal.errors import ConfigurationError
from solarcal.timescale import SystemClock

if TYPE_CHECKING:
    from solarcal.timescale import Clock
    from solarcal.unit.tracker import Tracker


def add_arguments(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--port", type=port, metavar="URL", help=f"{PORT_HELP} (default: the profile's)"
    )
    where.add_argument("--scenario", metavar="NAME|FILE", help="an emulated rotator, in process")
    add_driver_options(parser)
    add_emulator_arguments(parser)
    parser.add_argument(
        "--coefficients", type=Path, metavar="FILE",
        help="output of `solarcal fit --json`, or a session file, for this run; default: the last "
        "uploaded ones",
    )  # fmt: skip
    add_method_option(parser)
    parser.add_argument("--until", metavar="HH:MM", help="UTC; default: sunset")
    parser.add_argument(
        "--every",
        type=number_option(0.0, 86400.0),
        default=10.0,
        metavar="S",
        help="seconds between printed lines (default 10)",
    )
    parser.add_argument("--json", action="store_true", help="a summary on stdout at the end")


def run(args: argparse.Namespace) -> int:
    """Track until the end, then stop the rotator."""
    from solarcal.station.clocks import EmulatedClock

    if not 1.0 <= args.every <= 3600.0:
        raise ConfigurationError(f"--every {args.every:g}: give seconds between 1 and 3600")
    if args.scenario and not args.driver:
        args.driver = "rotctld"
    if not any((args.scenario, args.port, args.driver, args.profile, args.site)):
        raise ConfigurationError("which rotator? give --port and --site, or --site alone")
    with tracker_for(args) as (tracker, _, _):
        identity = tracker.open()
        emulation = tracker.emulation
        clock: Clock = SystemClock() if emulation is None else EmulatedClock(emulation)
        document = _tracked(args, tracker, f"{identity.model} {identity.serial}", clock)
    if args.json:
        print_json(document)
    return 0


def _tracked(
    args: argparse.Namespace, tracker: "Tracker", unit: str, clock: "Clock"
) -> dict[str, Any]:
    from solarcal.station.software_controller.rotator_tracker import RotatorTracker
    from solarcal.station.sun_tracking import SunTracking, TrackingRun, read_coefficients

    if not isinstance(tracker, RotatorTracker):
        raise ConfigurationError(
            f"{unit} has its own tracking: put it into mode TRACK with `solarcal run`, and load "
            "coefficients with `solarcal upload`; this command is for --driver rotctld"
        )
    source = "what was uploaded last"
    if args.coefficients is not None:
        found = read_coefficients(args.coefficients, args.method)
        if found.geometry != tracker.site().geometry:
            raise ConfigurationError(
                f"{args.coefficients} is of a {found.geometry} mount, this is "
                f"{tracker.site().geometry}: its coefficients do not apply here"
            )
        tracker.use_for_now(found.coefficients)
        source = found.source
    coefficients, _ = tracker.in_force()
    now_s = clock.utc_s()
    until_s = next_time(args.until, now_s, "--until") if args.until else None
    say(f"{unit}: tracking with P1..P6 {_numbers(coefficients.as_tuple())} ({source})")
    summary = SunTracking(tracker, clock, TrackingRun(unit, coefficients, source, now_s), say)
    done = summary.until(until_s, args.every).document()
    looks, worst = done["looks"], done["off_max_deg"]
    far = "" if worst is None else f", at most {worst:.3f} deg from their targets"
    say(f"stopped ({done['ended_by']}) after {looks} looks{far}")
    return done


def _numbers(values: tuple[float, ...]) -> str:
    return (
        " ".join(f"{value:+.4f}" for value in values[:4])
        + " "
        + " ".join(f"{value:+.6f}" for value in values[4:])
    )
