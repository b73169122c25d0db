"""The parameters of ``PARAM``: their names and how each is written, for both ends of the wire."""

from collections.abc import Mapping

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.drive import Drive, format_drive, parse_drive
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.unit import values
from solarcal.unit.tracker import UnitParameters

PARAMETER_NAMES = (
    "axis1.drive", "axis2.drive", "axis1.limits", "axis2.limits", "axis1.reference",
    "axis2.reference", "update_range", "tilt_decimals", "scale_decimals",
)  # fmt: skip
"""Everything ``PARAM`` knows."""


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
    }


def parameters_from_texts(texts: Mapping[str, str]) -> UnitParameters:
    """The parameters from the values of all ``PARAMETER_NAMES``."""
    return UnitParameters(
        drive1=_drive(texts, "axis1.drive"),
        drive2=_drive(texts, "axis2.drive"),
        limits=Limits(_limits(texts, "axis1.limits"), _limits(texts, "axis2.limits")),
        update_range_deg=values.number(texts["update_range"], "update_range"),
        reference1_deg=values.number(texts["axis1.reference"], "axis1.reference"),
        reference2_deg=values.number(texts["axis2.reference"], "axis2.reference"),
        tilt_decimals=_decimals(texts, "tilt_decimals"),
        scale_decimals=_decimals(texts, "scale_decimals"),
    )


def _drive(texts: Mapping[str, str], name: str) -> Drive:
    try:
        return parse_drive(texts[name])
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
