"""What the fields of each request and reply mean: text on the wire, tracker dataclasses above it.

For both ends: ``..._to_fields`` writes, ``..._from_fields`` reads. Reading is strict: a wrong
number of fields, a number that is none, a word the protocol does not know raise ``ProtocolError``
with the field's name. A unit answers that with refusal 13.
"""

import re
from collections.abc import Sequence

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients, Offsets
from solarcal.mount.geometry import GEOMETRIES
from solarcal.site import Site, Weather
from solarcal.timescale import format_utc
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

TILT_DECIMALS = 4
SCALE_DECIMALS = 6

SKY_SUNS = ("precise", "solartrak", "solartrak+", "noaa")
"""Suns an emulated world may have."""

_REFERENCED, _MEMORIES_DIFFER = 1, 2


def expect(fields: Sequence[str], names: str) -> tuple[str, ...]:
    """The fields, of which there must be as many as ``names`` (separated by spaces) has."""
    wanted = names.split()
    if len(fields) != len(wanted):
        raise ProtocolError(
            f"{len(fields)} fields where {len(wanted)} belong ({', '.join(wanted) or 'none'})"
        )
    return tuple(fields)


# Identity, clock, site ---------------------------------------------------------------------------


def identity_to_fields(identity: UnitIdentity) -> list[str]:
    """Reply to ``ID``. Spaces within the names are written as underscores."""
    names = (identity.model, identity.serial, identity.firmware)
    letters = "".join(sorted(identity.extensions)) or "-"
    return [*("_".join(name.split()) for name in names), str(identity.protocol), letters]


def identity_from_fields(fields: Sequence[str]) -> UnitIdentity:
    model, serial, firmware, protocol, letters = expect(
        fields, "model serial firmware protocol extensions"
    )
    if letters != "-" and not (letters.isascii() and letters.isalpha()):
        raise ProtocolError(f"field extensions: {letters!r} is neither letters nor '-'")
    extensions = frozenset() if letters == "-" else frozenset(letters)
    return UnitIdentity(
        model, serial, firmware, values.whole_number(protocol, "protocol"), extensions
    )


def clock_to_fields(unit_utc_s: float, zone_west_h: float) -> list[str]:
    """Reply to ``CLOCK`` and ``CLOCK SET``."""
    return [values.local_time_text(unit_utc_s, zone_west_h), values.number_text(zone_west_h, 2)]


def clock_from_fields(fields: Sequence[str]) -> tuple[float, float]:
    """The unit's UTC (its local clock plus its zone) and its zone, hours west."""
    local_time, zone = expect(fields, "local_time zone")
    zone_west_h = values.zone_west_h(zone)
    return values.utc_from_local_time(local_time, zone_west_h), zone_west_h


def site_to_fields(unit_site: UnitSite) -> list[str]:
    """Reply to ``SITE`` and ``SITE SET``."""
    return [
        *site_set_to_fields(unit_site.site, unit_site.zone_west_h),
        unit_site.geometry,
        values.number_text(unit_site.ax1_centre_deg),
    ]


def site_from_fields(fields: Sequence[str]) -> UnitSite:
    latitude, longitude, elevation_m, zone, geometry, ax1_centre = expect(
        fields, "latitude longitude elevation_m zone geometry ax1_centre"
    )
    if geometry not in GEOMETRIES:
        raise ProtocolError(f"field geometry: {geometry!r} is not one of {' '.join(GEOMETRIES)}")
    centre_deg = values.number(ax1_centre, "ax1_centre")
    if not abs(centre_deg) <= 360.0:
        raise ProtocolError(f"field ax1_centre: {ax1_centre} is not between -360 and 360")
    return UnitSite(
        values.site(latitude, longitude, elevation_m),
        values.zone_west_h(zone),
        geometry,
        centre_deg,
    )


def site_set_to_fields(site: Site, zone_west_h: float) -> list[str]:
    """Arguments of ``SITE SET``."""
    return [
        values.number_text(site.latitude_deg),
        values.number_text(site.longitude_deg),
        values.number_text(site.elevation_m, 1),
        values.number_text(zone_west_h, 2),
    ]


def site_set_from_fields(fields: Sequence[str]) -> tuple[Site, float]:
    latitude, longitude, elevation_m, zone = expect(fields, "latitude longitude elevation_m zone")
    return values.site(latitude, longitude, elevation_m), values.zone_west_h(zone)


# Status, jog, reference check --------------------------------------------------------------------


def status_to_fields(
    status: Status, zone_west_h: float, tilt_decimals: int = TILT_DECIMALS
) -> list[str]:
    """Reply to ``STATUS`` and ``OFFSET SET``."""
    flags = _REFERENCED * status.referenced + _MEMORIES_DIFFER * status.memories_differ
    return [
        status.mode.value,
        values.local_time_text(status.unit_utc_s, zone_west_h),
        values.number_text(status.ideal1_deg),
        values.number_text(status.ideal2_deg),
        values.number_text(status.reading1_deg),
        values.number_text(status.reading2_deg),
        str(status.counts1),
        str(status.counts2),
        values.number_text(status.target1_deg),
        values.number_text(status.target2_deg),
        values.number_text(status.offsets.O1, tilt_decimals),
        values.number_text(status.offsets.O2, tilt_decimals),
        values.senses_text(status.moving),
        values.senses_text(status.approach),
        str(min(99, max(0, int(status.update_phase * 100.0)))),
        f"{flags:02X}",
        str(max(0, int(status.unlocked_s))),
    ]


def status_from_fields(fields: Sequence[str], zone_west_h: float) -> Status:
    (
        mode, local_time, ideal1, ideal2, reading1, reading2, counts1, counts2, target1, target2,
        o1, o2, motion, approach, phase, flags, unlocked,
    ) = expect(
        fields,
        "mode local_time ideal1 ideal2 reading1 reading2 counts1 counts2 target1 target2"
        " O1 O2 motion approach phase flags unlocked",
    )  # fmt: skip
    if mode not in Mode.__members__:
        raise ProtocolError(f"field mode: {mode!r} is not one of {' '.join(Mode.__members__)}")
    percent = values.whole_number(phase, "phase")
    if not 0 <= percent <= 99:
        raise ProtocolError(f"field phase: {phase} is not between 0 and 99")
    if not re.fullmatch(r"[0-9A-F]{2}", flags):
        raise ProtocolError(f"field flags: {flags!r} is not two hexadecimal digits")
    bits = int(flags, 16)
    return Status(
        mode=Mode(mode),
        unit_utc_s=values.utc_from_local_time(local_time, zone_west_h),
        ideal1_deg=values.number(ideal1, "ideal1", -540.0, 540.0),
        ideal2_deg=values.number(ideal2, "ideal2", 0.0, 180.0),
        reading1_deg=values.number(reading1, "reading1"),
        reading2_deg=values.number(reading2, "reading2"),
        counts1=values.whole_number(counts1, "counts1"),
        counts2=values.whole_number(counts2, "counts2"),
        target1_deg=values.number(target1, "target1"),
        target2_deg=values.number(target2, "target2"),
        offsets=Offsets(values.number(o1, "O1"), values.number(o2, "O2")),
        moving=values.senses(motion, "motion"),
        approach=values.senses(approach, "approach"),
        update_phase=percent / 100.0,
        referenced=bool(bits & _REFERENCED),
        unlocked_s=float(values.whole_number(unlocked, "unlocked")),
        memories_differ=bool(bits & _MEMORIES_DIFFER),
    )


def jog_to_fields(target1_deg: float, target2_deg: float) -> list[str]:
    """Arguments of ``JOG`` and its reply."""
    return [values.number_text(target1_deg), values.number_text(target2_deg)]


def jog_from_fields(fields: Sequence[str]) -> tuple[float, float]:
    target1, target2 = expect(fields, "target1 target2")
    return values.number(target1, "target1"), values.number(target2, "target2")


def ref_check_to_fields(result: RefCheckResult) -> list[str]:
    """Reply to ``REF``."""
    if result.complete:
        state = "DONE"
    elif result.running:
        state = "RUNNING"
    else:
        state = "BROKEN" if result.number else "NONE"
    return [str(result.number), state, str(result.difference1), str(result.difference2)]


def ref_check_from_fields(fields: Sequence[str]) -> RefCheckResult:
    count, state, difference1, difference2 = expect(fields, "number state difference1 difference2")
    if state not in ("NONE", "RUNNING", "DONE", "BROKEN"):
        raise ProtocolError(f"field state: {state!r} is not one of NONE RUNNING DONE BROKEN")
    return RefCheckResult(
        number=values.whole_number(count, "number"),
        complete=state == "DONE",
        difference1=values.whole_number(difference1, "difference1"),
        difference2=values.whole_number(difference2, "difference2"),
        running=state == "RUNNING",
    )


# Coefficients ------------------------------------------------------------------------------------


def coefficients_to_fields(
    coefficients: Coefficients,
    offsets: Offsets,
    tilt_decimals: int = TILT_DECIMALS,
    scale_decimals: int = SCALE_DECIMALS,
) -> list[str]:
    """Arguments of ``COEF SET``, and the reply to it and to ``COEF`` and ``COEF STORED``."""
    tilts = coefficients.as_tuple()[:4]
    scales = coefficients.as_tuple()[4:]
    return [
        *(values.number_text(value, tilt_decimals) for value in tilts),
        *(values.number_text(value, scale_decimals) for value in scales),
        *(values.number_text(value, tilt_decimals) for value in (offsets.O1, offsets.O2)),
    ]


def coefficients_from_fields(fields: Sequence[str]) -> tuple[Coefficients, Offsets]:
    names = (*COEFFICIENT_NAMES, "O1", "O2")
    texts = expect(fields, " ".join(names))
    numbers = [values.number(text, name) for text, name in zip(texts, names, strict=True)]
    return Coefficients(*numbers[:6]), Offsets(*numbers[6:])


# Emulator only -----------------------------------------------------------------------------------


def times_to_fields(true_utc_s: float, laptop_utc_s: float) -> list[str]:
    """Reply to ``X ADVANCE``, and the first two fields of the reply to ``X TIME``."""
    return [format_utc(true_utc_s), format_utc(laptop_utc_s)]


def times_from_fields(fields: Sequence[str]) -> tuple[float, float]:
    """True and laptop UTC, POSIX seconds."""
    true_utc, laptop_utc = expect(fields, "true_utc laptop_utc")
    return (
        values.utc_from_iso(true_utc, "true_utc"),
        values.utc_from_iso(laptop_utc, "laptop_utc"),
    )


def times_and_speed_to_fields(true_utc_s: float, laptop_utc_s: float, speed: float) -> list[str]:
    """Reply to ``X TIME``."""
    return [*times_to_fields(true_utc_s, laptop_utc_s), values.number_text(speed, 3)]


def times_and_speed_from_fields(fields: Sequence[str]) -> tuple[tuple[float, float], float]:
    true_utc, laptop_utc, speed = expect(fields, "true_utc laptop_utc speed")
    return times_from_fields((true_utc, laptop_utc)), values.number(speed, "speed")


def sky_to_fields(sky: EmulatedSky) -> list[str]:
    """``sun pressure temperature`` of ``X SKY``."""
    return [
        sky.sun,
        values.number_text(sky.weather.pressure_hpa, 1),
        values.number_text(sky.weather.temperature_c, 1),
    ]


def sky_from_fields(fields: Sequence[str]) -> EmulatedSky:
    """What ``X SKY`` answers; raises ProtocolError."""
    sun, pressure, temperature = expect(fields, "sun pressure temperature")
    if sun not in SKY_SUNS:
        raise ProtocolError(f"field sun: {sun!r} is not one of {' '.join(SKY_SUNS)}")
    try:
        weather = Weather(
            values.number(pressure, "pressure"), values.number(temperature, "temperature")
        )
    except ConfigurationError as error:
        raise ProtocolError(str(error)) from None
    return EmulatedSky(sun, weather)


def speed_to_fields(speed: float) -> list[str]:
    """Argument of ``X SPEED`` and its reply."""
    return [values.number_text(speed, 3)]


def speed_from_fields(fields: Sequence[str]) -> float:
    (speed,) = expect(fields, "speed")
    return values.number(speed, "speed")


def spot_to_fields(spot: Spot) -> list[str]:
    """Reply to ``X SPOT``."""
    errors = (values.number_text(spot.error1_deg), values.number_text(spot.error2_deg))
    return ["1" if spot.visible else "0", *errors]


def spot_from_fields(fields: Sequence[str]) -> Spot:
    visible, error1, error2 = expect(fields, "visible error1 error2")
    if visible not in ("0", "1"):
        raise ProtocolError(f"field visible: {visible!r} is neither 0 nor 1")
    return Spot(visible == "1", values.number(error1, "error1"), values.number(error2, "error2"))


def truth_to_fields(truth: Truth) -> list[str]:
    """Reply to ``X TRUTH``."""
    errors = (truth.day_rms_deg, truth.day_max_deg, truth.year_rms_deg)
    coefficients = coefficients_to_fields(truth.coefficients, Offsets())[:6]
    return [*coefficients, *(values.number_text(error) for error in errors)]


def truth_from_fields(fields: Sequence[str]) -> Truth:
    names = (*COEFFICIENT_NAMES, "day_rms", "day_max", "year_rms")
    texts = expect(fields, " ".join(names))
    numbers = [values.number(text, name) for text, name in zip(texts, names, strict=True)]
    return Truth(Coefficients(*numbers[:6]), *numbers[6:])
