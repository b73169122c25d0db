"""The certificate's plots as vector drawings: black on white, shapes and dashes before colours.

Axis 1 is a circle and a full line, axis 2 a diamond and a dashed one. Each function gives the
inside of an ``<svg>`` of ``WIDTH`` by ``HEIGHT``.
"""

from collections.abc import Sequence
from html import escape

import numpy as np

from solarcal.model.forecast import Forecast
from solarcal.report import scales
from solarcal.report.blocks import FIGURE_SIZE
from solarcal.report.forecast_map import level, level_names, month_starts, year_cells
from solarcal.report.scales import Scale
from solarcal.station.curves import ErrorPlotData
from solarcal.units import FloatArray

WIDTH, HEIGHT = FIGURE_SIZE
_LEFT, _RIGHT, _TOP, _FOOT = 62, 12, 28, 40
AXIS1, AXIS2 = "#8a4b00", "#00562b"
_GREYS = ("#f2f2f2", "#d9d9d9", "#b5b5b5")
_HATCH = {3: ("beyond", "#7a2e00", 6), 4: ("far-beyond", "#5a0000", 3)}


class _Plot:
    """A frame with two rulers, and what is put into it."""

    def __init__(self, x: Scale, y: Scale, x_label: str, title: str) -> None:
        self._x, self._y = x, y
        right, foot = WIDTH - _RIGHT, HEIGHT - _FOOT
        self.parts = [
            f'<text x="{_LEFT}" y="16" font-weight="bold">{escape(title)}</text>',
            f'<rect x="{_LEFT}" y="{_TOP}" width="{right - _LEFT}" height="{foot - _TOP}" '
            'fill="none" stroke="#000"/>',
            f'<text x="{(_LEFT + right) / 2:g}" y="{HEIGHT - 6}" text-anchor="middle">'
            f"{escape(x_label)}</text>",
        ]
        for tick, label in zip(x.ticks, x.labels, strict=True):
            place = self.across(tick)
            self.parts.append(
                f'<path d="M{place:.1f} {foot}v5" stroke="#000"/>'
                f'<text x="{place:.1f}" y="{foot + 17}" text-anchor="middle">{escape(label)}</text>'
            )
        for tick, label in zip(y.ticks, y.labels, strict=True):
            place = self.down(tick)
            self.parts.append(
                f'<path d="M{_LEFT - 5} {place:.1f}h5" stroke="#000"/>'
                f'<text x="{_LEFT - 8}" y="{place + 4:.1f}" text-anchor="end">'
                f"{escape(label.strip())}</text>"
            )

    def across(self, value: float) -> float:
        share = (value - self._x.low) / (self._x.high - self._x.low)
        return _LEFT + share * (WIDTH - _RIGHT - _LEFT)

    def down(self, value: float) -> float:
        share = (value - self._y.low) / (self._y.high - self._y.low)
        return HEIGHT - _FOOT - share * (HEIGHT - _FOOT - _TOP)

    def level(self, value: float, dash: str) -> None:
        if self._y.low <= value <= self._y.high:
            self.parts.append(
                f'<path d="M{_LEFT} {self.down(value):.1f}H{WIDTH - _RIGHT}" stroke="#555" '
                f'stroke-width="0.7" stroke-dasharray="{dash}"/>'
            )

    def curve(self, x: FloatArray, y: FloatArray, colour: str, dash: str) -> None:
        """A line, broken where the values leave the frame or lie more than half an hour apart."""
        path, last = "", -np.inf
        for at, value in zip(x.tolist(), y.tolist(), strict=True):
            if not self._y.low <= value <= self._y.high:
                last = -np.inf
                continue
            joined = 0.0 <= at - last < 0.5
            path += f"{'L' if joined else 'M'}{self.across(at):.1f} {self.down(value):.1f}"
            last = at
        if path:
            dashes = f' stroke-dasharray="{dash}"' if dash else ""
            self.parts.append(
                f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.2"{dashes}/>'
            )

    def marks(
        self, x: FloatArray, y: FloatArray, used: Sequence[bool], axis: int, colour: str
    ) -> None:
        """One sign a point: circle or diamond, a cross where the point is not used."""
        for at, value, good in zip(x.tolist(), y.tolist(), used, strict=True):
            if not (np.isfinite(value) and self._y.low <= value <= self._y.high):
                continue
            self.parts.append(_sign(self.across(at), self.down(value), axis, good, colour))

    def legend(self, entries: Sequence[tuple[str, str]]) -> None:
        """Signs and their names at the right of the title."""
        place = WIDTH - _RIGHT
        for sign, name in reversed(entries):
            place -= int(6.4 * len(name)) + 4
            self.parts.append(f'<text x="{place}" y="16">{escape(name)}</text>')
            place -= 24
            self.parts.append(f'<g transform="translate({place + 8} 12)">{sign}</g>')


def _sign(x: float, y: float, axis: int, used: bool, colour: str) -> str:
    if not used:
        return (
            f'<path d="M{x - 4:.1f} {y - 4:.1f}l8 8m0 -8l-8 8" stroke="{colour}" '
            'stroke-width="1.5"/>'
        )
    if axis == 1:
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>'
    return f'<path d="M{x:.1f} {y - 5:.1f}l5 5l-5 5l-5 -5z" fill="#fff" stroke="{colour}"/>'


def _line_sign(colour: str, dash: str) -> str:
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<path d="M-9 0h18" stroke="{colour}" stroke-width="1.2"{dashes}/>'


def _axes_legend(data: ErrorPlotData, *, curves: bool) -> list[tuple[str, str]]:
    entries = [
        (_sign(0.0, 0.0, 1, True, AXIS1), "axis 1"),
        (_sign(0.0, 0.0, 2, True, AXIS2), "axis 2"),
    ]
    if curves:
        entries += [(_line_sign(AXIS1, ""), "model 1"), (_line_sign(AXIS2, "5 3"), "model 2")]
    if not all(data.points.used):
        entries.append((_sign(0.0, 0.0, 1, False, "#000"), "not used"))
    return entries


def _hours(data: ErrorPlotData) -> Scale:
    return scales.hour_scale((data.points.solar_time_h, data.path.solar_time_h), 90)


def error_figure(data: ErrorPlotData) -> str:
    """Axis errors of the points and of the model, against solar time."""
    points, model = data.points, data.model
    low, high = scales.error_range(
        (points.err1_deg, points.err2_deg), (model.err1_deg, model.err2_deg)
    )
    plot = _Plot(
        _hours(data), scales.value_scale(low, high, 24), "solar time, h", "axis error, deg"
    )
    plot.level(0.0, "1 3")
    for day in sorted(set(model.day)):
        of_day = np.array(model.day) == day
        plot.curve(model.solar_time_h[of_day], model.err1_deg[of_day], AXIS1, "")
        plot.curve(model.solar_time_h[of_day], model.err2_deg[of_day], AXIS2, "5 3")
    plot.marks(points.solar_time_h, points.err1_deg, points.used, 1, AXIS1)
    plot.marks(points.solar_time_h, points.err2_deg, points.used, 2, AXIS2)
    plot.legend(_axes_legend(data, curves=data.has_model))
    return "".join(plot.parts)


def residual_figure(data: ErrorPlotData) -> str:
    """What the model leaves of each point on the sky, with the tolerance."""
    points = data.points
    both = np.concatenate((points.cross_deg, points.along_deg))
    largest = np.abs(both[np.isfinite(both)]).max(initial=0.0)
    reach = 1.2 * max(float(largest), 0.3 * data.tolerance_deg)
    plot = _Plot(
        _hours(data),
        scales.value_scale(-reach, reach, 24),
        "solar time, h",
        "residual on the sky, deg",
    )
    plot.level(0.0, "1 3")
    for sign in (-1.0, 1.0):
        plot.level(sign * data.tolerance_deg, "8 4")
    plot.marks(points.solar_time_h, points.cross_deg, points.used, 1, AXIS1)
    plot.marks(points.solar_time_h, points.along_deg, points.used, 2, AXIS2)
    entries = _axes_legend(data, curves=False)
    if data.tolerance_deg <= reach:
        entries.append((_line_sign("#555", "8 4"), f"tolerance {data.tolerance_deg:g}"))
    plot.legend(entries)
    return "".join(plot.parts)


def forecast_figure(forecast: Forecast, tolerance_deg: float) -> str:
    """The year's map: grey within the tolerance, hatched beyond it."""
    cells = year_cells(forecast)
    rows, columns = cells.rms_deg.shape
    wide = (WIDTH - _RIGHT - _LEFT) / columns
    tall = (HEIGHT - _FOOT - _TOP) / rows
    parts = [
        "<defs>",
        *(_pattern(name, colour, step) for name, colour, step in _HATCH.values()),
        "</defs>",
        f'<text x="{_LEFT}" y="16" font-weight="bold">expected, deg rms</text>',
    ]
    for row, values in enumerate(cells.rms_deg.tolist()):
        for first, count, step in _runs([level(value, tolerance_deg) for value in values]):
            parts.append(
                f'<rect x="{_LEFT + first * wide:.2f}" y="{_TOP + row * tall:.2f}" '
                f'width="{count * wide:.2f}" height="{tall:.2f}" fill="{_fill(step)}"/>'
            )
        hour = float(cells.hours[row])
        if hour == int(hour):
            parts.append(
                f'<text x="{_LEFT - 8}" y="{_TOP + row * tall + 4:.1f}" text-anchor="end">'
                f"{int(hour):02d}</text>"
            )
    for column, name in month_starts(cells.months):
        place = _LEFT + column * wide
        parts.append(
            f'<path d="M{place:.1f} {HEIGHT - _FOOT}v5" stroke="#000"/>'
            f'<text x="{place + 2:.1f}" y="{HEIGHT - _FOOT + 17}">{name}</text>'
        )
    parts.append(
        f'<rect x="{_LEFT}" y="{_TOP}" width="{WIDTH - _RIGHT - _LEFT}" '
        f'height="{HEIGHT - _FOOT - _TOP}" fill="none" stroke="#000"/>'
        f'<text x="{(_LEFT + WIDTH - _RIGHT) / 2:g}" y="{HEIGHT - 6}" text-anchor="middle">'
        "day of the year; mean solar hour downwards; white: no Sun, or out of reach</text>"
    )
    place = 230
    for step, name in enumerate(level_names(tolerance_deg)):
        parts.append(
            f'<rect x="{place}" y="6" width="14" height="12" fill="{_fill(step)}" '
            f'stroke="#000"/><text x="{place + 18}" y="16">{escape(name)}</text>'
        )
        place += 80
    return "".join(parts)


def _runs(steps: Sequence[int | None]) -> list[tuple[int, int, int]]:
    """(first column, how many, level) of every run of equal cells with Sun."""
    runs: list[tuple[int, int, int]] = []
    for column, step in enumerate(steps):
        if step is None:
            continue
        if runs and runs[-1][2] == step and sum(runs[-1][:2]) == column:
            runs[-1] = (runs[-1][0], runs[-1][1] + 1, step)
        else:
            runs.append((column, 1, step))
    return runs


def _fill(step: int) -> str:
    return _GREYS[step] if step < len(_GREYS) else f"url(#{_HATCH[step][0]})"


def _pattern(name: str, colour: str, step: int) -> str:
    return (
        f'<pattern id="{name}" width="{step}" height="{step}" patternUnits="userSpaceOnUse" '
        f'patternTransform="rotate(45)"><rect width="{step}" height="{step}" fill="#fff"/>'
        f'<path d="M0 0v{step}" stroke="{colour}" stroke-width="{step * 0.9:g}"/></pattern>'
    )
