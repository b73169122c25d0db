"""The Sun's day as text: elevation above, azimuth below, both against solar time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solarcal.report import scales
from solarcal.report.canvas import Canvas, HeaderPart
from solarcal.report.scales import Scale, Theme
from solarcal.units import FloatArray

SMALLEST_HEIGHT = 20


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


def day_chart(
    track: DayTrack, width: int, height: int, colour: bool = True, theme: Theme = "phosphor"
) -> str:
    """Two charts on one time scale, together ``height`` lines of at most ``width`` characters.

    Both need 40 x 20; in fewer lines only the elevation is drawn. Only the Sun above the horizon is
    drawn; where it is beyond the mount's limits the dots are ``:``.
    """
    up = track.elevation_deg >= 0.0
    if height < SMALLEST_HEIGHT:
        return _elevation(track, up, width, height, colour, theme)
    upper = (height + 1) // 2
    return "\n".join(
        (
            _elevation(track, up, width, upper, colour, theme),
            _azimuth(track, up, width, height - upper, colour, theme),
        )
    )


def _hours(track: DayTrack, up: NDArray[np.bool_], cells: int) -> Scale:
    return scales.hour_scale([track.solar_time_h[up]] if up.any() else [], cells)


def _draw(canvas: Canvas, track: DayTrack, up: NDArray[np.bool_], y: FloatArray, tone: int) -> None:
    within = up if track.within_limits is None else up & track.within_limits
    outside = up & ~within
    canvas.dots(track.solar_time_h[outside], y[outside], scales.PATH_OUTSIDE, canvas.palette.faint)
    canvas.dots(track.solar_time_h[within], y[within], scales.AXIS1, tone)


def _elevation(
    track: DayTrack, up: NDArray[np.bool_], width: int, height: int, colour: bool, theme: Theme
) -> str:
    canvas = Canvas(width, height, colour, theme, "")
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


def _azimuth(
    track: DayTrack, up: NDArray[np.bool_], width: int, height: int, colour: bool, theme: Theme
) -> str:
    canvas = Canvas(width, height, colour, theme, "")
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
