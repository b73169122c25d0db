"""The sunspot as the technician would see it on the target plate, drawn in half cells.

The spot lies where the axes must go: it is right of the centre when axis 1 must move to +, above
it when axis 2 must move to +, so an arrow key pushes the collector towards the spot.
"""

import math

from rich.segment import Segment
from textual.strip import Strip
from textual.widget import Widget

from solarcal.unit.tracker import Spot

SUN_RADIUS_DEG = 0.266
HALF_WIDTHS_DEG = (0.5, 1.0, 2.0, 4.0)
"""Half widths of the plate: the closest in which the whole spot is seen is taken."""

RING_DEG = SUN_RADIUS_DEG
"""The mark on the plate: a centred spot fills it."""

UPPER, LOWER, FULL = "▀", "▄", "█"
RING, CROSS, EDGE = "·", "+", "│"


class Sunspot(Widget):
    """``show`` a spot; ``None`` where there is no device to look at."""

    DEFAULT_CSS = """
    Sunspot { width: 33; height: 13; color: $accent; }
    """

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._spot: tuple[float, float] | None = None
        self._half_width_deg = HALF_WIDTHS_DEG[0]

    @property
    def half_width_deg(self) -> float:
        return self._half_width_deg

    def show(self, spot: Spot | None, ideal2_deg: float) -> None:
        """On the plate an axis-1 error is seen as its angle on the sky."""
        if spot is None or not spot.visible:
            self._spot = None
        else:
            on_sky = spot.error1_deg * math.sin(math.radians(ideal2_deg))
            self._spot = (on_sky, spot.error2_deg)
            reach = max(abs(on_sky), abs(spot.error2_deg)) + SUN_RADIUS_DEG
            self._half_width_deg = next(
                (half for half in HALF_WIDTHS_DEG if half >= reach), HALF_WIDTHS_DEG[-1]
            )
        self.refresh()

    def words(self) -> str:
        """The same without the picture."""
        if self._spot is None:
            return "no spot on the plate"
        right, up = self._spot
        sides = [
            f"{abs(right):.3f} {'right' if right >= 0 else 'left'}",
            f"{abs(up):.3f} {'up' if up >= 0 else 'down'}",
        ]
        return f"spot {', '.join(sides)} (deg, sky)"

    def render_line(self, y: int) -> Strip:
        width, height = self.size
        style = self.rich_style
        if y >= height:
            return Strip.blank(width, style)
        cells = "".join(self._cell(x, y, width, height) for x in range(width))
        return Strip([Segment(cells, style)])

    def _cell(self, x: int, y: int, width: int, height: int) -> str:
        """One character: spot in half cells, over the cross, the ring and the scale's ticks."""
        # A cell is about twice as high as wide: half cells are square.
        scale = 2.0 * self._half_width_deg / (2.0 * height)
        right = (x - 0.5 * (width - 1)) * scale
        upper = (0.5 * (2 * height - 1) - 2 * y) * scale
        lower = upper - scale
        centre = abs(right) < 0.6 * scale and abs(upper - 0.5 * scale) < 0.6 * scale
        in_upper, in_lower = self._lit(right, upper), self._lit(right, lower)
        if centre:
            return CROSS if not (in_upper and in_lower) else "╋"
        if in_upper and in_lower:
            return FULL
        if in_upper:
            return UPPER
        if in_lower:
            return LOWER
        middle = 0.5 * (upper + lower)
        if abs(math.hypot(right, middle) - RING_DEG) < 0.6 * scale:
            return RING
        if abs(right) < 0.6 * scale and y in (0, height - 1):
            return EDGE
        if abs(middle) < 0.6 * scale and x in (0, width - 1):
            return "─"
        return " "

    def _lit(self, right: float, up: float) -> bool:
        if self._spot is None:
            return False
        return math.hypot(right - self._spot[0], up - self._spot[1]) <= SUN_RADIUS_DEG
