"""Single values as they are written on the wire: numbers, times, senses of motion.

Reading is strict; whatever is not exactly of its kind raises ``ProtocolError`` with the field's
name. See the table "Values" of ``docs/protocol.md``.
"""

import math
import re
from datetime import UTC, datetime, timedelta

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.timescale import parse_utc

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
