"""The plots a technician judges by, as text.

Amber is axis 1 and green is axis 2, and each has its own glyphs: nothing is said by colour alone.
All of them take any size from 40 x 10 on and answer an empty session with axes and a sentence.
Draw on one thread only (see ``canvas``).
"""

from collections.abc import Sequence

import numpy as np

from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.report import scales
from solarcal.report.canvas import Canvas, HeaderPart
from solarcal.report.scales import Scale, Theme
from solarcal.session.records import FitRecord
from solarcal.station.curves import ErrorPlotData
from solarcal.units import FloatArray

BAND_MIN_HEIGHT = 20
SIDE_BY_SIDE = 0.15
"""Of the distance from one number of points to the next, between two coefficients."""
SCALE_TRAVEL_DEG = 90.0
"""P5 and P6 are shown as the error they make over this much of axis travel."""


def _header(width: int, *wordings: Sequence[HeaderPart]) -> list[HeaderPart]:
    """The first wording that fits, else the last."""
    fitting = (w for w in wordings if sum(len(text) for text, _ in w) <= width)
    return list(next(fitting, wordings[-1]))


def _time_label(data: ErrorPlotData) -> str:
    """Without a single time (star catalogues) the ruler is an hour angle, whatever was observed."""
    return (
        "hour angle + 12, h" if data.points.labels and not data.days else "apparent solar time, h"
    )


def _draw_points(
    canvas: Canvas, data: ErrorPlotData, hours: Scale, values: Scale, y1: FloatArray, y2: FloatArray
) -> bool:
    """Both axes of every point, points of later days hollow; true if any two fell on one cell."""
    points, palette = data.points, canvas.palette
    used, later = np.array(points.used, dtype=bool), np.array(points.day) > 1
    x = points.solar_time_h
    for y, first, hollow, colour in (
        (y1, scales.AXIS1, scales.AXIS1_LATER, palette.axis1),
        (y2, scales.AXIS2, scales.AXIS2_LATER, palette.axis2),
    ):
        canvas.dots(x[~used], y[~used], scales.UNUSED, colour)
        canvas.dots(x[used & ~later], y[used & ~later], first, colour, bold=True)
        canvas.dots(x[used & later], y[used & later], hollow, colour, bold=True)
    together = np.array(
        [
            bool(np.isfinite(a + b)) and values.cell(a, canvas.rows) == values.cell(b, canvas.rows)
            for a, b in zip(y1.tolist(), y2.tolist(), strict=True)
        ],
        dtype=bool,
    )
    together &= used
    canvas.dots(x[together], y1[together], scales.BOTH, palette.text, bold=True)
    return bool(together.any())


def _legend(
    canvas: Canvas, data: ErrorPlotData, both: bool, subject: str, names: tuple[str, str]
) -> list[HeaderPart]:
    """What is drawn, and what the glyphs of the points mean."""
    palette = canvas.palette
    later1 = scales.AXIS1_LATER if data.days > 1 else ""
    later2 = scales.AXIS2_LATER if data.days > 1 else ""
    parts: list[HeaderPart] = [
        (subject, palette.text),
        (f"  {scales.AXIS1}{later1} {names[0]}", palette.axis1),
        (f"  {scales.AXIS2}{later2} {names[1]}", palette.axis2),
    ]
    if both:
        parts.append((f"  {scales.BOTH} both", palette.text))
    if not all(data.points.used):
        parts.append((f"  {scales.UNUSED} not used", palette.text))
    return parts


def error_plot(
    data: ErrorPlotData, width: int, height: int, colour: bool = True, theme: Theme = "phosphor"
) -> str:
    """Axis errors of the points and of the model every ten minutes, against solar time.

    Returns ``height`` lines of at most ``width`` characters; 40 x 10 is the least that can be read.
    Faint columns are times at which the limits shut the Sun out; from 20 rows on ``'`` and ``,``
    bound the model's one-sigma band.
    """
    canvas = Canvas(width, height, colour, theme, _time_label(data))
    points, model, palette = data.points, data.model, canvas.palette
    low, high = scales.error_range(
        (points.err1_deg, points.err2_deg), (model.err1_deg, model.err2_deg)
    )
    values = scales.value_scale(low, high, canvas.rows)
    hours = scales.hour_scale((points.solar_time_h, data.path.solar_time_h), canvas.columns)
    canvas.frame(hours, values)
    for start, end in data.outside_h:
        canvas.shade(start, end)
    canvas.level(0.0, scales.ZERO)
    band = False
    if height >= BAND_MIN_HEIGHT:
        for error, sigma, tone in (
            (model.err1_deg, model.sigma1_deg, palette.axis1),
            (model.err2_deg, model.sigma2_deg, palette.axis2),
        ):
            # A band narrower than the dots would only make them look ragged.
            wide = sigma >= 0.75 * canvas.cell_height
            band |= bool(wide.any())
            x, y, reach = model.solar_time_h[wide], error[wide], sigma[wide]
            canvas.dots(x, y + reach, scales.BAND_TOP, tone)
            canvas.dots(x, y - reach, scales.BAND_FOOT, tone)
    canvas.dots(model.solar_time_h, model.err1_deg, scales.MODEL1, palette.axis1)
    canvas.dots(model.solar_time_h, model.err2_deg, scales.MODEL2, palette.axis2)
    both = _draw_points(canvas, data, hours, values, points.err1_deg, points.err2_deg)
    if not points.labels:
        canvas.say("No points yet. The first one appears here as soon as it is stored.")
    curves: list[HeaderPart] = []
    if data.has_model:
        curves = [
            ("  model ", palette.text),
            (scales.MODEL1, palette.axis1),
            (" ", None),
            (scales.MODEL2, palette.axis2),
        ]
    marks: list[HeaderPart] = []
    if band:
        marks.append((f"  {scales.BAND_TOP} {scales.BAND_FOOT} 1 sigma", palette.text))
    if data.outside_h:
        marks.append((f"  {scales.SHADE} limits", palette.text))
    curve = np.concatenate((model.err1_deg, model.err2_deg))
    if bool(((curve < low) | (curve > high)).any()):
        marks.append(("  model off frame", palette.text))
    long = _legend(canvas, data, both, "axis error, deg", ("axis 1", "axis 2")) + curves
    short = _legend(canvas, data, both, "error, deg", ("ax1", "ax2")) + curves
    bare = _legend(canvas, data, False, "deg", ("ax1", "ax2")) + curves
    shorter = [short + marks[:k] for k in range(len(marks), -1, -1)]
    return canvas.finish(_header(width, long + marks, *shorter, bare))


def residual_plot(
    data: ErrorPlotData, width: int, height: int, colour: bool = True, theme: Theme = "phosphor"
) -> str:
    """What the model leaves of each point ON THE SKY, against solar time, with the tolerance."""
    canvas = Canvas(width, height, colour, theme, _time_label(data))
    points, palette = data.points, canvas.palette
    cross, along = points.cross_deg, points.along_deg
    finite = np.concatenate((cross, along))
    finite = np.abs(finite[np.isfinite(finite)])
    reach = 1.2 * max(float(finite.max()) if finite.size else 0.0, 0.3 * data.tolerance_deg)
    values = scales.value_scale(-reach, reach, canvas.rows)
    hours = scales.hour_scale((points.solar_time_h, data.path.solar_time_h), canvas.columns)
    canvas.frame(hours, values)
    for start, end in data.outside_h:
        canvas.shade(start, end)
    canvas.level(0.0, scales.ZERO)
    for sign in (-1.0, 1.0):
        canvas.level(sign * data.tolerance_deg, scales.TOLERANCE)
    both = False
    if data.has_model and points.labels:
        both = _draw_points(canvas, data, hours, values, cross, along)
    else:
        canvas.say("No fit yet. Residuals appear from the third point on.")
    names = ("across (axis 1)", "along (axis 2)")
    long = _legend(canvas, data, both, "residual on the sky, deg", names)
    short = _legend(canvas, data, both, "on sky, deg", ("axis 1", "axis 2"))
    bare = _legend(canvas, data, False, "on sky, deg", ("ax1", "ax2"))
    marks: list[HeaderPart] = []
    if data.tolerance_deg <= reach:
        marks.append((f"  {scales.TOLERANCE} tolerance {data.tolerance_deg:g}", palette.text))
    return canvas.finish(_header(width, long + marks, short + marks, long, short, bare))


def sky_map(
    data: ErrorPlotData, width: int, height: int, colour: bool = True, theme: Theme = "phosphor"
) -> str:
    """Where in the sky the points lie: elevation against azimuth, with the Sun's path."""
    canvas = Canvas(width, height, colour, theme, "azimuth")
    points, path, palette = data.points, data.path, canvas.palette
    tallest = max([30.0, *path.elevation_deg.tolist(), *points.elevation_deg.tolist()])
    top = min(90.0, 10.0 * np.ceil(tallest / 10.0))
    sun_x = scales.on_bearing_branch(path.azimuth_deg, data.latitude_deg)
    point_x = scales.on_bearing_branch(points.azimuth_deg, data.latitude_deg)
    canvas.frame(
        scales.bearing_scale(np.concatenate((sun_x, point_x))),
        scales.value_scale(0.0, top, canvas.rows, signed=False),
    )
    within = np.array(path.within_limits, dtype=bool)
    for mask, glyph, tone in (
        (~within, scales.PATH_OUTSIDE, palette.faint),
        (within, scales.PATH, palette.text),
    ):
        canvas.dots(sun_x[mask], path.elevation_deg[mask], glyph, tone)
    used = np.array(points.used, dtype=bool)
    y = points.elevation_deg
    canvas.dots(point_x[~used], y[~used], scales.UNUSED, palette.axis1)
    canvas.dots(point_x[used], y[used], scales.AXIS1, palette.axis1, bold=True)
    if not points.labels:
        canvas.say("No points yet: dots show where the Sun will be.")
    head: list[HeaderPart] = [
        ("elevation, deg", palette.text),
        (f"  {scales.AXIS1} points", palette.axis1),
        (f"  {scales.PATH} Sun", palette.text),
    ]
    outside: list[HeaderPart] = [(f"  {scales.PATH_OUTSIDE} beyond limits", palette.text)]
    return canvas.finish(_header(width, head + (outside if (~within).any() else []), head))


def convergence_plot(
    history: Sequence[FitRecord],
    width: int,
    height: int,
    colour: bool = True,
    theme: Theme = "phosphor",
) -> str:
    """P1..P6 against the number of points, each drawn with its own digit, with one-sigma bars.

    The six stand side by side about their number of points. P5 and P6 are shown as degrees per
    90 deg of travel. Early values are wild: the frame holds the later half of the history, and
    what lies beyond it is counted in the header.
    """
    canvas = Canvas(width, height, colour, theme, "points")
    palette = canvas.palette
    n = np.array([fit.points for fit in history], dtype=np.float64)
    weights = np.array([1.0] * 4 + [SCALE_TRAVEL_DEG] * 2)
    p = np.array([fit.coefficients.as_tuple() for fit in history]).reshape(-1, 6) * weights
    sigma = (
        np.array(
            [fit.sigmas.as_tuple() if fit.sigmas is not None else (np.nan,) * 6 for fit in history]
        ).reshape(-1, 6)
        * weights
    )
    half = len(p) // 2
    bar = np.nan_to_num(sigma[half:])
    low, high = scales.error_range([p[half:] - bar, p[half:] + bar], [])
    values = scales.value_scale(low, high, canvas.rows)
    first, last = (float(n.min()), float(n.max())) if n.size else (3.0, 12.0)
    last = max(last, first + 2.0)
    step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 1000) if (last - first) / s * 5 <= width)
    ticks = tuple(float(k) for k in range(int(first), int(last) + 1, step))
    canvas.frame(Scale(first - 0.5, last + 0.5, ticks, tuple(f"{int(k)}" for k in ticks)), values)
    canvas.level(0.0, scales.ZERO)
    tones = [scales.SERIES[i] if theme == "phosphor" else palette.text for i in range(6)]
    beside = n[:, np.newaxis] + SIDE_BY_SIDE * (np.arange(6) - 2.5)
    # Bars first: a digit may lie on a bar, no bar on a digit.
    for index in range(6):
        for x, y, s in zip(beside[:, index], p[:, index], sigma[:, index], strict=True):
            if np.isfinite(s):
                rows = np.arange(max(low, y - s), min(high, y + s), canvas.cell_height)
                canvas.dots(np.full(len(rows), x), rows, scales.BAR, palette.faint)
    for index in range(6):
        canvas.dots(beside[:, index], p[:, index], str(index + 1), tones[index], bold=True)
    if not history:
        canvas.say("No fit yet. P1..P6 appear here from the third point on.")
    beyond = int(((p < low) | (p > high)).sum())
    names = f"{COEFFICIENT_NAMES[0]}..{COEFFICIENT_NAMES[-1]}"
    short: list[HeaderPart] = [(f"P1..P6, deg (5, 6: per {SCALE_TRAVEL_DEG:g} deg)", palette.text)]
    long: list[HeaderPart] = [
        (
            f"{names} drawn as 1..6 with one sigma, deg (5, 6: per {SCALE_TRAVEL_DEG:g} deg)",
            palette.text,
        )
    ]
    if beyond:
        long.append((f"  {beyond} beyond the frame", palette.text))
    return canvas.finish(_header(width, long, short))
