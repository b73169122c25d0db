"""A field book: what was done at a unit and what its display showed, one line a step.

    2026-06-03                                   the day, UTC by the laptop
    15:30:05 open       clock 08:30:02           (P1..P6, O1, O2 left out: zero)
    15:34:00 clock      clock 08:34:00
    15:40:00 reference  complete yes found1 3 found2 -1
    15:58:20 offset     ax1 81.24 ax2 56.10 o1 -0.31 o2 0.12 came1 - came2 -
    15:59:00 initialise
    16:00:10 point      yes yes yes ax1 80.90 ax2 55.80 o1 -0.31 o2 0.12 store
    16:31:00 point      yes no                   # the first NO ends the attempt

A time is the laptop's, UTC, at the look. Then the step, the answers to its questions, and names and
values in any order. ``again`` corrects what the line before had wrong, ``keep`` lets it stand.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from solarcal.errors import ConfigurationError, InputFileError
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.station.typed.forms import (
    YES_NO,
    DisplayForm,
    Moment,
    TypedAnswer,
    TypedWrong,
    looked_again,
    time_of_day_s,
)
from solarcal.timescale import format_utc, parse_utc

STEPS = (
    "open", "clock", "reference", "offset", "initialise", "point", "check", "upload", "zero",
    "rollback", "held", "note", "void", "again", "keep",
)  # fmt: skip
NAMES = (
    *(name.lower() for name in COEFFICIENT_NAMES), "o1", "o2", "ax1", "ax2", "came1", "came2",
    "sun1", "sun2", "time", "clock", "complete", "found1", "found2", "stored",
)  # fmt: skip
ANSWERING = {"point": ("point", "check"), "upload": ("upload", "rollback")}
"""Steps that answer a form of another name than their own."""

TO_THE_END = ("reject", "because")
"""Words that take the rest of the line as a reason."""

_DAY = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}", re.ASCII)


@dataclass(frozen=True, slots=True)
class Entry:
    """One line: where it stands, when it was, and what it says.

    ``stores``: the result of a point is stored, rejected, or (``None``) not decided; ``reason`` is
    that of a rejection, of an overruled guard, or the text of a remark.
    """

    where: str
    utc_s: float
    step: str
    answers: tuple[bool, ...] = ()
    values: Mapping[str, str] = field(default_factory=dict)
    stores: bool | None = None
    reason: str = ""

    def error(self, message: str) -> InputFileError:
        """An error of this line, to be raised."""
        return InputFileError(f"{self.where}: {message}")


def read_entries(lines: Iterable[str], name: str) -> Iterator[Entry]:
    """The entries of a field book, line by line as they come.

    Raises
    ------
    InputFileError
        A line that says nothing, or a time before the one above it; names file and line.
    """
    day, last_utc_s = "", float("-inf")
    for number, line in enumerate(lines, start=1):
        where = f"{name}:{number}"
        words = re.sub(r"(^|\s)#.*", "", line).split()
        if not words:
            continue
        if len(words) == 1 and _DAY.fullmatch(words[0]):
            _instant(words[0], where)
            day = words[0]
            continue
        utc_s = _time(words[0], day, where)
        if utc_s < last_utc_s:
            raise InputFileError(
                f"{where}: {format_utc(utc_s, 0)} is before the line above; a new day needs a line "
                "with its date"
            )
        last_utc_s = utc_s
        yield _entry(words[1:], utc_s, where)


def _time(text: str, day: str, where: str) -> float:
    if "T" in text:
        return _instant(text, where)
    seconds = time_of_day_s(text) if text.count(":") == 2 else None
    if seconds is None:
        raise InputFileError(
            f"{where}: {text!r} is not a time like 15:30:05; a line begins with the laptop's UTC"
        )
    if not day:
        raise InputFileError(f"{where}: which day? A line with the date alone comes first")
    return round(_instant(day, where) + seconds, 3)


def _instant(text: str, where: str) -> float:
    try:
        return parse_utc(text)
    except ConfigurationError as error:
        raise InputFileError(f"{where}: {error}") from None


def _entry(words: list[str], utc_s: float, where: str) -> Entry:
    if not words:
        raise InputFileError(f"{where}: a step is missing after the time")
    step, rest = words[0].lower(), words[1:]
    if step not in STEPS:
        raise InputFileError(
            f"{where}: {words[0]!r} is not a step; the steps are: {', '.join(STEPS)}"
        )
    if step in ("note", "void", "keep"):
        return Entry(where, utc_s, step, reason=" ".join(rest))
    answers: list[bool] = []
    while rest and rest[0].lower() in YES_NO:
        answers.append(YES_NO[rest.pop(0).lower()])
    values: dict[str, str] = {}
    stores: bool | None = None
    reason = ""
    while rest:
        word = rest.pop(0).lower()
        if word == "store":
            stores = True
        elif word in TO_THE_END:
            stores = False if word == "reject" else stores
            reason, rest = " ".join(rest), []
            if not reason:
                raise InputFileError(f"{where}: {word} what? A reason follows it")
        elif word not in NAMES:
            raise InputFileError(
                f"{where}: {word!r} is not the name of a value; the names are: {', '.join(NAMES)}"
            )
        elif word in values:
            raise InputFileError(f"{where}: {word} is given twice")
        elif not rest:
            raise InputFileError(f"{where}: {word} has no value")
        else:
            values[word] = rest.pop(0)
    return Entry(where, utc_s, step, tuple(answers), values, stores, reason)


class BookClock:
    """The laptop's clock as the book tells it: it stands at the line that is being done."""

    def __init__(self) -> None:
        self._utc_s = 0.0

    def utc_s(self) -> float:
        return self._utc_s

    def wait(self, seconds: float) -> None:
        """Nothing waits in a book; the next line says how late it has become."""
        del seconds

    def stand_at(self, utc_s: float) -> None:
        """It is as late as that line says."""
        self._utc_s = utc_s


class FieldBook:
    """Answers forms from the lines of a book; a ``Display``.

    Parameters
    ----------
    lines, name : the text, and what messages call it.
    clock : moved along with the lines.
    """

    def __init__(self, lines: Iterable[str], name: str, clock: BookClock) -> None:
        self._entries = read_entries(lines, name)
        self._name = name
        self._clock = clock
        self._entry: Entry | None = None
        self._peeked: Entry | None = None
        self._answered = False

    def next_entry(self) -> Entry | None:
        """Go on to the next line; ``None`` at the end."""
        found = self._peek()
        self._peeked, self._entry, self._answered = None, found, False
        if found is not None:
            self._clock.stand_at(found.utc_s)
        return found

    def ask(self, form: DisplayForm) -> TypedAnswer:
        """The form from this line or the next, and from the corrections behind it.

        Raises
        ------
        InputFileError
            The line is of another step, a value in it means nothing or does not fit the form, or
            it is doubted and neither corrected nor kept.
        """
        entry = self._line_for(form)
        self._answered = True
        before: list[Mapping[str, str]] = []
        given, read_utc_s = dict(entry.values), entry.utc_s
        while True:
            texts = _texts(form, given, entry)
            doubts = form.doubts(texts, read_utc_s)
            if not doubts:
                return TypedAnswer(form, texts, read_utc_s, (), tuple(before))
            said = " ".join(doubt.sentence for doubt in doubts)
            after = self._peek()
            if after is None or after.step not in ("again", "keep"):
                raise entry.error(
                    f"{said} Correct it; or add a line below it: `again` with the right values, "
                    "or `keep` and a reason"
                )
            self._peeked = None
            if after.step == "keep":
                self._clock.stand_at(after.utc_s)
                reason = f" ({after.reason})" if after.reason else ""
                kept = tuple(f"{doubt.sentence}{reason}" for doubt in doubts)
                return TypedAnswer(form, texts, read_utc_s, kept, tuple(before))
            before.append({name: text for name, text in texts.items() if text})
            given |= after.values
            entry = after
            if form.moment is Moment.ENTER or looked_again(texts, given):
                read_utc_s = after.utc_s
            self._clock.stand_at(after.utc_s)

    def _line_for(self, form: DisplayForm) -> Entry:
        entry = self._entry
        if entry is None or self._answered or entry.step not in _steps(form):
            last, entry = entry, self.next_entry()
            if entry is None:
                after = f"behind {last.where}" if last is not None else f"in {self._name}"
                raise InputFileError(f"{after} a line `{form.word}` is missing: {form.title}")
        if entry.step not in _steps(form):
            raise entry.error(f"a line `{form.word}` belongs here: {form.title}")
        return entry

    def _peek(self) -> Entry | None:
        if self._peeked is None:
            self._peeked = next(self._entries, None)
        return self._peeked


def _steps(form: DisplayForm) -> tuple[str, ...]:
    return ANSWERING.get(form.word, (form.word,))


def _texts(form: DisplayForm, given: Mapping[str, str], entry: Entry) -> dict[str, str]:
    known = {one.name for one in form.fields}
    for name in given:
        if name not in known:
            raise entry.error(
                f"{name} is not asked for here; {form.word} takes {', '.join(sorted(known))}"
            )
    texts = form.texts(given)
    try:
        form.values(texts)
    except TypedWrong as error:
        raise entry.error(f"{error.field}: {error}") from None
    return texts
