"""A form of what a unit's display shows: typed, held against the Sun at once, corrected or kept."""

from collections.abc import Callable, Iterable, Mapping
from typing import ClassVar

from textual.containers import VerticalScroll
from textual.css.query import NoMatches
from textual.events import Key
from textual.widget import Widget
from textual.widgets import Input, Static

from solarcal.station.news import StepFailed, Stopped
from solarcal.station.typed.forms import (
    AskedForm,
    Doubt,
    Moment,
    TypedAnswer,
    TypedWrong,
    looked_again,
)
from solarcal.timescale import second_of_day
from solarcal.tui.dialogs.dialog import Dialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.lines import Field, Words

CLOCK_EVERY_S = 0.2


def _name_of(typed_into: Input) -> str | None:
    """Of the field an input belongs to."""
    parent = typed_into.parent
    return (parent.id or "").removeprefix("typed-") or None if parent is not None else None


class DisplayFormScreen(Dialog):
    """Enter goes from field to field; in the last one, and after a doubt, it finishes.

    Escape leaves the field first, so that no half-typed form is lost by one key; then it gives the
    form up.
    """

    LEAVE = "Give up"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("done", "Done", "ctrl+w", "^W"),
        DialogKey("keep", "Keep as typed", "f3,k", "F3 k"),
        DialogKey("now", "Looked NOW", "f2,n", "F2 n"),
    )

    DEFAULT_CSS = """
    DisplayFormScreen #at-the-unit { height: auto; margin-bottom: 1; }
    DisplayFormScreen #fields { height: auto; max-height: 12; scrollbar-size-vertical: 1; }
    DisplayFormScreen Field > .label { width: 29; }
    DisplayFormScreen Field > Input { max-width: 16; }
    DisplayFormScreen Field.-roomy > Input { max-width: 40; }
    DisplayFormScreen Field > Input.-wrong { background: $error 40%; text-style: bold; }
    DisplayFormScreen #clock { height: 1; color: $text-muted; }
    """

    def __init__(self, asked: AskedForm) -> None:
        super().__init__()
        self._asked = asked
        self._form = asked.form
        self._looked_utc_s: float | None = None
        self._looked_again_utc_s: float | None = None
        self._doubts: tuple[Doubt, ...] = ()
        self._doubted: dict[str, str] | None = None
        self._corrected: list[Mapping[str, str]] = []
        # Priority: a field would take them for its own, or tell of them a turn too late for what is
        # typed behind them.
        self._bindings.bind("ctrl+w", "done", show=False, priority=True)
        self._bindings.bind("enter", "enter", show=False, priority=True)
        self._bindings.bind("down", "next_field", show=False, priority=True)
        self._bindings.bind("up", "previous_field", show=False, priority=True)

    def stop_label(self) -> str:
        return "STOP: at the unit"

    # -- what is shown -------------------------------------------------------------------------

    def body(self) -> Iterable[Widget]:
        yield Static("\n".join(self._form.at_the_unit), id="at-the-unit", markup=False)
        key_in = dict(self._form.key_in)
        with VerticalScroll(id="fields", can_focus=False):
            for one in self._form.fields:
                label, wanted = one.label, key_in.get(one.name.upper())
                if wanted is not None:
                    label = f"{one.name.upper()}  key in {wanted:>13}"
                field = Field(f"typed-{one.name}", label, one.unit, one.default)
                field.set_class(bool(one.hint), "-roomy")
                yield field
        yield Words("", id="clock")

    def on_mount(self) -> None:
        super().on_mount()
        self.query_one("#dialog").border_title = self._form.title
        for one in self._form.fields:
            self._field(one.name).input.placeholder = one.hint
        self._offer()
        self._show_clock()
        self.set_interval(CLOCK_EVERY_S, self._show_clock)
        self._focus(self._form.fields[0].name)
        self.say(self._first_words())

    def _first_words(self) -> str:
        if self._form.moment is Moment.ENTER:
            return "Enter: next field. In the last field: at the MOMENT the display shows it."
        if self._form.key_in:
            return "Type each value as the DISPLAY shows it, not as shown here."
        return "Type the digits as displayed; the time is taken when you begin to type."

    def _offer(self) -> None:
        keep = ["keep"] if self._doubts else []
        now = ["now"] if any(field.name == "ax1" for field in self._form.fields) else []
        self.offer("done", *keep, *now)

    def _show_clock(self) -> None:
        utc_s = self._asked.clock.utc_s()
        zone_h = self._form.zone_west_h
        words = f"Laptop {second_of_day(utc_s)} UTC"
        if zone_h is not None:
            words += f", local standard time {second_of_day(utc_s - 3600.0 * zone_h)}"
        if self._looked_utc_s is not None and self._form.moment is Moment.FIRST_KEY:
            words += f".  Looked at {second_of_day(self._looked_utc_s)} UTC"
        try:
            self.query_one("#clock", Words).update(words)
        except NoMatches:
            # The timer may fire once more while the screen is taken down.
            return

    # -- keys ----------------------------------------------------------------------------------

    def on_input_changed(self, event: Input.Changed) -> None:
        event.stop()
        name = _name_of(event.input)
        if name is None or event.value == self._form.field(name).default:
            return
        event.input.remove_class("-wrong")
        now_s = self._asked.clock.utc_s()
        if self._looked_utc_s is None:
            self._looked_utc_s = now_s
            self._show_clock()
        if self._doubted is not None and self._looked_again_utc_s is None:
            self._looked_again_utc_s = now_s

    def action_enter(self) -> None:
        """To the next field; in the last one, after a doubt and outside the fields: done."""
        at = self._at()
        if at is None or self._doubts or at == len(self._form.fields) - 1:
            self.action_done()
            return
        name = self._form.fields[at].name
        self.action_next_field()
        self._when_typed(name, lambda: self._look_at(name))

    def on_key(self, event: Key) -> None:
        if event.key == "escape" and self.focused is not None:
            event.stop()
            event.prevent_default()
            self.set_focus(None)
            self.say("Enter or ^W finishes, Escape again cancels; Down goes to the fields.")

    def action_done(self) -> None:
        # First of all: the moment of a clock is this key.
        now_s = self._asked.clock.utc_s()
        at = self._at()
        name = self._form.fields[0 if at is None else at].name
        self._when_typed(name, lambda: self._finish(now_s))

    def _when_typed(self, name: str, then: Callable[[], None]) -> None:
        """Once the field has taken in what was typed into it before the key that asks for this.

        The keys bound here come to the screen at once, letters to a field in its own turn: whoever
        types fast, or into a slow terminal, must not have them change places.
        """
        self._field(name).input.call_later(then)

    def action_now(self) -> None:
        """The display was looked at this moment."""
        self._looked_utc_s = self._looked_again_utc_s = self._asked.clock.utc_s()
        self._show_clock()
        self.say("The moment is taken anew.")

    def action_keep(self) -> None:
        """What was doubted is what the display shows."""
        if not self._doubts or self._doubted is None:
            return
        if self._texts() != self._doubted:
            self.say("It was changed since: Enter looks at it again first.", "warning")
            return
        kept = tuple(doubt.sentence for doubt in self._doubts)
        self._answer(self._doubted, kept)

    def action_next_field(self) -> None:
        self._move(1)

    def action_previous_field(self) -> None:
        self._move(-1)

    def _move(self, step: int) -> None:
        at, last = self._at(), len(self._form.fields) - 1
        self._focus(self._form.fields[0 if at is None else min(max(at + step, 0), last)].name)

    def _at(self) -> int | None:
        """Which field the next key is for."""
        # The screen knows its focused widget at once; the widget hears of it a turn later.
        focused, fields = self.focused, self._form.fields
        inputs = [self._field(field.name).input for field in fields]
        return next((i for i, one in enumerate(inputs) if one is focused), None)

    def action_leave(self) -> None:
        self._asked.answer(None)
        self.dismiss(None)

    # -- finishing -----------------------------------------------------------------------------

    def _finish(self, now_s: float) -> None:
        texts = self._texts()
        try:
            self._form.values(texts)
        except TypedWrong as error:
            self._wrong(error.field, str(error))
            return
        if self._doubted is not None and texts != self._doubted:
            self._corrected.append({n: text for n, text in self._doubted.items() if text})
            if looked_again(self._doubted, texts) and self._looked_again_utc_s is not None:
                self._looked_utc_s = self._looked_again_utc_s
        if self._form.moment is Moment.ENTER or self._looked_utc_s is None:
            self._looked_utc_s = now_s
        self._doubts = tuple(self._form.doubts(texts, self._looked_utc_s))
        self._looked_again_utc_s = None
        if not self._doubts:
            self._answer(texts, ())
            return
        self._doubted = texts
        self._offer()
        field = next((d.field for d in self._doubts if d.field in texts), "")
        self._wrong(field, " ".join(doubt.sentence for doubt in self._doubts), doubted=True)

    def _answer(self, texts: Mapping[str, str], kept: tuple[str, ...]) -> None:
        looked = self._looked_utc_s
        assert looked is not None  # _finish has taken it
        self._asked.answer(TypedAnswer(self._form, texts, looked, kept, tuple(self._corrected)))
        self.dismiss(None)

    def _wrong(self, name: str, sentence: str, *, doubted: bool = False) -> None:
        if name:
            self._field(name).input.add_class("-wrong")
            self._focus(name)
        ending = (
            " Correct it and press Enter, or press F3 if the display shows it." if doubted else ""
        )
        self.say(sentence + ending, "warning" if doubted else "error")

    def _look_at(self, name: str) -> None:
        """Say at once what means nothing, and go back to it."""
        try:
            self._form.field(name).value(self._field(name).value)
        except TypedWrong as error:
            self._wrong(name, str(error))

    def _texts(self) -> dict[str, str]:
        return self._form.texts(
            {one.name: self._field(one.name).value for one in self._form.fields}
        )

    def _focus(self, name: str) -> None:
        # At once, not by the widget's own focus() a turn later: the next key is for this field.
        self.set_focus(self._field(name).input)

    def _field(self, name: str) -> Field:
        return self.query_one(f"#typed-{name}", Field)

    # -- the station ---------------------------------------------------------------------------

    def step_failed(self, failed: StepFailed) -> None:
        # Of the step that asks this form the screen below tells.
        if failed.kind is Stopped:
            self.say(str(failed.error), "error")
