"""The plots a technician judges by, as text.

Amber is axis 1 and green is axis 2, and each has its own glyphs: nothing is shown by colour alone.
All of them take any size from 40 x 10 on and answer an empty session with axes and a sentence.
Draw on one thread only (see ``canvas``).
"""

from collections.abc import Sequence

import numpy as np

from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.report import scales
from solarcal.report.canvas import Canvas, HeaderPart
from solarcal.report.scales import WHOLE, Scale, Sheet, View
from solarcal.session.records import FitRecord
from solarcal.station.curves import ErrorPlotData
from solarcal.units import FloatArray

BAND_MIN_HEIGHT = 20
SIDE_BY_SIDE = 0.15
"""Of the distance from one number of points to the next, between two coefficients."""
SCALE_TRAVEL_DEG = 90.0
"""P5 and P6 are shown as the error they make over this much of axis travel."""


class _PointPlot:
    """Two values of every point against solar time, ``y1`` of axis 1 and ``y2`` of axis 2, (n,)."""

    def __init__(
        self, data: ErrorPlotData, sheet: Sheet, view: View, y1: FloatArray, y2: FloatArray
    ) -> None:
        # Without a single time (star catalogues) the ruler is an hour angle, whatever was observed.
        timeless = data.points.labels and not data.days
        label = "hour angle + 12, h" if timeless else "apparent solar time, h"
        self.canvas = Canvas(sheet, label)
        self.palette = self.canvas.palette
        self.at = view.point(len(data.points.labels))
        """Index of the point the cursor marks."""
        self._data, self._view = data, view
        self._y1, self._y2 = y1, y2

    def frame(self, low: float, high: float, tolerance_deg: float | None = None) -> Scale:
        """Frame, shut hours, levels and cursor; the ruler of values, or its window looked at."""
        canvas, data, view = self.canvas, self._data, self._view
        points = data.points
        hours = scales.hour_scale((points.solar_time_h, data.path.solar_time_h), canvas.columns)
        if view.zoom > 1.0:
            place = None
            if self.at is not None and np.isfinite(self._y1[self.at] + self._y2[self.at]):
                ends = sorted((float(self._y1[self.at]), float(self._y2[self.at])))
                place = (float(points.solar_time_h[self.at]), ends[0], ends[1])
            span_h, (low, high) = view.windows((hours.low, hours.high), (low, high), place)
            hours = scales.time_scale(*span_h, canvas.columns)
        values = scales.value_scale(low, high, canvas.rows, fine=view.fine)
        canvas.frame(hours, values)
        for start, end in data.outside_h:
            canvas.shade(start, end)
        canvas.level(0.0, scales.ZERO)
        if tolerance_deg is not None:
            for sign in (-1.0, 1.0):
                canvas.level(sign * tolerance_deg, scales.TOLERANCE)
        if self.at is not None:
            canvas.upright(float(points.solar_time_h[self.at]), self.palette.text)
        return values

    def draw_points(self, values: Scale) -> bool:
        """Points of later days are hollow; true if both axes of any fell on one cell."""
        points, canvas, palette = self._data.points, self.canvas, self.palette
        used, later = np.array(points.used, dtype=bool), np.array(points.day) > 1
        x = points.solar_time_h
        for y, first, hollow, colour in (
            (self._y1, scales.AXIS1, scales.AXIS1_LATER, palette.axis1),
            (self._y2, scales.AXIS2, scales.AXIS2_LATER, palette.axis2),
        ):
            canvas.dots(x[~used], y[~used], scales.UNUSED, colour)
            canvas.dots(x[used & ~later], y[used & ~later], first, colour, bold=True)
            canvas.dots(x[used & later], y[used & later], hollow, colour, bold=True)
        together = np.array(
            [
                bool(np.isfinite(a + b))
                and values.cell(a, canvas.rows) == values.cell(b, canvas.rows)
                for a, b in zip(self._y1.tolist(), self._y2.tolist(), strict=True)
            ],
            dtype=bool,
        )
        together &= used
        canvas.dots(x[together], self._y1[together], scales.BOTH, palette.text, bold=True)
        return bool(together.any())

    def legend(self, both: bool, subject: str, names: tuple[str, str]) -> list[HeaderPart]:
        """What is drawn, and what the glyphs of the points mean."""
        palette, several = self.palette, self._data.days > 1
        parts: list[HeaderPart] = [
            (subject, palette.text),
            (f"  {scales.AXIS1}{scales.AXIS1_LATER * several} {names[0]}", palette.axis1),
            (f"  {scales.AXIS2}{scales.AXIS2_LATER * several} {names[1]}", palette.axis2),
        ]
        if both:
            parts.append((f"  {scales.BOTH} both", palette.text))
        if not all(self._data.points.used):
            parts.append((f"  {scales.UNUSED} not used", palette.text))
        return parts

    def reading(self, at: int, what: str) -> str:
        """The plot with the values of the cursor's point in place of the legend."""
        points, palette = self._data.points, self.palette
        minutes = round(60.0 * float(points.solar_time_h[at]))
        parts: list[HeaderPart] = [
            (
                f"record {points.labels[at]}  {minutes // 60:02d}:{minutes % 60:02d} solar",
                palette.text,
            ),
            (f"  {scales.AXIS1} {self._y1[at]:+z.4f}", palette.axis1),
            (f"  {scales.AXIS2} {self._y2[at]:+z.4f} deg", palette.axis2),
            (what, palette.text),
        ]
        if not points.used[at]:
            parts.append(("  not used", palette.text))
        return self.canvas.finish(parts, parts[:3])


MODEL_GAP_H = 0.35
"""Model dots come every ten minutes; farther apart they are of different days or limits."""


def _model_curves(canvas: Canvas, data: ErrorPlotData) -> bool:
    """Both curves and their one-sigma bands in braille; true if a band is seen.

    Axis 1 is a whole line, axis 2 a dashed one.
    """
    model, palette = data.model, canvas.palette
    days = [np.array(model.day) == number for number in sorted(set(model.day))]
    axes = (
        (model.err1_deg, model.sigma1_deg, palette.axis1, 0),
        (model.err2_deg, model.sigma2_deg, palette.axis2, 3),
    )
    band = False
    for on in days:
        for error, sigma, _, _ in axes:
            # A band narrower than the line itself would only make it look ragged.
            if bool((sigma[on] >= 0.5 * canvas.cell_height).any()):
                band = True
                for edge in (error - sigma, error + sigma):
                    canvas.curve(
                        model.solar_time_h[on], edge[on], palette.faint, dash=1, gap=MODEL_GAP_H
                    )
    for on in days:
        for error, _, tone, dash in axes:
            canvas.curve(model.solar_time_h[on], error[on], tone, dash=dash, gap=MODEL_GAP_H)
    return band


def error_reach(*data: ErrorPlotData) -> tuple[float, float]:
    """Ends of the one ruler on which all of these are plotted."""
    points = [error for one in data for error in (one.points.err1_deg, one.points.err2_deg)]
    model = [error for one in data for error in (one.model.err1_deg, one.model.err2_deg)]
    return scales.error_range(points, model)


def error_plot(
    data: ErrorPlotData,
    sheet: Sheet,
    view: View = WHOLE,
    reach_deg: tuple[float, float] | None = None,
) -> str:
    """Axis errors of the points and of the model, against solar time.

    Returns ``height`` lines of at most ``width`` characters; 40 x 10 is the least that can be read.
    Faint columns are times at which the limits shut the Sun out. The model is a dot every ten
    minutes, from 20 rows on with ``'`` and ``,`` at its one-sigma band; where the view is fine,
    curves in braille with dotted bands at any height. ``reach_deg``: ends of the ruler of errors
    where it is not this plot's own.
    """
    points, model = data.points, data.model
    plot = _PointPlot(data, sheet, view, points.err1_deg, points.err2_deg)
    canvas, palette = plot.canvas, plot.palette
    low, high = reach_deg or error_reach(data)
    values = plot.frame(low, high)
    if view.fine:
        band = _model_curves(canvas, data)
    else:
        band = _model_dots(canvas, data, sheet.height)
    both = plot.draw_points(values)
    if not points.labels:
        canvas.say("No points yet. The first one appears here as soon as it is stored.")
    if (at := plot.at) is not None:
        words = ""
        if data.has_model:
            words = f"  residual {points.residual1_deg[at]:+z.4f} {points.residual2_deg[at]:+z.4f}"
        return plot.reading(at, words)
    curves: list[HeaderPart] = []
    if data.has_model:
        glyphs = ("⠒⠒", "⠒ ⠒") if view.fine else (scales.MODEL1, scales.MODEL2)
        curves = [
            ("  model ", palette.text),
            (glyphs[0], palette.axis1),
            (" ", None),
            (glyphs[1], palette.axis2),
        ]
    marks: list[HeaderPart] = []
    if band:
        ends = "⠂⠂" if view.fine else f"{scales.BAND_TOP} {scales.BAND_FOOT}"
        marks.append((f"  {ends} 1 sigma", palette.text))
    if data.outside_h:
        marks.append((f"  {scales.SHADE} limits", palette.text))
    curve = np.concatenate((model.err1_deg, model.err2_deg))
    if bool(((curve < low) | (curve > high)).any()):
        marks.append(("  model off frame", palette.text))
    long = plot.legend(both, "axis error, deg", ("axis 1", "axis 2")) + curves
    short = plot.legend(both, "error, deg", ("ax1", "ax2")) + curves
    bare = plot.legend(False, "deg", ("ax1", "ax2")) + curves
    shorter = [short + marks[:k] for k in range(len(marks), -1, -1)]
    return canvas.finish(long + marks, *shorter, bare)


def _model_dots(canvas: Canvas, data: ErrorPlotData, height: int) -> bool:
    """The model as one character every ten minutes; true if a band is seen."""
    model, palette = data.model, canvas.palette
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
    return band


def residual_plot(data: ErrorPlotData, sheet: Sheet, view: View = WHOLE) -> str:
    """What the model leaves of each point ON THE SKY, against solar time, with the tolerance.

    Where the view is fine a braille line goes from zero to each residual: a quarter of a row is
    seen.
    """
    points = data.points
    cross, along = points.cross_deg, points.along_deg
    plot = _PointPlot(data, sheet, view, cross, along)
    canvas, palette = plot.canvas, plot.palette
    # On screen a point that is not used must not flatten the others; in print all are shown.
    used = np.array(points.used, dtype=bool) | (not view.fine)
    finite = np.concatenate((cross[used], along[used]))
    finite = np.abs(finite[np.isfinite(finite)])
    reach = 1.2 * max(float(finite.max()) if finite.size else 0.0, 0.3 * data.tolerance_deg)
    values = plot.frame(-reach, reach, data.tolerance_deg)
    both = False
    if data.has_model and points.labels:
        if view.fine:
            canvas.stems(points.solar_time_h, cross, palette.axis1, -0.25)
            canvas.stems(points.solar_time_h, along, palette.axis2, 0.25)
        both = plot.draw_points(values)
    else:
        canvas.say("No fit yet. Residuals appear from the third point on.")
    if (at := plot.at) is not None and data.has_model:
        return plot.reading(at, f"  on the sky {np.hypot(cross[at], along[at]):.4f} deg")
    names = ("across (axis 1)", "along (axis 2)")
    long = plot.legend(both, "residual on the sky, deg", names)
    short = plot.legend(both, "on sky, deg", ("axis 1", "axis 2"))
    bare = plot.legend(False, "on sky, deg", ("ax1", "ax2"))
    marks: list[HeaderPart] = []
    if beyond := int((np.abs(np.fmax(np.abs(cross), np.abs(along))) > reach).sum()):
        marks.append((f"  {beyond} beyond the frame", palette.text))
    if data.tolerance_deg <= reach:
        marks.append((f"  {scales.TOLERANCE} tolerance {data.tolerance_deg:g}", palette.text))
    return canvas.finish(long + marks, short + marks, long, short, bare)


def convergence_plot(history: Sequence[FitRecord], sheet: Sheet) -> str:
    """P1..P6 against the number of points, each drawn with its own digit, with one-sigma bars.

    The six stand side by side about their number of points. P5 and P6 are shown as degrees per
    90 deg of travel. Early values are wild: the frame holds the later half of the history, and
    what lies beyond it is counted in the header.
    """
    canvas = Canvas(sheet, "points")
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
    step = next(
        s for s in (1, 2, 5, 10, 20, 50, 100, 1000) if (last - first) / s * 5 <= sheet.width
    )
    ticks = tuple(float(k) for k in range(int(first), int(last) + 1, step))
    canvas.frame(Scale(first - 0.5, last + 0.5, ticks, tuple(f"{int(k)}" for k in ticks)), values)
    canvas.level(0.0, scales.ZERO)
    tones = [scales.SERIES[i] if sheet.theme == "phosphor" else palette.text for i in range(6)]
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
    return canvas.finish(long, short)
