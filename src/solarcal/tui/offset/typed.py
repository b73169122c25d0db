"""Set Sun Offset at the unit's own keys; what its display shows then is typed."""

from collections.abc import Iterable
from typing import Any, ClassVar

from textual.containers import Horizontal
from textual.events import Key
from textual.widget import Widget
from textual.widgets import Input

from solarcal.errors import ConfigurationError
from solarcal.station.news import Done, OffsetSet, StepFailed
from solarcal.station.state import StationState
from solarcal.station.sun_path import forward_sense, sun_rates_deg_per_s
from solarcal.tui.dialogs.dialog import Dialog, DialogKey
from solarcal.tui.offset.spot import SpotCalculator
from solarcal.tui.widgets.lines import Words


class TypedOffsetDialog(Dialog):
    """What the spot asks for at the unit's keys, and then what the unit made of it."""

    HEADING = "Set Sun Offset, at the unit"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("type", "It is set: type it", "enter,y", "Enter y"),
        DialogKey("calculate", "Jog by E", "j", "j"),
    )

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
        self.say("This screen moves and sets nothing. Tab: calculator, j: compute.")

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
        try:
            jogs = self.query_one(SpotCalculator).jogs_deg(status.ideal2_deg)
        except ConfigurationError as error:
            self.say(str(error), "warning")
            return
        self.set_focus(None)
        self.say(f"At the unit jog axis 1 by {jogs[0]:+.3f} and axis 2 by {jogs[1]:+.3f} deg.")

    def on_input_submitted(self, event: Input.Submitted) -> None:
        event.stop()
        self.action_calculate()

    def on_key(self, event: Key) -> None:
        # A field keeps its keys; Escape gives them back first.
        if event.key == "escape" and self.focused is not None:
            event.stop()
            event.prevent_default()
            self.set_focus(None)

    def action_type(self) -> None:
        self.offer()
        self.submit(OffsetSet, lambda station: station.set_sun_offset())

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, OffsetSet):
            offsets = done.result.offsets
            self.leave_saying(
                f"Recorded: O1 {offsets.O1:+.4f}, O2 {offsets.O2:+.4f} deg. Let the "
                "unit track; watch it a minute and through one update."
            )

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if failed.kind is OffsetSet:
            self.offer("type", "calculate")
