"""Two 45-degree mirrors on an altazimuth mount: axes, the diode's correction, field of view."""

import math
from dataclasses import asdict
from pathlib import Path

from solarcal.errors import ConfigurationError
from solarcal.instruments.form import Answer, Form, answered
from solarcal.instruments.mount_and_collector import drawn_latitude_deg
from solarcal.instruments.sun import asked_sun_deg
from solarcal.instruments.sunspot import asked_image, asked_view, disc_line, found_in
from solarcal.optics.disc_image import find_disc
from solarcal.report.instrument_plots import Ring, directions_plot, rings_drawing
from solarcal.two_mirror.diode import (
    DISC_GAIN_PER_RAD,
    SUN_RADIUS_MRAD,
    QuadrantDiode,
    Signals,
    field_of_view,
    quadrant_errors,
)
from solarcal.two_mirror.mirrors import EulerBase, sun_axes_deg, tracker_matrix
from solarcal.units import RAD_PER_DEG


def point(form: Form) -> Answer:
    """Axis angles that look at the Sun."""
    base = EulerBase(form.number("alpha"), form.number("beta"), form.number("gamma"))
    latitude_deg = drawn_latitude_deg(form)
    azimuth_deg, zenith_deg = asked_sun_deg(form)
    sun1, sun2 = sun_axes_deg(azimuth_deg, zenith_deg)
    t1, t2 = base.axes_deg(sun1, sun2)
    matrix = tracker_matrix(t1, t2)
    document = {
        "azimuth_deg": azimuth_deg,
        "zenith_deg": zenith_deg,
        "base": asdict(base),
        "t1_deg": t1,
        "t2_deg": t2,
        "tracker_matrix": matrix,
    }
    lines = [
        f"Sun: azimuth {azimuth_deg:.4f}, zenith angle {zenith_deg:.4f} deg",
        f"axis 1 (t1, from South, East positive) {t1:+z10.4f} deg",
        f"axis 2 (t2, zenith angle)              {t2:+z10.4f} deg",
        "mirrors (ray traced back from the instrument; South, East, Up):",
    ]
    lines += ["  " + " ".join(f"{value:+z9.6f}" for value in row) for row in matrix]
    places = [
        ("S", "Sun", azimuth_deg, 90.0 - zenith_deg),
        ("A", "where a level base's axes would look", 180.0 - t1, 90.0 - t2),
    ]

    return answered(
        document, lines, "directions", lambda sheet: directions_plot(places, latitude_deg, sheet)
    )


SINGULAR_BELOW = math.sin(3.0 * RAD_PER_DEG)
"""Of sin t2: nearer to its pole axis 1 turns twenty times as far as the light moves."""
DARK_LEVEL = 0.05
"""Of all the light: how far below nothing a dark quadrant may read."""


def asked_mirrors(form: Form) -> list[list[float]]:
    """Normals of the fixed mirrors, the tracker's side first."""
    normals = [form.numbers(row) for row in form.filled_rows("mirror")]
    return [list(normal) for normal in normals if normal is not None]


def near_zenith_warning(t2_deg: float) -> list[str]:
    """A line where axis 1 is near its singularity; none elsewhere."""
    if abs(math.sin(t2_deg * RAD_PER_DEG)) >= SINGULAR_BELOW:
        return []
    return [
        f"warning: at t2 {t2_deg:g} deg axis 1 is near its singularity (t2 = 0 or 180): its "
        "correction is the offset divided by sin t2; turn axis 1 in the calculated mode there"
    ]


def trace(form: Form) -> Answer:
    """The four signals as axis corrections."""
    gain = form.optional("gain")
    diode = QuadrantDiode.with_fixed_mirrors(
        asked_mirrors(form),
        gain_per_rad=DISC_GAIN_PER_RAD if gain is None else gain,
        set_point1=form.number("set1"),
        set_point2=form.number("set2"),
    )
    signals: Signals = form.number("a"), form.number("b"), form.number("c"), form.number("d")
    t1_deg, t2_deg = form.number("t1"), form.number("t2")
    e1, e2 = quadrant_errors(signals)
    if min(signals) < -DARK_LEVEL * sum(signals):
        raise ConfigurationError(
            f"no light gives a signal of {min(signals):g}: measure the dark level anew, and check "
            "the diode's wires"
        )
    sun1, sun2 = diode.sun_axes_deg(e1, e2, t1_deg, t2_deg)
    turn1, turn2 = diode.corrections_deg(e1, e2, t1_deg, t2_deg)
    off_mrad = diode.off_centre_mrad(e1, e2)
    warning = near_zenith_warning(t2_deg)
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
        "near_zenith": bool(warning),
    }
    lines = [
        f"e1 {e1:+z.5f}  e2 {e2:+z.5f}: {off_mrad:.3f} mrad off the set point"
        + (" at least (the diode is saturated)" if saturated else ""),
        f"Sun in the tracker's frame: t1 {sun1:+z.4f}, t2 {sun2:+z.4f} deg",
        f"add to axis 1 {turn1:+z.5f} deg",
        f"add to axis 2 {turn2:+z.5f} deg",
        *warning,
    ]
    across = 1e3 * (e1 - diode.set_point1) / diode.gain_per_rad
    up = 1e3 * (e2 - diode.set_point2) / diode.gain_per_rad
    rings = [
        Ring("Sun at the set point", "#", 2.0 * SUN_RADIUS_MRAD),
        Ring("where it is", "o", 2.0 * SUN_RADIUS_MRAD, across, up),
    ]

    return answered(
        document, lines, "diode", lambda sheet: rings_drawing("traced back", rings, sheet)
    )


def camera(form: Form) -> Answer:
    """The disc in a camera's image as axis corrections, as those of the diode."""
    path, image = asked_image(form)
    disc = found_in(form, lambda: find_disc(image, form.optional("threshold")))
    aim = form.pair("aim") or (0.5 * (image.shape[1] - 1), 0.5 * (image.shape[0] - 1))
    radius_mrad = form.number("disc")
    pixel = form.optional("pixel")
    pixel_mrad = radius_mrad / disc.radius if pixel is None else pixel
    right, up = asked_view(form).moved(disc.x - aim[0], aim[1] - disc.y)
    d1, d2 = 1e-3 * pixel_mrad * right, 1e-3 * pixel_mrad * up
    sigma = 1e-3 * pixel_mrad * disc.sigma
    # A ray (d1, d2, 1): a diode of gain one, whose signals are the angles themselves.
    optics = QuadrantDiode.with_fixed_mirrors(asked_mirrors(form), gain_per_rad=1.0)
    t1_deg, t2_deg = form.number("t1"), form.number("t2")
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
        disc_line("disc", disc),
        f"{pixel_mrad:.4f} mrad a pixel"
        + (f", from a disc of radius {radius_mrad:g} mrad" if pixel is None else ""),
        f"d1 {1e3 * d1:+z.4f}  d2 {1e3 * d2:+z.4f} +- {1e3 * sigma:.4f} mrad: "
        f"{1e3 * math.hypot(d1, d2):.4f} mrad off the aim",
        f"add to axis 1 {turn1:+z.5f} +- {sigma1:.5f} deg",
        f"add to axis 2 {turn2:+z.5f} +- {sigma2:.5f} deg",
        *near_zenith_warning(t2_deg),
    ]
    diameter = 2.0 * pixel_mrad * disc.radius
    rings = [
        Ring("disc at the aim", "#", diameter),
        Ring("where it is", "o", diameter, 1e3 * d1, 1e3 * d2),
    ]

    return answered(
        document, lines, "image", lambda sheet: rings_drawing("traced back, mrad", rings, sheet)
    )


def fov(form: Form) -> Answer:
    """The field-of-view budget."""
    sizes = (form.number(name) for name in ("diode", "focal", "tracker", "distance", "sun"))
    field = field_of_view(*sizes)
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
    rings = [
        Ring("diode", "#", field.diode_mrad),
        Ring("tracker", "+", field.tracker_mrad),
        Ring("Sun", "o", field.sun_mrad),
    ]

    return answered(
        document, lines, "fields", lambda sheet: rings_drawing("fields of view", rings, sheet)
    )
