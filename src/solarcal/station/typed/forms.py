"""What is asked of a person who reads a display: fields with a meaning, and what was typed.

A form is asked through a ``Display``: a file that holds the answers, or whoever answers a
``WaitingDisplay`` on another thread.
"""

import math
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from solarcal.decimals import decimal, whole
from solarcal.errors import ConfigurationError, ProcedureRefused
from solarcal.timescale import Clock, SystemClock

Value = float | int | bool | None
Values = Mapping[str, Value]
"""What was typed, by field; ``None`` where nothing was and nothing had to be."""

_TIME = re.compile(
    r"([0-9]{1,2})[:hH. ]?([0-5][0-9])[:mM. ]?([0-5][0-9](?:[.,][0-9]+)?)s?", re.ASCII
)
YES_NO = {"y": True, "yes": True, "n": False, "no": False}
_SENSES = {"+": 1, "-": -1}


class Kind(StrEnum):
    """What a field holds."""

    DEGREES = "degrees"
    NUMBER = "number"
    COUNTS = "counts"
    TIME = "time"
    """Of day, as a clock shows it: seconds since its midnight."""
    SENSE = "sense"
    """``+`` or ``-``."""
    YES_NO = "yes or no"


class Moment(StrEnum):
    """Which instant belongs to what was typed."""

    FIRST_KEY = "as the typing begins"
    """Whoever types a number has just looked at it."""
    ENTER = "Enter"
    """A time is typed before the display shows it, and sent off as it does."""


class TypedWrong(ConfigurationError):
    """What was typed into a field means nothing; ``field`` is its name."""

    def __init__(self, field: "DisplayField", message: str) -> None:
        super().__init__(f"{field.label}: {message}")
        self.field = field.name


@dataclass(frozen=True, slots=True)
class DisplayField:
    """One value of the display. ``name`` is the word a field book has for it.

    ``optional`` fields may stay empty; ``default`` stands there at first; ``low`` and ``high``
    bound what can be meant.
    """

    name: str
    label: str
    kind: Kind = Kind.DEGREES
    unit: str = "deg"
    optional: bool = False
    default: str = ""
    hint: str = ""
    low: float = -math.inf
    high: float = math.inf

    def value(self, text: str) -> Value:
        """What a text means, a comma taken for a point; TypedWrong where it can mean nothing."""
        text = plain_text(text)
        if not text:
            if self.optional:
                return None
            raise TypedWrong(self, "is missing")
        found = self._meaning(text)
        if found is None:
            raise TypedWrong(self, f"{text!r} is not {_WANTED[self.kind]}")
        if not isinstance(found, bool) and not self.low <= found <= self.high:
            raise TypedWrong(self, f"{text} is not between {self.low:g} and {self.high:g}")
        return found

    def _meaning(self, text: str) -> Value:
        match self.kind:
            case Kind.DEGREES | Kind.NUMBER:
                return number(text)
            case Kind.COUNTS:
                with suppress(ConfigurationError):
                    return whole(text)
                return None
            case Kind.TIME:
                return time_of_day_s(text)
            case Kind.SENSE:
                return _SENSES.get(text)
            case Kind.YES_NO:
                return YES_NO.get(text.lower())


_WANTED = {
    Kind.DEGREES: "a number of degrees",
    Kind.NUMBER: "a number",
    Kind.COUNTS: "a whole number of counts",
    Kind.TIME: "a time like 08:15:30",
    Kind.SENSE: "+ or -",
    Kind.YES_NO: "yes or no",
}


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something typed that cannot well be so; ``field`` is where to look first."""

    sentence: str
    field: str = ""


Doubting = Callable[[Mapping[str, str], float], Sequence[Doubt]]
"""Texts that mean something, and the laptop's UTC they were read at, to what is doubtful."""


@dataclass(frozen=True, slots=True)
class DisplayForm:
    """What to do at the unit, and then what to type.

    ``word`` is the step's name in a field book and in the session file; ``key_in`` are values to
    key into the unit first, by name; ``zone_west_h`` is the unit's, where its clock matters.
    """

    word: str
    title: str
    at_the_unit: tuple[str, ...]
    fields: tuple[DisplayField, ...]
    moment: Moment = Moment.FIRST_KEY
    key_in: tuple[tuple[str, str], ...] = ()
    doubts: Doubting = lambda texts, read_utc_s: ()
    zone_west_h: float | None = None

    def field(self, name: str) -> DisplayField:
        """The field of that name."""
        return next(field for field in self.fields if field.name == name)

    def texts(self, typed: Mapping[str, str]) -> dict[str, str]:
        """What stands in every field, in the form's order: what was typed, else its default."""
        return {
            field.name: plain_text(typed.get(field.name, field.default)) for field in self.fields
        }

    def values(self, typed: Mapping[str, str]) -> dict[str, Value]:
        """What was typed as numbers; TypedWrong names the first field that means nothing."""
        return {
            field.name: field.value(typed.get(field.name, field.default)) for field in self.fields
        }


@dataclass(frozen=True, slots=True)
class TypedAnswer:
    """A form as it was answered.

    Attributes
    ----------
    texts : by field, as typed.
    read_utc_s : the laptop's UTC at the moment that belongs to them.
    kept : what was doubted and kept all the same.
    corrected : what had been typed before, where a doubt made the technician look again.
    """

    form: DisplayForm
    texts: Mapping[str, str]
    read_utc_s: float
    kept: tuple[str, ...] = ()
    corrected: tuple[Mapping[str, str], ...] = ()

    @property
    def values(self) -> dict[str, Value]:
        return self.form.values(self.texts)


def looked_again(before: Mapping[str, str], after: Mapping[str, str]) -> bool:
    """Whether a correction is another look at the axes, not a slip of typing put right."""
    return all(before.get(name) != after.get(name) for name in ("ax1", "ax2"))


class Display(Protocol):
    """Whoever can answer a form."""

    def ask(self, form: DisplayForm) -> TypedAnswer:
        """The form, answered; called from the thread that talks to the station, and may wait.

        Raises
        ------
        ProcedureRefused
            It was given up; nothing was typed then.
        InputFileError
            A file that holds the answers holds none that can be.
        """
        ...


# -- texts -----------------------------------------------------------------------------------


def plain_text(text: str) -> str:
    """A typed text as it is kept: no blanks around it, a point for a comma, a plain minus."""
    return text.strip().replace("−", "-").replace(",", ".").removesuffix("°").strip()


def number(text: str) -> float | None:
    """The number a text is; no exponents, no names of numbers."""
    try:
        return decimal(text, exponent=False) + 0.0
    except ConfigurationError:
        return None


def decimals(text: str) -> int:
    """How many decimals a text has."""
    return len(plain_text(text).partition(".")[2])


def time_of_day_s(text: str) -> float | None:
    """Seconds since midnight of ``08:15:30``, ``08:15:30.5`` or ``081530``."""
    match = _TIME.fullmatch(text)
    if match is None or int(match[1]) > 23:
        return None
    return 3600.0 * int(match[1]) + 60.0 * int(match[2]) + float(match[3].replace(",", "."))


GIVEN_UP = "given up: nothing was typed, nothing is recorded"


class AskedForm:
    """A form that waits for its answer.

    Attributes
    ----------
    form : what is asked.
    clock : the laptop's, for the moment of a look.
    """

    def __init__(self, form: DisplayForm, clock: Clock) -> None:
        self.form = form
        self.clock = clock
        self._answer: TypedAnswer | None = None
        self._done = threading.Event()

    @property
    def done(self) -> bool:
        """Answered or given up."""
        return self._done.is_set()

    def answer(self, answer: TypedAnswer | None) -> None:
        """The answer, or ``None``: given up. The first one counts."""
        if not self._done.is_set():
            self._answer = answer
            self._done.set()

    def wait(self) -> TypedAnswer:
        """The answer, once there is one; ProcedureRefused where it was given up."""
        self._done.wait()
        if self._answer is None:
            raise ProcedureRefused(GIVEN_UP)
        return self._answer


class WaitingDisplay:
    """A ``Display`` whose forms are answered on another thread, which is waited for.

    ``post``: takes a form to who answers it; safe to call from the thread that asks.
    """

    def __init__(self, post: Callable[[AskedForm], object], clock: Clock | None = None) -> None:
        self._post = post
        self._clock = clock or SystemClock()
        self._asked: AskedForm | None = None
        self._closed = False

    def ask(self, form: DisplayForm) -> TypedAnswer:
        if self._closed:
            raise ProcedureRefused(GIVEN_UP)
        self._asked = AskedForm(form, self._clock)
        self._post(self._asked)
        return self._asked.wait()

    @property
    def asking(self) -> bool:
        """A form waits for its answer."""
        return self._asked is not None and not self._asked.done

    def close(self) -> None:
        """Ask no more; a form that still waits is given up."""
        self._closed = True
        if self._asked is not None:
            self._asked.answer(None)
