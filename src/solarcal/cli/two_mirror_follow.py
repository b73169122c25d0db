"""`solarcal two-mirror follow`: points that take themselves, by a unit's sun sensor.

Typing the command is the explicit command. Today only an emulator's wire tells what its sensor
sees; a real unit is refused. On the Moon the unit is jogged: what it computes is the Sun.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solarcal.cli.calibrate import add_emulator_arguments, tracker_for
from solarcal.cli.output import say
from solarcal.cli.unit_options import add_driver_options, asks_for_unit, journal_creator
from solarcal.decimals import number_option, whole_option

if TYPE_CHECKING:
    from solarcal.unit.tracker import Tracker


def add_follow_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the subcommand."""

    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scenario", metavar="NAME|FILE", help="an emulated tracker, in process")
    where.add_argument("--port", metavar="URL", help="an emulator on a line")
    add_driver_options(parser)
    add_emulator_arguments(parser)
    parser.add_argument(
        "--target",
        choices=("sun", "moon"),
        default="sun",
        help="light of the sensor (default sun); an emulator in process gets the same light",
    )
    parser.add_argument(
        "--points", type=whole_option(1), default=12, help="points to take (default 12)"
    )
    parser.add_argument(
        "--every", type=number_option(0.0), default=30.0, metavar="MINUTES", help="(default 30)"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="the session file")


def follow(args: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    """Prepare the unit as the procedure asks, then let the sensor take the points."""
    if not asks_for_unit(args):
        args.settings = [*args.settings, f"truth.light={args.target}"]
    with tracker_for(args) as (tracker, name, noise_deg):
        return _followed(args, tracker, name, noise_deg)


def _followed(
    args: argparse.Namespace, tracker: "Tracker", name: str, noise_deg: float | None
) -> tuple[dict[str, Any], list[str]]:
    from solarcal.station.headless import emulated_station
    from solarcal.station.moon_following import MoonFollower
    from solarcal.station.sensor_following import FollowPlan, SensorFollower
    from solarcal.station.technician import AutomaticTechnician, Schedule

    plan = FollowPlan(args.points, args.every)
    station, emulation = emulated_station(
        tracker,
        "does not report a sun sensor; take points by eye with `solarcal run`",
        target=args.target,
        operator="sun sensor",
        pointing_device="emulated sun sensor",
    )
    path = station.open_session(journal_creator(args.output, name)).path
    kind: type[SensorFollower]
    if args.target == "moon":
        station.set_unit_clock()
        station.ref_check()
        station.initialise(confirmed=True)
        kind = MoonFollower
    else:
        AutomaticTechnician(station, emulation.spot, Schedule(), say=say).prepare()
        kind = SensorFollower
    sigma_deg = 0.02 if noise_deg is None else noise_deg
    follower = kind(station, emulation.spot, sensor_sigma_deg=sigma_deg, say=say)
    followed = follower.follow(plan, commanded=True)
    taken = len(followed.points)
    lines = [f"{taken} points by the sun sensor"]
    if followed.stopped:
        lines.append(f"STOPPED: {followed.stopped}")
    lines.append(f"session: {path}")
    station.close("following the sun sensor finished")
    document = {"session": str(path), "points": taken, "stopped": followed.stopped or None}
    return document, lines
