"""Where a heliostat's target lies, and two small sums: a mirror on a circle, a translation."""

from typing import Any

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.instruments.answer import Answer, Drawing, paragraph
from solarcal.instruments.form import Form
from solarcal.instruments.mount_and_collector import asked_geometry, drawn_latitude_deg
from solarcal.instruments.sun import apparent_sun
from solarcal.optics.heliostat import targeting, translation_deg
from solarcal.optics.mirror_roots import circle_roots, published_bisection
from solarcal.report.instrument_plots import Curve, curve_plot, directions_plot
from solarcal.report.scales import Theme

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
    document = {
        "azimuth_deg": found.azimuth_deg,
        "zenith_deg": found.zenith_deg,
        "residual_deg": found.residual_deg,
        "rms_deg": found.rms_deg,
        "sigma_deg": found.sigma_deg,
        "observations": len(sightings),
    }
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

    def draw(width: int, height: int, colour: bool, theme: Theme) -> str:
        return directions_plot(places, latitude_deg, width, height, colour, theme)

    return Answer(document, (paragraph(*lines),), Drawing("directions", draw))


def circle(form: Form) -> Answer:
    """Both roots of a mirror on a circle (AzimPivot_R = PivotRefl_R = 0)."""
    angle_deg, distance, radius = (form.number(one) for one in ("angle", "distance", "radius"))
    if radius <= 0.0:
        raise ConfigurationError(f"the radius must be greater than zero, not {radius:g}")
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
                    f"  {number:4d}{step.low_deg:12.6f}{step.high_deg:12.6f}"
                    f"{step.incidence_deg:13.6f}{step.difference:+13.6f}"
                    for number, step in enumerate(steps, start=1)
                ),
                f"  {steps[-1].incidence_deg:.6f} after {len(steps)} steps; the root finder above "
                f"gives {getattr(roots, f'{side}_deg'):.6f}",
            ]

    def draw(width: int, height: int, colour: bool, theme: Theme) -> str:
        ratios = np.linspace(min(_CIRCLE_REACH[0], ratio), max(_CIRCLE_REACH[1], 1.5 * ratio), 40)
        both = [circle_roots(angle_deg, float(one)) for one in ratios]
        curves = [
            Curve("front", np.array([one.front_deg for one in both]), "●"),
            Curve("back", np.array([one.back_deg for one in both]), "+"),
        ]
        return curve_plot(
            "incidence T, deg", ratios, curves, "distance / radius", width, height, colour, theme,
            marks=[(ratio, "asked")],
        )  # fmt: skip

    return Answer(document, (paragraph(*lines),), Drawing("both roots", draw))


def shift(form: Form) -> Answer:
    """By how much a translation turns the line of sight."""
    by, distance = form.number("by"), form.number("distance")
    angle = translation_deg(by, distance)

    def draw(width: int, height: int, colour: bool, theme: Theme) -> str:
        far = np.linspace(0.5 * distance, 2.0 * distance, 60)
        turned = np.array([translation_deg(by, float(one)) for one in far])
        return curve_plot(
            "target turned by, deg", far, [Curve("angle", turned, "●")], "distance",
            width, height, colour, theme, marks=[(distance, "asked")],
        )  # fmt: skip

    said = f"  A translation of {by:g} at {distance:g} turns the target by {angle:.4f} deg"
    return Answer({"angle_deg": angle}, (said,), Drawing("over the distance", draw))
