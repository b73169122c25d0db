"""A heliostat's mirror over a day, its target; a mirror on a circle, a translation."""

from dataclasses import asdict
from typing import Any

import numpy as np

from solarcal.decimals import require_positive
from solarcal.errors import ConfigurationError
from solarcal.instruments.form import Answer, Draw, Drawing, Form, answered
from solarcal.instruments.mount_and_collector import asked_geometry, drawn_latitude_deg
from solarcal.instruments.sun import apparent_sun, asked_sun_deg
from solarcal.optics.mirror_roots import Root, circle_roots, exact_roots, published_bisection
from solarcal.optics.offset_mirror import (
    Heliostat,
    MirrorOffset,
    drift_over,
    format_mirror,
    format_target,
)
from solarcal.optics.reflection import Target, angle_deg, direction_enu, targeting, translation_deg
from solarcal.report.instrument_plots import Curve, curve_plot, directions_plot
from solarcal.report.scales import Sheet
from solarcal.sun.day import daylight
from solarcal.timescale import format_utc
from solarcal.units import format_degrees

Sighting = tuple[float, float, float, float]
"""Sun azimuth and zenith angle, normal azimuth and zenith angle, while the beam was on target."""

_CIRCLE_REACH = (1.5, 12.0)
"""Distances, in radii, over which both roots are drawn; wider where it is asked for."""


def _sighting(form: Form, row: str) -> Sighting | None:
    """One row: four angles, or a time that stands for the Sun and the normal's two angles."""
    text = form.text(row)
    if "T" not in text.upper():
        numbers = form.numbers(row)
        return None if numbers is None else (numbers[0], numbers[1], numbers[2], numbers[3])
    parts = text.split()
    if len(parts) != 3:
        raise form.error(row, "write the time and the normal's two angles")
    sun = apparent_sun(form.instant(row, parts[0]), form.site(), form.choice("refraction"))
    normal = form.number_in(row, parts[1]), form.number_in(row, parts[2])
    return float(sun.azimuth_deg), float(sun.zenith_deg), *normal


def _sightings(form: Form) -> list[Sighting]:
    rows = [one for row in form.filled_rows("seen") if (one := _sighting(form, row)) is not None]
    if not rows:
        raise form.missing("seen")
    geometry = asked_geometry(form, form.optional("lat"))
    if form.choice("read") != "AX1 AX2":
        return rows
    read = []
    for azimuth, zenith, first, second in rows:
        normal = geometry.horizontal_from_axes(first, second)
        read.append((azimuth, zenith, float(normal[0]), float(normal[1])))
    return read


def target(form: Form) -> Answer:
    """The target's direction from sightings, at least one."""
    sightings, latitude_deg = _sightings(form), drawn_latitude_deg(form)
    found = targeting(*np.array(sightings, dtype=np.float64).T)
    document = {**asdict(found), "observations": len(sightings)}
    lines = [f"  TARGET  azimuth {found.azimuth_deg:9.4f}  zenith angle {found.zenith_deg:8.4f}"]
    lines += [
        f"  observation {number}: {residual:.4f} deg away from there"
        for number, residual in enumerate(found.residual_deg, start=1)
    ]
    if found.rms_deg is None:
        lines.append("  One observation only: a second one, hours later, proves it.")
    else:
        lines.append(
            f"  rms {found.rms_deg:.4f} deg per axis, of the mean {found.sigma_deg:.4f} deg"
        )
    lines.append("  The distance is not in these angles: measure it.")
    places = [("T", "target", found.azimuth_deg, 90.0 - found.zenith_deg)]
    places += [
        (str(number % 10), f"Sun {number}", one[0], 90.0 - one[1])
        for number, one in enumerate(sightings, start=1)
    ]

    return answered(
        document, lines, "directions", lambda sheet: directions_plot(places, latitude_deg, sheet)
    )


def circle(form: Form) -> Answer:
    """Both roots of a mirror on a circle (AzimPivot_R = PivotRefl_R = 0)."""
    angle_deg, distance, radius = (form.number(one) for one in ("angle", "distance", "radius"))
    require_positive("the radius", radius)
    ratio = distance / radius
    roots = circle_roots(angle_deg, ratio)
    document: dict[str, Any] = {
        "front_deg": roots.front_deg,
        "front_from_target_deg": roots.front_from_target_deg,
        "back_deg": roots.back_deg,
        "back_from_target_deg": roots.back_from_target_deg,
    }
    lines = [
        f"  {'root':<7}{'incidence T':>14}{'normal from target':>22}   deg",
        f"  {'front':<7}{roots.front_deg:14.6f}{roots.front_from_target_deg:22.6f}",
        f"  {'back':<7}{roots.back_deg:14.6f}{roots.back_from_target_deg:22.6f}",
        "  Use the front one: at the back the light would fall on the mirror's reverse.",
    ]
    if form.choice("steps") == "yes":
        sides = {
            "front": published_bisection(angle_deg, ratio, "front"),
            "back": published_bisection(angle_deg, ratio, "back"),
        }
        document["bisection"] = {
            side: [step.incidence_deg for step in steps] for side, steps in sides.items()
        }
        for side, steps in sides.items():
            lines += [
                "",
                f"  published bisection, {side}",
                f"  {'step':>4}{'from':>12}{'to':>12}{'middle T':>13}{'d/r residual':>13}",
                *(
                    f"  {number:4d}{step.low_deg:z12.6f}{step.high_deg:z12.6f}"
                    f"{step.incidence_deg:13.6f}{step.difference:+z13.6f}"
                    for number, step in enumerate(steps, start=1)
                ),
                f"  {steps[-1].incidence_deg:.6f} after {len(steps)} steps; the root finder above "
                f"gives {getattr(roots, f'{side}_deg'):.6f}",
            ]

    def draw(sheet: Sheet) -> str:
        ratios = np.linspace(min(_CIRCLE_REACH[0], ratio), max(_CIRCLE_REACH[1], 1.5 * ratio), 40)
        both = [circle_roots(angle_deg, float(one)) for one in ratios]
        curves = [
            Curve("front", np.array([one.front_deg for one in both]), "●"),
            Curve("back", np.array([one.back_deg for one in both]), "+"),
        ]
        return curve_plot(
            "incidence T, deg", ratios, curves, "distance / radius", sheet, marks=[(ratio, "asked")]
        )

    return answered(document, lines, "both roots", draw)


def shift(form: Form) -> Answer:
    """By how much a translation turns the line of sight."""
    by, distance = form.number("by"), form.number("distance")
    angle = translation_deg(by, distance)

    def draw(sheet: Sheet) -> str:
        far = np.linspace(0.5 * distance, 2.0 * distance, 60)
        turned = np.array([translation_deg(by, float(one)) for one in far])
        return curve_plot(
            "target turned by, deg", far, [Curve("angle", turned, "●")], "distance",
            sheet, marks=[(distance, "asked")],
        )  # fmt: skip

    said = f"  A translation of {by:g} at {distance:g} turns the target by {angle:.4f} deg"
    return Answer({"angle_deg": angle}, (said,), Drawing("over the distance", draw))


_STEP_S = 600.0
_LOWEST_DEG = 5.0


def _heliostat(form: Form) -> Heliostat:
    offset = MirrorOffset(
        form.number("azimpivot_r"), form.number("pivotrefl_r"), form.number("pivotrefl_z")
    )
    azimuth_deg, zenith_deg = form.number("target_azimuth"), form.number("target_zenith")
    # Without an offset directions say everything, and any distance will do.
    distance = form.number("distance") if offset else form.optional("distance")
    return Heliostat(Target(azimuth_deg, zenith_deg, 1.0 if distance is None else distance), offset)


def aim(form: Form) -> Answer:
    """The normal for a Sun and a target, with everything the offset does to it.

    Without a distance the unit's parameters are not determined.
    """
    sun_deg, heliostat = asked_sun_deg(form), _heliostat(form)
    geometry = asked_geometry(form, form.optional("lat"))
    distance_known = form.optional("distance") is not None
    latitude_deg = drawn_latitude_deg(form)
    target, offset = heliostat.target, heliostat.offset
    front, back = exact_roots(*sun_deg, target, offset)
    first = heliostat.controller_normal_deg(*sun_deg)
    ax1, ax2 = geometry.axes_from_horizontal(front.azimuth_deg, front.zenith_deg)
    apart = angle_deg(direction_enu(*first), direction_enu(front.azimuth_deg, front.zenith_deg))
    parameters = {
        "target": format_target(target),
        "mirror": format_mirror(heliostat.reduced_offset),
    }
    document = {
        "sun_azimuth_deg": sun_deg[0],
        "sun_zenith_deg": sun_deg[1],
        "normal_azimuth_deg": front.azimuth_deg,
        "normal_zenith_deg": front.zenith_deg,
        "incidence_deg": front.incidence_deg,
        "geometry": geometry.name,
        "ax1_deg": float(ax1),
        "ax2_deg": float(ax2),
        "controller": {"azimuth_deg": first[0], "zenith_deg": first[1], "apart_deg": float(apart)},
        "front": _root_document(front),
        "back": _root_document(back) if back is not None and offset else None,
        "parameters": parameters if distance_known else None,
    }
    lines = [
        f"  Sun     azimuth {sun_deg[0]:9.4f}  zenith angle {sun_deg[1]:8.4f}",
        f"  target  azimuth {target.azimuth_deg:9.4f}  zenith angle {target.zenith_deg:8.4f}",
        f"  NORMAL  azimuth {front.azimuth_deg:9.4f}  zenith angle {front.zenith_deg:8.4f}",
        f"  AX1 {format_degrees(float(ax1), 4):>9}  AX2 {float(ax2):z8.4f}  ({geometry.name})",
        f"  angle of incidence {front.incidence_deg:.4f} deg",
    ]
    if offset:
        lines += [
            f"  the controller's first order is {float(apart):.5f} deg from it:",
            f"          azimuth {first[0]:9.4f}  zenith angle {first[1]:8.4f}",
            "  That is the front root: the light falls on the mirror's face.",
        ]
        if back is None:
            lines.append("  There is no back root.")
        else:
            lines += [
                f"  The back root, azimuth {back.azimuth_deg:.4f} zenith angle "
                f"{back.zenith_deg:.4f}, would turn",
                "  the mirror's reverse to the Sun; do not use it.",
            ]
    if distance_known:
        lines += [f"  PARAM {name} {value}" for name, value in parameters.items()]
    places = [
        ("S", "Sun", sun_deg[0], 90.0 - sun_deg[1]),
        ("N", "normal", front.azimuth_deg, 90.0 - front.zenith_deg),
        ("T", "target", target.azimuth_deg, 90.0 - target.zenith_deg),
    ]

    drawing = Drawing("directions", lambda sheet: directions_plot(places, latitude_deg, sheet), 12)
    return Answer(document, ("\n".join(lines), drawing))


def _root_document(root: Root) -> dict[str, Any]:
    """The part of a document about a root, whose side is its key."""
    return {name: value for name, value in asdict(root).items() if name != "side"}


def drift(form: Form) -> Answer:
    """What an uncorrected mirror offset does to the beam over the day of an instant.

    Raises
    ------
    ConfigurationError
        There is no offset, or no Sun that day.
    """
    site, heliostat = form.site(), _heliostat(form)
    utc_s, refraction = form.day_utc_s("at", site), form.choice("refraction")
    form.number("distance")
    if not heliostat.offset:
        raise ConfigurationError("the mirror's offset is zero: without one nothing drifts")
    span = daylight(site, utc_s, _LOWEST_DEG)
    if span is None:
        raise ConfigurationError("the Sun does not get 5 deg above the horizon that day")
    first, last = np.ceil(span[0] / _STEP_S), np.floor(span[1] / _STEP_S)
    times = np.arange(first, last + 1.0) * _STEP_S
    sun = apparent_sun(times, site, refraction)
    day = drift_over(heliostat, sun.azimuth_deg, sun.zenith_deg)
    span_length = float(np.hypot(np.ptp(day.right), np.ptp(day.up)))
    worst_deg = float(day.first_order_deg.max())
    document = {
        "utc": [format_utc(t) for t in times.tolist()],
        "solar_time_h": sun.solar_time_h,
        "right": day.right,
        "up": day.up,
        "drift_max": day.drift_max,
        "drift_max_deg": day.drift_max_deg,
        "drift_span": span_length,
        "first_order_deg": day.first_order_deg,
        "first_order_max_deg": worst_deg,
    }
    hours = sun.solar_time_h

    def over_the_day(title: str, *curves: Curve) -> Draw:
        return lambda sheet: curve_plot(
            title, hours, curves, "apparent solar time, h", sheet, hours=True
        )

    beam = over_the_day(
        "beam from the target's middle", Curve("right", day.right, "●"), Curve("up", day.up, "+")
    )
    first_order = over_the_day(
        "normal, first order from exact, deg", Curve("apart", day.first_order_deg, "●")
    )

    return Answer(
        document,
        (
            Drawing("beam", beam, 16),
            f"  Without correction the offset moves the beam up to {day.drift_max:.4g} "
            f"({day.drift_max_deg:.3f} deg) off the target's middle\n"
            f"  and the beam moves by {span_length:.4g} over the day, in the unit of the distance.",
            Drawing("first order", first_order, 12),
            f"  Corrected to first order, the normal is at most {worst_deg:.2g} deg from the "
            "exact one.",
        ),
    )
