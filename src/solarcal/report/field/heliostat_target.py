"""Where a heliostat's target lies, and two small sums: a mirror on a circle, a translation."""

from collections.abc import Sequence

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import MountGeometry
from solarcal.optics.heliostat import targeting, translation_deg
from solarcal.optics.mirror_roots import circle_roots
from solarcal.report.field.answer import Answer, Drawing, paragraph
from solarcal.report.instrument_plots import Curve, curve_plot, directions_plot
from solarcal.report.scales import Theme

Sighting = tuple[float, float, float, float]
"""Sun azimuth and zenith angle, normal azimuth and zenith angle, while the beam was on target."""

_CIRCLE_REACH = (1.5, 12.0)
"""Distances, in radii, over which both roots are drawn; wider where it is asked for."""


def from_axes(sighting: Sighting, geometry: MountGeometry) -> Sighting:
    """A sighting whose last two angles were read as AX1, AX2 of a mount."""
    azimuth, zenith = geometry.horizontal_from_axes(sighting[2], sighting[3])
    return sighting[0], sighting[1], float(azimuth), float(zenith)


def target(sightings: Sequence[Sighting], *, latitude_deg: float = 45.0) -> Answer:
    """The target's direction from sightings, at least one."""
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


def circle(angle_deg: float, distance: float, radius: float) -> Answer:
    """Both roots of a mirror on a circle (AzimPivot_R = PivotRefl_R = 0)."""
    if radius <= 0.0:
        raise ConfigurationError(f"the radius must be greater than zero, not {radius:g}")
    ratio = distance / radius
    roots = circle_roots(angle_deg, ratio)
    document = {
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


def shift(by: float, distance: float) -> Answer:
    """By how much a translation turns the line of sight."""
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
