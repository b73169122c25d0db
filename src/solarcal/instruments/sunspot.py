"""The sunspot device: pointing error from the spot, the device for a resolution and range."""

import math

from solarcal.instruments.form import Answer, Drawing, Form, paragraph
from solarcal.optics.sunspot import (
    design_for,
    design_from_size,
    spot_error_deg,
    two_position_check,
)
from solarcal.report.instrument_plots import plate_drawing
from solarcal.report.scales import Sheet
from solarcal.units import format_degrees


def error(form: Form) -> Answer:
    """The pointing error from the edge readings; one at 180 deg checks the device itself."""
    height, hole, spot, edge = (form.number(name) for name in ("height", "hole", "spot", "edge"))
    edge_up, turned = form.optional("edge_up"), form.optional("turned")
    found = spot_error_deg(height, hole, spot, edge)
    up = None if edge_up is None else spot_error_deg(height, hole, spot, edge_up)
    check = None
    if turned is not None:
        check = two_position_check(found, spot_error_deg(height, hole, spot, turned))
    rim = 0.5 * (spot - hole)
    sky = math.hypot(found, up or 0.0)
    document = {
        "error_deg": found,
        "error_up_deg": up,
        "sky_error_deg": sky,
        "even_rim": rim,
        "device_deg": None if check is None else check.device_deg,
        "tracker_deg": None if check is None else check.tracker_deg,
    }
    lines = [f"  error towards that edge  {format_degrees(found, 4)} deg"]
    if up is not None:
        lines += [
            f"  error upwards            {format_degrees(up, 4)} deg",
            f"  on the sky               {sky:8.4f} deg",
        ]
    lines.append(f"  E without an error       {rim:8.4g} on every side")
    if check is not None:
        lines += [
            f"  of this the device's own {format_degrees(check.device_deg, 4)} deg",
            f"  and the tracker's        {format_degrees(check.tracker_deg, 4)} deg",
        ]
    above = 0.0 if edge_up is None else edge_up - rim

    drawing = Drawing(
        "plate", lambda sheet: plate_drawing(hole, spot, edge - rim, above, sheet), 15
    )
    return Answer(document, (paragraph(*lines), drawing))


def design(form: Form) -> Answer:
    """What a device shows: its resolution and its range; by its size, or by what is wanted."""
    hole, shift = form.number("hole"), form.number("shift")
    if form.choice("from") == "a resolution":
        device = design_for(form.number("resolution"), form.number("range"), hole, shift)
    else:
        device = design_from_size(form.number("height"), hole, form.number("plate"), shift)
    document = {
        "height": device.height,
        "hole": device.hole_diameter,
        "plate": device.plate_diameter,
        "spot": device.spot_diameter,
        "even_rim": device.even_rim,
        "smallest_shift": device.smallest_shift,
        "resolution_deg": device.resolution_deg,
        "range_deg": device.range_deg,
    }
    lines = [
        f"  {name:<24}{value:>10.4g} {unit}".rstrip()
        for name, value, unit in (
            ("height H of the plate", device.height, ""),
            ("hole Do", device.hole_diameter, ""),
            ("plate, diameter", device.plate_diameter, ""),
            ("spot Ds", device.spot_diameter, ""),
            ("E without an error", device.even_rim, ""),
            ("resolution", device.resolution_deg, "deg"),
            ("range, either side", device.range_deg, "deg"),
        )
    ]

    def draw(sheet: Sheet) -> str:
        return plate_drawing(
            device.hole_diameter,
            device.spot_diameter,
            0.0,
            0.0,
            sheet,
            plate_diameter=device.plate_diameter,
        )

    return Answer(document, (paragraph(*lines),), Drawing("plate", draw))
