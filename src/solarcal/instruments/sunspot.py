"""The sunspot device: pointing error from readings or a picture; a device for resolution and range.

What any picture of a form is: ``asked_image`` and ``asked_view``.
"""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TypeVar

from solarcal.errors import InputFileError
from solarcal.instruments.form import Answer, Drawing, Form, answered, labelled
from solarcal.optics.disc_image import Disc, find_disc, find_spot_and_hole, newest_image, read_image
from solarcal.optics.sunspot import design_for, design_from_size, spot_error_deg, two_position_check
from solarcal.report.instrument_plots import plate_drawing
from solarcal.report.scales import Sheet
from solarcal.units import FloatArray, format_degrees


def error(form: Form) -> Answer:
    """The pointing error from the edge readings; one at 180 deg checks the device itself."""
    height, hole, spot, edge = (form.number(name) for name in ("height", "hole", "spot", "edge"))
    edge_up, turned = form.optional("edge_up"), form.optional("turned")
    found = spot_error_deg(height, hole, spot, edge)
    up = None if edge_up is None else spot_error_deg(height, hole, spot, edge_up)
    device = tracker = None
    if turned is not None:
        device, tracker = two_position_check(found, spot_error_deg(height, hole, spot, turned))
    rim = 0.5 * (spot - hole)
    sky = math.hypot(found, up or 0.0)
    document = {
        "error_deg": found,
        "error_up_deg": up,
        "sky_error_deg": sky,
        "even_rim": rim,
        "device_deg": device,
        "tracker_deg": tracker,
    }
    lines = [f"  error towards that edge  {format_degrees(found, 4)} deg"]
    if up is not None:
        lines += [
            f"  error upwards            {format_degrees(up, 4)} deg",
            f"  on the sky               {sky:8.4f} deg",
        ]
    lines.append(f"  E without an error       {rim:8.4g} on every side")
    if device is not None and tracker is not None:
        lines += [
            f"  of this the device's own {format_degrees(device, 4)} deg",
            f"  and the tracker's        {format_degrees(tracker, 4)} deg",
        ]
    above = 0.0 if edge_up is None else edge_up - rim

    drawing = Drawing(
        "plate", lambda sheet: plate_drawing(hole, spot, edge - rim, above, sheet), 15
    )
    return Answer(document, ("\n".join(lines), drawing))


def design(form: Form) -> Answer:
    """What a device shows: its resolution and its range; by its size, or by what is wanted."""
    hole, shift = form.number("hole"), form.number("shift")
    if form.choice("from") == "a resolution":
        device = design_for(form.number("resolution"), form.number("range"), hole, shift)
    else:
        device = design_from_size(form.number("height"), hole, form.number("plate"), shift)
    lines = labelled(
        ("height H of the plate", f"{device.height:.4g}", ""),
        ("hole Do", f"{device.hole:.4g}", ""),
        ("plate, diameter", f"{device.plate:.4g}", ""),
        ("spot Ds", f"{device.spot:.4g}", ""),
        ("E without an error", f"{device.even_rim:.4g}", ""),
        ("resolution", f"{device.resolution_deg:.4g}", "deg"),
        ("range, either side", f"{device.range_deg:.4g}", "deg"),
    )

    def draw(sheet: Sheet) -> str:
        return plate_drawing(device.hole, device.spot, 0.0, 0.0, sheet, plate_diameter=device.plate)

    return answered(asdict(device), lines, "plate", draw)


Found = TypeVar("Found", Disc, tuple[Disc, Disc])


@dataclass(frozen=True, slots=True)
class View:
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


def plate(form: Form) -> Answer:
    """E in both directions, and what they mean, from a picture of the sunspot device's plate."""
    path, image = asked_image(form)
    threshold, given = form.optional("threshold"), form.pair("hole_at")
    height, hole_diameter = form.number("height"), form.number("hole")
    spot_diameter = form.optional("spot")
    if given is None:
        spot, hole = found_in(form, lambda: find_spot_and_hole(image, threshold))
        pixel = hole_diameter / (2.0 * hole.radius)
    else:
        spot = found_in(form, lambda: find_disc(image, threshold))
        if spot_diameter is None:
            raise form.missing("spot")
        pixel = spot_diameter / (2.0 * spot.radius)
        hole = replace(
            spot, x=given[0], y=given[1], radius=0.5 * hole_diameter / pixel, sigma=0.0, edges=0
        )
    right, up = asked_view(form).moved(spot.x - hole.x, hole.y - spot.y)
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
        disc_line("spot", spot),
        disc_line("hole", hole),
        f"  E to the right           {edges[0]:8.4g} +- {edge_sigma:.2g}",
        f"  E upwards                {edges[1]:8.4g} +- {edge_sigma:.2g}",
        f"  E without an error       {rim:8.4g} on every side",
        f"  error to the right       {format_degrees(errors[0], 4)} +- {sigma_deg:.4f} deg",
        f"  error upwards            {format_degrees(errors[1], 4)} +- {sigma_deg:.4f} deg",
        f"  on the sky               {math.hypot(*errors):8.4f} deg",
    ]

    def draw(sheet: Sheet) -> str:
        return plate_drawing(hole_diameter, spot_size, pixel * right, pixel * up, sheet)

    return Answer(document, ("\n".join(lines), Drawing("plate", draw, 15)))


def asked_image(form: Form) -> tuple[str, FloatArray]:
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


def found_in(form: Form, look: Callable[[], Found]) -> Found:
    try:
        return look()
    except InputFileError as error:
        raise form.error("image", str(error)) from None


def asked_view(form: Form) -> View:
    return View(form.number("rotated"), form.choice("mirrored") == "yes")


def disc_line(name: str, disc: Disc) -> str:
    known = f" +- {disc.sigma:.3f}" if disc.edges else ", as given"
    return f"{name} at x {disc.x:.3f}, y {disc.y:.3f}{known}, radius {disc.radius:.3f} pixels"
