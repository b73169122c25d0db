"""What the fields of each request and reply mean: tracker dataclasses above, ``verbs`` below.

For both ends: ``..._to_fields`` writes, ``..._from_fields`` reads. Reading is strict: a wrong
number of fields, a number that is none, a word the protocol does not know raise ``ProtocolError``
with the field's name. A unit answers that with refusal 13.
"""

from collections.abc import Sequence

from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients, Offsets
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
from solarcal.unit.verbs import SCALE_DECIMALS, TILT_DECIMALS, expect, read, verb, write

__all__ = ["SCALE_DECIMALS", "TILT_DECIMALS", "expect"]

_REFERENCED, _MEMORIES_DIFFER = 1, 2


# Identity, clock, site ---------------------------------------------------------------------------


def identity_to_fields(identity: UnitIdentity) -> list[str]:
    """Reply to ``ID``. Spaces within the names are written as underscores."""
    names = (identity.model, identity.serial, identity.firmware)
    model, serial, firmware = ("_".join(name.split()) for name in names)
    content = {
        "model": model,
        "serial": serial,
        "firmware": firmware,
        "protocol": identity.protocol,
        "extensions": "".join(sorted(identity.extensions)) or "-",
    }
    return write(verb("ID").reply, content)


def identity_from_fields(fields: Sequence[str]) -> UnitIdentity:
    f = read(verb("ID").reply, fields)
    extensions = frozenset() if f["extensions"] == "-" else frozenset(f["extensions"])
    return UnitIdentity(f["model"], f["serial"], f["firmware"], f["protocol"], extensions)


def clock_to_fields(unit_utc_s: float, zone_west_h: float) -> list[str]:
    """Reply to ``CLOCK`` and ``CLOCK SET``."""
    local_time = values.local_time_text(unit_utc_s, zone_west_h)
    return write(verb("CLOCK").reply, {"local_time": local_time, "zone": zone_west_h})


def clock_from_fields(fields: Sequence[str]) -> tuple[float, float]:
    """The unit's UTC (its local clock plus its zone) and its zone, hours west."""
    f = read(verb("CLOCK").reply, fields)
    return values.utc_from_local_time(f["local_time"], f["zone"]), f["zone"]


def site_to_fields(unit_site: UnitSite) -> list[str]:
    """Reply to ``SITE`` and ``SITE SET``."""
    site = unit_site.site
    content = {
        "latitude": site.latitude_deg,
        "longitude": site.longitude_deg,
        "elevation_m": site.elevation_m,
        "zone": unit_site.zone_west_h,
        "geometry": unit_site.geometry,
        "ax1_centre": unit_site.ax1_centre_deg,
    }
    return write(verb("SITE").reply, content)


def site_from_fields(fields: Sequence[str]) -> UnitSite:
    f = read(verb("SITE").reply, fields)
    site = Site(f["latitude"], f["longitude"], f["elevation_m"])
    return UnitSite(site, f["zone"], f["geometry"], f["ax1_centre"])


def site_set_from_fields(fields: Sequence[str]) -> tuple[Site, float]:
    """Arguments of ``SITE SET``."""
    f = read(verb("SITE SET").arguments, fields)
    return Site(f["latitude"], f["longitude"], f["elevation_m"]), f["zone"]


# Status, jog, reference check --------------------------------------------------------------------


def status_to_fields(
    status: Status, zone_west_h: float, tilt_decimals: int = TILT_DECIMALS
) -> list[str]:
    """Reply to ``STATUS`` and ``OFFSET SET``."""
    flags = _REFERENCED * status.referenced + _MEMORIES_DIFFER * status.memories_differ
    content = {
        "mode": status.mode.value,
        "local_time": values.local_time_text(status.unit_utc_s, zone_west_h),
        "ideal1": status.ideal1_deg,
        "ideal2": status.ideal2_deg,
        "reading1": status.reading1_deg,
        "reading2": status.reading2_deg,
        "counts1": status.counts1,
        "counts2": status.counts2,
        "target1": status.target1_deg,
        "target2": status.target2_deg,
        "O1": status.offsets.O1,
        "O2": status.offsets.O2,
        "motion": status.moving,
        "approach": status.approach,
        "phase": min(99, max(0, int(status.update_phase * 100.0))),
        "flags": f"{flags:02X}",
        "unlocked": max(0, int(status.unlocked_s)),
    }
    return write(verb("STATUS").reply, content, (tilt_decimals, SCALE_DECIMALS))


def status_from_fields(fields: Sequence[str], zone_west_h: float) -> Status:
    f = read(verb("STATUS").reply, fields)
    bits = int(f["flags"], 16)
    return Status(
        mode=Mode(f["mode"]),
        unit_utc_s=values.utc_from_local_time(f["local_time"], zone_west_h),
        ideal1_deg=f["ideal1"],
        ideal2_deg=f["ideal2"],
        reading1_deg=f["reading1"],
        reading2_deg=f["reading2"],
        counts1=f["counts1"],
        counts2=f["counts2"],
        target1_deg=f["target1"],
        target2_deg=f["target2"],
        offsets=Offsets(f["O1"], f["O2"]),
        moving=f["motion"],
        approach=f["approach"],
        update_phase=f["phase"] / 100.0,
        referenced=bool(bits & _REFERENCED),
        unlocked_s=float(f["unlocked"]),
        memories_differ=bool(bits & _MEMORIES_DIFFER),
    )


def jog_to_fields(target1_deg: float, target2_deg: float) -> list[str]:
    """Arguments of ``JOG`` and its reply."""
    return write(verb("JOG").reply, {"target1": target1_deg, "target2": target2_deg})


def jog_from_fields(fields: Sequence[str]) -> tuple[float, float]:
    f = read(verb("JOG").arguments, fields)
    return f["target1"], f["target2"]


def ref_check_to_fields(result: RefCheckResult) -> list[str]:
    """Reply to ``REF``."""
    if result.complete:
        state = "DONE"
    elif result.running:
        state = "RUNNING"
    else:
        state = "BROKEN" if result.number else "NONE"
    content = {
        "number": result.number,
        "state": state,
        "difference1": result.difference1,
        "difference2": result.difference2,
    }
    return write(verb("REF").reply, content)


def ref_check_from_fields(fields: Sequence[str]) -> RefCheckResult:
    f = read(verb("REF").reply, fields)
    return RefCheckResult(
        number=f["number"],
        complete=f["state"] == "DONE",
        difference1=f["difference1"],
        difference2=f["difference2"],
        running=f["state"] == "RUNNING",
    )


# Coefficients ------------------------------------------------------------------------------------


def coefficients_to_fields(
    coefficients: Coefficients,
    offsets: Offsets,
    tilt_decimals: int = TILT_DECIMALS,
    scale_decimals: int = SCALE_DECIMALS,
) -> list[str]:
    """Arguments of ``COEF SET``, and the reply to it and to ``COEF`` and ``COEF STORED``."""
    content = dict(zip(COEFFICIENT_NAMES, coefficients.as_tuple(), strict=True))
    content |= {"O1": offsets.O1, "O2": offsets.O2}
    return write(verb("COEF").reply, content, (tilt_decimals, scale_decimals))


def coefficients_from_fields(fields: Sequence[str]) -> tuple[Coefficients, Offsets]:
    f = read(verb("COEF").reply, fields)
    return Coefficients(*(f[name] for name in COEFFICIENT_NAMES)), Offsets(f["O1"], f["O2"])


# Emulator only -----------------------------------------------------------------------------------


def times_to_fields(true_utc_s: float, laptop_utc_s: float) -> list[str]:
    """Reply to ``X ADVANCE``, and the first two fields of the reply to ``X TIME``."""
    content = {"true_utc": format_utc(true_utc_s), "laptop_utc": format_utc(laptop_utc_s)}
    return write(verb("X ADVANCE").reply, content)


def times_from_fields(fields: Sequence[str]) -> tuple[float, float]:
    """True and laptop UTC, POSIX seconds."""
    f = read(verb("X ADVANCE").reply, fields)
    return (
        values.utc_from_iso(f["true_utc"], "true_utc"),
        values.utc_from_iso(f["laptop_utc"], "laptop_utc"),
    )


def times_and_speed_to_fields(true_utc_s: float, laptop_utc_s: float, speed: float) -> list[str]:
    """Reply to ``X TIME``."""
    return [*times_to_fields(true_utc_s, laptop_utc_s), *speed_to_fields(speed)]


def times_and_speed_from_fields(fields: Sequence[str]) -> tuple[tuple[float, float], float]:
    f = read(verb("X TIME").reply, fields)
    return times_from_fields((f["true_utc"], f["laptop_utc"])), f["speed"]


def advance_to_fields(seconds: float) -> list[str]:
    """Argument of ``X ADVANCE``."""
    return write(verb("X ADVANCE").arguments, {"seconds": seconds})


def advance_from_fields(fields: Sequence[str]) -> float:
    seconds: float = read(verb("X ADVANCE").arguments, fields)["seconds"]
    return seconds


def sky_to_fields(sky: EmulatedSky) -> list[str]:
    """Reply to ``X SKY``."""
    weather = sky.weather
    content = {
        "sun": sky.sun,
        "pressure": weather.pressure_hpa,
        "temperature": weather.temperature_c,
    }
    return write(verb("X SKY").reply, content)


def sky_from_fields(fields: Sequence[str]) -> EmulatedSky:
    f = read(verb("X SKY").reply, fields)
    try:
        return EmulatedSky(f["sun"], Weather(f["pressure"], f["temperature"]))
    except ConfigurationError as error:
        raise ProtocolError(str(error)) from None


def speed_to_fields(speed: float) -> list[str]:
    """Argument of ``X SPEED`` and its reply."""
    return write(verb("X SPEED").reply, {"speed": speed})


def speed_from_fields(fields: Sequence[str]) -> float:
    speed: float = read(verb("X SPEED").reply, fields)["speed"]
    return speed


def spot_to_fields(spot: Spot) -> list[str]:
    """Reply to ``X SPOT``."""
    content = {
        "visible": "1" if spot.visible else "0",
        "error1": spot.error1_deg,
        "error2": spot.error2_deg,
    }
    return write(verb("X SPOT").reply, content)


def spot_from_fields(fields: Sequence[str]) -> Spot:
    f = read(verb("X SPOT").reply, fields)
    return Spot(f["visible"] == "1", f["error1"], f["error2"])


def truth_to_fields(truth: Truth) -> list[str]:
    """Reply to ``X TRUTH``."""
    content = dict(zip(COEFFICIENT_NAMES, truth.coefficients.as_tuple(), strict=True))
    content |= {
        "day_rms": truth.day_rms_deg,
        "day_max": truth.day_max_deg,
        "year_rms": truth.year_rms_deg,
    }
    return write(verb("X TRUTH").reply, content)


def truth_from_fields(fields: Sequence[str]) -> Truth:
    f = read(verb("X TRUTH").reply, fields)
    coefficients = Coefficients(*(f[name] for name in COEFFICIENT_NAMES))
    return Truth(coefficients, f["day_rms"], f["day_max"], f["year_rms"])
