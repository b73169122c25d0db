"""The options that say which mount is meant and how far its axes go."""

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solarcal.mount.geometry import MountGeometry
    from solarcal.mount.limits import Limits
    from solarcal.site import Site


def add_limits_options(parser: argparse.ArgumentParser) -> None:
    """Which mount, and how far its axes go."""
    mount = parser.add_argument_group("when is the Sun within the mount's limits")
    mount.add_argument(
        "--geometry",
        default="azel",
        metavar="NAME",
        help="azel (default), tiltroll-ew, tiltroll-ns or polar",
    )
    mount.add_argument(
        "--ax1-centre",
        type=float,
        metavar="DEG",
        help="centre of the branch of AX1 (default 0; 180 for azel south of the equator)",
    )
    for axis in (1, 2):
        mount.add_argument(
            f"--limits{axis}",
            nargs=2,
            type=float,
            metavar=("LOW", "HIGH"),
            help=f"how far axis {axis} goes, deg (default: everywhere)",
        )
    mount.add_argument(
        "--lowest",
        type=float,
        default=0.0,
        metavar="DEG",
        help="airless elevation below which the Sun does not count (default 0)",
    )


def asked_mount(args: argparse.Namespace, site: "Site") -> "tuple[MountGeometry, Limits]":
    """The mount and limits asked about; axes without limits go everywhere."""
    from solarcal.errors import ConfigurationError
    from solarcal.mount.geometry import MountGeometry, default_ax1_centre
    from solarcal.mount.limits import AxisLimits, Limits

    centre_deg = args.ax1_centre
    if centre_deg is None:
        centre_deg = default_ax1_centre(args.geometry, site.latitude_deg)
    geometry = MountGeometry(args.geometry, site.latitude_deg, centre_deg)
    if not -90.0 <= args.lowest < 90.0:
        raise ConfigurationError(f"--lowest {args.lowest:g} is not between -90 and 90 degrees")
    first = args.limits1 or (centre_deg - 180.0, centre_deg + 180.0)
    second = args.limits2 or (0.0, 180.0)
    return geometry, Limits(AxisLimits(*first), AxisLimits(*second))
