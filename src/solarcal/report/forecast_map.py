"""The year at a glance: expected error by day of the year (across) and solar hour (down).

Each cell is drawn with one of five glyphs. The first three are thin and within the tolerance, the
last two are filled and beyond it: nothing is shown by colour alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.model.forecast import Forecast
from solarcal.report import scales
from solarcal.report.scales import Theme
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
    rms_deg : (hours, days)
        NaN for no Sun, or Sun out of reach.
    hours : (hours,)
        Mean solar time at which each row begins.
    months : (days,)
        1..12 of each column.
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
    forecast: Forecast,
    width: int,
    height: int,
    colour: bool = True,
    theme: Theme = "phosphor",
    tolerance_deg: float = TOLERANCE_DEG,
    fine: bool = False,
) -> str:
    """At most ``height`` lines of at most ``width`` characters; 40 x 10 is the least.

    A cell that stands for several days or half hours shows the worst of them. ``fine``: two half
    hours a character in half blocks, where there is colour to tell them apart.
    """
    cells = year_cells(forecast)
    if fine and scales.colour_wanted(colour):
        return _half_blocks(cells, width, height, tolerance_deg, COLOURS[theme])
    down = _share(len(cells.hours), height - 3)
    across = _share(len(cells.months), width - _RULER)
    worst = _worst(cells.rms_deg, down, across)
    stretch = 2 if 2 * worst.shape[1] + _RULER <= width else 1
    coloured = scales.colour_wanted(colour)
    tones = COLOURS[theme]

    def cell(value: float) -> str:
        step = level(value, tolerance_deg)
        if step is None:
            return " " * stretch
        shown = GLYPHS[step] * stretch
        return f"\x1b[38;5;{tones[step]}m{shown}\x1b[0m" if coloured else shown

    lines = [_legend(width, tolerance_deg, tones if coloured else None)]
    for row, hour in zip(worst.tolist(), cells.hours[::down].tolist(), strict=True):
        ruler = f"{int(hour):02d} " if hour == int(hour) else " " * _RULER
        line = ruler + "".join(map(cell, row))
        lines.append(line if coloured else line.rstrip())
    lines.append(" " * _RULER + _months_ruler(cells.months, across, stretch))
    note = "mean solar hour down, day of the year across; blank: no Sun, or out of reach"
    short = "solar hour down, day of the year across"
    lines.append(note if len(note) <= width else short[:width])
    return "\n".join(lines)


def _half_blocks(
    cells: YearCells, width: int, height: int, tolerance_deg: float, tones: tuple[int, ...]
) -> str:
    """The map with two rows of cells in each line."""
    down = _share(len(cells.hours), 2 * (height - 3))
    across = _share(len(cells.months), width - _RULER)
    worst = _worst(cells.rms_deg, down, across)
    stretch = max(1, (width - _RULER) // worst.shape[1])
    levels = [[level(value, tolerance_deg) for value in row] for row in worst.tolist()]
    if len(levels) % 2:
        levels.append([None] * worst.shape[1])
    hours = cells.hours[::down].tolist()
    lines = [_legend(width, tolerance_deg, tones, "█" * len(GLYPHS))]
    for row in range(0, len(levels), 2):
        whole = [hour for hour in hours[row : row + 2] if hour == int(hour)]
        line = f"{int(whole[0]):02d} " if whole else " " * _RULER
        for upper, lower in zip(levels[row], levels[row + 1], strict=True):
            if upper is None and lower is None:
                line += " " * stretch
            elif lower is None and upper is not None:
                line += f"\x1b[38;5;{tones[upper]}m{'▀' * stretch}\x1b[0m"
            elif upper is None and lower is not None:
                line += f"\x1b[38;5;{tones[lower]}m{'▄' * stretch}\x1b[0m"
            elif upper is not None and lower is not None:
                line += f"\x1b[38;5;{tones[upper]};48;5;{tones[lower]}m{'▀' * stretch}\x1b[0m"
        lines.append(line)
    lines.append(" " * _RULER + _months_ruler(cells.months, across, stretch))
    note = "mean solar hour down, day of the year across; blank: no Sun, or out of reach"
    short = "solar hour down, day of the year across"
    lines.append(note if len(note) <= width else short[:width])
    return "\n".join(lines)


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
    width: int,
    tolerance_deg: float,
    tones: tuple[int, ...] | None,
    glyphs: Sequence[str] = GLYPHS,
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
