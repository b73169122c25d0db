"""What the fields of each request and reply mean: tracker dataclasses above, ``verbs`` below.

One ``Message`` serves both ends: what one writes, the other reads. Reading is strict: a wrong
number of fields, a number that is none, a word the protocol does not know raise ``ProtocolError``
with the field's name. A unit answers that with refusal 13.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.site import Site, Weather
from solarcal.unit import values
from solarcal.unit.tracker import (
    EmulatedSky,
    Mode,
    RefCheckResult,
    Spot,
    Status,
    Truth,
    UnitIdentity,
    UnitSite,
)
from solarcal.unit.verbs import SCALE_DECIMALS, TILT_DECIMALS, read, verb, write

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
    lambda clock: (values.local_time_text(*clock), clock[1]),
    lambda local_time, zone: (values.utc_from_local_time(local_time, zone), zone),
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
            values.local_time_text(now.unit_utc_s, zone_west_h),
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
            values.utc_from_local_time(local_time, zone_west_h),
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
