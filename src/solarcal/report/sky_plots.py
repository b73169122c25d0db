"""Plots of the sky: the Sun's path over a day, points on it, and directions to aim at.

Any size from 40 x 10 on; nothing is shown by colour alone. Draw on one thread only (``canvas``).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solarcal.report import scales
from solarcal.report.canvas import Canvas, HeaderPart
from solarcal.report.scales import WHOLE, Scale, Sheet, View
from solarcal.station.curves import ErrorPlotData
from solarcal.units import FloatArray

SMALLEST_HEIGHT = 20


def sky_map(data: ErrorPlotData, sheet: Sheet, view: View = WHOLE) -> str:
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
        words = f"  azimuth {bearing:.1f}, elevation {points.elevation_deg[at]:.1f} deg"
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
