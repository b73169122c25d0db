"""One plot being drawn. The only module that knows plotext, and it imports it on first use.

plotext has one figure for the whole process: draw on one thread (the event loop) only.
"""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from solarcal.report import scales
from solarcal.report.scales import PALETTES, Scale, Sheet
from solarcal.units import FloatArray

LABEL_MIN_HEIGHT = 14
"""Below this the x ruler carries its numbers but no label: rows are dear."""

HeaderPart = tuple[str, int | None]


def _plotext() -> Any:
    """plotext takes 150 ms to import: only when the first plot is drawn."""
    import plotext  # noqa: PLC0415

    plotext.terminal.limit(False, False)  # else the size of this process's terminal clips the plot
    return plotext


class Canvas:
    """One plot being drawn: a header line of our own, then plotext's frame and rulers."""

    def __init__(self, sheet: Sheet, x_label: str) -> None:
        width, height = sheet.width, sheet.height
        self._plt = _plotext()
        self._colour = scales.colour_wanted(sheet.colour)
        self._width = width
        self.palette = PALETTES[sheet.theme]
        self._x_label = x_label if height >= LABEL_MIN_HEIGHT else ""
        self.rows = height - 4 - bool(self._x_label)
        self.columns = width - 8  # before the tick labels are known; exact after ``frame``
        name = f"solarcal-{sheet.theme}"
        self._plt.add_theme(name, canvas="default", text=self.palette.frame)
        self._figure = self._plt.figure
        self._figure.clear()
        self._figure.theme(name)
        self._figure.plot_size(width, height - 1)

    def frame(self, x: Scale, y: Scale) -> None:
        self._x, self._y = x, y
        self.columns = self._width - 2 - max((len(label) for label in y.labels), default=0)
        for name, scale in (("x", x), ("y", y)):
            ruler = self._figure.ruler(name, 0)
            ruler.lim(scale.low, scale.high)
            ruler.ticks(list(scale.ticks), list(scale.labels))
        if self._x_label:
            self._figure.label(self._x_label, "x")

    def dots(
        self, x: FloatArray, y: FloatArray, glyph: str, colour: int, bold: bool = False
    ) -> None:
        """Glyphs at values; what is not finite or beyond the frame is left out."""
        signal = self._signal(x, y, glyph, colour, bold)
        if signal is not None:
            self._figure.draw(signal)

    def _signal(
        self, x: FloatArray, y: FloatArray, glyph: str, colour: int, bold: bool = False
    ) -> Any:
        keep = np.isfinite(x) & np.isfinite(y)
        keep &= (x >= self._x.low) & (x <= self._x.high) & (y >= self._y.low) & (y <= self._y.high)
        if not keep.any():
            return None
        pixel = self._plt.pixel(colour, "default", "bold" if bold else None)
        marker = self._plt.marker(glyph, pixel=pixel)
        return self._figure.signal(x[keep].tolist(), y[keep].tolist(), marker=marker)

    def curve(
        self, x: FloatArray, y: FloatArray, colour: int, *, dash: int = 0, gap: float = np.inf
    ) -> None:
        """A line in braille through values in order; broken where not finite or ``gap`` apart in x.

        ``dash``: so many braille dots drawn, as many left out; 0 draws all.
        """
        across = (self._x.high - self._x.low) / max(1, 2 * self.columns - 1)
        down = (self._y.high - self._y.low) / max(1, 4 * self.rows - 1)
        ok = np.isfinite(x) & np.isfinite(y)
        # What is far beyond the frame must not be walked dot by dot.
        margin = self._y.high - self._y.low
        ok &= (y > self._y.low - margin) & (y < self._y.high + margin)
        joined = ok[:-1] & ok[1:] & (np.abs(np.diff(x)) <= gap)
        steps = np.where(
            joined, np.maximum(np.abs(np.diff(x)) / across, np.abs(np.diff(y)) / down), 0.0
        )
        length = np.concatenate(([0.0], np.cumsum(np.nan_to_num(steps))))
        if not ok.any():
            return
        at = np.arange(0.0, length[-1] + 1.0)
        index = np.clip(np.searchsorted(length, at, side="right") - 1, 0, max(0, len(x) - 2))
        if len(x) < 2:
            return
        span = np.where(steps[index] > 0.0, steps[index], 1.0)
        share = np.clip((at - length[index]) / span, 0.0, 1.0)
        keep = joined[index]
        if dash:
            keep &= (at // dash) % 2 == 0
        self.dots(
            (x[index] + share * (x[index + 1] - x[index]))[keep],
            (y[index] + share * (y[index + 1] - y[index]))[keep],
            scales.FINE,
            colour,
        )

    def stems(self, x: FloatArray, y: FloatArray, colour: int, side: float = 0.0) -> None:
        """A braille line from zero to each value; ``side`` moves it by that part of a column.

        What is beyond the frame ends at its edge.
        """
        across = (self._x.high - self._x.low) / max(1, self.columns - 1)
        seen = (np.maximum(y, 0.0) >= self._y.low) & (np.minimum(y, 0.0) <= self._y.high)
        ends = np.clip(y[seen], self._y.low, self._y.high)
        signal = self._signal(x[seen] + side * across, ends, scales.FINE, colour)
        if signal is not None:
            # Filled by plotext's kernel: dot by dot, two hundred points take a tenth of a second.
            self._figure.draw(signal.fillx())

    def upright(self, x: float, colour: int) -> None:
        """A vertical line over the whole frame."""
        y = np.linspace(self._y.low, self._y.high, self.rows)
        self.dots(np.full(self.rows, x), y, scales.BAR, colour)

    def level(self, y: float, glyph: str) -> None:
        """A faint horizontal line."""
        x = np.linspace(self._x.low, self._x.high, self.columns)
        self.dots(x, np.full(self.columns, y), glyph, self.palette.faint)

    def shade(self, low: float, high: float) -> None:
        """Faint columns from ``low`` to ``high`` of the x ruler."""
        x = np.linspace(self._x.low, self._x.high, self.columns)
        x = x[(x >= low) & (x <= high)]
        y = np.linspace(self._y.low, self._y.high, self.rows)
        grid_x, grid_y = np.meshgrid(x, y)
        self.dots(grid_x.ravel(), grid_y.ravel(), scales.SHADE, self.palette.faint)

    def say(self, sentence: str) -> None:
        """A sentence in the middle of the empty frame."""
        lines = textwrap.wrap(sentence, max(8, self.columns - 4))[: self.rows]
        top = (self.rows + len(lines)) // 2 - 1
        for number, line in enumerate(lines):
            share = (self.columns - len(line) - 2) // 2 / max(1, self.columns - 1)
            x = self._x.low + (self._x.high - self._x.low) * share
            y = self._y.low + (self._y.high - self._y.low) * (top - number) / max(1, self.rows - 1)
            pixel = self._plt.pixel(self.palette.text, "default")
            label = self._plt.colorize(f" {line} ").fill(pixel)
            self._figure.draw(self._figure.text(x, y, label))

    @property
    def cell_height(self) -> float:
        """Height of one character cell in units of the y ruler."""
        return (self._y.high - self._y.low) / max(1, self.rows - 1)

    def finish(self, *headers: Sequence[HeaderPart]) -> str:
        """The plot, ``height`` lines of at most ``width`` characters, without a last newline.

        ``headers``: wordings of its first line; the first that fits is taken, else the last, of
        which the glyphs' names are worth more than the title they follow.
        """
        names = list(headers[-1][1:])
        if names:
            names[0] = (names[0][0].lstrip(), names[0][1])
        wordings = (*headers, names) if names else headers
        fitting = (h for h in wordings if sum(len(text) for text, _ in h) <= self._width)
        header = next(fitting, wordings[-1])
        left, line = self._width, ""
        for text, colour in header:
            shown = text[:left]
            left -= len(shown)
            if self._colour and colour is not None:
                pixel = self._plt.pixel(colour, "default")
                shown = self._plt.colorize(shown).fill(pixel).string() if shown else ""
            line += shown
        body = self._figure.build().string(not self._colour).removesuffix("\n")
        self._figure.clear()
        if not self._colour:
            body = "\n".join(row.rstrip() for row in body.split("\n"))
            line = line.rstrip()
        return f"{line}\n{body}"
