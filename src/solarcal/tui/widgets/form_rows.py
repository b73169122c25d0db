"""The rows of a calculator's form: a text field or a choice, with label and unit."""

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.message import Message
from textual.widgets import Input, Static

from solarcal.instruments.form import Field


class ChoiceBox(Static, can_focus=True):
    """One of a few words; left, right, space or a click goes to another."""

    class Changed(Message):
        """Another choice was made."""

    def __init__(self, choices: tuple[str, ...], value: str) -> None:
        super().__init__()
        self._choices = choices
        self.value = value

    def on_mount(self) -> None:
        self.choose(self.value)

    def choose(self, value: str) -> None:
        """Show this one; the first where it is none of them."""
        self.value = value if value in self._choices else self._choices[0]
        self.update(Content(f"‹ {self.value} ›"))

    def on_key(self, event: events.Key) -> None:
        # Not a binding: that would be looked up when the next arrow may have moved the focus.
        step = {"right": 1, "space": 1, "left": -1}.get(event.key)
        if step is not None:
            event.stop()
            self.turn(step)

    def turn(self, step: int) -> None:
        """To the next choice, or the one before."""
        at = self._choices.index(self.value)
        self.choose(self._choices[(at + step) % len(self._choices)])
        self.post_message(self.Changed())

    def on_click(self) -> None:
        self.turn(1)


class FormRow(Horizontal):
    """Label, what is asked for, unit."""

    def __init__(self, field: Field, value: str) -> None:
        super().__init__(classes="row")
        self.field = field
        self._value = value

    def compose(self) -> ComposeResult:
        yield Static(self.field.label, classes="label", markup=False)
        if self.field.choices:
            yield ChoiceBox(self.field.choices, self._value)
        else:
            yield Input(self._value, placeholder=self.field.hint, compact=True)
            if self.field.unit:
                yield Static(self.field.unit, classes="unit", markup=False)

    @property
    def entry(self) -> Input | ChoiceBox:
        """What takes the focus."""
        return self.query_one(ChoiceBox) if self.field.choices else self.query_one(Input)

    @property
    def value(self) -> str:
        return self.entry.value.strip()

    def fill(self, value: str) -> None:
        """Put this there."""
        entry = self.entry
        if isinstance(entry, ChoiceBox):
            entry.choose(value)
        else:
            entry.value = value


class FormRows(Vertical):
    """All rows; scrolls to the one with the focus, without keys of its own."""

    DEFAULT_CSS = """
    FormRows { overflow-y: auto; scrollbar-size: 1 1; width: 39; height: 1fr; }
    FormRows .row { height: 1; padding: 0 1; }
    FormRows .label { width: 19; }
    FormRows Input { width: 1fr; height: 1; border: none; padding: 0; background: $panel; }
    FormRows Input:focus { background-tint: $foreground 20%; }
    FormRows ChoiceBox { width: 1fr; height: 1; }
    FormRows ChoiceBox:focus { text-style: bold reverse; }
    FormRows .unit { width: 9; padding: 0 0 0 1; color: $text-muted; }
    FormRows .-wrong .label { background: $error; color: $background; text-style: bold; }
    """

    def __init__(self, fields: tuple[Field, ...], values: dict[str, str]) -> None:
        super().__init__()
        self._fields, self._values = fields, values

    def compose(self) -> ComposeResult:
        for field in self._fields:
            yield FormRow(field, self._values[field.name])

    def values(self) -> dict[str, str]:
        """What stands in every field."""
        return {row.field.name: row.value for row in self.query(FormRow)}

    def fill(self, values: dict[str, str]) -> None:
        """Put these into the fields."""
        for row in self.query(FormRow):
            row.fill(values[row.field.name])

    def mark_wrong(self, name: str | None) -> None:
        """Mark the field that cannot be, or none."""
        for row in self.query(FormRow):
            row.set_class(row.field.name == name, "-wrong")
