"""`solarcal heliostat target`, `circle` and `shift`: where the target lies, and two small sums."""

import argparse

from solarcal.cli.heliostat import asked_geometry, asked_site
from solarcal.cli.output import print_answer, require


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
