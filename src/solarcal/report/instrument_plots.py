"""Plots of the field calculators: the sky, heliostats, screwjacks, the sunspot device.

The map of the sky is the workstation's, too. Any size from 40 x 10 on; nothing is shown by colour
alone. Draw on one thread only (``canvas``).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from solarcal.report import scales
from solarcal.report.canvas import Canvas, HeaderPart
from solarcal.report.scales import WHOLE, Scale, Sheet, View
from solarcal.units import FloatArray

if TYPE_CHECKING:
    from solarcal.station.curves import ErrorPlotData

_CIRCLE_POINTS = 240
_CELL_ASPECT = 2.0
"""A character cell is about twice as high as wide."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One quantity over the x ruler, (n,), with its glyph and name; at most two in one plot."""

    name: str
    y: FloatArray
    glyph: str


def curve_plot(
    title: str,
    x: FloatArray,
    curves: Sequence[Curve],
    x_label: str,
    sheet: Sheet,
    *,
    hours: bool = False,
    marks: Sequence[tuple[float, str]] = (),
) -> str:
    """Curves over one ruler. ``marks``: x values of which columns are shaded, with their names.

    ``hours``: x is solar time, its ruler whole hours.
    """
    canvas = Canvas(sheet, x_label)
    palette = canvas.palette
    values = np.concatenate([curve.y for curve in curves])
    values = values[np.isfinite(values)]
    spread = float(np.ptp(values)) if values.size else 0.0
    smallest = spread or max(1e-6, 1e-3 * float(np.abs(values).max(initial=0.0)))
    low, high = scales.error_range([values], [], smallest=smallest)
    places = np.concatenate([x, np.array([mark for mark, _ in marks])])
    ruler = (
        scales.hour_scale([x], canvas.columns)
        if hours
        else _plain_scale(float(places.min()), float(places.max()), canvas.columns)
    )
    canvas.frame(ruler, scales.value_scale(low, high, 2 * canvas.rows, signed=low < 0.0))
    half_column = 0.5 * (ruler.high - ruler.low) / max(1, canvas.columns - 1)
    for place, _ in marks:
        canvas.shade(place - half_column, place + half_column)
    if low < 0.0 < high:
        canvas.level(0.0, scales.ZERO)
    tones = (palette.axis1, palette.axis2)
    for curve, tone in zip(curves, tones, strict=False):
        canvas.dots(x, curve.y, curve.glyph, tone, bold=True)
    head: list[HeaderPart] = [(title, palette.text)]
    for curve, tone in zip(curves, tones, strict=False):
        head.append((f"  {curve.glyph} {curve.name}", tone))
    names = ", ".join(dict.fromkeys(name for _, name in marks))
    if names:
        head.append((f"  {scales.SHADE} {names}", palette.text))
    return canvas.finish(head)


def plate_drawing(
    hole_diameter: float,
    spot_diameter: float,
    across: float,
    up: float,
    sheet: Sheet,
    *,
    plate_diameter: float | None = None,
) -> str:
    """The orifice plate seen from the mirror: the hole, and the spot moved by (across, up)."""
    rings = [Ring("hole", "#", hole_diameter), Ring("spot", "o", spot_diameter, across, up)]
    if plate_diameter is not None:
        rings.insert(0, Ring("plate", ".", plate_diameter))
    return rings_drawing("the plate from the mirror", rings, sheet)


@dataclass(frozen=True, slots=True)
class Ring:
    """A circle with its name and glyph; its centre stands (across, up) from the middle."""

    name: str
    glyph: str
    diameter: float
    across: float = 0.0
    up: float = 0.0


def rings_drawing(title: str, rings: Sequence[Ring], sheet: Sheet) -> str:
    """Circles in one plane, all of one unit, round and in view."""
    canvas = Canvas(sheet, "")
    palette = canvas.palette
    turn = np.linspace(0.0, 2.0 * math.pi, _CIRCLE_POINTS)
    largest = max(ring.diameter for ring in rings)
    reach = 1.15 * (0.5 * largest + max(math.hypot(ring.across, ring.up) for ring in rings))
    rows = max(1, canvas.rows)
    wide = reach * canvas.columns / (_CELL_ASPECT * rows)
    canvas.frame(Scale(-wide, wide, (0.0,), ("0",)), Scale(-reach, reach, (0.0,), ("0",)))
    head: list[HeaderPart] = [(title, palette.text)]
    for ring in rings:
        tone = palette.axis1 if ring is rings[-1] else palette.text
        x = ring.across + 0.5 * ring.diameter * np.cos(turn)
        y = ring.up + 0.5 * ring.diameter * np.sin(turn)
        canvas.dots(x, y, ring.glyph, tone, bold=True)
        head.append((f"  {ring.glyph} {ring.name}", tone))
    return canvas.finish(head)


def _plain_scale(low: float, high: float, columns: int) -> Scale:
    """A ruler of plain numbers, about one label every ten columns."""
    margin = 0.02 * max(high - low, 1e-9)
    found = scales.value_scale(low - margin, high + margin, 3 * max(2, columns // 10))
    return Scale(found.low, found.high, found.ticks, tuple(t.strip() for t in found.labels))


SMALLEST_HEIGHT = 20


def sky_map(data: "ErrorPlotData", sheet: Sheet, view: View = WHOLE) -> str:
    """Where in the sky the points lie: elevation against azimuth, with the Sun's path."""
    canvas = Canvas(sheet, "azimuth")
    points, path, palette = data.points, data.path, canvas.palette
    tallest = max([30.0, *path.elevation_deg.tolist(), *points.elevation_deg.tolist()])
    top = min(90.0, 10.0 * np.ceil(tallest / 10.0))
    sun_x = scales.on_bearing_branch(path.azimuth_deg, data.latitude_deg)
    point_x = scales.on_bearing_branch(points.azimuth_deg, data.latitude_deg)
    bearings = scales.bearing_scale(np.concatenate((sun_x, point_x)))
    heights = scales.value_scale(0.0, top, canvas.rows, signed=False)
    at = view.point(len(points.labels))
    if view.zoom > 1.0:
        place = None
        if at is not None:
            up_deg = float(points.elevation_deg[at])
            place = (float(point_x[at]), up_deg, up_deg)
        across, up = view.windows((bearings.low, bearings.high), (0.0, top), place)
        bearings = replace(bearings, low=across[0], high=across[1])
        inside = [i for i, tick in enumerate(bearings.ticks) if across[0] <= tick <= across[1]]
        bearings = replace(
            bearings,
            ticks=tuple(bearings.ticks[i] for i in inside),
            labels=tuple(bearings.labels[i] for i in inside),
        )
        heights = scales.value_scale(*up, canvas.rows, signed=False)
    canvas.frame(bearings, heights)
    if at is not None:
        canvas.upright(float(point_x[at]), palette.text)
    within = np.array(path.within_limits, dtype=bool)
    for mask, glyph, tone in (
        (~within, scales.PATH_OUTSIDE, palette.faint),
        (within, scales.PATH, palette.text),
    ):
        if view.fine and glyph == scales.PATH:
            for number in sorted(set(path.day)):
                on = mask & (np.array(path.day) == number)
                canvas.curve(sun_x[on], path.elevation_deg[on], tone, gap=30.0)
        else:
            canvas.dots(sun_x[mask], path.elevation_deg[mask], glyph, tone)
    used = np.array(points.used, dtype=bool)
    y = points.elevation_deg
    canvas.dots(point_x[~used], y[~used], scales.UNUSED, palette.axis1)
    canvas.dots(point_x[used], y[used], scales.AXIS1, palette.axis1, bold=True)
    if not points.labels:
        canvas.say("No points yet: dots show where the Sun will be.")
    if at is not None:
        bearing = float(points.azimuth_deg[at]) % 360.0
        words = f"  azimuth {bearing:.1f}, elevation {points.elevation_deg[at]:z.1f} deg"
        return canvas.finish(
            [(f"record {points.labels[at]}", palette.text), (words, palette.axis1)]
        )
    head: list[HeaderPart] = [
        ("elevation, deg", palette.text),
        (f"  {scales.AXIS1} points", palette.axis1),
        (f"  {scales.PATH} Sun", palette.text),
    ]
    outside: list[HeaderPart] = [(f"  {scales.PATH_OUTSIDE} beyond limits", palette.text)]
    return canvas.finish(head + (outside if (~within).any() else []), head)


@dataclass(frozen=True, slots=True)
class DayTrack:
    """The Sun at moments of one solar day, in order; arrays (n,).

    ``solar_time_h`` grows from 0 to 24; azimuth from North through East, airless elevation, both
    degrees; ``within_limits`` where a mount with limits was asked about.
    """

    solar_time_h: FloatArray
    azimuth_deg: FloatArray
    elevation_deg: FloatArray
    within_limits: NDArray[np.bool_] | None
    latitude_deg: float


def day_chart(track: DayTrack, sheet: Sheet) -> str:
    """Two charts on one time scale, together as high as the sheet.

    Both need 40 x 20; in fewer lines only the elevation is drawn. Only the Sun above the horizon is
    drawn; where it is beyond the mount's limits the dots are ``:``.
    """
    up = track.elevation_deg >= 0.0
    if sheet.height < SMALLEST_HEIGHT:
        return _elevation(track, up, sheet)
    upper = (sheet.height + 1) // 2
    return "\n".join(
        (
            _elevation(track, up, replace(sheet, height=upper)),
            _azimuth(track, up, replace(sheet, height=sheet.height - upper)),
        )
    )


def _hours(track: DayTrack, up: NDArray[np.bool_], cells: int) -> Scale:
    return scales.hour_scale([track.solar_time_h[up]] if up.any() else [], cells)


def _draw(canvas: Canvas, track: DayTrack, up: NDArray[np.bool_], y: FloatArray, tone: int) -> None:
    within = up if track.within_limits is None else up & track.within_limits
    outside = up & ~within
    canvas.dots(track.solar_time_h[outside], y[outside], scales.PATH_OUTSIDE, canvas.palette.faint)
    canvas.dots(track.solar_time_h[within], y[within], scales.AXIS1, tone)


def _elevation(track: DayTrack, up: NDArray[np.bool_], sheet: Sheet) -> str:
    canvas = Canvas(sheet, "")
    palette = canvas.palette
    top = 10.0 * np.ceil(max(float(track.elevation_deg.max()), 10.0) / 10.0)
    canvas.frame(
        _hours(track, up, canvas.columns), scales.value_scale(0.0, top, canvas.rows, signed=False)
    )
    _draw(canvas, track, up, track.elevation_deg, palette.axis1)
    if not up.any():
        canvas.say("The Sun stays below the horizon all day.")
    head: list[HeaderPart] = [("elevation, deg, against apparent solar time, h", palette.text)]
    if track.within_limits is not None and bool((up & ~track.within_limits).any()):
        head.append((f"  {scales.PATH_OUTSIDE} beyond limits", palette.text))
    return canvas.finish(head)


def _azimuth(track: DayTrack, up: NDArray[np.bool_], sheet: Sheet) -> str:
    canvas = Canvas(sheet, "")
    palette = canvas.palette
    azimuth = scales.on_bearing_branch(track.azimuth_deg, track.latitude_deg)
    bearings = scales.bearing_scale(azimuth[up])
    # One letter a row at most.
    step = 1 if len(bearings.ticks) <= canvas.rows else 2
    canvas.frame(
        _hours(track, up, canvas.columns),
        Scale(
            bearings.low,
            bearings.high,
            bearings.ticks[::step],
            tuple(label.rjust(2) for label in bearings.labels[::step]),
        ),
    )
    _draw(canvas, track, up, azimuth, palette.axis2)
    return canvas.finish([("azimuth", palette.text)])


def directions_plot(
    places: Sequence[tuple[str, str, float, float]], latitude_deg: float, sheet: Sheet
) -> str:
    """Sun, mirror normal and target in the sky: (letter, name, azimuth, elevation), degrees."""
    canvas = Canvas(sheet, "azimuth")
    palette = canvas.palette
    azimuth = scales.on_bearing_branch(np.array([place[2] for place in places]), latitude_deg)
    elevation = np.array([place[3] for place in places])
    low = min(0.0, 10.0 * math.floor(float(elevation.min()) / 10.0))
    top = min(90.0, max(30.0, 10.0 * math.ceil(float(elevation.max()) / 10.0 + 0.5)))
    canvas.frame(
        scales.bearing_scale(azimuth), scales.value_scale(low, top, canvas.rows, signed=low < 0.0)
    )
    canvas.level(0.0, scales.ZERO)
    head: list[HeaderPart] = [("elevation, deg", palette.text)]
    tones = (palette.axis1, palette.axis2, palette.text)
    for index, (letter, name, _, _) in enumerate(places):
        tone = tones[index % len(tones)]
        canvas.dots(azimuth[index : index + 1], elevation[index : index + 1], letter, tone, True)
        head.append((f"  {letter} {name}", tone))
    return canvas.finish(head)
