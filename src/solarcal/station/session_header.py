"""The first line of a session: the unit as it answers, and what the technician says beside it."""

from typing import TypedDict

import msgspec

from solarcal import __version__
from solarcal.decimals import Six
from solarcal.errors import ProcedureRefused
from solarcal.mount.drive import Drive
from solarcal.mount.formula import Coefficients
from solarcal.profiles import Profile
from solarcal.session.points import SITE_TOLERANCE_DEG
from solarcal.session.records import Header, UnitRecord
from solarcal.site import (
    BoltCircle,
    Inclinometer,
    Site,
    Weather,
    longitude_apart_deg,
    standard_pressure_hpa,
)
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule
from solarcal.timescale import format_utc
from solarcal.unit.tracker import Tracker, UnitIdentity, UnitParameters, UnitSite


class SessionSettings(TypedDict, total=False):
    """What a header says beside the unit.

    ``site``: the technician's; the unit's own when None. ``weather``: station pressure and
    temperature; the standard atmosphere's when None. ``rule``: when the calibration is done.
    ``true_sun``: the Sun the points are taken on; another than ``precise`` only in an emulated
    world. ``target``: what the points are taken on, ``sun`` or ``moon``.
    """

    site: Site | None
    weather: Weather | None
    true_sun: str
    target: str
    operator: str
    pointing_device: str
    rule: StoppingRule
    inclinometer: Inclinometer | None
    last_coefficients: Six | None
    bolt_circle: BoltCircle | None


def profile_settings(profile: Profile, clock_s: float) -> SessionSettings:
    """What a profile says of a session; ``clock_s``: how well the laptop's clock is known."""
    return {
        "site": profile.site,
        "weather": profile.weather,
        "operator": profile.operator,
        "pointing_device": profile.pointing_device,
        "rule": profile.rule(clock_s),
        "inclinometer": profile.inclinometer,
        "last_coefficients": profile.last_coefficients,
        "bolt_circle": profile.bolt_circle,
    }


def refuse_another_unit(
    header: Header, identity: UnitIdentity, site: UnitSite, parameters: UnitParameters
) -> None:
    """A session goes on with its own unit, set up as it was; limits and decimals may differ.

    Raises
    ------
    ProcedureRefused
        The unit is another one, or its read-outs have another meaning than in the session.
    """
    ours = header.unit
    name = f"unit {ours.model} {ours.serial}"
    if (identity.model, identity.serial) != (ours.model, ours.serial):
        raise ProcedureRefused(
            f"the session belongs to {name}, but {identity.model} {identity.serial} is connected; "
            "start a new session"
        )
    for what, now, then in (
        ("geometry", site.geometry, header.geometry),
        ("centre of the branch of axis 1", site.ax1_centre_deg, header.ax1_centre_deg),
        ("reference position of axis 1", parameters.reference1_deg, ours.reference1_deg),
        ("reference position of axis 2", parameters.reference2_deg, ours.reference2_deg),
        ("drive of axis 1", _drive_words(parameters.drive1), _drive_words(ours.drive1)),
        ("drive of axis 2", _drive_words(parameters.drive2), _drive_words(ours.drive2)),
    ):
        if now != then:
            raise ProcedureRefused(
                f"{name} has another {what} now ({now}) than in this session ({then}): the "
                "session's points and coefficients do not apply; calibrate again"
            )
    for what, here, there in (
        ("latitude", site.site.latitude_deg, ours.site.latitude_deg),
        ("longitude", site.site.longitude_deg, ours.site.longitude_deg),
    ):
        # Latitudes are never so far apart that it matters.
        if abs(longitude_apart_deg(here, there)) > SITE_TOLERANCE_DEG:
            raise ProcedureRefused(
                f"{name} has been given another {what} ({here:g} deg) than it had in this "
                f"session ({there:g} deg); set it back, or calibrate again"
            )


def _drive_words(drive: Drive) -> str:
    return ", ".join(f"{name} {value}" for name, value in msgspec.structs.asdict(drive).items())


def session_header(
    tracker: Tracker,
    identity: UnitIdentity,
    unit_site: UnitSite,
    utc_s: float,
    settings: SessionSettings,
    continues: str = "",
) -> Header:
    """The header of a session that begins now; asks the unit for its parameters and coefficients.

    Raises
    ------
    LinkError, ProtocolError, UnitRefused
        As the unit answers.
    """
    parameters, stored = tracker.parameters(), tracker.stored()
    site = settings.get("site") or unit_site.site
    rule = settings.get("rule", DEFAULT_RULE)
    last = settings.get("last_coefficients")
    return Header(
        utc=format_utc(utc_s),
        software=f"solarcal {__version__}",
        unit=UnitRecord(
            model=identity.model,
            serial=identity.serial,
            firmware=identity.firmware,
            zone_west_h=unit_site.zone_west_h,
            drive1=parameters.drive1,
            drive2=parameters.drive2,
            limits=parameters.limits,
            update_range_deg=parameters.update_range_deg,
            reference1_deg=parameters.reference1_deg,
            reference2_deg=parameters.reference2_deg,
            tilt_decimals=parameters.tilt_decimals,
            scale_decimals=parameters.scale_decimals,
            site=unit_site.site,
            heliostat=parameters.heliostat,
            has_switches=tracker.capabilities.has_switches,
        ),
        site=site,
        geometry=unit_site.geometry,
        ax1_centre_deg=unit_site.ax1_centre_deg,
        true_sun=settings.get("true_sun", "precise"),
        target=settings.get("target", "sun"),
        tolerance_deg=rule.tolerance_deg,
        done_probability=rule.probability,
        unmodelled=rule.unmodelled,
        coefficients=stored.coefficients,
        offsets=stored.offsets,
        operator=settings.get("operator", ""),
        weather=settings.get("weather")
        or Weather(pressure_hpa=round(standard_pressure_hpa(site.elevation_m), 1)),
        pointing_device=settings.get("pointing_device", ""),
        continues=continues,
        inclinometer=settings.get("inclinometer"),
        last_coefficients=None if last is None else Coefficients(*last),
        bolt_circle=settings.get("bolt_circle"),
    )
