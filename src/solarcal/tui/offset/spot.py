"""The sunspot on its plate and the calculator for a real device; Set Sun Offset at the unit's own
keys, where what its display shows then is typed.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from rich.segment import Segment
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Digits, Input, Label, Static

from solarcal.errors import ConfigurationError
from solarcal.optics.sunspot import spot_error_deg
from solarcal.station.jogging import JogView
from solarcal.station.news import Done, OffsetSet
from solarcal.station.state import StationState
from solarcal.station.sun_path import forward_sense, sun_rates_deg_per_s
from solarcal.tui.dialogs.dialog import Dialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.offset.words import big_numbers
from solarcal.tui.widgets.lines import Field, Words
from solarcal.unit.tracker import Mode, Spot, Status
from solarcal.units import SUN_RADIUS_DEG

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
        self.half_width_deg = HALF_WIDTHS_DEG[0]

    def show(self, spot: Spot | None, ideal2_deg: float) -> None:
        """On the plate an axis-1 error is seen as its angle on the sky."""
        if spot is None or not spot.visible:
            self._spot = None
        else:
            on_sky = spot.error1_deg * math.sin(math.radians(ideal2_deg))
            self._spot = (on_sky, spot.error2_deg)
            reach = max(abs(on_sky), abs(spot.error2_deg)) + SUN_RADIUS_DEG
            self.half_width_deg = next(
                (half for half in HALF_WIDTHS_DEG if half >= reach), HALF_WIDTHS_DEG[-1]
            )
        self.refresh()

    def words(self, status: Status) -> str:
        """The same without the picture; without a spot, what brings it back."""
        if self._spot is None:
            if status.mode is not Mode.TRACK:
                return "no spot on the plate: jog back or\npress t, which tracks the Sun again"
            if status.moving != (0, 0):
                return "no spot on the plate yet:\nthe axes still drive to the Sun"
            return "no spot on the plate: the unit tracks,\nbut points elsewhere; jog to the Sun"
        right, up = self._spot
        sides = [
            f"{abs(right):.3f} {'right' if right >= 0 else 'left'}",
            f"{abs(up):.3f} {'up' if up >= 0 else 'down'}",
        ]
        return (
            f"spot {', '.join(sides)} (deg, sky)\n"
            f"+-{self.half_width_deg:g} deg plate; press arrows towards it"
        )

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
        scale = 2.0 * self.half_width_deg / (2.0 * height)
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


FIELDS = (
    ("spot-height", "H  plate over mirror"),
    ("spot-hole", "Do hole diameter"),
    ("spot-diameter", "Ds spot diameter"),
    ("spot-edge1", "E1 edges, axis 1 +"),
    ("spot-edge2", "E2 edges, axis 2 +"),
)


class SpotCalculator(Vertical):
    """Five readings in one unit of length; what stood there last stays for the next reading."""

    DEFAULT_CSS = """
    SpotCalculator { width: 44; height: auto; }
    SpotCalculator Field > .label { width: 21; }
    SpotCalculator Field > Input { max-width: 12; }
    """

    def compose(self) -> ComposeResult:
        yield Label("Sunspot plate, one unit of length")
        for name, label in FIELDS:
            yield Field(name, label)
        yield Label("", id="spot-errors")

    def jogs_deg(self, ideal2_deg: float) -> tuple[float, float]:
        """Axis degrees to jog, from what was read.

        Raises
        ------
        ConfigurationError
            A field that is no number, readings no device gives, or an axis 1 that no longer
            moves the spot.
        """
        height, hole, spot, edge1, edge2 = (
            self.query_one(f"#{name}", Field).number() for name, _ in FIELDS
        )
        across = spot_error_deg(height, hole, spot, edge1)
        along = spot_error_deg(height, hole, spot, edge2)
        weight = math.sin(math.radians(ideal2_deg))
        if abs(weight) < 0.02:
            raise ConfigurationError(
                "so near its pole axis 1 hardly moves the spot; wait until the Sun is elsewhere"
            )
        self.query_one("#spot-errors", Label).update(f"sky error {across:+z.3f}, {along:+z.3f} deg")
        return across / weight, along


def calculated_jogs_deg(dialog: Dialog, ideal2_deg: float) -> tuple[float, float] | None:
    """What a dialog's calculator asks for, or None and the dialog says why."""
    try:
        jogs = dialog.query_one(SpotCalculator).jogs_deg(ideal2_deg)
    except ConfigurationError as error:
        dialog.say(str(error), "warning")
        return None
    dialog.set_focus(None)
    return jogs


class BigDigits(Vertical):
    """What is still to move, in characters three rows high."""

    DEFAULT_CSS = """
    BigDigits { height: 11; align-horizontal: center; }
    BigDigits Digits { width: 40; height: 3; text-align: right; }
    BigDigits Static { height: 1; text-align: center; }
    """

    def compose(self) -> ComposeResult:
        yield Words("", markup=False)
        for axis in (1, 2):
            yield Static(f"axis {axis}, deg", markup=False)
            yield Digits("", id=f"big-{axis}")

    def show(self, view: JogView) -> None:
        words, numbers = big_numbers(view)
        self.query_one(Words).update(words)
        for digits, number in zip(self.query(Digits), numbers, strict=True):
            digits.update(f"{number:+z.3f}")


class TypedOffsetDialog(Dialog):
    """What the spot asks for at the unit's keys, and then what the unit made of it."""

    HEADING = "Set Sun Offset, at the unit"
    FIELDS_FIRST = True
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("type", "It is set: type it", "enter,y", "Enter y"),
        DialogKey("calculate", "Compute the jog", "j", "j"),
    )
    FIRST_WORDS = "This screen moves and sets nothing. Tab: calculator, j: compute the jog."
    AGAIN: ClassVar[Mapping[type[Done[Any]], tuple[str, ...]]] = {OffsetSet: ("type", "calculate")}

    DEFAULT_CSS = """
    TypedOffsetDialog #plate { height: 9; }
    TypedOffsetDialog #spot { width: 40; height: 9; }
    TypedOffsetDialog #guide { width: 1fr; height: 9; padding-left: 1; }
    """

    def body(self) -> Iterable[Widget]:
        with Horizontal(id="plate"):
            yield SpotCalculator(id="spot")
            yield Words("", id="guide", markup=False)

    def on_mount(self) -> None:
        super().on_mount()
        self.offer("type", "calculate")

    def state_changed(self, state: StationState) -> None:
        status, session = state.live.status, state.session
        if status is None or session is None:
            return
        rates = sun_rates_deg_per_s(session.geometry, session.header.unit.site, status.unit_utc_s)
        signs = ["+" if forward_sense(rate, 0) > 0 else "-" for rate in rates]
        self.query_one("#guide", Words).update(
            "At the unit's own keys:\n"
            f"1. Jog behind the Sun, which moves\n   axis 1 {signs[0]} and axis 2 {signs[1]}.\n"
            f"2. Come forward ({signs[0]}, {signs[1]}) until the\n   spot is centred.\n"
            "3. Press its Set Sun Offset.\n"
            "4. Enter here: type what it shows.\n"
            "5. Let it track; watch an update."
        )

    def action_calculate(self) -> None:
        status = self.workstation.state.live.status
        if status is None:
            return
        jogs = calculated_jogs_deg(self, status.ideal2_deg)
        if jogs is not None:
            self.say(
                f"At the unit jog axis 1 by {jogs[0]:+z.3f} and axis 2 by {jogs[1]:+z.3f} deg."
            )

    def on_input_submitted(self, event: Input.Submitted) -> None:
        event.stop()
        self.action_calculate()

    def action_type(self) -> None:
        self.offer()
        self.submit(OffsetSet, lambda station: station.set_sun_offset())

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, OffsetSet):
            offsets = done.result.offsets
            self.leave_saying(
                f"Recorded: O1 {offsets.O1:+z.4f}, O2 {offsets.O2:+z.4f} deg. Let the "
                "unit track; watch it a minute and through one update."
            )
