"""A slip of typing, noticed at once and named.

What a display shows hangs together: reading = ideal + E(P in force) + O. Where what was typed does
not, each way to mistype it is undone in turn; the one after which it fits is what happened.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from solarcal.decimals import Pair
from solarcal.station.typed.forms import Doubt, number

Texts = Mapping[str, str]

NAMED_AT_MOST = 2
"""Of all slips that would explain it so many are named, the likeliest first."""

CLEAR = 3.0
"""A wrong digit is only looked for where one unit of it moves the reading by so many tolerances:
further down some digit or other always fits."""

EARLIER_MIN = 45
"""Readings from so long ago, or so far ahead, are recognised as such."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How well typed read-outs and offsets hang together.

    Parameters
    ----------
    off_deg : texts, and seconds to add to the moment they were read at, to reading minus
        (ideal + E + O) of both axes, degrees; not a number where a text is none, or where no
        position of the axis has these counts.
    tolerance_deg : what each axis may be off by honestly.
    """

    off_deg: Callable[[Texts, float], Pair]
    tolerance_deg: Pair

    def holds(self, texts: Texts, shift_s: float = 0.0) -> tuple[bool, bool]:
        """Whether each axis fits."""
        off = self.off_deg(texts, shift_s)
        return abs(off[0]) <= self.tolerance_deg[0], abs(off[1]) <= self.tolerance_deg[1]


def reading_doubts(fit: Fit, texts: Texts, other_offsets: Texts | None = None) -> tuple[Doubt, ...]:
    """What is wrong with typed read-outs (``ax1 ax2``) and offsets (``o1 o2``); empty if nothing.

    ``other_offsets`` are those in force before, which stay where a key was not really pressed.
    """
    good = fit.holds(texts)
    if all(good):
        return ()
    named = []
    for doubt, undone, shift_s in _slips(fit, texts, good, other_offsets):
        if all(fit.holds(undone, shift_s)) and doubt not in named:
            named.append(doubt)
            if len(named) == NAMED_AT_MOST:
                break
    off = fit.off_deg(texts, 0.0)
    wrong = [axis for axis in (0, 1) if not good[axis]]
    measured = " and ".join(
        f"AX{axis + 1} by {off[axis]:+z.3f} deg"
        if math.isfinite(off[axis])
        else f"no position of axis {axis + 1} has {texts[f'ax{axis + 1}']} counts"
        for axis in wrong
    )
    if any(math.isfinite(off[axis]) for axis in wrong):
        measured += " off ideal + E + O"
    if not named:
        return (Doubt(f"{measured}; no single slip explains it.", f"ax{wrong[0] + 1}"),)
    first, *rest = named
    sentence = first.sentence + "".join(f" Or: {d.sentence}" for d in rest)
    return (Doubt(f"{sentence} ({measured}.)", first.field),)


def _slips(
    fit: Fit, texts: Texts, good: tuple[bool, bool], other_offsets: Texts | None
) -> Iterator[tuple[Doubt, dict[str, str], float]]:
    """Every slip: what it is called, the texts with it undone, seconds to shift the moment by."""
    for a, b in (("ax1", "ax2"), ("o1", "o2")):
        if texts[a] != texts[b]:
            swapped = {**texts, a: texts[b], b: texts[a]}
            yield Doubt(f"{a.upper()} and {b.upper()} exchanged?", a), swapped, 0.0
    if other_offsets is not None:
        yield (
            Doubt(
                "They fit the previous offsets: was the offset really set, and O read after that?",
                "o1",
            ),
            {**texts, "o1": other_offsets["o1"], "o2": other_offsets["o2"]},
            0.0,
        )
    # A slip in a value of one axis explains nothing where the other axis is off too.
    fields = [f"{what}{axis + 1}" for axis in (0, 1) if not good[axis] for what in ("ax", "o")]
    for undo in (_sign, _point, _neighbours):
        for field in fields:
            for what, text in undo(texts[field]):
                yield _instead(field, texts[field], what, text), {**texts, field: text}, 0.0
    for field in (name for name in fields if name.startswith("ax")):
        axis = int(field[2]) - 1
        for text, step in _other_digits(texts[field]):
            moved = fit.off_deg({**texts, field: _nudged(texts[field], step)}, 0.0)[axis]
            unit_deg = abs(moved - fit.off_deg(texts, 0.0)[axis])
            if unit_deg > CLEAR * fit.tolerance_deg[axis]:
                yield (
                    _instead(field, texts[field], "a digit wrong", text),
                    {**texts, field: text},
                    0.0,
                )
    for hours in (1, -1):
        yield (
            Doubt(
                f"It fits a clock {abs(hours)} h {'ahead' if hours > 0 else 'behind'}: the zone, "
                "daylight-saving time, or the hour typed.",
                "time",
            ),
            dict(texts),
            3600.0 * hours,
        )
    for minutes in sorted((m for m in range(-EARLIER_MIN, EARLIER_MIN + 1) if m), key=abs):
        when = f"{abs(minutes)} min {'later' if minutes > 0 else 'earlier'}"
        yield (
            Doubt(f"It fits a reading {when}: read at another time?", "time"),
            dict(texts),
            60.0 * minutes,
        )


def _instead(field: str, text: str, what: str, undone: str) -> Doubt:
    return Doubt(f"{field.upper()} typed {text}, {what}: {undone}?", field)


def _sign(text: str) -> Iterator[tuple[str, str]]:
    if text.startswith("-"):
        yield "the sign", text[1:]
    else:
        yield "the sign", "-" + text.removeprefix("+")


def _point(text: str) -> Iterator[tuple[str, str]]:
    """The decimal point left out, or in another place."""
    sign = text[:1] if text[:1] in ("+", "-") else ""
    digits = text[len(sign) :].replace(".", "")
    at_present = text[len(sign) :].find(".")
    for at in range(1, len(digits) + 1):
        moved = f"{digits[:at]}.{digits[at:]}" if at < len(digits) else digits
        if at != at_present and moved != text[len(sign) :]:
            what = "the decimal point" if "." in text else "no decimal point"
            yield what, sign + moved


def _neighbours(text: str) -> Iterator[tuple[str, str]]:
    """Two digits next to each other exchanged; a point between them stays where it is."""
    places = [i for i, c in enumerate(text) if c.isdigit()]
    for one, other in pairwise(places):
        if text[one] != text[other]:
            swapped = list(text)
            swapped[one], swapped[other] = text[other], text[one]
            yield "two digits exchanged", "".join(swapped)


def _other_digits(text: str) -> Iterator[tuple[str, float]]:
    """The text with one digit another one, and what a unit of that digit is worth."""
    whole = text.find(".") if "." in text else len(text)
    for i, c in enumerate(text):
        if c.isdigit():
            power = whole - i - 1 if i < whole else whole - i
            for digit in "0123456789":
                if digit != c:
                    yield text[:i] + digit + text[i + 1 :], 10.0**power


def _nudged(text: str, step: float) -> str:
    value = number(text)
    return text if value is None else f"{value + step:.6f}".rstrip("0").rstrip(".")


def difference_named(name: str, typed: str, wanted: str) -> str:
    """How a typed text came to differ from the one that belongs there; for exact comparisons."""
    for undo in (_sign, _point, _neighbours):
        for what, text in undo(typed):
            found, want = number(text), number(wanted)
            if found is not None and want is not None and math.isclose(found, want, abs_tol=1e-12):
                return f"{name} was typed {typed}, {what}: {wanted} belongs there"
    return f"{name} was typed {typed}, {wanted} belongs there"
