"""What a picture says: a camera in place of the diode, and the plate of a sunspot device."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from solarcal.errors import InputFileError
from solarcal.instruments.form import Answer, Drawing, Form, paragraph
from solarcal.instruments.two_mirror import asked_axes_deg, asked_mirrors, near_zenith_warning
from solarcal.optics.disc_image import (
    Disc,
    find_disc,
    find_spot_and_hole,
    newest_image,
    read_image,
)
from solarcal.optics.sunspot import spot_error_deg
from solarcal.report.instrument_plots import Ring, plate_drawing, rings_drawing
from solarcal.report.scales import Sheet
from solarcal.two_mirror.diode import QuadrantDiode
from solarcal.units import FloatArray, format_degrees

_Found = TypeVar("_Found", Disc, tuple[Disc, Disc])


@dataclass(frozen=True, slots=True)
class _View:
    """How a picture lies: it shows the device rotated clockwise, and mirrored left to right."""

    rotated_deg: float
    mirrored: bool

    def moved(self, right: float, up: float) -> tuple[float, float]:
        """A shift in the picture as a shift along the device's own two directions."""
        if self.mirrored:
            right = -right
        angle = math.radians(self.rotated_deg)
        sine, cosine = math.sin(angle), math.cos(angle)
        return cosine * right - sine * up, sine * right + cosine * up


def camera(form: Form) -> Answer:
    """The disc in a camera's image as axis corrections, as those of the diode."""
    path, image = _image(form)
    disc = _found(form, lambda: find_disc(image, form.optional("threshold")))
    aim = form.pair("aim") or (0.5 * (image.shape[1] - 1), 0.5 * (image.shape[0] - 1))
    radius_mrad = form.number("disc")
    pixel = form.optional("pixel")
    pixel_mrad = radius_mrad / disc.radius if pixel is None else pixel
    right, up = _view(form).moved(disc.x - aim[0], aim[1] - disc.y)
    d1, d2 = 1e-3 * pixel_mrad * right, 1e-3 * pixel_mrad * up
    sigma = 1e-3 * pixel_mrad * disc.sigma
    # A ray (d1, d2, 1): a diode of gain one, whose signals are the angles themselves.
    optics = QuadrantDiode.with_fixed_mirrors(asked_mirrors(form), gain_per_rad=1.0)
    t1_deg, t2_deg = asked_axes_deg(form)
    turn1, turn2 = optics.corrections_deg(d1, d2, t1_deg, t2_deg)
    slopes = [
        optics.corrections_deg(d1 + step1, d2 + step2, t1_deg, t2_deg)
        for step1, step2 in ((sigma, 0.0), (0.0, sigma))
    ]
    sigma1 = math.hypot(*(math.remainder(one - turn1, 360.0) for one, _ in slopes))
    sigma2 = math.hypot(*(two - turn2 for _, two in slopes))
    document = {
        "image": path,
        "disc": disc.as_json(),
        "aim": list(aim),
        "pixel_mrad": pixel_mrad,
        "d1_mrad": 1e3 * d1,
        "d2_mrad": 1e3 * d2,
        "sigma_mrad": 1e3 * sigma,
        "off_centre_mrad": 1e3 * math.hypot(d1, d2),
        "correction1_deg": turn1,
        "correction2_deg": turn2,
        "correction1_sigma_deg": sigma1,
        "correction2_sigma_deg": sigma2,
    }
    lines = [
        f"{Path(path).name}, {image.shape[1]} x {image.shape[0]} pixels",
        _disc_line("disc", disc),
        f"{pixel_mrad:.4f} mrad a pixel"
        + (f", from a disc of radius {radius_mrad:g} mrad" if pixel is None else ""),
        f"d1 {1e3 * d1:+.4f}  d2 {1e3 * d2:+.4f} +- {1e3 * sigma:.4f} mrad: "
        f"{1e3 * math.hypot(d1, d2):.4f} mrad off the aim",
        f"add to axis 1 {turn1:+.5f} +- {sigma1:.5f} deg",
        f"add to axis 2 {turn2:+.5f} +- {sigma2:.5f} deg",
        *near_zenith_warning(t2_deg),
    ]
    diameter = 2.0 * pixel_mrad * disc.radius
    rings = [
        Ring("disc at the aim", "#", diameter),
        Ring("where it is", "o", diameter, 1e3 * d1, 1e3 * d2),
    ]

    return Answer(
        document,
        (paragraph(*lines),),
        Drawing("image", lambda sheet: rings_drawing("traced back, mrad", rings, sheet)),
    )


def plate(form: Form) -> Answer:
    """E in both directions, and what they mean, from a picture of the sunspot device's plate."""
    path, image = _image(form)
    threshold, given = form.optional("threshold"), form.pair("hole_at")
    height, hole_diameter = form.number("height"), form.number("hole")
    spot_diameter = form.optional("spot")
    if given is None:
        spot, hole = _found(form, lambda: find_spot_and_hole(image, threshold))
        pixel = hole_diameter / (2.0 * hole.radius)
    else:
        spot = _found(form, lambda: find_disc(image, threshold))
        if spot_diameter is None:
            raise form.missing("spot")
        pixel = spot_diameter / (2.0 * spot.radius)
        hole = replace(
            spot, x=given[0], y=given[1], radius=0.5 * hole_diameter / pixel, sigma=0.0, edges=0
        )
    right, up = _view(form).moved(spot.x - hole.x, hole.y - spot.y)
    spot_size = 2.0 * pixel * spot.radius
    rim = 0.5 * (spot_size - hole_diameter)
    edges = (rim + pixel * right, rim + pixel * up)
    errors = [spot_error_deg(height, hole_diameter, spot_size, edge) for edge in edges]
    edge_sigma = pixel * math.hypot(spot.sigma, hole.sigma)
    sigma_deg = math.degrees(math.atan(edge_sigma / (2.0 * height)))
    document = {
        "image": path,
        "spot": spot.as_json(),
        "hole": hole.as_json(),
        "pixel": pixel,
        "spot_diameter": spot_size,
        "even_rim": rim,
        "edge": edges[0],
        "edge_up": edges[1],
        "edge_sigma": edge_sigma,
        "error_deg": errors[0],
        "error_up_deg": errors[1],
        "error_sigma_deg": sigma_deg,
        "sky_error_deg": math.hypot(*errors),
    }
    lines = [
        f"{Path(path).name}, {image.shape[1]} x {image.shape[0]} pixels, {pixel:.4g} a pixel",
        _disc_line("spot", spot),
        _disc_line("hole", hole),
        f"  E to the right           {edges[0]:8.4g} +- {edge_sigma:.2g}",
        f"  E upwards                {edges[1]:8.4g} +- {edge_sigma:.2g}",
        f"  E without an error       {rim:8.4g} on every side",
        f"  error to the right       {format_degrees(errors[0], 4)} +- {sigma_deg:.4f} deg",
        f"  error upwards            {format_degrees(errors[1], 4)} +- {sigma_deg:.4f} deg",
        f"  on the sky               {math.hypot(*errors):8.4f} deg",
    ]

    def draw(sheet: Sheet) -> str:
        return plate_drawing(hole_diameter, spot_size, pixel * right, pixel * up, sheet)

    return Answer(document, (paragraph(*lines), Drawing("plate", draw, 15)))


def _image(form: Form) -> tuple[str, FloatArray]:
    """The image named, or the newest whole one of the folder named."""
    path = form.text("image")
    if not path:
        raise form.missing("image")
    try:
        if not Path(path).is_dir():
            return path, read_image(path)
        newest = newest_image(path)
    except InputFileError as error:
        raise form.error("image", str(error)) from None
    if newest is None:
        raise form.error("image", f"no whole image (.pgm, .png) is in the folder {path}")
    return newest


def _found(form: Form, look: Callable[[], _Found]) -> _Found:
    try:
        return look()
    except InputFileError as error:
        raise form.error("image", str(error)) from None


def _view(form: Form) -> _View:
    return _View(form.number("rotated"), form.choice("mirrored") == "yes")


def _disc_line(name: str, disc: Disc) -> str:
    known = f" +- {disc.sigma:.3f}" if disc.edges else ", as given"
    return f"{name} at x {disc.x:.3f}, y {disc.y:.3f}{known}, radius {disc.radius:.3f} pixels"
