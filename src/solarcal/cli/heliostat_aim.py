"""`solarcal heliostat aim` and `drift`: the mirror's normal, and what its offset does."""

import argparse
from typing import TYPE_CHECKING, Any

from solarcal.cli.heliostat import (
    apparent_sun,
    asked_geometry,
    asked_heliostat,
    asked_site,
    asked_sun_deg,
)

if TYPE_CHECKING:
    from solarcal.optics.aiming import Heliostat
    from solarcal.optics.mirror_roots import Root


def aim(args: argparse.Namespace) -> int:
    """The normal for a Sun and a target, with everything the offset does to it."""
    from solarcal.cli.output import print_json
    from solarcal.optics.aiming import format_mirror, format_target
    from solarcal.optics.mirror_roots import exact_roots
    from solarcal.optics.reflection import angle_deg, direction_enu

    sun, heliostat, geometry = asked_sun_deg(args), asked_heliostat(args), asked_geometry(args)
    target, offset = heliostat.target, heliostat.offset
    front, back = exact_roots(*sun, target, offset)
    first = heliostat.controller_normal_deg(*sun)
    ax1, ax2 = geometry.axes_from_horizontal(front.azimuth_deg, front.zenith_deg)
    apart = angle_deg(direction_enu(*first), direction_enu(front.azimuth_deg, front.zenith_deg))
    document = {
        "sun_azimuth_deg": sun[0],
        "sun_zenith_deg": sun[1],
        "normal_azimuth_deg": front.azimuth_deg,
        "normal_zenith_deg": front.zenith_deg,
        "incidence_deg": front.incidence_deg,
        "geometry": args.geometry,
        "ax1_deg": float(ax1),
        "ax2_deg": float(ax2),
        "controller": {
            "azimuth_deg": first[0],
            "zenith_deg": first[1],
            "apart_deg": float(apart),
        },
        "front": _root_document(front),
        "back": _root_document(back) if back is not None and offset else None,
        "parameters": None
        if args.distance is None
        else {
            "target": format_target(target),
            "mirror": format_mirror(heliostat.reduced_offset),
        },
    }
    if args.json:
        print_json(document)
        return 0
    print(f"  Sun     azimuth {sun[0]:9.4f}  zenith angle {sun[1]:8.4f}")
    print(f"  target  azimuth {target.azimuth_deg:9.4f}  zenith angle {target.zenith_deg:8.4f}")
    print(f"  NORMAL  azimuth {front.azimuth_deg:9.4f}  zenith angle {front.zenith_deg:8.4f}")
    print(f"  AX1 {float(ax1):+9.4f}  AX2 {float(ax2):8.4f}  ({args.geometry})")
    print(f"  angle of incidence {front.incidence_deg:.4f} deg")
    if offset:
        print(f"  the controller's first order is {float(apart):.5f} deg from it:")
        print(f"          azimuth {first[0]:9.4f}  zenith angle {first[1]:8.4f}")
        print("  That is the front root: the light falls on the mirror's face.")
        if back is None:
            print("  There is no back root.")
        else:
            print(
                f"  The back root, azimuth {back.azimuth_deg:.4f} zenith angle "
                f"{back.zenith_deg:.4f}, would turn\n"
                "  the mirror's reverse to the Sun; it is never the one to use."
            )
    if document["parameters"]:
        print(f"  PARAM target {format_target(target)}")
        print(f"  PARAM mirror {format_mirror(heliostat.reduced_offset)}")
    _draw_directions(args, sun, heliostat, front)
    return 0


def _root_document(root: "Root") -> dict[str, Any]:
    return {
        "azimuth_deg": root.azimuth_deg,
        "zenith_deg": root.zenith_deg,
        "normal_azimuth_deg": root.normal_azimuth_deg,
        "normal_zenith_deg": root.normal_zenith_deg,
        "incidence_deg": root.incidence_deg,
        "from_target_deg": root.from_target_deg,
        "miss": root.miss,
    }


def _draw_directions(
    args: argparse.Namespace, sun: tuple[float, float], heliostat: "Heliostat", front: "Root"
) -> None:
    from solarcal.cli.output import terminal_size
    from solarcal.report.instrument_plots import directions_plot

    width, colour = terminal_size()
    target = heliostat.target
    places = [
        ("S", "Sun", sun[0], 90.0 - sun[1]),
        ("N", "normal", front.azimuth_deg, 90.0 - front.zenith_deg),
        ("T", "target", target.azimuth_deg, 90.0 - target.zenith_deg),
    ]
    print(directions_plot(places, args.lat or 45.0, width, 12, colour))


def drift(args: argparse.Namespace) -> int:
    """What an uncorrected mirror offset does to the beam over a day."""
    import numpy as np

    from solarcal.cli.output import print_json, require, terminal_size
    from solarcal.cli.sun import asked_utc_s
    from solarcal.errors import ConfigurationError
    from solarcal.optics.drift import drift_over
    from solarcal.report.instrument_plots import Curve, curve_plot
    from solarcal.sun.day import daylight
    from solarcal.timescale import format_utc

    site, heliostat = asked_site(args), asked_heliostat(args)
    require(args.distance, "--distance")
    if not heliostat.offset:
        raise ConfigurationError("--offset is missing: without a mirror offset nothing drifts")
    span = daylight(site, asked_utc_s(args.at), 5.0)
    if span is None:
        raise ConfigurationError("the Sun does not get 5 deg above the horizon that day")
    utc_s = np.arange(np.ceil(span[0] / 600.0), np.floor(span[1] / 600.0) + 1.0) * 600.0
    sun = apparent_sun(utc_s, args)
    day = drift_over(heliostat, sun.azimuth_deg, sun.zenith_deg)
    span_length = float(np.hypot(np.ptp(day.right), np.ptp(day.up)))
    if args.json:
        print_json(
            {
                "utc": [format_utc(t) for t in utc_s.tolist()],
                "solar_time_h": sun.solar_time_h,
                "right": day.right,
                "up": day.up,
                "drift_max": day.drift_max,
                "drift_max_deg": day.drift_max_deg,
                "drift_span": span_length,
                "first_order_deg": day.first_order_deg,
                "first_order_max_deg": float(day.first_order_deg.max()),
            }
        )
        return 0
    width, colour = terminal_size()
    hours = sun.solar_time_h
    print(
        curve_plot(
            "beam from the target's middle",
            hours,
            [Curve("right", day.right, "●"), Curve("up", day.up, "+")],
            "apparent solar time, h",
            width,
            16,
            colour,
            hours=True,
        )
    )
    print(
        f"  Not corrected, the offset throws the beam up to {day.drift_max:.4g} "
        f"({day.drift_max_deg:.3f} deg) off the target's middle\n"
        f"  and lets it wander by {span_length:.4g} over the day, in the unit of the distance."
    )
    print(
        curve_plot(
            "normal, first order from exact, deg",
            hours,
            [Curve("apart", day.first_order_deg, "●")],
            "apparent solar time, h",
            width,
            12,
            colour,
            hours=True,
        )
    )
    print(
        "  Corrected to first order, the normal is at most "
        f"{float(day.first_order_deg.max()):.2g} deg from the exact one."
    )
    return 0
