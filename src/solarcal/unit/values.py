"""Single values as they are written on the wire, and the kind of each field by its name.

Reading is strict; whatever is not exactly of its kind raises ``ProtocolError`` with the field's
name. See the table "Values" of ``docs/protocol.md``.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import GEOMETRIES
from solarcal.timescale import format_utc, parse_utc
from solarcal.unit.tracker import Mode

_NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?", re.ASCII)
_WHOLE = re.compile(r"-?[0-9]+", re.ASCII)
_LOCAL_TIME = re.compile(
    r"([0-9]{4})([0-9]{2})([0-9]{2})T([0-9]{2})([0-9]{2})([0-9]{2})\.([0-9]{3})", re.ASCII
)
_UTC = re.compile(r"[0-9-]{10}T[0-9:]{8}\.[0-9]{3}Z", re.ASCII)
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_SENSES = {"+": 1, "-": -1, ".": 0}
_SENSE_MARKS = {sense: mark for mark, sense in _SENSES.items()}


def number_text(value: float, decimals: int = 5) -> str:
    """A number with fixed decimals, without a negative zero."""
    if not math.isfinite(value):
        raise ProtocolError(f"{value} cannot be written to a unit")
    text = f"{value:.{decimals}f}"
    return text if text.strip("-0.") else text.removeprefix("-")


def number(text: str, name: str, low: float = -math.inf, high: float = math.inf) -> float:
    if not _NUMBER.fullmatch(text):
        raise ProtocolError(f"field {name}: {text!r} is not a number")
    value = float(text)
    if not low <= value <= high:
        raise ProtocolError(f"field {name}: {text} is not between {low:g} and {high:g}")
    return value


def whole_number(text: str, name: str) -> int:
    if not _WHOLE.fullmatch(text):
        raise ProtocolError(f"field {name}: {text!r} is not a whole number")
    return int(text)


def local_time_text(utc_s: float, zone_west_h: float) -> str:
    """The unit's local standard time, to the millisecond: UTC = local time + zone."""
    millis = round(utc_s * 1000.0) - round(zone_west_h * 3600e3)
    instant = _EPOCH + timedelta(milliseconds=millis)
    # %Y has no leading zeros everywhere.
    return f"{instant.year:04d}{instant:%m%dT%H%M%S}.{instant.microsecond // 1000:03d}"


def utc_from_local_time(text: str, zone_west_h: float, name: str = "local_time") -> float:
    """POSIX UTC seconds of the unit's local time."""
    match = _LOCAL_TIME.fullmatch(text)
    if match is None:
        raise ProtocolError(f"field {name}: {text!r} is not a time like 20260621T153000.000")
    year, month, day, hour, minute, second, millis = map(int, match.groups())
    try:
        local = datetime(year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        raise ProtocolError(f"field {name}: {text!r} is no date and time") from None
    elapsed = local - _EPOCH
    whole_ms = (elapsed.days * 86400 + elapsed.seconds) * 1000 + millis
    return (whole_ms + round(zone_west_h * 3600e3)) / 1000.0


def senses(text: str, name: str) -> tuple[int, int]:
    """The sense of motion of both axes: +1, -1, 0."""
    if len(text) != 2 or not set(text) <= _SENSES.keys():
        raise ProtocolError(f"field {name}: {text!r} is not two of + - .")
    return _SENSES[text[0]], _SENSES[text[1]]


def senses_text(both: tuple[int, int]) -> str:
    return _SENSE_MARKS[both[0]] + _SENSE_MARKS[both[1]]


def utc_from_iso(text: str, name: str) -> float:
    """POSIX UTC seconds of ISO 8601 with milliseconds and ``Z``."""
    if not _UTC.fullmatch(text):
        raise ProtocolError(f"field {name}: {text!r} is not a time like 2026-06-21T15:30:00.000Z")
    try:
        return parse_utc(text)
    except ConfigurationError as error:
        raise ProtocolError(f"field {name}: {error}") from None


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
        lambda text, name: number(text, name, low, high),
        lambda value, decimals: number_text(value, digits),
        tuple(f"{value:.{digits}f}" for value in (max(low, 0.0), min(high, 12.0))),
        ("", "1e1", "+1", "nan", "x", *([f"{high + 1.0:.1f}"] if high < 1e9 else [])),
    )


def _kept(which: int) -> Kind:
    """A number with as many decimals as the unit keeps: of tilts (0), of scales (1)."""
    digits = (TILT_DECIMALS, SCALE_DECIMALS)[which]
    return Kind(
        number,
        lambda value, decimals: number_text(value, decimals[which]),
        tuple(f"{value:.{digits}f}" for value in (0.0, -0.125)),
        ("", "1e-3", "x"),
    )


def _whole(low: int = -(10**9), high: int = 10**9) -> Kind:
    def read(text: str, name: str) -> int:
        value = whole_number(text, name)
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
        utc_from_local_time(text, 0.0, name)
        return text

    return Kind(
        read,
        lambda value, decimals: str(value),
        ("20260603T083000.000",),
        ("", "20261301T000000.000"),
    )


_ANGLE, _TILT, _COUNTS = _number(5), _kept(0), _whole()
_INSTANT = Kind(
    utc_from_iso,
    lambda value, decimals: format_utc(value),
    ("2026-06-03T15:30:00.125Z",),
    ("", "20261301T000000.000"),
)
_NAME = _text(r"\S+", "a name", "SOLARTRAK-EMU")
_MOTION = Kind(senses, lambda value, decimals: senses_text(value), ("+-", ".."), ("", "+", "ab"))

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
    **dict.fromkeys(("motion", "approach"), _MOTION),
    "phase": _whole(0, 99),
    "flags": _text(r"[0-9A-F]{2}", "two hexadecimal digits", "03"),
    "unlocked": _whole(0),
    "state": _word("NONE", "RUNNING", "DONE", "BROKEN"),
    **dict.fromkeys(("true_utc", "laptop_utc"), _INSTANT),
    "speed": _number(3, 0.0, 1e6),
    "seconds": _number(6, 0.0, 86400.0),
    "visible": _word("0", "1"),
    "sun": _word(*SKY_SUNS),
    "pressure": _number(1, 0.0, 1200.0),
    "temperature": _number(1, -100.0, 100.0),
}
"""Field -> its kind."""
