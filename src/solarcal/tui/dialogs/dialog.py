"""What the dialogs of the procedure share: a frame, a message line, keys as large targets."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, Literal

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.events import Key
from textual.notifications import SeverityLevel
from textual.timer import Timer
from textual.widget import Widget
from textual.widgets import Input

from solarcal.errors import LinkError
from solarcal.station.news import Done, Result, SpeedTold, StepFailed, Stopped
from solarcal.station.procedure import Station
from solarcal.station.state import LinkState, StationState
from solarcal.station.worker import StationWorker
from solarcal.tui.base import StationModal, Workstation, is_typed, refusal_words
from solarcal.tui.keys import DialogKey, shown_key
from solarcal.tui.widgets.footer import KeyButton
from solarcal.tui.widgets.lines import Field, LogLine, NoticeLine, Words

Tone = Literal["plain", "good", "warning", "error"]

MARKS: dict[Tone, str] = {"plain": "", "good": "OK  ", "warning": "!  ", "error": "!! "}
"""Nothing is shown by colour alone."""

STYLES: dict[Tone, str] = {
    "plain": "", "good": "$success", "warning": "bold $warning", "error": "bold $error",
}  # fmt: skip


SPEED_KEYS = (
    DialogKey("faster", "emulator faster", "plus", "+", button=False),
    DialogKey("slower", "emulator slower", "minus", "-", button=False),
)

STEPS = frozenset(
    {
        "link", "clock", "initialise", "plan", "ref_check", "sun_offset", "take_point", "upload",
        "recompute", "report", "void", "note",
    }
)  # fmt: skip
"""Actions that may follow a dialog whose own step is done or refused, without leaving it first."""

KEYS_COLUMNS = 76
"""Of a dialog's row of keys: those that take more are set tight."""

BLINK_S = 0.5
"""How long a key that was not taken shows. Until then it is not taken again: one held down comes
again much sooner, and a terminal does not tell when it is let go."""


class Dialog(StationModal[None]):
    """A step of the procedure.

    Subclasses give ``HEADING``, ``KEYS`` and ``body``. A lost link is shown here; what to do
    about it, if anything, in ``link_lost``.
    """

    AUTO_FOCUS = ""
    HEADING: ClassVar[str] = ""
    KEYS: ClassVar[tuple[DialogKey, ...]] = ()
    LEAVE: ClassVar[str] = "Leave"
    FIRST_WORDS: ClassVar[str] = ""
    AGAIN: ClassVar[Mapping[type[Done[Any]], tuple[str, ...]]] = {}
    """What is offered again when a step of this kind was refused or has failed."""
    FIELDS_FIRST: ClassVar[bool] = False
    """A field with the focus keeps its keys; Escape gives them back first, and then leaves."""

    DEFAULT_CSS = """
    Dialog { align: center middle; }
    Dialog > #dialog {
        width: 80; max-width: 100%; height: auto; max-height: 100%;
        border: heavy $primary; border-title-style: bold; border-title-color: $accent;
        padding: 0 1; background: $surface;
    }
    Dialog > #dialog.-early {
        border: heavy $warning; border-subtitle-color: $background;
        border-subtitle-background: $warning; border-subtitle-style: bold;
    }
    Dialog #body { height: auto; }
    Dialog NoticeLine { max-height: 2; padding: 0; }
    Dialog #said { height: auto; min-height: 1; max-height: 4; }
    Dialog #keys { height: 3; }
    Dialog #keys KeyButton.-stop { dock: right; margin-right: 0; }
    Dialog #keys.-tight KeyButton { padding: 0; margin-right: 0; }
    """

    def __init_subclass__(cls) -> None:
        # Textual reads BINDINGS when the class is made: they must be there before.
        cls.BINDINGS = [key.binding() for key in (*cls.KEYS, *SPEED_KEYS)]
        super().__init_subclass__()

    def __init__(self) -> None:
        super().__init__()
        self._lost = False
        self._finished = False
        self._submitted: type[Done[Any]] | None = None
        self._own_kinds: set[type[Done[Any]]] = set()
        self._offered = {key.action for key in self.KEYS}
        self._blinking: Timer | None = None
        self._early_key = ""

    def compose(self) -> ComposeResult:
        with Vertical(id="dialog") as dialog:
            dialog.border_title = self.HEADING
            with Vertical(id="body"):
                yield from self.body()
            yield NoticeLine()
            yield Words("", id="said", markup=False)
            with Horizontal(id="keys"):
                for key in self.KEYS:
                    if key.button:
                        name = f"key-{_identifier(key.action)}"
                        yield KeyButton(key.shown, key.label, f"screen.{key.action}", id=name)
                yield KeyButton("Esc", self.LEAVE, "screen.leave")
                keys = self.workstation.stop_keys().removesuffix(" ^S")
                yield KeyButton(keys, self.stop_label(), "app.perform('stop')", stop=True)

    def body(self) -> Iterable[Widget]:
        """What stands between the heading and the line that speaks."""
        return ()

    def on_mount(self) -> None:
        self._show_speed()
        self.show_state(self.workstation.state)
        if self.FIRST_WORDS:
            self.say(self.FIRST_WORDS)
        if self._lost:
            # After the first words of the dialog itself.
            self.call_later(self._say_lost)

    def stop_label(self) -> str:
        """What the STOP button says: where this program cannot stop a unit, that."""
        return "STOP: at the unit" if is_typed(self.workstation) else "STOP"

    # -- speaking ----------------------------------------------------------------------------

    def say(self, sentence: str, tone: Tone = "plain") -> None:
        said = Content.assemble((MARKS[tone] + sentence, STYLES[tone]))
        self.query_one("#said", Words).update(said)

    def finish(self, sentence: str, tone: Tone = "good") -> None:
        """The step is done: say so; from now on the key of another step leads on to it."""
        self._finished = True
        self.say(sentence, tone)

    def finished(self) -> bool:
        """Whether there is nothing left here that a key of another step could interrupt."""
        return self._finished

    def leave_saying(self, sentence: str, severity: SeverityLevel = "information") -> None:
        """Leave; the line of the screen below shows the sentence, and none before it."""
        app = self.workstation
        self.dismiss(None)
        for line in app.screen.query(LogLine):
            line.forget_notices()
        app.notify(sentence, severity=severity)

    def ask_reason(
        self, sentence: str = "Type the reason and press Enter; it is written to the session file."
    ) -> None:
        self._finished = False
        field = self.query_one("#reason", Field)
        field.display = True
        field.input.focus()
        self.say(sentence)

    def offer(self, *actions: str) -> None:
        """Show the buttons of these actions; a key whose button is away does nothing."""
        for key in self.KEYS:
            if key.button:
                button = self.query_one(f"#key-{_identifier(key.action)}", KeyButton)
                button.display = key.action in actions
        self._offered = set(actions)
        row = self.query_one("#keys")
        shown = sum(button.cells for button in row.query(KeyButton) if button.display)
        row.set_class(shown > KEYS_COLUMNS, "-tight")

    def offered(self, action: str) -> bool:
        return action in self._offered

    def came_early(self, action: str) -> bool:
        """Whether a key of this action was pressed when it was not offered, and still counts as
        held down."""
        return any(
            key.action == action and self._early_key in key.keys.split(",") for key in self.KEYS
        )

    def under_way(self) -> bool:
        """Whether a step was begun and is not done: an Enter that bounces begins it once."""
        return not self._offered

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """A key belongs to the phase the dialog is in."""
        del parameters
        if any(key.action == action and key.button for key in self.KEYS):
            return self.offered(action)
        return True

    def on_key(self, event: Key) -> None:
        """A key that comes before its question is on the screen is not taken, and that is seen; one
        of another step follows a step that is done or was refused."""
        if self.FIELDS_FIRST and event.key == "escape" and self.focused is not None:
            event.stop()
            event.prevent_default()
            self.set_focus(None)
            return
        if not self.is_current:
            # It came with the key that left: that one has begun the next step already.
            return
        own = [key for key in self.KEYS if event.key in key.keys.split(",")]
        if self.finished() and not own and (step := self._step_of(event.key)) is not None:
            event.stop()
            self.dismiss(None)
            self.workstation.action_perform(step)
            return
        buttons = [key.action for key in own if key.button]
        asked = any(map(self.offered, buttons))
        if (
            buttons
            and not isinstance(self.focused, Input)
            and (not asked or event.key == self._early_key)
        ):
            event.stop()
            event.prevent_default()
            self._early_key = event.key
            why = "let it go first" if asked else "not asked yet"
            self._blink(f"{shown_key(event.key)} not taken: {why}")

    def _step_of(self, key: str) -> str | None:
        """The step of the procedure that a key begins on the screen below."""
        actions = self.workstation.actions
        return next((a.id for a in actions if key in a.keys and a.id in STEPS), None)

    def _blink(self, words: str) -> None:
        frame = self.query_one("#dialog")
        frame.border_subtitle = words
        frame.add_class("-early")
        if self._blinking is not None:
            self._blinking.stop()
        self._blinking = self.set_timer(BLINK_S, self._blinked)

    def _blinked(self) -> None:
        self._early_key = ""
        self.query_one("#dialog").remove_class("-early")
        self._show_speed()

    # -- an emulator's time ------------------------------------------------------------------

    def action_faster(self) -> None:
        self.workstation.action_perform("faster")

    def action_slower(self) -> None:
        self.workstation.action_perform("slower")

    def _show_speed(self) -> None:
        """On the frame, with its keys, where time is emulated."""
        speed = self.workstation.emulated_speed
        words = "" if speed is None else f"time x{speed:g} [+ -]" if speed else "clock paused [+]"
        self.query_one("#dialog").border_subtitle = words

    def palette_refused(self) -> None:
        self.warn("Leave this first (Esc): the palette begins other steps.")

    # -- the station -------------------------------------------------------------------------

    @property
    def worker(self) -> StationWorker:
        return self.workstation.station_worker()

    def submit(
        self,
        kind: type[Done[Result]],
        step: Callable[[Station], Result],
        *,
        moves: bool = False,
        needs_unit: bool = True,
    ) -> None:
        self._finished, self._submitted = False, kind
        self._own_kinds.add(kind)
        self.worker.submit(kind, step, moves=moves, needs_unit=needs_unit)

    def show_state(self, state: StationState) -> None:
        lost = state.live.link is LinkState.LOST
        if lost and not self._lost:
            self._say_lost()
            self.link_lost()
        elif self._lost and not lost:
            self.say("The link is back; the unit was read again.", "good")
            self.link_restored()
        self._lost = lost
        self.state_changed(state)

    def _say_lost(self) -> None:
        self.say(
            f"LINK LOST: {self.workstation.state.live.link_message}. It reconnects automatically; "
            "your entries are kept.",
            "error",
        )

    def state_changed(self, state: StationState) -> None:
        """The station's newest state."""

    def link_lost(self) -> None:
        """The line is gone."""

    def link_restored(self) -> None:
        """The line is back, identity and settings are read again."""

    def step_done(self, done: Done[Any]) -> None:
        if isinstance(done, SpeedTold):
            self._show_speed()
        if isinstance(done, Stopped):
            self.warn("STOPPED. Nothing moves until the next motion command.")

    def step_failed(self, failed: StepFailed) -> None:
        # Of a lost line the state tells.
        if self._lost and isinstance(failed.error, LinkError):
            self._say_lost()
        elif failed.kind not in self._own_kinds:  # what is asked here stays
            self.warn(refusal_words(self.workstation, failed.error), "error")
        else:
            self.say(refusal_words(self.workstation, failed.error), "error")
        if failed.kind is not None and failed.kind is self._submitted:
            # A refusal may send to another step: that one's key leads on to it.
            self._finished = self.workstation.state.attempt is None or bool(failed.error.action)
        if failed.kind is not None and failed.kind in self.AGAIN:
            self.offer(*self.AGAIN[failed.kind])


def reason_field(label: str) -> Field:
    """Where a reason is typed; hidden until ``ask_reason``."""
    field = Field("reason", label)
    field.display = False
    return field


def _identifier(action: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in action).strip("-")


def open_dialog(app: Workstation, dialog: Dialog) -> None:
    """Push a dialog of the procedure, once; without a unit the reason is shown instead."""
    app.station_worker()
    if not any(type(screen) is type(dialog) for screen in app.screen_stack):
        app.push_screen(dialog)
