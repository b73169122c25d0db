"""`solarcal two-mirror point`, `trace` and `fov`: what the bench asks, as document and as text."""

import argparse
from typing import Any

from solarcal.errors import ConfigurationError
from solarcal.report.field import two_mirror
from solarcal.report.field.two_mirror import base_document
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc
from solarcal.two_mirror.diode import QuadrantDiode, disc_gain_per_rad, field_of_view
from solarcal.two_mirror.mirrors import EulerBase

__all__ = ["base_document", "fov", "point", "trace"]

Answer = tuple[dict[str, Any], list[str]]
"""The JSON document, and the same as lines of text."""


def point(args: argparse.Namespace) -> Answer:
    """Axis angles that look at the Sun."""
    azimuth, zenith = args.azimuth, args.zenith
    if azimuth is None or zenith is None:
        if args.lat is None or args.lon is None or args.at is None:
            raise ConfigurationError(
                "give the Sun by --azimuth and --zenith, or the place and time by --lat, --lon "
                "and --at"
            )
        site = Site(args.lat, args.lon, args.elevation)
        sun = sun_position("precise", parse_utc(args.at), site, refraction="hughes")
        azimuth, zenith = float(sun.azimuth_deg), float(sun.zenith_deg)
    answer = two_mirror.point(azimuth, zenith, EulerBase(args.alpha, args.beta, args.gamma))
    return answer.document, answer.lines


def trace(args: argparse.Namespace) -> Answer:
    """The four signals as axis corrections."""
    normals = []
    for text in args.mirror:
        try:
            normals.append([float(part) for part in text.split(",")])
        except ValueError:
            raise ConfigurationError(f"--mirror {text}: write three numbers X,Y,Z") from None
    diode = QuadrantDiode.with_fixed_mirrors(
        normals,
        gain_per_rad=disc_gain_per_rad() if args.gain is None else args.gain,
        set_point1=args.set_point[0],
        set_point2=args.set_point[1],
    )
    a, b, c, d = args.signals
    answer = two_mirror.trace((a, b, c, d), args.t1, args.t2, diode)
    return answer.document, answer.lines


def fov(args: argparse.Namespace) -> Answer:
    """The field-of-view budget."""
    answer = two_mirror.fov(
        field_of_view(
            args.diode_diameter, args.focal_length, args.tracker_diameter, args.distance, args.sun
        )
    )
    return answer.document, answer.lines
