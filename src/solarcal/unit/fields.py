"""What the fields of each request and reply mean: tracker dataclasses above, ``verbs`` below.

One ``Message`` serves both ends: what one writes, the other reads. ``PARAM``, whose values have a
writing of their own for each name, stands at the end. Reading is strict: a wrong number of fields,
a number that is none, a word the protocol does not know raise ``ProtocolError`` with the field's
name. A unit answers that with refusal 13.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.drive import format_drive, parse_drive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.optics.offset_mirror import format_mirror, format_target, parse_mirror, parse_target
from solarcal.site import Site, Weather
from solarcal.unit.tracker import (
    EmulatedSky,
    Mode,
    RefCheckResult,
    Spot,
    Status,
    Truth,
    UnitIdentity,
    UnitParameters,
    UnitSite,
)
from solarcal.unit.values import (
    SCALE_DECIMALS,
    TILT_DECIMALS,
    local_time_text,
    number,
    number_text,
    utc_from_local_time,
    whole_number,
)
from solarcal.unit.verbs import read, verb, write

_REFERENCED, _MEMORIES_DIFFER = 1, 2

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Message(Generic[T]):
    """The fields of a request or reply, and the value they mean.

    Attributes
    ----------
    names : of the fields, in their order.
    parts : a value to what stands in its fields.
    whole : what stands in the fields to the value.
    """

    names: str
    parts: Callable[[T], Sequence[Any]]
    whole: Callable[..., T]

    def write(
        self, value: T, decimals: tuple[int, int] = (TILT_DECIMALS, SCALE_DECIMALS)
    ) -> list[str]:
        """The texts of the fields; ``decimals``: what the unit keeps of tilts and of scales."""
        return write(self.names, self.parts(value), decimals)

    def read(self, texts: Sequence[str]) -> T:
        try:
            return self.whole(*read(self.names, texts))
        except ConfigurationError as error:
            raise ProtocolError(str(error)) from None


def _pair(first: float, second: float) -> tuple[float, float]:
    return first, second


def _alone(value: float) -> tuple[float]:
    return (value,)


# Identity, clock, site ---------------------------------------------------------------------------

IDENTITY: Message[UnitIdentity] = Message(
    verb("ID").reply,
    # Spaces within the names are written as underscores.
    lambda unit: (
        *("_".join(name.split()) for name in (unit.model, unit.serial, unit.firmware)),
        unit.protocol,
        "".join(sorted(unit.extensions)) or "-",
    ),
    lambda model, serial, firmware, protocol, extensions: UnitIdentity(
        model, serial, firmware, protocol, frozenset(extensions) - {"-"}
    ),
)

CLOCK: Message[tuple[float, float]] = Message(
    verb("CLOCK").reply,
    lambda clock: (local_time_text(*clock), clock[1]),
    lambda local_time, zone: (utc_from_local_time(local_time, zone), zone),
)
"""The unit's UTC (its local clock plus its zone) and its zone, hours west."""

SITE_SET: Message[tuple[Site, float]] = Message(
    verb("SITE SET").arguments,
    lambda own: (own[0].latitude_deg, own[0].longitude_deg, own[0].elevation_m, own[1]),
    lambda latitude, longitude, elevation, zone: (Site(latitude, longitude, elevation), zone),
)

SITE: Message[UnitSite] = Message(
    verb("SITE").reply,
    lambda unit: (
        *SITE_SET.parts((unit.site, unit.zone_west_h)),
        unit.geometry,
        unit.ax1_centre_deg,
    ),
    lambda *fields: UnitSite(*SITE_SET.whole(*fields[:4]), *fields[4:]),
)


# Status, jog, reference check --------------------------------------------------------------------


def status(zone_west_h: float) -> Message[Status]:
    """Reply to ``STATUS`` and ``OFFSET SET`` of a unit in this zone."""

    def parts(now: Status) -> Sequence[Any]:
        flags = _REFERENCED * now.referenced + _MEMORIES_DIFFER * now.memories_differ
        return (
            now.mode,
            local_time_text(now.unit_utc_s, zone_west_h),
            *now.ideal_deg,
            *now.reading_deg,
            *(now.counts1, now.counts2),
            *(now.target1_deg, now.target2_deg),
            *(now.offsets.O1, now.offsets.O2),
            now.moving,
            now.approach,
            min(99, max(0, int(now.update_phase * 100.0))),
            f"{flags:02X}",
            max(0, int(now.unlocked_s)),
        )

    def whole(mode: str, local_time: str, *fields: Any) -> Status:
        *axes, offset1, offset2, moving, approach, percent, flags, unlocked = fields
        bits = int(flags, 16)
        seen: list[Any] = [
            Mode(mode),
            utc_from_local_time(local_time, zone_west_h),
            *axes,
            Offsets(offset1, offset2),
            moving,
            approach,
            percent / 100.0,
            bool(bits & _REFERENCED),
            float(unlocked),
            bool(bits & _MEMORIES_DIFFER),
        ]
        return Status(*seen)

    return Message(verb("STATUS").reply, parts, whole)


JOG: Message[tuple[float, float]] = Message(verb("JOG").reply, tuple, _pair)
"""Target read-outs of both axes: arguments of ``JOG`` and its reply."""


def _ref_check_state(result: RefCheckResult) -> str:
    if result.complete:
        return "DONE"
    if result.running:
        return "RUNNING"
    return "BROKEN" if result.number else "NONE"


REF_CHECK: Message[RefCheckResult] = Message(
    verb("REF").reply,
    lambda result: (
        result.number,
        _ref_check_state(result),
        result.difference1,
        result.difference2,
    ),
    lambda number, state, difference1, difference2: RefCheckResult(
        number, state == "DONE", difference1, difference2, running=state == "RUNNING"
    ),
)


# Coefficients ------------------------------------------------------------------------------------

COEFFICIENTS: Message[tuple[Coefficients, Offsets]] = Message(
    verb("COEF").reply,
    lambda both: (*both[0].as_tuple(), both[1].O1, both[1].O2),
    lambda *fields: (Coefficients(*fields[:6]), Offsets(*fields[6:])),
)
"""Arguments of ``COEF SET``, and the reply to it and to ``COEF`` and ``COEF STORED``."""


# Emulator only -----------------------------------------------------------------------------------

TIMES: Message[tuple[float, float]] = Message(verb("X ADVANCE").reply, tuple, _pair)
"""True and laptop UTC, POSIX seconds."""

TIMES_AND_SPEED: Message[tuple[tuple[float, float], float]] = Message(
    verb("X TIME").reply,
    lambda now: (*now[0], now[1]),
    lambda true_utc_s, laptop_utc_s, speed: ((true_utc_s, laptop_utc_s), speed),
)

ADVANCE: Message[float] = Message(verb("X ADVANCE").arguments, _alone, float)

SPEED: Message[float] = Message(verb("X SPEED").reply, _alone, float)

SKY: Message[EmulatedSky] = Message(
    verb("X SKY").reply,
    lambda sky: (sky.sun, sky.weather.pressure_hpa, sky.weather.temperature_c),
    lambda sun, pressure, temperature: EmulatedSky(sun, Weather(pressure, temperature)),
)

SPOT: Message[Spot] = Message(
    verb("X SPOT").reply,
    lambda spot: (int(spot.visible), spot.error1_deg, spot.error2_deg),
    lambda visible, error1, error2: Spot(visible == "1", error1, error2),
)

TRUTH: Message[Truth] = Message(
    verb("X TRUTH").reply,
    lambda truth: (
        *truth.coefficients.as_tuple(),
        truth.day_rms_deg,
        truth.day_max_deg,
        truth.year_rms_deg,
    ),
    lambda *fields: Truth(Coefficients(*fields[:6]), *fields[6:]),
)


# Parameters --------------------------------------------------------------------------------------

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


def _written(texts: Mapping[str, str], name: str, parse: Callable[[str], T]) -> T:
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
