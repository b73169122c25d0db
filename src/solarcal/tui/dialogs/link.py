"""The line to the unit: how it is, who answers, reconnect now, what went over it. And the clocks:
is the laptop's right, how far is the unit's off, and set it.
"""

from collections.abc import Iterable
from typing import Any, ClassVar

from textual.widget import Widget
from textual.widgets import Input

from solarcal.decimals import counted
from solarcal.errors import ConfigurationError
from solarcal.session.records import LinkLost, LinkRestored
from solarcal.station.clocks import LaptopClock, laptop_clock
from solarcal.station.news import ClockAdjusted, Done, Progress, Reconnected, StepFailed
from solarcal.station.state import LinkState, StationState
from solarcal.timescale import SECONDS_PER_SUN_DEG, format_utc, second_of_day
from solarcal.tui.base import Workstation, is_typed
from solarcal.tui.dialogs.dialog import Dialog, open_dialog
from solarcal.tui.dialogs.paced import PacedDialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.lines import Field, Words
from solarcal.tui.widgets.text_lines import TextLines
from solarcal.unit.tracker import Capabilities

TRAFFIC_EVERY_S = 0.5
STATES = {
    LinkState.CONNECTED: "CONNECTED",
    LinkState.LOST: "LOST; it reconnects automatically, with growing pauses",
    LinkState.CLOSED: "closed",
}


def open_link(app: Workstation) -> None:
    open_dialog(app, LinkDialog())
    if app.state.live.link is LinkState.LOST:
        app.station_worker().reconnect_now()


class LinkDialog(Dialog):
    HEADING = "Link"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("reconnect", "Reconnect now", "enter,r", "Enter r"),
    )

    DEFAULT_CSS = """
    LinkDialog #link { height: auto; margin-bottom: 1; }
    LinkDialog #traffic { height: 9; border-top: solid $primary; }
    """

    def body(self) -> Iterable[Widget]:
        yield Words("", id="link", markup=False)
        yield TextLines(id="traffic", follow=True)

    def on_mount(self) -> None:
        super().on_mount()
        traffic = self.query_one("#traffic")
        traffic.border_title = (
            "Typed last"
            if is_typed(self.workstation)
            else "Last over the line (> sent, < received)"
        )
        self.set_interval(TRAFFIC_EVERY_S, self._show_traffic)
        self._show_traffic()

    def action_reconnect(self) -> None:
        if self._lost:
            self.say("Trying now ...")
            self.worker.reconnect_now()
        else:
            self.say("The link is up; nothing to reconnect.")

    def state_changed(self, state: StationState) -> None:
        live = state.live
        who = live.identity
        state_words = STATES[live.link]
        if silent_s := self.workstation.silent_s:
            state_words += f"; the last answer is {silent_s} s old"
        if is_typed(self.workstation):
            state_words = "no line: what the unit's display shows is typed"
        lines = [f"State     {state_words}"]
        if who is not None:
            emulated = ", an EMULATOR" if live.capabilities.emulated else ""
            lines.append(f"Unit      {who.model} {who.serial}, firmware {who.firmware}{emulated}")
        if kept := kept_by_station(live.capabilities):
            lines.append(f"Station   {kept}")
        line = self.workstation.line
        if line is not None and line.choice.port:
            lines.append(f"Port      {line.choice.port} ({line.choice.driver})")
        session = state.session
        if session is not None:
            lost = live.losses_unrecorded
            lost += sum(r.losses for r in session.records if isinstance(r, LinkRestored))
            lost += sum(isinstance(r, LinkLost) for r in session.records)
            back = lost - (live.link is LinkState.LOST)
            lines.append(
                f"Recorded  lost {counted(lost, 'time')}, restored {counted(back, 'time')} in this "
                "session"
            )
        if live.link is LinkState.LOST:
            lines.append(f"Reason    {live.link_message}")
        self.query_one("#link", Words).update("\n".join(lines))
        self.offer(*(["reconnect"] if live.link is LinkState.LOST else []))

    def show_progress(self, progress: Progress) -> None:
        if progress.kind is Reconnected and self._lost:
            self.say(f"LINK LOST: {progress.words}.", "error")

    def _show_traffic(self) -> None:
        self.query_one(TextLines).show(self.worker.station.tracker.recent_traffic())


REACTION_SIGMA_S = 0.2
"""Of a person who presses a key at the pip."""


NO_CLOCK = "This unit has no clock: a time tick corrects the laptop's."


class ClockDialog(PacedDialog):
    """Unit minus laptop before and after; a radio or GPS time tick may correct the laptop.

    A unit without a clock uses the laptop's: there is nothing to set, but a time tick to use.
    """

    HEADING = "Clocks"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("set", "Set the unit's clock", "enter,y", "Enter y"),
        DialogKey("use", "Use the time tick", "enter,y", "Enter y"),
        DialogKey("pip", "A full minute: NOW", "m", "m"),
    )

    DEFAULT_CSS = """
    ClockDialog #clocks { height: auto; margin-bottom: 1; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._laptop: LaptopClock | None = None

    def body(self) -> Iterable[Widget]:
        yield Words("", id="clocks", markup=False)
        yield Field("tick-minus-laptop", "Time tick minus laptop", "s   (empty: no tick)")
        yield Field("tick-sigma", "its uncertainty", "s")

    def on_mount(self) -> None:
        super().on_mount()
        self._offer()
        emulation = self.worker.station.tracker.emulation
        if emulation is not None:
            self._laptop = LaptopClock(None, "The laptop's clock here is the emulator's.")
            self.show_state(self.workstation.state)
        else:
            # The tools may take seconds to answer, or never.
            self.compute(laptop_clock, self._show_laptop)
        tip = (
            "24 s of clock error are 0.1 deg of Sun. Tab reaches the fields; or press m at the pip "
            "of a full minute."
        )
        if not self._has_clock:
            tip = f"{NO_CLOCK} {tip}"
        self.say(tip)

    @property
    def _has_clock(self) -> bool:
        return self.workstation.state.live.capabilities.has_clock

    def _offer(self) -> None:
        self.offer("set" if self._has_clock else "use", "pip")

    def _show_laptop(self, answer: LaptopClock) -> None:
        self._laptop = answer
        self.state_changed(self.workstation.state)

    def state_changed(self, state: StationState) -> None:
        live = state.live
        lines = []
        unit, difference, last_set = (
            ("Unit    ", "Unit - laptop", "Last set")
            if self._has_clock
            else ("Used    ", "Correction of the laptop's", "Tick used")
        )
        if live.laptop_utc_s is not None and live.status is not None:
            lines += [
                f"Laptop  {_shown(live.laptop_utc_s)} UTC",
                f"{unit}{_shown(live.status.unit_utc_s)} UTC",
            ]
        if live.unit_minus_laptop_s is not None:
            off = live.unit_minus_laptop_s
            lines.append(
                f"{difference}  {off:+z.3f} s = {off / SECONDS_PER_SUN_DEG:+z.4f} deg of Sun"
            )
        if state.session is not None and state.session.clock_sets:
            last = state.session.clock_sets[-1]
            lines.append(
                f"{last_set} {second_of_day(last.utc)} UTC: {last.before_s:+z.3f} s before, "
                f"{last.after_s:+z.3f} s after"
            )
        if self._laptop is not None:
            mark = {True: "OK  ", False: "!! ", None: "?  "}[self._laptop.synchronised]
            lines.append(mark + self._laptop.sentence)
        self.query_one("#clocks", Words).update("\n".join(lines))

    def action_pip(self) -> None:
        """A time signal marks the full minute this instant."""
        laptop_s = self.worker.station.clock.utc_s()
        tick_s = 60.0 * round(laptop_s / 60.0) - laptop_s
        self.query_one("#tick-minus-laptop", Field).input.value = f"{tick_s:.2f}"
        self.query_one("#tick-sigma", Field).input.value = f"{REACTION_SIGMA_S:g}"
        how = "Set the unit's clock to use it." if self._has_clock else "Enter uses it."
        self.say(f"Signal - laptop {tick_s:+z.2f} s. {how}")

    def on_input_changed(self) -> None:
        """A time tick that was typed is not left by the key of another step."""
        self._finished = False

    def on_input_submitted(self, event: Input.Submitted) -> None:
        tick, sigma = self.query(Field)
        if event.input is tick.input and tick.value:
            sigma.input.focus()
        else:
            self.action_set()

    def action_use(self) -> None:
        """Correct the laptop's clock; without a time tick there is nothing to correct it by."""
        if not self.query_one("#tick-minus-laptop", Field).value:
            self.finish(
                f"{NO_CLOCK} Give the time tick first, or press m at a full minute.", "warning"
            )
            return
        self._adjust()

    def action_set(self) -> None:
        if self._has_clock:
            self._adjust()
        else:
            self.action_use()

    def _adjust(self) -> None:
        try:
            tick_s, sigma_s = self._tick()
        except ConfigurationError as error:
            self.finish(str(error), "warning")
            return
        self.set_focus(None)
        self.offer()
        self.submit(ClockAdjusted, lambda station: station.set_unit_clock(tick_s, sigma_s))

    def _tick(self) -> tuple[float | None, float | None]:
        tick, sigma = self.query(Field)
        if not tick.value:
            return None, None
        if not sigma.value:
            raise ConfigurationError("a time tick needs its uncertainty, in seconds")
        tick_s, sigma_s = tick.number(), sigma.number()
        if not sigma_s > 0.0:
            raise ConfigurationError("the uncertainty of a time tick is greater than zero")
        return tick_s, sigma_s

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, ClockAdjusted):
            result = done.result
            self._offer()
            what = "unit - laptop" if self._has_clock else "the correction"
            self.finish(
                f"{'Set' if self._has_clock else 'Used'} and recorded: {what} was "
                f"{result.before_s:+z.3f} s, is {result.after_s:+z.3f} s."
            )

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if failed.kind is ClockAdjusted:
            self._offer()


def _shown(utc_s: float) -> str:
    return format_utc(utc_s).replace("T", " ").removesuffix("Z")


def kept_by_station(unit: Capabilities) -> str:
    """What the station does for a unit; empty where that does all itself."""
    owned = {
        "clock": unit.has_clock,
        "offsets": unit.has_offsets,
        "coefficients": unit.stores_coefficients,
    }
    kept = [what for what, own in owned.items() if not own]
    does = [] if unit.has_controller else ["follows the Sun"]
    return "; ".join(does + ([f"keeps its {', '.join(kept)}"] if kept else []))
