"""Drawings for the field calculators: heliostats, screwjacks, the sunspot device.

Any size from 40 x 10 on; nothing is shown by colour alone. Draw on one thread only (``canvas``).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.report import scales
from solarcal.report.canvas import Canvas, HeaderPart
from solarcal.report.scales import Scale, Sheet
from solarcal.units import FloatArray

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
