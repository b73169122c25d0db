"""The parameters of ``PARAM``: their names and how each is written, for both ends of the wire."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.drive import format_drive, parse_drive
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.optics.aiming import format_mirror, format_target, parse_mirror, parse_target
from solarcal.unit import values
from solarcal.unit.tracker import UnitParameters

Written = TypeVar("Written")

PARAMETER_NAMES = (
    "axis1.drive", "axis2.drive", "axis1.limits", "axis2.limits", "axis1.reference",
    "axis2.reference", "update_range", "tilt_decimals", "scale_decimals", "target", "mirror",
)  # fmt: skip
"""Everything ``PARAM`` knows."""

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
        update_range_deg=values.number(texts["update_range"], "update_range"),
        reference1_deg=values.number(texts["axis1.reference"], "axis1.reference"),
        reference2_deg=values.number(texts["axis2.reference"], "axis2.reference"),
        tilt_decimals=_decimals(texts, "tilt_decimals"),
        scale_decimals=_decimals(texts, "scale_decimals"),
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
        return AxisLimits(values.number(low, "low"), values.number(high, "high"))
    except (ConfigurationError, ProtocolError) as error:
        raise ProtocolError(f"field {name}: {error}") from None


def _decimals(texts: Mapping[str, str], name: str) -> int:
    decimals = values.whole_number(texts[name], name)
    if not 0 <= decimals <= 12:
        raise ProtocolError(f"field {name}: {decimals} is not between 0 and 12")
    return decimals
