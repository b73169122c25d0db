"""Set Sun Offset: jog exactly onto the Sun, coming from behind, and set the offset there."""

from collections.abc import Iterable
from typing import ClassVar

from textual.containers import Horizontal
from textual.content import Content
from textual.events import Key, Resize
from textual.widget import Widget
from textual.widgets import Input, Static

from solarcal.errors import ConfigurationError, SolarcalError
from solarcal.session.records import SunOffset
from solarcal.station.jogging import STEPS_DEG, JogView, SunOffsetJog
from solarcal.station.procedure import Station
from solarcal.station.state import StationState
from solarcal.tui.base import Workstation, is_typed
from solarcal.tui.dialogs.dialog import DialogKey, PacedDialog, open_dialog
from solarcal.tui.offset.spot import SpotCalculator, Sunspot, jog_table
from solarcal.tui.station_worker import Step
from solarcal.unit.tracker import Mode

LOOK, NUDGE, SET, LEAVE = "look", "jog", "set sun offset", "leave sun offset"
MOVES = (NUDGE, SET, LEAVE)
LOOK_EVERY_S = 0.25
ROOMY = (112, 36)
DEFAULT_STEP = STEPS_DEG.index(0.05)


def open_screen(app: Workstation) -> None:
    worker = app.station_worker()
    if is_typed(app):
        from solarcal.tui.offset.typed import TypedOffsetDialog

        open_dialog(app, TypedOffsetDialog())
    else:
        open_dialog(app, SunOffsetDialog(worker.station))


class SunOffsetDialog(PacedDialog):
    """Arrow keys jog; Enter sets the offset here; Escape leaves without writing."""

    HEADING = "Set Sun Offset"
    LEAVE = "Leave"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("set", "Set here", "enter", "Enter"),
        DialogKey("behind", "Behind", "b", "b"),
        DialogKey("follow", "Follow", "f", "f"),
        DialogKey("track", "Track", "t", "t"),
        DialogKey("calculate", "Jog E", "j", "j"),
        DialogKey("jog(-1,0)", "axis 1 -", "left", "left", button=False),
        DialogKey("jog(1,0)", "axis 1 +", "right", "right", button=False),
        DialogKey("jog(0,-1)", "axis 2 -", "down", "down", button=False),
        DialogKey("jog(0,1)", "axis 2 +", "up", "up", button=False),
        *(
            DialogKey(f"step({index})", f"{step:g}", str(index + 1), str(index + 1), button=False)
            for index, step in enumerate(STEPS_DEG)
        ),
        DialogKey("finer", "smaller step", "comma,left_square_bracket", ",", button=False),
        DialogKey("coarser", "larger step", "right_square_bracket", "]", button=False),
    )

    DEFAULT_CSS = """
    SunOffsetDialog #plate { height: 13; }
    SunOffsetDialog #sight { width: 33; height: 13; }
    SunOffsetDialog #axes { width: 1fr; height: 13; padding-left: 1; }
    SunOffsetDialog #steps { height: 1; }
    SunOffsetDialog.-roomy > #dialog { width: 110; }
    SunOffsetDialog.-roomy #plate { height: 25; }
    SunOffsetDialog.-roomy Sunspot#sight { width: 61; height: 25; }
    SunOffsetDialog.-roomy #axes { height: 25; }
    """

    def __init__(self, station: Station) -> None:
        super().__init__()
        self._jog = SunOffsetJog(station)
        self._step = DEFAULT_STEP
        self._view: JogView | None = None
        self._set: SunOffset | None = None
        self._waiting = 0
        self._warned = ""

    @property
    def emulated(self) -> bool:
        return self._jog.station.tracker.emulation is not None

    def body(self) -> Iterable[Widget]:
        with Horizontal(id="plate"):
            yield Sunspot(id="sight") if self.emulated else SpotCalculator(id="sight")
            yield Static("", id="axes", markup=False)
        yield Static("", id="steps", markup=False)

    def on_mount(self) -> None:
        super().on_mount()
        self._show_steps()
        self._offer()
        self.say(self._how_to_begin())
        self._look()
        self.set_interval(LOOK_EVERY_S, self._look)

    def _how_to_begin(self) -> str:
        status = self.workstation.state.live.status
        tracks = status is not None and status.mode is Mode.TRACK
        first = "" if tracks else "The unit does not track: press t, and it goes to its Sun. "
        fields = "" if self.emulated else " Tab reaches the plate's fields, Esc the arrows."
        return (
            f"{first}Arrow keys jog: left/right axis 1, down/up axis 2. "
            f"Nothing moves before one.{fields}"
        )

    def on_resize(self, event: Resize) -> None:
        room = self.app.size
        self.set_class(room.width >= ROOMY[0] and room.height >= ROOMY[1], "-roomy")

    def _offer(self) -> None:
        self.offer("set", "behind", "follow", "track", *([] if self.emulated else ["calculate"]))

    # -- keys ----------------------------------------------------------------------------------

    def action_jog(self, axis1: int, axis2: int) -> None:
        step = STEPS_DEG[self._step]
        self._nudge(axis1 * step, axis2 * step)

    def _nudge(self, axis1_deg: float, axis2_deg: float) -> None:
        if self._lost:
            return
        self._set = None
        self._submit(NUDGE, lambda station: self._jog.nudge(axis1_deg, axis2_deg))

    def action_step(self, index: int) -> None:
        self._step = min(max(index, 0), len(STEPS_DEG) - 1)
        self._show_steps()

    def action_finer(self) -> None:
        self.action_step(self._step - 1)

    def action_coarser(self) -> None:
        self.action_step(self._step + 1)

    def action_behind(self) -> None:
        if self._view is not None and all(self._view.watch.from_behind):
            self.say("Both axes came from behind already: nothing to take up.", "good")
            return
        self._submit(NUDGE, lambda station: self._jog.go_behind())

    def action_follow(self) -> None:
        follows = not self._jog.follows
        self._submit(NUDGE, lambda station: self._jog.follow(follows))
        self.say(
            "The aim follows the Sun: the spot stands but for your jogs."
            if follows
            else "The aim stands still: the Sun goes by; press Enter as the spot is centred."
        )

    def action_track(self) -> None:
        self._submit(NUDGE, lambda station: self._jog.track())
        self.say("The unit tracks by itself, with the offsets it has.")

    def action_calculate(self) -> None:
        view = self._view
        if view is None:
            return
        try:
            jogs = self.query_one(SpotCalculator).jogs_deg(view.status.ideal2_deg)
        except ConfigurationError as error:
            self.say(str(error), "warning")
            return
        self.set_focus(None)
        self.say(f"Jogging axis 1 by {jogs[0]:+.3f}, axis 2 by {jogs[1]:+.3f} deg.")
        self._nudge(*jogs)

    def action_set(self) -> None:
        self.offer()
        self.say("Waiting until the axes rest and the Sun is there ...")
        self._submit(SET, lambda station: self._jog.set_here())

    def on_input_submitted(self, event: Input.Submitted) -> None:
        del event
        self.action_calculate()

    def on_key(self, event: Key) -> None:
        # A field keeps its keys; Escape gives them back to the arrows first.
        if event.key == "escape" and self.focused is not None:
            event.stop()
            event.prevent_default()
            self.set_focus(None)

    def action_leave(self) -> None:
        if self._lost:
            self.dismiss(None)
            return
        self._submit(LEAVE, lambda station: self._jog.leave())

    # -- the station ---------------------------------------------------------------------------

    def _submit(self, name: str, step: Step) -> None:
        self._waiting += 1
        self.submit(name, step, moves=name in MOVES)

    def _look(self) -> None:
        """Look, and renew the jog: only when nothing of ours still waits."""
        if not self._waiting and not self._lost:
            self._submit(LOOK, lambda station: self._jog.look())

    def state_changed(self, state: StationState) -> None:
        del state

    def link_lost(self) -> None:
        # What was to be jogged is forgotten: nothing moves by itself when the line is back.
        self._jog.release()
        self._waiting = 0

    def link_restored(self) -> None:
        self._offer()

    def step_done(self, name: str, result: object) -> None:
        super().step_done(name, result)
        if name in (LOOK, NUDGE, SET, LEAVE):
            self._waiting = max(0, self._waiting - 1)
        if isinstance(result, JogView):
            self._show(result)
        elif name == SET and isinstance(result, SunOffset):
            self._set = result
            self._offer()
            self.say(
                f"SET and recorded: O1 {result.offsets.O1:+.4f}, O2 {result.offsets.O2:+.4f} deg. "
                "Tracking: watch it a minute and through one update, then leave.",
                "good",
            )
        elif name == LEAVE:
            self.dismiss(None)
        elif name == "stop":
            self._jog.release()

    def step_failed(self, name: str, error: SolarcalError) -> None:
        super().step_failed(name, error)
        if name in (LOOK, NUDGE, SET, LEAVE):
            self._waiting = max(0, self._waiting - 1)
        if name == SET:
            self._offer()
        elif name == LEAVE:
            self.dismiss(None)

    # -- showing -------------------------------------------------------------------------------

    def _show(self, view: JogView) -> None:
        self._view = view
        words = ""
        if self.emulated:
            sight = self.query_one(Sunspot)
            sight.show(view.spot, view.status.ideal2_deg)
            words = (
                f"{sight.words()}\n+-{sight.half_width_deg:g} deg plate; press arrows towards it"
            )
        self.query_one("#axes", Static).update(
            jog_table(view, follows=self._jog.follows, words=words)
        )
        self._warn(view)

    def _warn(self, view: JogView) -> None:
        """Say once what the technician has to know of the side the axes came from."""
        behind = view.watch.from_behind
        if view.aim is not None and any(view.aim.behind):
            warning = "Going behind the Sun; the axes come forward by themselves."
        elif view.aim is not None and not all(behind):
            axes = " and ".join(str(i + 1) for i, ok in enumerate(behind) if not ok)
            warning = (
                f"Axis {axes} did NOT come from behind: backlash is in it. "
                "Press b: behind the Sun first, then forward."
            )
        elif view.status.mode in (Mode.STOP, Mode.FAULT) and not view.status.referenced:
            key = self.workstation.keys_of("ref_check").split()[0]
            warning = (
                f"The unit is in mode {view.status.mode} and has no reference: leave, and do a "
                f"reference check [{key}]; then it can be jogged."
            )
        elif view.status.mode in (Mode.STOP, Mode.FAULT):
            warning = f"The unit is in mode {view.status.mode}: press t to track again."
        else:
            warning = ""
        if warning and warning != self._warned:
            self.say(warning, "warning")
        elif self._warned and not warning and view.aim is not None:
            self.say("Both axes came from behind. Centre the spot, then Enter.", "good")
        self._warned = warning

    def _show_steps(self) -> None:
        parts: list[str | tuple[str, str]] = ["Step "]
        for index, step in enumerate(STEPS_DEG):
            chosen = index == self._step
            text = f"[{index + 1}:{step:g}]" if chosen else f" {index + 1}:{step:g} "
            parts.append((text, "bold reverse" if chosen else ""))
        self.query_one("#steps", Static).update(Content.assemble(*parts, " deg"))
