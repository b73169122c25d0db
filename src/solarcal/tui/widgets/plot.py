"""A plot of the report as a widget: drawn when it changes, kept as strips until then."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.binding import Binding, BindingType
from textual.cache import LRUCache
from textual.message import Message
from textual.reactive import reactive
from textual.strip import Strip
from textual.widget import Widget

from solarcal.model.analysis import Analysis
from solarcal.model.solution import Solution
from solarcal.report.forecast_map import forecast_map
from solarcal.report.instrument_plots import sky_map
from solarcal.report.plots import convergence_plot, error_plot, residual_plot
from solarcal.report.scales import Sheet, Theme, View
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView
from solarcal.station.curves import ErrorPlotData, session_plot_data

_SGR = re.compile(r"\x1b\[([0-9;]*)m")

Draw = Callable[[Sheet], str]
"""The plot for a sheet as text with ANSI colours."""

PLOTS = ("error", "residuals", "sky map", "history", "forecast")
WITH_POINTS = PLOTS[:3]
"""Those whose points a cursor walks over."""

MOST_ZOOM = 64.0
KEPT = 8
"""Drawings of a plot that are kept: going through its kinds draws each of them once."""

PAN = 0.2
"""Of the window, a press of an arrow."""


@lru_cache(maxsize=256)
def _after(style: Style, codes: str) -> Style:
    """The style after one SGR sequence; only what the plots use: reset, bold, 256 colours
    of the character and behind it."""
    numbers = [int(code) for code in codes.split(";") if code] or [0]
    index = 0
    while index < len(numbers):
        code = numbers[index]
        if code == 0:
            style = Style.null()
        elif code == 1:
            style += Style(bold=True)
        elif code == 39:
            style = Style(bold=style.bold)
        elif code in (38, 48) and numbers[index + 1 : index + 2] == [5]:
            colour = f"color({numbers[index + 2]})"
            style += Style(color=colour) if code == 38 else Style(bgcolor=colour)
            index += 2
        index += 1
    return style


def strips_of_ansi(text: str, width: int, base: Style) -> list[Strip]:
    """Lines with ANSI colours as strips of ``width`` cells over a base style.

    Straight to segments: by way of rich's own parser it takes three times as long.
    """
    strips = []
    for line in text.split("\n"):
        style, segments, at = Style.null(), [], 0
        for found in _SGR.finditer(line):
            if found.start() > at:
                segments.append(Segment(line[at : found.start()], base + style))
            style, at = _after(style, found.group(1)), found.end()
        if at < len(line):
            segments.append(Segment(line[at:], base + style))
        strips.append(Strip(segments).adjust_cell_length(width, base))
    return strips


class AnsiPlot(Widget):
    """Shows what a ``Draw`` function draws; draws again when that, the size or the theme changes.

    plotext has one figure for the whole process, so all of this happens on the event loop.
    """

    DEFAULT_CSS = """
    AnsiPlot { width: 1fr; height: 1fr; min-width: 40; min-height: 10; }
    """

    SMALLEST = (40, 10)

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._what: object = None
        self._draw: Draw | None = None
        self._drawn: LRUCache[tuple[object, ...], list[Strip]] = LRUCache(KEPT)

    def show(self, draw: Draw, what: object = None) -> None:
        """Draw this from now on; what was drawn of just this ``what`` before is shown again."""
        if what is not None and what == self._what:
            return
        self._what, self._draw = object() if what is None else what, draw
        self.refresh()

    def render_line(self, y: int) -> Strip:
        width, height = self.size
        base = self.rich_style
        wanted = (self._what, width, height, base, self.app.theme, self._drawn_of())
        strips = self._drawn.get(wanted)
        if strips is None:
            self._drawn[wanted] = strips = self._drawing(width, height, base)
        return strips[y] if y < len(strips) else Strip.blank(width, base)

    def _drawn_of(self) -> object:
        """What else the drawing depends on."""
        return None

    def _drawing(self, width: int, height: int, base: Style) -> list[Strip]:
        least_width, least_height = self.SMALLEST
        if self._draw is None:
            return []
        if width < least_width or height < least_height:
            return strips_of_ansi("the plot does not fit; make the window larger", width, base)
        theme: Theme = "phosphor" if self.app.current_theme.dark else "light"
        return strips_of_ansi(self._draw(Sheet(width, height, theme=theme)), width, base)


def fine_characters(encoding: str | None) -> bool:
    """Whether a terminal of this encoding shows braille and half blocks."""
    return (encoding or "").lower().replace("-", "") in ("utf8", "utf16", "utf32")


def shades_differ(color_system: str | None) -> bool:
    """Whether shades of grey differ; in 16 colours two of the forecast map's are one."""
    return color_system != "standard"


def plotted_points(session: SessionView) -> tuple[PointRecord, ...]:
    """The points a plot shows, in its order: those with an error."""
    return tuple(p for p in session.points if p.error_deg is not None and p.ideal_deg is not None)


def drawing(
    kind: str, session: SessionView, solution: Solution | None, judgement: Analysis | None = None
) -> Callable[[Sheet, View], str]:
    """How to draw one of ``PLOTS`` for a session as it stands."""
    if kind == "forecast":
        return lambda sheet, view: (
            forecast_map(
                judgement.forecast, sheet, session.header.tolerance_deg, view.fine and view.shades
            )
            if judgement is not None
            else "The forecast of the year comes with the first point."
        )
    if kind == "history":
        return lambda sheet, view: convergence_plot(session.fits, sheet)
    plot = {"error": error_plot, "residuals": residual_plot, "sky map": sky_map}[kind]

    @cache
    def data() -> ErrorPlotData:
        # Zooming and walking draw the same numbers again.
        return session_plot_data(session.header, session.points, solution)

    return lambda sheet, view: plot(data(), sheet, view)


class ExploredPlot(AnsiPlot, can_focus=True):
    """A plot of a session that zooms, pans and reads its points by keys."""

    DEFAULT_CSS = """
    ExploredPlot:focus { background-tint: $foreground 4%; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("plus,equals_sign", "zoom(2)", "Zoom in", show=False),
        Binding("minus", "zoom(0.5)", "Zoom out", show=False),
        Binding("0", "whole", "All", show=False),
        Binding("left", "arrow(-1,0)", "Left", show=False),
        Binding("right", "arrow(1,0)", "Right", show=False),
        Binding("up", "arrow(0,1)", "Up", show=False),
        Binding("down", "arrow(0,-1)", "Down", show=False),
        Binding("pagedown", "walk(1)", "Next point", show=False),
        Binding("pageup", "walk(-1)", "Previous point", show=False),
        Binding("home", "walk_end(False)", "First point", show=False),
        Binding("end", "walk_end(True)", "Last point", show=False),
        Binding("enter", "open", "Open the point", show=False),
    ]
    HELP = "+ - zoom  arrows pan  0 all  PgUp PgDn points  Enter open  z whole"

    view: reactive[View] = reactive(View())

    @dataclass
    class PointOpened(Message):
        """The cursor's point was opened."""

        point: PointRecord

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._points: tuple[PointRecord, ...] = ()

    def show_plot(
        self,
        kind: str,
        session: SessionView,
        solution: Solution | None,
        judgement: Analysis | None = None,
        what: object = None,
    ) -> None:
        """Draw one of ``PLOTS`` from now on, of as much as is looked at."""
        draw = drawing(kind, session, solution, judgement)
        fine = fine_characters(self.app.console.encoding)
        shades = shades_differ(self.app.console.color_system)
        self._points = plotted_points(session) if kind in WITH_POINTS else ()
        if (cursor := self.view.cursor) is not None and cursor >= len(self._points):
            self.view = replace(self.view, cursor=None, follows=False)
        self.show(lambda sheet: draw(sheet, replace(self.view, fine=fine, shades=shades)), what)

    def _drawn_of(self) -> object:
        return self.view

    def action_zoom(self, factor: float) -> None:
        zoom = min(max(self.view.zoom * factor, 1.0), MOST_ZOOM)
        self.view = replace(self.view, zoom=zoom, follows=self.view.cursor is not None)

    def action_whole(self) -> None:
        self.view = View()

    def action_arrow(self, right: int, up: int) -> None:
        """Move the window; where all is in view there is nothing to move, and the cursor walks."""
        view = self.view
        if view.zoom <= 1.0:
            self.action_walk(right or up)
            return
        half = 0.5 / view.zoom
        self.view = replace(
            view,
            x=min(max(view.x + 2.0 * half * PAN * right, half), 1.0 - half),
            y=min(max(view.y + 2.0 * half * PAN * up, half), 1.0 - half),
            follows=False,
        )

    def action_walk(self, step: int) -> None:
        if not self._points:
            return
        at, last = self.view.cursor, len(self._points) - 1
        first = 0 if step > 0 else last
        at = first if at is None else min(max(at + step, 0), last)
        self.view = replace(self.view, cursor=at, follows=True)

    def action_walk_end(self, last: bool) -> None:
        if self._points:
            at = len(self._points) - 1 if last else 0
            self.view = replace(self.view, cursor=at, follows=True)

    def go_to_newest(self) -> None:
        """All of the plot, the cursor on its newest point."""
        self.view = View(cursor=len(self._points) - 1)

    def action_open(self) -> None:
        if self.view.cursor is not None and self.view.cursor < len(self._points):
            self.post_message(self.PointOpened(self._points[self.view.cursor]))
