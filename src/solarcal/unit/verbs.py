"""Every request of the wire protocol, described once: its arguments, its reply, what it does.

Both ends write and read fields by this table, ``docs/protocol.md`` has its tables from it
(``python -m tools.protocol_page``), and a test goes through every entry. A field's name says what
it holds; ``KINDS`` says how that is written and what it can be.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from solarcal.errors import ProtocolError
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import GEOMETRIES
from solarcal.timescale import format_utc
from solarcal.unit import values
from solarcal.unit.tracker import Mode

TILT_DECIMALS, SCALE_DECIMALS = 4, 6
"""Decimals of P1..P4 and O, and of P5, P6, where a unit keeps no others."""

SKY_SUNS = ("precise", "solartrak", "solartrak+", "noaa")
"""Suns an emulated world may have."""


@dataclass(frozen=True, slots=True)
class Kind:
    """How one kind of field is written.

    Attributes
    ----------
    read : a text and the field's name to the value; raises ProtocolError with the name.
    write : a value, and the decimals a unit keeps of tilts and scales, to the text.
    examples, wrong : texts that are of this kind, as written; and some that are not.
    """

    read: Callable[[str, str], Any]
    write: Callable[[Any, tuple[int, int]], str]
    examples: tuple[str, ...]
    wrong: tuple[str, ...]


def _number(digits: int, low: float = -1e9, high: float = 1e9) -> Kind:
    return Kind(
        lambda text, name: values.number(text, name, low, high),
        lambda value, decimals: values.number_text(value, digits),
        tuple(f"{value:.{digits}f}" for value in (max(low, 0.0), min(high, 12.0))),
        ("", "1e1", "+1", "nan", "x", *([f"{high + 1.0:.1f}"] if high < 1e9 else [])),
    )


def _kept(which: int) -> Kind:
    """A number with as many decimals as the unit keeps: of tilts (0), of scales (1)."""
    digits = (TILT_DECIMALS, SCALE_DECIMALS)[which]
    return Kind(
        values.number,
        lambda value, decimals: values.number_text(value, decimals[which]),
        tuple(f"{value:.{digits}f}" for value in (0.0, -0.125)),
        ("", "1e-3", "x"),
    )


def _whole(low: int = -(10**9), high: int = 10**9) -> Kind:
    def read(text: str, name: str) -> int:
        value = values.whole_number(text, name)
        if not low <= value <= high:
            raise ProtocolError(f"field {name}: {text} is not between {low} and {high}")
        return value

    return Kind(read, lambda value, decimals: str(value), (str(max(low, 0)), "7"), ("", "1.5", "x"))


def _text(pattern: str, what: str, *examples: str) -> Kind:
    known = re.compile(pattern, re.ASCII)

    def read(text: str, name: str) -> str:
        if not known.fullmatch(text):
            raise ProtocolError(f"field {name}: {text!r} is not {what}")
        return text

    return Kind(read, lambda value, decimals: str(value), examples, ("",))


def _word(*words: str) -> Kind:
    pattern = "|".join(re.escape(word) for word in words)
    kind = _text(pattern, f"one of {' '.join(words)}", *words)
    return Kind(kind.read, kind.write, kind.examples, ("", "sideways"))


def _local_time() -> Kind:
    """Kept as a text: it means an instant only together with the unit's zone."""

    def read(text: str, name: str) -> str:
        values.utc_from_local_time(text, 0.0, name)
        return text

    return Kind(
        read,
        lambda value, decimals: str(value),
        ("20260603T083000.000",),
        ("", "20261301T000000.000"),
    )


_ANGLE, _TILT, _COUNTS = _number(5), _kept(0), _whole()
_UTC = Kind(
    values.utc_from_iso,
    lambda value, decimals: format_utc(value),
    ("2026-06-03T15:30:00.125Z",),
    ("", "20261301T000000.000"),
)
_NAME = _text(r"\S+", "a name", "SOLARTRAK-EMU")
_SENSES = Kind(
    values.senses,
    lambda value, decimals: values.senses_text(value),
    ("+-", ".."),
    ("", "+", "ab"),
)

KINDS: dict[str, Kind] = {
    "nonce": _text(r"[0-9A-F]{8}", "8 hexadecimal digits", "5C0FFEE5"),
    **dict.fromkeys(("model", "serial", "firmware", "name", "value"), _NAME),
    "protocol": _whole(1),
    "extensions": _text(r"-|[A-Za-z]+", "letters or '-'", "X", "-"),
    "local_time": _local_time(),
    "zone": _number(2, -15.0, 15.0),
    "latitude": _number(5, -90.0, 90.0),
    "longitude": _number(5, -180.0, 360.0),
    "elevation_m": _number(1, -500.0, 9000.0),
    "geometry": _word(*GEOMETRIES),
    "ax1_centre": _number(5, -360.0, 360.0),
    "mode": _word(*Mode.__members__),
    "ideal1": _number(5, -540.0, 540.0),
    "ideal2": _number(5, 0.0, 180.0),
    **dict.fromkeys(("reading1", "reading2", "target1", "target2", "error1", "error2"), _ANGLE),
    **dict.fromkeys(("day_rms", "day_max", "year_rms"), _ANGLE),
    **dict.fromkeys(("counts1", "counts2", "difference1", "difference2", "number"), _COUNTS),
    **dict.fromkeys((*COEFFICIENT_NAMES[:4], "O1", "O2"), _TILT),
    **dict.fromkeys(COEFFICIENT_NAMES[4:], _kept(1)),
    **dict.fromkeys(("motion", "approach"), _SENSES),
    "phase": _whole(0, 99),
    "flags": _text(r"[0-9A-F]{2}", "two hexadecimal digits", "03"),
    "unlocked": _whole(0),
    "state": _word("NONE", "RUNNING", "DONE", "BROKEN"),
    **dict.fromkeys(("true_utc", "laptop_utc"), _UTC),
    "speed": _number(3, 0.0, 1e6),
    "seconds": _number(6, 0.0, 86400.0),
    "visible": _word("0", "1"),
    "sun": _word(*SKY_SUNS),
    "pressure": _number(1, 0.0, 1200.0),
    "temperature": _number(1, -100.0, 100.0),
}
"""Field -> its kind."""


@dataclass(frozen=True, slots=True)
class Verb:
    """One request. Words that are no field stand as they are.

    Attributes
    ----------
    request, reply : words and names of fields, as they go over the line.
    does : for the page.
    unlock : it needs the unlock.
    """

    request: str
    reply: str
    does: str
    unlock: bool = False

    @property
    def arguments(self) -> str:
        """Names of the fields behind the words of the request."""
        return " ".join(word for word in self.request.split() if word in KINDS)


_STATUS = (
    "mode local_time ideal1 ideal2 reading1 reading2 counts1 counts2 target1 target2 O1 O2"
    " motion approach phase flags unlocked"
)
_SITE = "latitude longitude elevation_m zone geometry ax1_centre"
_COEF = "P1 P2 P3 P4 P5 P6 O1 O2"

VERBS: tuple[Verb, ...] = (
    Verb(
        "OPEN nonce",
        "nonce",
        "starts a conversation. `nonce`: 8 hex digits, new each time. Cancels a jog and locks",
    ),
    Verb(
        "ID",
        "model serial firmware protocol extensions",
        "`extensions`: letters, or `-` for none; `X` announces the emulator requests",
    ),
    Verb(
        "CLOCK",
        "local_time zone",
        "reads the clock",
    ),
    Verb(
        "CLOCK SET local_time",
        "local_time zone",
        "sets it",
        unlock=True,
    ),
    Verb(
        "SITE",
        _SITE,
        "`geometry`: `azel`, `polar`, `tiltroll-ew`, `tiltroll-ns`",
    ),
    Verb(
        "SITE SET latitude longitude elevation_m zone",
        _SITE,
        "sets it",
        unlock=True,
    ),
    Verb(
        "STATUS",
        _STATUS,
        "everything of one instant; the fields are explained below",
    ),
    Verb(
        "PARAM name",
        "value",
        "reads a parameter",
    ),
    Verb(
        "PARAM name value",
        "value",
        "writes it",
        unlock=True,
    ),
    Verb(
        "UNLOCK",
        "unlocked",
        "unlocks writes and motion for that number of seconds (60); every unlocked request "
        "restarts the time",
    ),
    Verb(
        "LOCK",
        "",
        "ends the unlock at once",
    ),
    Verb(
        "MODE mode",
        "mode",
        "`TRACK`: track the Sun; `MANUAL`: hold position and wait for jogs",
        unlock=True,
    ),
    Verb(
        "STOP",
        "STOP",
        "every motion ends now; the unit stays in mode `STOP` until `MODE`",
    ),
    Verb(
        "STOW",
        "STOW",
        "drives to the stow position",
    ),
    Verb(
        "JOG target1 target2",
        "target1 target2",
        "drives to ABSOLUTE readings. The target expires 5 s after it was last sent: "
        "the axes then stop where they are. Leaves `TRACK` for `JOG`; on arrival and on "
        "expiry the mode becomes `MANUAL`. Refused beyond limits",
        unlock=True,
    ),
    Verb(
        "OFFSET SET",
        _STATUS,
        "sets O so that `reading = ideal + E + O` is true now, and returns the status of "
        "that instant (new O included). Refused while an axis moves",
        unlock=True,
    ),
    Verb(
        "REF START",
        "number",
        "starts a reference check: drives to the reference switches, stores the counts "
        "found there, sets the count registers to zero; O and P do not change. The mode is "
        "`REF` during the check and `MANUAL` afterwards",
        unlock=True,
    ),
    Verb(
        "REF",
        "number state difference1 difference2",
        "the last check: `state` is `NONE`, `RUNNING`, `DONE` or `BROKEN` (stopped "
        "before the end); differences: counts found on the register at the switch, 0 "
        "expected",
    ),
    Verb(
        "COEF",
        _COEF,
        "in force (temporary memory)",
    ),
    Verb(
        "COEF STORED",
        _COEF,
        "permanent memory",
    ),
    Verb(
        f"COEF SET {_COEF}",
        _COEF,
        "sets all eight or none; the reply has the stored values",
        unlock=True,
    ),
    Verb(
        "STORE",
        "1",
        "temporary to permanent memory",
        unlock=True,
    ),
    Verb(
        "X TIME",
        "true_utc laptop_utc speed",
        "ISO 8601 with `Z`, milliseconds; speed 0: time moves only by `X ADVANCE`",
    ),
    Verb(
        "X SPEED speed",
        "speed",
        "sets the number of virtual seconds per real second, 0 to a million, up to three "
        "decimals; 0 as above",
    ),
    Verb(
        "X ADVANCE seconds",
        "true_utc laptop_utc",
        "advances virtual time by this, as fast as possible. 0 to 86400, up to six decimals",
    ),
    Verb(
        "X SPOT",
        "visible error1 error2",
        "spot as seen by the technician: `1` or `0`, and the motion of each axis that centres "
        "the Sun (heliostat: that brings the beam onto the middle of the target board), degrees, "
        "as estimated by eye",
    ),
    Verb(
        "X SKY",
        "sun pressure temperature",
        "values of the emulated world: its Sun model (`precise`), station pressure in hPa "
        "(0: no air, no refraction), temperature in degrees Celsius",
    ),
    Verb(
        "X TRUTH",
        "P1 P2 P3 P4 P5 P6 day_rms day_max year_rms",
        "the true coefficients, and the true pointing error with the P and O in force",
    ),
    Verb(
        "X FAULT name",
        "name",
        "from now on: `mute` (no replies), `garbage` (noise instead of replies), "
        "`none`, `freeze1`, `freeze2` (axis read-out does not change), `reboot` (loses "
        "reference and temporary memory), `miss1:counts`, `miss2:counts`",
    ),
)


def verb(words: str) -> Verb:
    """The description of a request, by its words: ``COEF SET``."""
    return _BY_WORDS[words]


def expect(fields: Sequence[str], names: str) -> tuple[str, ...]:
    """The fields, of which there must be as many as ``names`` (separated by spaces) has."""
    wanted = names.split()
    if len(fields) != len(wanted):
        raise ProtocolError(
            f"{len(fields)} fields where {len(wanted)} belong ({', '.join(wanted) or 'none'})"
        )
    return tuple(fields)


def read(names: str, texts: Sequence[str]) -> list[Any]:
    """The values of fields, in the order of their names.

    Raises
    ------
    ProtocolError
        As many texts as there are names there must be, each of its kind; names the field.
    """
    found = zip(names.split(), expect(texts, names), strict=True)
    return [KINDS[name].read(text, name) for name, text in found]


def write(
    names: str,
    values: Sequence[Any],
    decimals: tuple[int, int] = (TILT_DECIMALS, SCALE_DECIMALS),
) -> list[str]:
    """The texts of fields from their values, in the order of their names."""
    fields = zip(names.split(), values, strict=True)
    return [KINDS[name].write(value, decimals) for name, value in fields]


_BY_WORDS = {
    " ".join(word for word in verb.request.split() if word not in KINDS): verb
    for verb in reversed(VERBS)
}
