"""`solarcal heliostat`: aim, targeting, mirror offset and its drift, the mirror on a circle.

What to compute is the first word: ``aim`` (default), ``target``, ``drift``, ``circle``, ``shift``.

JSON of ``aim``: ``sun_azimuth_deg, sun_zenith_deg, normal_azimuth_deg, normal_zenith_deg,
incidence_deg, geometry, ax1_deg, ax2_deg, controller`` (first order: ``azimuth_deg, zenith_deg,
apart_deg``), ``front`` and ``back`` (exact roots: ``azimuth_deg, zenith_deg, normal_azimuth_deg,
normal_zenith_deg, incidence_deg, from_target_deg, miss``; ``back`` null without a mirror offset)
and ``parameters`` (``target``, ``mirror`` as the unit's PARAM takes them; null without a distance).
``target``: ``azimuth_deg, zenith_deg, residual_deg, rms_deg, sigma_deg, observations``. ``drift``:
``utc, solar_time_h, right, up, drift_max, drift_max_deg, drift_span, first_order_deg,
first_order_max_deg``. ``circle``: ``front_deg, front_from_target_deg, back_deg,
back_from_target_deg``. ``shift``: ``angle_deg``.
"""

import argparse
from typing import TYPE_CHECKING

from solarcal.cli.output import print_answer, require

if TYPE_CHECKING:
    from solarcal.mount.geometry import MountGeometry
    from solarcal.optics.aiming import Heliostat
    from solarcal.site import Site

HELP = "aim, target and mirror offset of a heliostat"

WHATS = ("aim", "target", "drift", "circle", "shift")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    add = parser.add_argument
    add(
        "what",
        nargs="?",
        choices=WHATS,
        default="aim",
        help="aim: the normal for a Sun and a target (default); target: where the beam goes, from "
        "normals read while it was on the target; drift: of an uncorrected mirror offset over a "
        "day; circle: both roots of AzimPivot_R = PivotRefl_R = 0; shift: what a translation turns",
    )
    direction = ("AZIMUTH", "ZENITH")
    add("--sun", type=float, nargs=2, metavar=direction, help="the Sun, instead of place and time")
    add("--lat", type=float, metavar="DEG", help="latitude, positive north")
    add("--lon", type=float, metavar="DEG", help="longitude, positive EAST")
    add("--elevation", type=float, default=0.0, metavar="M", help="metres above sea (0)")
    add("--at", metavar="ISO", help="date and time, UTC unless with an offset (default: now)")
    add(
        "--refraction",
        default="hughes",
        metavar="FORMULA",
        help="hughes (default; mean air of that elevation), saemundsson or none",
    )
    add("--target", type=float, nargs=2, metavar=direction, help="the target from the hub")
    add("--distance", type=float, metavar="D", help="to the target (circle: d, shift: how far)")
    add(
        "--offset",
        type=float,
        nargs=3,
        metavar=("AZIMPIVOT_R", "PIVOTREFL_R", "PIVOTREFL_Z"),
        help="the mirror's offsets, in the unit of the distance",
    )
    add(
        "--seen",
        type=float,
        nargs=4,
        action="append",
        default=[],
        metavar=("SUN_AZ", "SUN_ZEN", "N1", "N2"),
        help="target: Sun and normal while the beam was on the target; as often as seen",
    )
    add(
        "--seen-at",
        nargs=3,
        action="append",
        default=[],
        metavar=("ISO", "N1", "N2"),
        help="target: the same with the time instead of the Sun (needs --lat --lon)",
    )
    add("--axes", action="store_true", help="N1 N2 are AX1 AX2 of --geometry, not azimuth, zenith")
    add("--geometry", default="azel", metavar="NAME", help="azel (default), tiltroll-ew, ...")
    add("--ax1-centre", type=float, default=0.0, metavar="DEG", help="branch of AX1 (0)")
    add("--angle", type=float, metavar="DEG", help="circle: phi, between Sun and target")
    add("--radius", type=float, default=1.0, metavar="R", help="circle: r (1)")
    add("--by", type=float, metavar="LENGTH", help="shift: by how much across the line of sight")
    add("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "Azimuth from North through East, zenith angle from straight up, degrees. JSON keys: see "
        "docs/instruments.md."
    )


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    calculators = {
        "aim": aim,
        "drift": drift,
        "target": target,
        "circle": circle,
        "shift": shift,
    }
    return calculators[args.what](args)


def asked_site(args: argparse.Namespace) -> "Site":
    """The place of --lat, --lon and --elevation."""
    from solarcal.site import Site

    return Site(require(args.lat, "--lat"), require(args.lon, "--lon"), args.elevation)


def asked_geometry(args: argparse.Namespace) -> "MountGeometry":
    """The frame in which axis angles are given and shown."""
    from solarcal.errors import ConfigurationError
    from solarcal.mount.geometry import MountGeometry

    if args.geometry == "polar" and args.lat is None:
        raise ConfigurationError("--lat is missing; a polar mount's axes stand by the latitude")
    return MountGeometry(args.geometry, args.lat or 0.0, args.ax1_centre)


def asked_sun_deg(args: argparse.Namespace) -> tuple[float, float]:
    """Azimuth and zenith angle: given, or the apparent ones for place and time."""
    if args.sun is not None:
        return require(args.sun[0], "--sun AZIMUTH"), require(args.sun[1], "--sun ZENITH")
    from solarcal.cli.sun import asked_utc_s
    from solarcal.errors import ConfigurationError

    if args.lat is None and args.lon is None:
        raise ConfigurationError("give the Sun: --sun AZIMUTH ZENITH, or --lat --lon and --at")
    from solarcal.report.field.heliostat_aim import apparent_sun

    sun = apparent_sun(asked_utc_s(args.at), asked_site(args), args.refraction)
    return float(sun.azimuth_deg), float(sun.zenith_deg)


def asked_heliostat(args: argparse.Namespace) -> "Heliostat":
    """Target and mirror offset of the options."""
    from solarcal.errors import ConfigurationError
    from solarcal.optics.aiming import Heliostat
    from solarcal.optics.heliostat import Target
    from solarcal.optics.offset_mirror import MirrorOffset

    if args.target is None:
        raise ConfigurationError("--target AZIMUTH ZENITH is missing")
    offset = MirrorOffset(*(args.offset or (0.0, 0.0, 0.0)))
    # Without an offset directions say everything, and any distance will do.
    distance = require(args.distance, "--distance") if offset else args.distance
    azimuth_deg, zenith_deg = args.target
    return Heliostat(Target(azimuth_deg, zenith_deg, 1.0 if distance is None else distance), offset)


def aim(args: argparse.Namespace) -> int:
    """The normal for a Sun and a target, with everything the offset does to it."""
    from solarcal.report.field.heliostat_aim import aim as answer

    return print_answer(
        answer(
            asked_sun_deg(args),
            asked_heliostat(args),
            asked_geometry(args),
            distance_known=args.distance is not None,
            latitude_deg=args.lat or 45.0,
        ),
        args.json,
    )


def drift(args: argparse.Namespace) -> int:
    """What an uncorrected mirror offset does to the beam over a day."""
    from solarcal.cli.sun import asked_day_utc_s
    from solarcal.report.field.heliostat_aim import drift as answer

    site, heliostat = asked_site(args), asked_heliostat(args)
    require(args.distance, "--distance")
    at_utc_s = asked_day_utc_s(args.at, site)
    return print_answer(answer(site, heliostat, at_utc_s, args.refraction), args.json)


def target(args: argparse.Namespace) -> int:
    """The target's direction from normals read while the beam was on it."""
    from solarcal.errors import ConfigurationError
    from solarcal.report.field import heliostat_aim, heliostat_target
    from solarcal.timescale import parse_utc

    geometry = asked_geometry(args)
    rows = [(row[0], row[1], row[2], row[3]) for row in args.seen]
    for iso, first, second in args.seen_at:
        sun = heliostat_aim.apparent_sun(parse_utc(iso), asked_site(args), args.refraction)
        try:
            normal = float(first), float(second)
        except ValueError:
            raise ConfigurationError(
                f"--seen-at {iso} {first} {second}: the normal's angles must be numbers"
            ) from None
        rows.append((float(sun.azimuth_deg), float(sun.zenith_deg), *normal))
    if not rows:
        raise ConfigurationError(
            "targeting needs --seen SUN_AZ SUN_ZEN N1 N2 or --seen-at ISO N1 N2, once at least"
        )
    if args.axes:
        rows = [heliostat_target.from_axes(row, geometry) for row in rows]
    return print_answer(heliostat_target.target(rows, latitude_deg=args.lat or 45.0), args.json)


def circle(args: argparse.Namespace) -> int:
    """Both roots of a mirror on a circle."""
    from solarcal.report.field.heliostat_target import circle as answer

    distance, radius = require(args.distance, "--distance"), require(args.radius, "--radius")
    return print_answer(answer(require(args.angle, "--angle"), distance, radius), args.json)


def shift(args: argparse.Namespace) -> int:
    """By how much a translation turns the line of sight."""
    from solarcal.report.field.heliostat_target import shift as answer

    by, distance = require(args.by, "--by"), require(args.distance, "--distance")
    return print_answer(answer(by, distance), args.json)
