"""A text field with its label before it and its unit behind it, one row high."""

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Input, Label

from solarcal.decimals import decimal
from solarcal.errors import ConfigurationError


class Field(Horizontal):
    """``value`` is what was typed; ``number`` what it means."""

    DEFAULT_CSS = """
    Field { height: 1; }
    Field > .label { width: 28; }
    Field > Input { width: 1fr; max-width: 40; background: $panel; }
    Field > .unit { width: auto; padding-left: 1; color: $text-muted; }
    """

    def __init__(self, id: str, label: str, unit: str = "", value: str = "") -> None:
        super().__init__(id=id)
        self._label, self._unit, self._value = label, unit, value

    def compose(self) -> ComposeResult:
        yield Label(self._label, classes="label", markup=False)
        yield Input(self._value, compact=True)
        if self._unit:
            yield Label(self._unit, classes="unit", markup=False)

    @property
    def input(self) -> Input:
        return self.query_one(Input)

    @property
    def value(self) -> str:
        return self.input.value.strip()

    def number(self) -> float:
        """The number typed; a comma is taken for a decimal point.

        Raises
        ------
        ConfigurationError
            It is none.
        """
        try:
            return decimal(self.value, comma=True)
        except ConfigurationError as error:
            raise ConfigurationError(f"{self._label}: {error}") from None
