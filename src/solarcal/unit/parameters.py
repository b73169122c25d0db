"""The parameters of ``PARAM``: their names and how each is written, for both ends of the wire."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.drive import format_drive, parse_drive
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.optics.offset_mirror import format_mirror, format_target, parse_mirror, parse_target
from solarcal.unit import values
from solarcal.unit.tracker import UnitParameters

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
        "axis1.reference": values.number_text(parameters.reference1_deg),
        "axis2.reference": values.number_text(parameters.reference2_deg),
        "update_range": values.number_text(parameters.update_range_deg),
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
    return f"{values.number_text(limits.low_deg)}:{values.number_text(limits.high_deg)}"


def _limits(texts: Mapping[str, str], name: str) -> AxisLimits:
    low, colon, high = texts[name].partition(":")
    if not colon:
        raise ProtocolError(f"field {name}: {texts[name]!r} is not low:high")
    try:
        return AxisLimits(
            _within(values.number(low, "low"), name), _within(values.number(high, "high"), name)
        )
    except (ConfigurationError, ProtocolError) as error:
        raise ProtocolError(f"field {name}: {error}") from None


def _bounded(texts: Mapping[str, str], name: str) -> float:
    read = values.whole_number if name.endswith("decimals") else values.number
    try:
        return _within(read(texts[name], name), name)
    except ConfigurationError as error:
        raise ProtocolError(f"field {name}: {error}") from None


def _within(value: float, name: str) -> float:
    low, high = RANGES[name]
    if not low <= value <= high:
        raise ConfigurationError(f"{value:g} is not between {low:g} and {high:g}")
    return value
