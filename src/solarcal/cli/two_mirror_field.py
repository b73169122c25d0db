"""`solarcal two-mirror point`, `trace` and `fov`: what the bench asks, as document and as text."""

import argparse
from typing import Any

from solarcal.errors import ConfigurationError
from solarcal.optics.two_mirror import (
    EulerBase,
    axes_of,
    ray_to_sky,
    sun_axes_deg,
    tracker_matrix,
)
from solarcal.optics.two_mirror_diode import QuadrantDiode, disc_gain_per_rad, quadrant_errors
from solarcal.optics.two_mirror_fov import field_of_view
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc

Answer = tuple[dict[str, Any], list[str]]
"""The JSON document, and the same as lines of text."""


def base_document(base: EulerBase) -> dict[str, float]:
    """Euler angles as JSON."""
    return {
        "alpha_deg": base.alpha_deg,
        "beta_deg": base.beta_deg,
        "gamma_deg": base.gamma_deg,
    }


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
    base = EulerBase(args.alpha, args.beta, args.gamma)
    sun1, sun2 = sun_axes_deg(azimuth, zenith)
    t1, t2 = base.axes_deg(sun1, sun2)
    matrix = tracker_matrix(t1, t2)
    document = {
        "azimuth_deg": azimuth,
        "zenith_deg": zenith,
        "base": base_document(base),
        "t1_deg": t1,
        "t2_deg": t2,
        "tracker_matrix": matrix,
    }
    lines = [
        f"Sun: azimuth {azimuth:.4f}, zenith angle {zenith:.4f} deg",
        f"axis 1 (t1, from South, East positive) {t1:+10.4f} deg",
        f"axis 2 (t2, zenith angle)              {t2:+10.4f} deg",
        "mirrors (ray traced back from the instrument; South, East, Up):",
    ]
    lines += ["  " + " ".join(f"{value + 0.0:+9.6f}" for value in row) for row in matrix]
    return document, lines


def trace(args: argparse.Namespace) -> Answer:
    """The four signals as axis corrections."""

    normals = []
    for text in args.mirror:
        try:
            normals.append([float(part) for part in text.split(",")])
        except ValueError:
            raise ConfigurationError(f"--mirror {text}: write three numbers X,Y,Z") from None
    if not (-360.0 <= args.t1 <= 360.0 and -180.0 <= args.t2 <= 180.0):
        raise ConfigurationError("--t1 lies between -360 and 360, --t2 between -180 and 180 deg")
    diode = QuadrantDiode.with_fixed_mirrors(
        normals,
        gain_per_rad=disc_gain_per_rad() if args.gain is None else args.gain,
        set_point1=args.set_point[0],
        set_point2=args.set_point[1],
    )
    a, b, c, d = args.signals
    e1, e2 = quadrant_errors((a, b, c, d))
    sun1, sun2 = axes_of(ray_to_sky(diode.ray(e1, e2), args.t1, args.t2))
    turn1, turn2 = diode.corrections_deg(e1, e2, args.t1, args.t2)
    off_mrad = diode.off_centre_mrad(e1, e2)
    saturated = max(abs(e1), abs(e2)) > 0.95
    document = {
        "e1": e1,
        "e2": e2,
        "off_centre_mrad": off_mrad,
        "saturated": saturated,
        "sun_t1_deg": sun1,
        "sun_t2_deg": sun2,
        "correction1_deg": turn1,
        "correction2_deg": turn2,
    }
    lines = [
        f"e1 {e1:+.5f}  e2 {e2:+.5f}: {off_mrad:.3f} mrad off the set point"
        + (" at least (the diode is saturated)" if saturated else ""),
        f"Sun in the tracker's frame: t1 {sun1:+.4f}, t2 {sun2:+.4f} deg",
        f"add to axis 1 {turn1:+.5f} deg",
        f"add to axis 2 {turn2:+.5f} deg",
    ]
    return document, lines


def fov(args: argparse.Namespace) -> Answer:
    """The field-of-view budget."""

    field = field_of_view(
        args.diode_diameter, args.focal_length, args.tracker_diameter, args.distance, args.sun
    )
    document = {
        "diode_mrad": field.diode_mrad,
        "tracker_mrad": field.tracker_mrad,
        "field_mrad": field.field_mrad,
        "limited_by": field.limited_by,
        "sun_mrad": field.sun_mrad,
        "sun_centre_within_mrad": field.any_light_mrad,
        "whole_sun_within_mrad": field.whole_sun_mrad,
    }
    lines = [
        f"FOV1 of the diode    {field.diode_mrad:8.2f} mrad",
        f"FOV2 of the tracker  {field.tracker_mrad:8.2f} mrad",
        f"the {field.limited_by} limits: {field.field_mrad:.2f} mrad for a Sun of "
        f"{field.sun_mrad:.2f} mrad",
        f"the Sun's centre stays in the field up to {field.any_light_mrad:.2f} mrad of error,",
        f"the whole Sun up to {field.whole_sun_mrad:.2f} mrad"
        if field.whole_sun_mrad > 0.0
        else "the whole Sun never fits",
    ]
    return document, lines
