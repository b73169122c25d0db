"""Set Sun Offset: jog exactly onto the Sun, coming from behind, and set the offset there."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, ClassVar

from textual.containers import Horizontal
from textual.widget import Widget

from solarcal.errors import UnitRefused
from solarcal.model.solution import Solution
from solarcal.session.records import SunOffset
from solarcal.station.gathering import stale
from solarcal.station.jogging import JogView, SunOffsetJog
from solarcal.station.news import (
    Done,
    Jogged,
    JogSeen,
    OffsetLeft,
    OffsetSet,
    OffsetTakenBack,
    Result,
    StepFailed,
    Stopped,
)
from solarcal.station.procedure import Station
from solarcal.tui.base import Workstation, is_typed
from solarcal.tui.dialogs.dialog import Tone, open_dialog
from solarcal.tui.dialogs.paced import DriveWatch, PacedDialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.offset import words
from solarcal.tui.offset.arrows import ARROW_KEYS, ArrowSteps
from solarcal.tui.offset.spot import (
    BigDigits,
    SpotCalculator,
    Sunspot,
    TypedOffsetDialog,
    calculated_jogs_deg,
)
from solarcal.tui.widgets.lines import Words
from solarcal.unit.frames import Code

STEPS = (JogSeen, Jogged, OffsetSet, OffsetTakenBack, OffsetLeft)
WITHOUT_BUTTON = {"behind", "follow", "undo", "predicted"}
"""Where their buttons make room for others, the keys stay."""

LOOK_EVERY_S = 0.25
ROOMY = (112, 36)


def open_screen(app: Workstation) -> None:
    worker = app.station_worker()
    if is_typed(app):
        open_dialog(app, TypedOffsetDialog())
    else:
        open_dialog(app, SunOffsetDialog(worker.station))


class SunOffsetDialog(PacedDialog):
    """Arrow keys jog; Enter sets the offset here; Escape leaves without writing."""

    HEADING = "Set Sun Offset"
    FIELDS_FIRST = True
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("set", "Set here", "enter", "Enter"),
        DialogKey("predicted", "To fit", "p", "p"),
        DialogKey("behind", "Behind", "b", "b"),
        DialogKey("follow", "Follow", "f", "f"),
        DialogKey("track", "Track", "t", "t"),
        DialogKey("calculate", "Jog E", "j", "j"),
        DialogKey("undo", "Undo", "u", "u"),
        DialogKey("point", "Take point", "full_stop,f7", "."),
        DialogKey("big", "large digits", "B", "B", button=False),
        *ARROW_KEYS,
    )

    DEFAULT_CSS = """
    SunOffsetDialog #plate { height: 13; }
    SunOffsetDialog #sight { width: 33; height: 13; }
    SunOffsetDialog #axes { width: 1fr; height: 13; padding-left: 1; }
    SunOffsetDialog #steps { height: 1; }
    SunOffsetDialog BigDigits { display: none; }
    SunOffsetDialog.-big BigDigits { display: block; }
    SunOffsetDialog.-big #plate { display: none; }
    SunOffsetDialog.-roomy > #dialog { width: 110; }
    SunOffsetDialog.-roomy #plate { height: 25; }
    SunOffsetDialog.-roomy Sunspot#sight { width: 61; height: 25; }
    SunOffsetDialog.-roomy #axes { height: 25; }
    """

    def __init__(self, station: Station) -> None:
        super().__init__()
        self._jog = SunOffsetJog(station)
        self._steps = ArrowSteps()
        self._drive = DriveWatch()
        self._view: JogView | None = None
        self._waiting = 0
        self._warned = ""

    @property
    def emulated(self) -> bool:
        return self._jog.station.tracker.emulation is not None

    def body(self) -> Iterable[Widget]:
        with Horizontal(id="plate"):
            yield Sunspot(id="sight") if self.emulated else SpotCalculator(id="sight")
            yield Words("", id="axes", markup=False)
        yield BigDigits(id="big")
        yield Words("", id="steps", markup=False)

    def on_mount(self) -> None:
        super().on_mount()
        self._show_steps()
        self._offer()
        self.say(self._how_to_begin())
        self._look()
        self.set_interval(LOOK_EVERY_S, self._look)

    def _how_to_begin(self) -> str:
        before, is_set = self._jog.station.replaced_offsets, self._set is not None
        return words.how_to_begin(self.workstation, before, is_set, fields=not self.emulated)

    def on_resize(self) -> None:
        room = self.app.size
        self.set_class(room.width >= ROOMY[0] and room.height >= ROOMY[1], "-roomy")

    def _offer(self) -> None:
        offered = ["set", "track"]
        if self._jog.station.replaced_offsets is not None and (self.emulated or self._set):
            offered.append("undo")
        if self._set is not None:
            if words.can_take_points(self.workstation.state):
                offered.append("point")
            self.offer(*offered)
            return
        offered.append("behind")
        if self._solution() is None:
            offered.append("follow")
        elif self._view is not None:
            # Where the fit expects the Sun is known once the axes have been read.
            offered.append("predicted")
        self.offer(*offered, *([] if self.emulated else ["calculate"]))

    def offered(self, action: str) -> bool:
        return super().offered(action) or (not self.under_way() and action in WITHOUT_BUTTON)

    @property
    def _set(self) -> SunOffset | None:
        """The offset that waits for its point; ``None`` while the axes are jogged off it."""
        if self._steps.jogging or (self._view is not None and self._view.aim is not None):
            return None
        fresh = self._jog.station.session.fresh_sun_offset
        return None if stale(fresh, self.workstation.state.live.laptop_utc_s) else fresh

    def _solution(self) -> Solution | None:
        fit = self.workstation.fit
        return fit.solution if fit is not None else None

    # -- keys ----------------------------------------------------------------------------------

    def action_jog(self, axis1: int, axis2: int) -> None:
        if not self._lost:
            self._steps.press(axis1, axis2, self._view.spot if self._view is not None else None)
            self._jog_on()

    def _jog_on(self) -> None:
        """One step at a time goes to the unit; what a held key adds meanwhile is the next."""
        if (step := self._steps.take()) is not None:
            self._nudge(*step)

    def _nudge(self, axis1_deg: float, axis2_deg: float) -> None:
        if not self._lost:
            self._submit(Jogged, lambda station: self._jog.nudge(axis1_deg, axis2_deg))

    def action_step(self, index: int | None) -> None:
        self._steps.choose(index)
        self._show_steps()

    def action_resize_step(self, by: int) -> None:
        self.action_step(self._steps.nominal + by)

    def _show_steps(self) -> None:
        self.query_one("#steps", Words).update(self._steps.words())

    def action_big(self) -> None:
        """Characters three rows high, to be read from the collector."""
        self.toggle_class("-big")

    def action_predicted(self) -> None:
        """Where the fit expects the Sun: behind it first, then forward."""
        solution, view = self._solution(), self._view
        if solution is None or view is None:
            self.say("There is no fit yet to say where the Sun is expected.", "warning")
            return
        error1, error2 = solution.predict_deg(view.status.ideal1_deg, view.status.ideal2_deg)
        self._submit(Jogged, lambda station: self._jog.go_to((float(error1), float(error2))))
        self.say(
            f"Going from behind to the Sun position expected by the fit of {solution.n_points} "
            "points. Centre the spot there."
        )

    def action_point(self) -> None:
        """The offset is set: on to the point."""
        self.dismiss(None)
        self.workstation.action_perform("take_point")

    def action_behind(self) -> None:
        if self._view is not None and all(self._view.watch.from_behind):
            self.say("Both axes came from behind already: nothing to take up.", "good")
            return
        self._submit(Jogged, lambda station: self._jog.go_behind())

    def action_follow(self) -> None:
        follows = not self._jog.follows
        self._submit(Jogged, lambda station: self._jog.follow(follows))
        self.say(
            "The aim follows the Sun: only your jogs move the spot."
            if follows
            else "The target is fixed, the Sun moves past it: press Enter when it is centred."
        )

    def action_track(self) -> None:
        self.say("To the Sun, with the offsets the unit has.")
        self._submit(Jogged, lambda station: self._jog.track())

    def action_calculate(self) -> None:
        view = self._view
        jogs = None if view is None else calculated_jogs_deg(self, view.status.ideal2_deg)
        if jogs is not None:
            self.say(f"Jogging axis 1 by {jogs[0]:+z.3f}, axis 2 by {jogs[1]:+z.3f} deg.")
            self._nudge(*jogs)

    def action_undo(self) -> None:
        before = self._jog.station.replaced_offsets
        if before is None:
            self.say("There is no Set Sun Offset here to take back.", "warning")
            return
        self.offer()
        self._submit(OffsetTakenBack, lambda station: self._jog.take_back())

    def action_set(self) -> None:
        self.offer()
        self.say("Waiting until the axes rest and the Sun is there ...")
        self._submit(OffsetSet, lambda station: self._jog.set_here())

    def on_input_submitted(self) -> None:
        self.action_calculate()

    def finished(self) -> bool:
        # The unit tracks again once the offset is set; a jog after that takes it off the Sun.
        # Without a reference it does neither.
        unreferenced = self._view is not None and not self._view.status.referenced
        return not self.under_way() and (self._set is not None or unreferenced)

    def action_leave(self) -> None:
        if self._lost:
            self.dismiss(None)
            return
        self._submit(OffsetLeft, lambda station: self._jog.leave())

    # -- the station ---------------------------------------------------------------------------

    def _submit(self, kind: type[Done[Result]], step: Callable[[Station], Result]) -> None:
        self._waiting += 1
        if kind is Jogged:
            self._steps.jogging = True
            self._offer()
        self.submit(kind, step, moves=kind is not JogSeen)

    def _look(self) -> None:
        """Look, and renew the jog: only when nothing of ours still waits."""
        if not self._waiting and not self._lost:
            self._submit(JogSeen, lambda station: self._jog.look())

    def link_lost(self) -> None:
        # What was to be jogged is forgotten: nothing moves by itself when the line is back.
        self._jog.release()
        self._waiting = 0
        self._steps.forget()

    def link_restored(self) -> None:
        self._offer()

    def step_done(self, done: Done[Any]) -> None:
        super().step_done(done)
        if isinstance(done, STEPS):
            self._waiting = max(0, self._waiting - 1)
        match done:
            case JogSeen(view) | Jogged(view):
                if isinstance(done, Jogged):
                    self._steps.jogging = False
                self._show(view)
                if not self.under_way():
                    self._offer()
                self._jog_on()
            case OffsetSet(record):
                # Looked at next in a moment; the key that is named works now.
                self._view = self._view and replace(self._view, aim=None)
                self._offer()
                before = self._jog.station.replaced_offsets
                then = words.next_words(self.workstation)
                tone: Tone = "warning" if record.slack_axes else "good"
                self.say(words.set_words(record, before, then), tone)
            case OffsetTakenBack(void):
                self._offer()
                self.say(f"{void.reason}. Record {void.voids} is struck.", "good")
            case OffsetLeft():
                self.dismiss(None)
            case Stopped():
                self._steps.forget_waiting()
                self._jog.release()

    def step_failed(self, failed: StepFailed) -> None:
        super().step_failed(failed)
        if isinstance(failed.error, UnitRefused) and failed.error.code == Code.NOT_REFERENCED:
            self.say(f"Refused. {words.no_reference(self.workstation)}", "error")
        if failed.kind in STEPS:
            self._waiting = max(0, self._waiting - 1)
        if failed.kind is Jogged:
            self._steps.forget()
        elif failed.kind in (OffsetSet, OffsetTakenBack):
            self._offer()
        elif failed.kind is OffsetLeft:
            self.dismiss(None)

    # -- showing -------------------------------------------------------------------------------

    def _show(self, view: JogView) -> None:
        self._view = view
        spot = ""
        if self.emulated:
            sight = self.query_one(Sunspot)
            sight.show(view.spot, view.status.ideal2_deg)
            spot = sight.words(view.status)
        self.query_one("#axes", Words).update(
            words.jog_table(view, follows=self._jog.follows, words=spot)
        )
        self.query_one(BigDigits).show(view)
        self._warn(view)

    def _warn(self, view: JogView) -> None:
        """Say once what the technician has to know of the side the axes came from."""
        if driving := self._drive.jog_words(view):
            self.say(driving)
            self._warned = driving
            return
        if self._warned.startswith("Driving") and view.aim is None:
            self._warned = ""
            self.say("The axes have arrived. " + self._how_to_begin())
        warning = words.jog_warning(view, self.workstation)
        if warning and warning != self._warned:
            self.say(warning, "warning")
        elif self._warned and not warning and view.aim is not None:
            self.say(*words.came_words(view))
        self._warned = warning
