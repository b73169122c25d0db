"""Single values as they are written on the wire: numbers, times, senses of motion; and those of
``PARAM``, the parameters with their names, for both ends.

Reading is strict; whatever is not exactly of its kind raises ``ProtocolError`` with the field's
name. See the table "Values" of ``docs/protocol.md``.
"""

import math
import re
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta
from typing import TypeVar

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.drive import format_drive, parse_drive
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.optics.offset_mirror import format_mirror, format_target, parse_mirror, parse_target
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import UnitParameters

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


Written = TypeVar("Written")

PARAMETER_NAMES = (
    "axis1.drive", "axis2.drive", "axis1.limits", "axis2.limits", "axis1.reference",
    "axis2.reference", "update_range", "tilt_decimals", "scale_decimals", "target", "mirror",
)  # fmt: skip
"""Everything ``PARAM`` knows."""

RANGES: dict[str, tuple[float, float]] = {
    "axis1.limits": (-540.0, 540.0),
    "axis2.limits": (-180.0, 360.0),
    "axis1.reference": (-540.0, 540.0),
    "axis2.reference": (-180.0, 360.0),
    "update_range": (0.001, 5.0),
    "tilt_decimals": (2, 9),
    "scale_decimals": (4, 9),
}
"""What each can be, degrees or decimals. Outside of it a unit is broken or misread: its limits
would protect nothing, its P and O would be rounded away."""

ABSENT = {"target": "-", "mirror": "0:0:0"}
"""What a unit that does not know these names is taken to have: it is no heliostat."""


def parameters_to_texts(parameters: UnitParameters) -> dict[str, str]:
    """What ``PARAM name`` answers, for every name."""
    limits = parameters.limits
    return {
        "axis1.drive": format_drive(parameters.drive1),
        "axis2.drive": format_drive(parameters.drive2),
        "axis1.limits": _limits_text(limits.axis1),
        "axis2.limits": _limits_text(limits.axis2),
        "axis1.reference": number_text(parameters.reference1_deg),
        "axis2.reference": number_text(parameters.reference2_deg),
        "update_range": number_text(parameters.update_range_deg),
        "tilt_decimals": str(parameters.tilt_decimals),
        "scale_decimals": str(parameters.scale_decimals),
        "target": format_target(parameters.target),
        "mirror": format_mirror(parameters.mirror),
    }


def parameters_from_texts(texts: Mapping[str, str]) -> UnitParameters:
    """The parameters from the values of all ``PARAMETER_NAMES``."""
    return UnitParameters(
        drive1=_written(texts, "axis1.drive", parse_drive),
        drive2=_written(texts, "axis2.drive", parse_drive),
        limits=Limits(_limits(texts, "axis1.limits"), _limits(texts, "axis2.limits")),
        update_range_deg=_bounded(texts, "update_range"),
        reference1_deg=_bounded(texts, "axis1.reference"),
        reference2_deg=_bounded(texts, "axis2.reference"),
        tilt_decimals=int(_bounded(texts, "tilt_decimals")),
        scale_decimals=int(_bounded(texts, "scale_decimals")),
        target=_written(texts, "target", parse_target),
        mirror=_written(texts, "mirror", parse_mirror),
    )


def _written(texts: Mapping[str, str], name: str, parse: Callable[[str], Written]) -> Written:
    try:
        return parse(texts[name])
    except ConfigurationError as error:
        raise ProtocolError(f"field {name}: {error}") from None


def _limits_text(limits: AxisLimits) -> str:
    return f"{number_text(limits.low_deg)}:{number_text(limits.high_deg)}"


def _limits(texts: Mapping[str, str], name: str) -> AxisLimits:
    low, colon, high = texts[name].partition(":")
    if not colon:
        raise ProtocolError(f"field {name}: {texts[name]!r} is not low:high")
    try:
        return AxisLimits(_within(number(low, "low"), name), _within(number(high, "high"), name))
    except (ConfigurationError, ProtocolError) as error:
        raise ProtocolError(f"field {name}: {error}") from None


def _bounded(texts: Mapping[str, str], name: str) -> float:
    read = whole_number if name.endswith("decimals") else number
    try:
        return _within(read(texts[name], name), name)
    except ConfigurationError as error:
        raise ProtocolError(f"field {name}: {error}") from None


def _within(value: float, name: str) -> float:
    low, high = RANGES[name]
    if not low <= value <= high:
        raise ConfigurationError(f"{value:g} is not between {low:g} and {high:g}")
    return value
