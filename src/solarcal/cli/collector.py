"""The options that describe a collector, for every command that tells its energy."""

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solarcal.sun.energy import Collector


def add_collector_options(parser: argparse.ArgumentParser) -> None:
    """Which way the collector faces; a level one where nothing is said."""
    group = parser.add_argument_group("collector (default: level, fixed)")
    which = group.add_mutually_exclusive_group()
    vector: dict[str, Any] = {"nargs": 3, "type": float, "metavar": ("N", "E", "U")}
    which.add_argument(
        "--normal", **vector, help="fixed, facing this North East Up vector of any length"
    )
    which.add_argument(
        "--tilt", type=float, metavar="DEG", help="fixed, tilted from level towards --facing"
    )
    which.add_argument("--tracking", action="store_true", help="faces the Sun on two axes")
    which.add_argument(
        "--axis", **vector, help="turns about this axis alone; 1 0 0 is a North-South trough"
    )
    group.add_argument(
        "--facing",
        type=float,
        metavar="DEG",
        help="azimuth from North through East for --tilt (default: the equator's side)",
    )


def collector_of(args: argparse.Namespace, latitude_deg: float) -> "Collector":
    """The collector asked for.

    Raises
    ------
    ConfigurationError
        A zero vector, a tilt beyond 0..180, or --facing without --tilt.
    """
    from solarcal.errors import ConfigurationError
    from solarcal.report.field.collector import tilted
    from solarcal.sun.energy import FixedCollector, OneAxisCollector, TrackingCollector

    if args.facing is not None and args.tilt is None:
        raise ConfigurationError("--facing says where a --tilt leans to; give both, or --normal")
    if args.tracking:
        return TrackingCollector()
    if args.axis is not None:
        return OneAxisCollector((args.axis[0], args.axis[1], args.axis[2]))
    if args.normal is not None:
        return FixedCollector((args.normal[0], args.normal[1], args.normal[2]))
    if args.tilt is None:
        return FixedCollector()
    return tilted(args.tilt, args.facing, latitude_deg)
