"""Ranges, ticks, glyphs and colours of the plots: what is decided without drawing."""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solarcal.units import FloatArray

Theme = Literal["phosphor", "light"]


@dataclass(frozen=True, slots=True)
class Sheet:
    """What a plot is drawn for: columns and rows of characters, colour wanted, theme."""

    width: int
    height: int
    colour: bool = True
    theme: Theme = "phosphor"


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours out of the 256 every terminal has; the background is left to the terminal."""

    axis1: int
    axis2: int
    frame: int
    faint: int
    text: int


PALETTES: dict[Theme, Palette] = {
    "phosphor": Palette(axis1=214, axis2=83, frame=136, faint=240, text=222),
    "light": Palette(axis1=130, axis2=22, frame=238, faint=249, text=16),
}

SERIES = (214, 83, 222, 120, 45, 207)
"""P1..P6 of the convergence plot; each is also drawn with its own digit."""

AXIS1, AXIS2, BOTH = "●", "◆", "◈"
"""Points of the first day; ``BOTH`` where the two axes fall on one cell."""
AXIS1_LATER, AXIS2_LATER = "○", "◇"
MODEL1, MODEL2 = "·", "+"
UNUSED = "x"
BAND_TOP, BAND_FOOT = "'", ","
SHADE = "░"
BAR = "│"
"""One sigma up and down."""
FINE = "braille"
"""Not a glyph: plotext's marker of 2 x 4 dots a character."""
ZERO = "─"
TOLERANCE = "╌"
PATH, PATH_OUTSIDE = "·", ":"


def colour_wanted(asked: bool) -> bool:
    """Colour only when asked for and not refused by the environment (no-color.org)."""
    return asked and not os.environ.get("NO_COLOR")


@dataclass(frozen=True, slots=True)
class Scale:
    """Limits of one ruler with its ticks."""

    low: float
    high: float
    ticks: tuple[float, ...]
    labels: tuple[str, ...]

    def cell(self, value: float, cells: int) -> int:
        """Number of the character cell a value falls on, counted from the low end."""
        return round((value - self.low) / (self.high - self.low) * (cells - 1))


@dataclass(frozen=True, slots=True)
class View:
    """What part of a plot is looked at, and how.

    Attributes
    ----------
    zoom : 1 fits everything; the factor by which both rulers are stretched.
    x, y : middle of the window as a share of the full range, 0 to 1.
    cursor : index of the point whose values are read, ``None`` for none.
    follows : whether the window is centred on the cursor's point.
    fine : curves in braille, 2 x 4 dots a character, instead of one character a step.
    shades : the terminal has more than 16 colours: shades of grey differ.
    """

    zoom: float = 1.0
    x: float = 0.5
    y: float = 0.5
    cursor: int | None = None
    follows: bool = False
    fine: bool = False
    shades: bool = True

    def point(self, count: int) -> int | None:
        """The cursor's point, where there is one among ``count``."""
        at = self.cursor
        return at if at is not None and 0 <= at < count else None

    def windows(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        point: tuple[float, float, float] | None,
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """The parts of both rulers in view.

        ``point`` is the cursor's, its place in x and its lowest and highest value: where the
        window follows it, both values stay in view.
        """
        half_x = half_y = 0.5 / self.zoom
        middle_x, middle_y = self.x, self.y
        if self.follows and point is not None:
            middle_x = (point[0] - x[0]) / (x[1] - x[0])
            middle_y = (0.5 * (point[1] + point[2]) - y[0]) / (y[1] - y[0])
            half_y = min(0.5, max(half_y, 0.6 * (point[2] - point[1]) / (y[1] - y[0])))
        return _part(x, middle_x, half_x), _part(y, middle_y, half_y)


def _part(ruler: tuple[float, float], middle: float, half: float) -> tuple[float, float]:
    """The part of a ruler about ``middle`` (shares of its length), never beyond its ends."""
    middle = min(max(middle, half), 1.0 - half)
    span = ruler[1] - ruler[0]
    return ruler[0] + (middle - half) * span, ruler[0] + (middle + half) * span


WHOLE = View()
FINE_TICKS = 5
"""Labelled ticks a ruler of values has at least in a fine view, from ten rows on."""


def value_scale(
    low: float, high: float, cells: int, signed: bool = True, fine: bool = False
) -> Scale:
    """Ticks at round steps, about one for every three rows; more in a fine view of few rows."""
    if fine:
        wanted = (high - low) / max(FINE_TICKS if cells >= 10 else 2, cells // 4)
        power = 10.0 ** math.floor(math.log10(wanted))
        step = next(k * power for k in (10.0, 5.0, 2.5, 2.0, 1.0) if k * power <= wanted * 1.001)
    else:
        wanted = (high - low) / max(4, cells // 3)
        power = 10.0 ** math.floor(math.log10(wanted))
        step = next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= wanted * 0.999)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    quarter = abs(step / power - 2.5) < 1e-6
    decimals = max(0, -math.floor(math.log10(step) + 1e-9) + quarter)
    ticks = tuple(round(k * step, 10) for k in range(first, last + 1))
    texts = [f"{t:+z.{decimals}f}" if signed and t else f"{t:.{decimals}f}" for t in ticks]
    width = max((len(t) for t in texts), default=0)
    return Scale(low, high, ticks, tuple(t.rjust(width) for t in texts))


def error_range(
    points: Sequence[FloatArray], curves: Sequence[FloatArray], smallest: float = 0.05
) -> tuple[float, float]:
    """Limits that hold every point, and the curves as far as they stay near the points.

    An unrealistic model must not flatten the points into one line: a curve widens the range by no
    more than twice the spread of the points (at least 0.3) on either side.
    """
    data = np.concatenate([np.ravel(a) for a in points]) if points else np.empty(0)
    data = data[np.isfinite(data)]
    model = np.concatenate([np.ravel(a) for a in curves]) if curves else np.empty(0)
    model = model[np.isfinite(model)]
    if not data.size:
        data = np.clip(model, -5.0, 5.0) if model.size else np.array([-0.5, 0.5])
    low, high = float(data.min()), float(data.max())
    reach = 2.0 * max(high - low, 0.15)
    if model.size:
        low = min(low, max(float(model.min()), low - reach))
        high = max(high, min(float(model.max()), high + reach))
    if high - low < smallest:
        middle = 0.5 * (low + high)
        low, high = middle - 0.5 * smallest, middle + 0.5 * smallest
    margin = 0.06 * (high - low)
    return low - margin, high + margin


def hour_scale(hours: Sequence[FloatArray], cells: int) -> Scale:
    """Whole hours around all the times given, HH, spaced so that labels keep apart."""
    times = np.concatenate([np.ravel(h) for h in hours]) if hours else np.empty(0)
    if times.size:
        low = math.floor(float(times.min()) + 1e-9)
        high = max(math.ceil(float(times.max()) - 1e-9), low + 2)
    else:
        low, high = 6, 18
    step = next((s for s in (1, 2, 3, 6) if (high - low) / s * 5 <= cells), 12)
    first = -(-low // step) * step
    ticks = tuple(float(h) for h in range(first, high + 1, step))
    return Scale(float(low), float(high), ticks, tuple(f"{int(h):02d}" for h in ticks))


def time_scale(low_h: float, high_h: float, cells: int) -> Scale:
    """Part of a day, with ticks at round minutes kept apart."""
    room = max(1, cells // 7)
    steps = (1, 2, 5, 10, 15, 30, 60, 120, 180, 360, 720)
    step = next((s for s in steps if (high_h - low_h) * 60.0 / s <= room), 720)
    first, last = math.ceil(low_h * 60.0 / step - 1e-9), math.floor(high_h * 60.0 / step + 1e-9)
    minutes = [k * step for k in range(first, last + 1)]
    return Scale(
        low_h,
        high_h,
        tuple(m / 60.0 for m in minutes),
        tuple(f"{m // 60:02d}:{m % 60:02d}" for m in minutes),
    )


def on_bearing_branch(azimuth_deg: FloatArray, latitude_deg: float) -> FloatArray:
    """Azimuths cut where the Sun of this hemisphere is lowest: [0, 360) or [-180, 180)."""
    low = 0.0 if latitude_deg >= 0.0 else -180.0
    return (azimuth_deg - low) % 360.0 + low


def bearing_scale(azimuth_deg: FloatArray) -> Scale:
    """Ruler around azimuths on their branch, from one eighth of the compass to another."""
    names = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
    first, last = -4, 4
    if azimuth_deg.size:
        first = math.floor(float(azimuth_deg.min()) / 45.0)
        last = max(math.ceil(float(azimuth_deg.max()) / 45.0), first + 2)
    ticks = tuple(45.0 * k for k in range(first, last + 1))
    return Scale(ticks[0], ticks[-1], ticks, tuple(names[k % 8] for k in range(first, last + 1)))
