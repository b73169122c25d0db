"""The year at a glance: expected error by day of the year (across) and solar hour (down).

Each cell is drawn with one of five glyphs. The first three are thin and within the tolerance, the
last two are filled and beyond it: nothing is shown by colour alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.model.forecast import Forecast
from solarcal.report import scales
from solarcal.report.scales import Sheet, Theme
from solarcal.stopping_rule import TOLERANCE_DEG
from solarcal.timescale import SECONDS_PER_DAY, format_utc
from solarcal.units import FloatArray

GLYPHS = (".", "-", "+", "▒", "█")
STEPS = (0.25, 0.5, 1.0, 2.0)
"""Upper ends of the first four levels, in tolerances."""
COLOURS: dict[Theme, tuple[int, ...]] = {
    "phosphor": (240, 244, 250, 214, 203),
    "light": (249, 244, 238, 130, 124),
}
MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_RULER = 3
"""Columns of the hours and the space after them."""


@dataclass(frozen=True, slots=True)
class YearCells:
    """The part of a map in which there is Sun.

    Attributes
    ----------
    rms_deg : (hours, days), NaN for no Sun, or Sun out of reach.
    hours : (hours,), mean solar time at which each row begins.
    months : (days,), 1..12 of each column.
    """

    rms_deg: FloatArray
    hours: FloatArray
    months: tuple[int, ...]


def year_cells(forecast: Forecast) -> YearCells:
    """The map with hours down and days across, cut to the hours of Sun."""
    rms = forecast.map_rms_deg.T
    lit = np.flatnonzero(np.isfinite(rms).any(axis=1))
    rows = slice(int(lit[0]), int(lit[-1]) + 1)
    noon = forecast.days_utc_s + 0.5 * SECONDS_PER_DAY
    return YearCells(
        rms_deg=rms[rows],
        hours=forecast.map_hours[rows],
        months=tuple(int(format_utc(float(time), 0)[5:7]) for time in noon),
    )


def level(rms_deg: float, tolerance_deg: float) -> int | None:
    """0..4, None where there is no Sun. 3 and 4 are beyond the tolerance."""
    if not np.isfinite(rms_deg):
        return None
    return int(np.searchsorted(np.array(STEPS) * tolerance_deg, rms_deg))


def level_names(tolerance_deg: float) -> tuple[str, ...]:
    """What each level means, degrees."""
    ends = [f"{step * tolerance_deg:.3g}" for step in STEPS]
    return (*(f"to {end}" for end in ends), "more")


def forecast_map(
    forecast: Forecast, sheet: Sheet, tolerance_deg: float = TOLERANCE_DEG, fine: bool = False
) -> str:
    """At most as many lines and columns as the sheet has; 40 x 10 is the least.

    A cell that stands for several days or half hours shows the worst of them. ``fine``: two half
    hours a character in half blocks, where there is colour to tell them apart.
    """
    cells = year_cells(forecast)
    coloured = scales.colour_wanted(sheet.colour)
    tones = COLOURS[sheet.theme] if coloured else None
    halves = 2 if fine and coloured else 1
    down = _share(len(cells.hours), halves * (sheet.height - 3))
    across = _share(len(cells.months), sheet.width - _RULER)
    worst = _worst(cells.rms_deg, down, across)
    levels = [[level(value, tolerance_deg) for value in row] for row in worst.tolist()]
    if len(levels) % halves:
        levels.append([None] * worst.shape[1])
    stretch = max(1, (sheet.width - _RULER) // worst.shape[1])
    if halves == 1:
        stretch = min(stretch, 2)
    hours = cells.hours[::down].tolist()
    lines = [_legend(sheet.width, tolerance_deg, tones, "█" * 5 if halves == 2 else GLYPHS)]
    for row in range(0, len(levels), halves):
        whole = [hour for hour in hours[row : row + halves] if hour == int(hour)]
        line = f"{int(whole[0]):02d} " if whole else " " * _RULER
        for steps in zip(*levels[row : row + halves], strict=True):
            line += _cell(steps, stretch, tones)
        lines.append(line if coloured else line.rstrip())
    lines.append(" " * _RULER + _months_ruler(cells.months, across, stretch))
    note = "mean solar hour down, day of the year across; blank: no Sun, or out of reach"
    short = "solar hour down, day of the year across"
    lines.append(note if len(note) <= sheet.width else short[: sheet.width])
    return "\n".join(lines)


def _cell(steps: tuple[int | None, ...], stretch: int, tones: tuple[int, ...] | None) -> str:
    """One level as its glyph, or two above one another as half blocks in their colours."""
    upper, lower = steps[0], steps[-1]
    if upper is None and lower is None:
        return " " * stretch
    if len(steps) == 1:
        assert upper is not None
        shown = GLYPHS[upper] * stretch
        return shown if tones is None else f"\x1b[38;5;{tones[upper]}m{shown}\x1b[0m"
    assert tones is not None
    if lower is None:
        assert upper is not None
        return f"\x1b[38;5;{tones[upper]}m{'▀' * stretch}\x1b[0m"
    if upper is None:
        return f"\x1b[38;5;{tones[lower]}m{'▄' * stretch}\x1b[0m"
    return f"\x1b[38;5;{tones[upper]};48;5;{tones[lower]}m{'▀' * stretch}\x1b[0m"


def _share(cells: int, room: int) -> int:
    """How many cells one character has to stand for."""
    return max(1, -(-cells // max(1, room)))


def _worst(rms_deg: FloatArray, down: int, across: int) -> FloatArray:
    """The largest of every block; NaN where a block has no Sun at all."""
    rows, columns = -(-rms_deg.shape[0] // down), -(-rms_deg.shape[1] // across)
    padded = np.full((rows * down, columns * across), -np.inf)
    padded[: rms_deg.shape[0], : rms_deg.shape[1]] = np.nan_to_num(rms_deg, nan=-np.inf)
    worst: FloatArray = padded.reshape(rows, down, columns, across).max(axis=(1, 3))
    worst[np.isneginf(worst)] = np.nan
    return worst


def _legend(
    width: int, tolerance_deg: float, tones: tuple[int, ...] | None, glyphs: Sequence[str] = GLYPHS
) -> str:
    names = level_names(tolerance_deg)
    entries = [f"{glyph} {name}" for glyph, name in zip(glyphs, names, strict=True)]
    if len("  ".join(entries)) > width:
        entries = [entry.replace(" to ", "<").replace(" ", "") for entry in entries]
    titles = ("expected error on the sky, deg rms:  ", "error, deg rms:  ", "deg: ", "")
    plain = "  ".join(entries)
    title = next((t for t in titles if len(t) + len(plain) <= width), "")
    if tones is None or len(plain) > width:
        return (title + plain)[:width]
    tinted = [
        f"\x1b[38;5;{tone}m{entry[0]}\x1b[0m{entry[1:]}"
        for tone, entry in zip(tones, entries, strict=True)
    ]
    return title + "  ".join(tinted)


def month_starts(months: tuple[int, ...]) -> Iterator[tuple[int, str]]:
    """Column and name of each month's first day on the map."""
    for column, month in enumerate(months):
        if column == 0 or months[column - 1] != month:
            yield column, MONTHS[month - 1]


def _months_ruler(months: tuple[int, ...], across: int, stretch: int) -> str:
    line = ""
    room = -(-len(months) // across) * stretch
    for column, name in month_starts(months):
        place = column // across * stretch
        if place >= len(line) + bool(line) and place + len(name) <= room:
            line = line.ljust(place) + name
    return line
