"""The sunspot calculator: edge distances read on a real device become jogs."""

import math

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Label

from solarcal.errors import ConfigurationError
from solarcal.optics.sunspot import spot_error_deg
from solarcal.tui.widgets.field import Field

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
        self.query_one("#spot-errors", Label).update(f"sky error {across:+.3f}, {along:+.3f} deg")
        return across / weight, along
