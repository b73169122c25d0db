"""`solarcal heliostat target`, `circle` and `shift`: where the target lies, and two small sums."""

import argparse

from solarcal.cli.heliostat import apparent_sun, asked_geometry


def target(args: argparse.Namespace) -> int:
    """The target's direction from normals read while the beam was on it."""
    import numpy as np

    from solarcal.cli.output import print_json
    from solarcal.errors import ConfigurationError
    from solarcal.optics.heliostat import targeting
    from solarcal.timescale import parse_utc

    geometry = asked_geometry(args)
    rows = [tuple(row) for row in args.seen]
    for iso, first, second in args.seen_at:
        sun = apparent_sun(parse_utc(iso), args)
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
        rows = [
            (a, z, *(float(v) for v in geometry.horizontal_from_axes(n1, n2)))
            for a, z, n1, n2 in rows
        ]
    found = targeting(*np.array(rows, dtype=np.float64).T)
    if args.json:
        print_json(
            {
                "azimuth_deg": found.azimuth_deg,
                "zenith_deg": found.zenith_deg,
                "residual_deg": found.residual_deg,
                "rms_deg": found.rms_deg,
                "sigma_deg": found.sigma_deg,
                "observations": len(rows),
            }
        )
        return 0
    print(f"  TARGET  azimuth {found.azimuth_deg:9.4f}  zenith angle {found.zenith_deg:8.4f}")
    for number, residual in enumerate(found.residual_deg, start=1):
        print(f"  observation {number}: {residual:.4f} deg away from there")
    if found.rms_deg is None:
        print("  One observation only: a second one, hours later, proves it.")
    else:
        print(f"  rms {found.rms_deg:.4f} deg per axis, of the mean {found.sigma_deg:.4f} deg")
    print("  The distance is not in these angles: measure it.")
    return 0


def circle(args: argparse.Namespace) -> int:
    """Both roots of a mirror on a circle."""
    from solarcal.cli.output import print_json, require
    from solarcal.errors import ConfigurationError
    from solarcal.optics.mirror_roots import circle_roots

    distance, radius = require(args.distance, "--distance"), require(args.radius, "--radius")
    if radius <= 0.0:
        raise ConfigurationError(f"--radius must be greater than zero, not {radius:g}")
    roots = circle_roots(require(args.angle, "--angle"), distance / radius)
    if args.json:
        print_json(
            {
                "front_deg": roots.front_deg,
                "front_from_target_deg": roots.front_from_target_deg,
                "back_deg": roots.back_deg,
                "back_from_target_deg": roots.back_from_target_deg,
            }
        )
        return 0
    print(f"  {'root':<7}{'incidence T':>14}{'normal from target':>22}   deg")
    print(f"  {'front':<7}{roots.front_deg:14.6f}{roots.front_from_target_deg:22.6f}")
    print(f"  {'back':<7}{roots.back_deg:14.6f}{roots.back_from_target_deg:22.6f}")
    print("  Use the front one: at the back the light would fall on the mirror's reverse.")
    return 0


def shift(args: argparse.Namespace) -> int:
    """By how much a translation turns the line of sight."""
    from solarcal.cli.output import print_json, require
    from solarcal.optics.heliostat import translation_deg

    angle = translation_deg(require(args.by, "--by"), require(args.distance, "--distance"))
    if args.json:
        print_json({"angle_deg": angle})
        return 0
    print(
        f"  A translation of {args.by:g} at {args.distance:g} turns the target by {angle:.4f} deg"
    )
    return 0
