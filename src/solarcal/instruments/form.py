"""What a field calculator asks for: fields with unit, range and default, and their texts read.

The texts come from a form on the screen or from options of a command; either way they are read
here, and every error names the field it is about.
"""

import importlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from solarcal.decimals import between, decimal, shortened
from solarcal.errors import ConfigurationError
from solarcal.site import Site, day_utc_s
from solarcal.timescale import parse_utc

if TYPE_CHECKING:
    from solarcal.report.scales import Sheet

Draw = Callable[["Sheet"], str]
"""The drawing for a sheet as text with ANSI colours."""


@dataclass(frozen=True, slots=True)
class Drawing:
    """A drawing not yet drawn. ``height`` is what it takes when printed; None: a whole screen."""

    name: str
    draw: Draw
    height: int | None = 14


@dataclass(frozen=True, slots=True)
class Answer:
    """The JSON document, what is printed in its order, and a sketch only a screen has room for."""

    document: dict[str, Any]
    blocks: tuple[str | Drawing, ...]
    sketch: Drawing | None = None

    @property
    def lines(self) -> list[str]:
        """All the text."""
        text = [block.split("\n") for block in self.blocks if isinstance(block, str)]
        return [line for block in text for line in block]

    @property
    def drawings(self) -> tuple[Drawing, ...]:
        """The sketch and whatever is drawn between the text."""
        drawn = tuple(block for block in self.blocks if isinstance(block, Drawing))
        return drawn if self.sketch is None else (self.sketch, *drawn)


def labelled(*rows: tuple[str, str, str]) -> list[str]:
    """Lines of a label, a number and its unit."""
    return [f"  {label:<24}{value:>10} {unit}".rstrip() for label, value, unit in rows]


def answered(document: dict[str, Any], lines: Iterable[str], name: str, draw: Draw) -> Answer:
    """Text, and a sketch for where a screen has room for one."""
    return Answer(document, ("\n".join(lines),), Drawing(name, draw))


@dataclass(frozen=True, slots=True)
class Field:
    """One thing asked for.

    Parameters
    ----------
    name, label, unit : ``label`` is the form's, at most 19 characters.
    default : what counts where nothing is given.
    example : what the form shows at first instead; a command has no such value.
    hint : what an empty field means, in the form.
    choices : makes it one of these words.
    low, high : both allowed.
    count : that many numbers with spaces between.
    repeat : the form has that many rows of it; a command's option may be repeated at will.
    help : of the option; without one the command has no such option.
    flag : of the option where it is not ``--name``; fields with the same flag share the option.
        Several flags, one for each of ``count`` numbers, are separated by a space.
    metavar : of the option.
    on_form : whether the form has it.
    required : the command cannot do without.
    """

    name: str
    label: str
    unit: str = ""
    default: str = ""
    example: str = ""
    hint: str = ""
    choices: tuple[str, ...] = ()
    low: float = -math.inf
    high: float = math.inf
    count: int = 1
    repeat: int = 0
    help: str = ""
    flag: str = ""
    metavar: str = ""
    on_form: bool = True
    required: bool = False

    @property
    def first_text(self) -> str:
        """What the form shows at first."""
        return self.example or self.default

    @property
    def option(self) -> str:
        """The flag, or flags, of the command."""
        return self.flag or f"--{self.name.replace('_', '-')}"

    def rows(self) -> "Iterator[Field]":
        """The rows of the form: itself, or one for each repetition."""
        if not self.on_form:
            return
        if not self.repeat:
            yield self
        for number in range(1, self.repeat + 1):
            yield replace(self, name=f"{self.name}{number}", label=f"{number}: {self.label}")


@dataclass(frozen=True, slots=True)
class Flag:
    """An option that sets fields: a switch, or another way to give a field its text.

    ``to`` takes the option's own words; ``sets`` are texts of other fields where those have none;
    options with the same word in ``exclusive`` exclude one another; ``repeat``: every one given
    fills a row of its own, one word with commas holding several numbers.
    """

    flag: str
    help: str
    sets: Mapping[str, str] = field(default_factory=dict)
    to: str = ""
    metavar: str = ""
    exclusive: str = ""
    repeat: bool = False


class FormError(ConfigurationError):
    """A field that cannot be, by its label; ``missing`` where it holds nothing yet."""

    def __init__(self, name: str, label: str, message: str, *, missing: bool = False) -> None:
        super().__init__(f"{label} is missing" if missing else f"{label}: {message}")
        self.field = name
        self.missing = missing


class Form:
    """The texts of a calculator's fields, read.

    Parameters
    ----------
    fields, values : what is asked, and the texts; a field without one holds its first text.
    now_utc_s : what an empty time means, POSIX UTC seconds.
    labels : for a command: how errors call a field. There a decimal comma is refused.
    """

    def __init__(
        self,
        fields: tuple[Field, ...],
        values: Mapping[str, str],
        now_utc_s: float,
        labels: Mapping[str, str] | None = None,
    ) -> None:
        self._fields = {one.name: one for one in fields}
        self._values = values
        self._labels = labels or {}
        self.now_utc_s = now_utc_s
        self.of_command = bool(labels)

    def text(self, name: str) -> str:
        """The text of a field."""
        found = self._values.get(name)
        return (self._field(name).first_text if found is None else found).strip()

    def choice(self, name: str) -> str:
        """One of the field's choices."""
        text, choices = self.text(name), self._field(name).choices
        if text not in choices:
            raise self.error(name, f"{shortened(text)} is none of {', '.join(choices)}")
        return text

    def number(self, name: str) -> float:
        """The number of a field; a comma is taken for a decimal point."""
        found = self.optional(name)
        if found is None:
            raise self.missing(name)
        return found

    def optional(self, name: str) -> float | None:
        """The number of a field, or None where it is empty."""
        text = self.text(name)
        return self._number(name, text) if text else None

    def numbers(self, name: str) -> tuple[float, ...] | None:
        """The numbers of a field that takes several, or None where it is empty."""
        text, count = self.text(name), self._field(name).count
        if not text:
            return None
        parts = text.replace(";", " ").split()
        if len(parts) != count:
            raise self.error(name, f"write {count} numbers, not {shortened(text)}")
        return tuple(self._number(name, part) for part in parts)

    def pair(self, name: str) -> tuple[float, float] | None:
        """Two numbers, or None."""
        found = self.numbers(name)
        return None if found is None else (found[0], found[1])

    def filled_rows(self, name: str) -> list[str]:
        """The names of a repeated field's rows that hold something."""
        found = []
        number = 1
        while f"{name}{number}" in self._values or number <= self._fields[name].repeat:
            if self._values.get(f"{name}{number}", "").strip():
                found.append(f"{name}{number}")
            number += 1
        return found

    def utc_s(self, name: str) -> float:
        """The instant of a field, POSIX UTC seconds; now where it is empty."""
        text = self.text(name)
        return self.instant(name, text) if text not in ("", "now") else self.now_utc_s

    def day_utc_s(self, name: str, site: Site) -> float:
        """An instant of the day meant: a date alone is the site's own day, at its noon."""
        text = self.text(name)
        try:
            return day_utc_s(text, site) if text not in ("", "now") else self.now_utc_s
        except ConfigurationError as error:
            raise self.error(name, str(error)) from None

    def instant(self, name: str, text: str) -> float:
        """An ISO 8601 text of this field."""
        try:
            return parse_utc(text)
        except ConfigurationError as error:
            raise self.error(name, str(error)) from None

    def site(self) -> Site:
        """The place of the fields lat, lon and elevation."""
        return Site(self.number("lat"), self.number("lon"), self.number("elevation"))

    def error(self, name: str, message: str) -> FormError:
        """An error of this field, to be raised."""
        return FormError(name, self.label(name), message)

    def missing(self, name: str) -> FormError:
        """The error of a field that must not be empty."""
        return FormError(name, self.label(name), "", missing=True)

    def number_in(self, name: str, text: str) -> float:
        """A number among other words of a field, without the field's range."""
        try:
            return decimal(text, comma=not self.of_command)
        except ConfigurationError as error:
            raise self.error(name, str(error)) from None

    def _number(self, name: str, text: str) -> float:
        value, asked = self.number_in(name, text), self._field(name)
        if not asked.low <= value <= asked.high:
            raise self.error(name, f"{value:g} is not {between(asked.low, asked.high)}")
        return value

    def _field(self, name: str) -> Field:
        found = self._fields.get(name)
        return self._fields[name.rstrip("0123456789")] if found is None else found

    def label(self, name: str) -> str:
        """How errors call a field."""
        label = self._labels.get(name) or self._labels.get(name.rstrip("0123456789"))
        if label is not None:
            return label
        asked = self._field(name)
        return asked.label if asked.name == name else f"{name[len(asked.name) :]}: {asked.label}"


@dataclass(frozen=True, slots=True)
class Instrument:
    """A field calculator: what it asks, and the function that answers.

    Parameters
    ----------
    id, group, title, purpose : for the list of calculators.
    physics : module of this package; its function of the same name as ``function`` takes a
        :class:`Form` and returns the Answer. Imported when first asked: it needs numpy.
    fields, flags : what is asked; further options of the command.
    command : the words that ask for it on the command line.
    json_keys : of the document, for the command's help.
    """

    id: str
    group: str
    title: str
    purpose: str
    physics: str
    function: str
    fields: tuple[Field, ...]
    command: str
    json_keys: str = ""
    flags: tuple[Flag, ...] = ()

    @property
    def rows(self) -> tuple[Field, ...]:
        """The rows of its form."""
        return tuple(row for one in self.fields for row in one.rows())

    def form(
        self, values: Mapping[str, str], now_utc_s: float, labels: Mapping[str, str] | None = None
    ) -> Form:
        """Its fields with these texts."""
        return Form(self.fields, values, now_utc_s, labels)

    def answer(self, form: Form) -> "Answer":
        """What it answers; runs on any thread, and does not draw.

        Raises
        ------
        ConfigurationError
            Something asked cannot be; a :class:`FormError` where one field is to blame.
        """
        # In this one place: forms and helps are shown without numpy.
        module = importlib.import_module(f"solarcal.instruments.{self.physics}")
        answer: Answer = getattr(module, self.function)(form)
        return answer
