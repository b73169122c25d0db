"""Forms about the Sun: where it is, its day and year, what a collector makes of it."""

from typing import TYPE_CHECKING

from solarcal.tui.calculators.form import (
    GEOMETRY_FIELDS,
    PLACE_FIELDS,
    TIME_FIELD,
    Calculator,
    Form,
    FormField,
)

if TYPE_CHECKING:
    from solarcal.mount.geometry import MountGeometry
    from solarcal.mount.limits import Limits
    from solarcal.report.field.answer import Answer
    from solarcal.site import Site
    from solarcal.sun.energy import Collector

_LIMITS = (
    FormField("limits1", "AX1 from, to", "deg", hint="anywhere"),
    FormField("limits2", "AX2 from, to", "deg", hint="anywhere"),
    FormField("lowest", "Sun counts from", "deg", "0"),
)
_COLLECTOR = (
    FormField(
        "collector", "Collector", default="level",
        choices=("level", "tilted", "normal", "tracking", "one axis"),
    ),
    FormField("tilt", "tilted by", "deg", "30"),
    FormField("facing", "towards azimuth", "deg", hint="equator"),
    FormField("vector", "normal, axis", "N E U", "1 0 0"),
)  # fmt: skip


def _geometry(form: Form, latitude_deg: float) -> "MountGeometry":
    from solarcal.mount.geometry import MountGeometry, default_ax1_centre

    name, centre = form.choice("geometry"), form.optional("centre")
    if centre is None:
        centre = default_ax1_centre(name, latitude_deg)
    return MountGeometry(name, latitude_deg, centre)


def _mount(form: Form, site: "Site") -> "tuple[MountGeometry, Limits, bool]":
    """The mount, its limits, and whether any were given."""
    from solarcal.mount.limits import AxisLimits, Limits

    geometry = _geometry(form, site.latitude_deg)
    first, second = form.pair("limits1"), form.pair("limits2")
    centre = geometry.ax1_centre_deg
    limits = Limits(
        AxisLimits(*(first or (centre - 180.0, centre + 180.0))),
        AxisLimits(*(second or (0.0, 180.0))),
    )
    return geometry, limits, first is not None or second is not None


def _collector(form: Form, latitude_deg: float) -> "Collector":
    from solarcal.report.field.collector import tilted
    from solarcal.sun.energy import FixedCollector, OneAxisCollector, TrackingCollector

    kind = form.choice("collector")
    if kind == "tracking":
        return TrackingCollector()
    if kind == "tilted":
        return tilted(form.number("tilt"), form.optional("facing"), latitude_deg)
    if kind == "level":
        return FixedCollector()
    vector = form.numbers("vector", 3)
    if vector is None:
        raise form.error("vector", "write North, East and Up parts, like 1 0 0")
    parts = (vector[0], vector[1], vector[2])
    return FixedCollector(parts) if kind == "normal" else OneAxisCollector(parts)


def _sun(form: Form) -> "Answer":
    from solarcal.report.field.sun import sun
    from solarcal.site import Weather, standard_pressure_hpa

    site = form.site()
    pressure = form.optional("pressure")
    if pressure is None:
        pressure = standard_pressure_hpa(site.elevation_m)
    return sun(
        form.utc_s("at"),
        site,
        _geometry(form, site.latitude_deg),
        model=form.choice("model"),
        refraction=form.choice("refraction"),
        weather=Weather(pressure, form.number("temperature")),
        dut1_s=form.number("dut1"),
    )


def _day(form: Form) -> "Answer":
    from solarcal.report.field.day import AskedDay, day

    site = form.site()
    geometry, limits, limited = _mount(form, site)
    return day(
        AskedDay(
            form.day_utc_s("at", site),
            site,
            geometry,
            limits,
            limited=limited,
            method=form.choice("method"),
            altitude_deg=form.optional("altitude"),
            lowest_deg=form.number("lowest"),
            table_every_min=form.optional("every"),
        )
    )


def _year(form: Form) -> "Answer":
    from solarcal.report.field.year import year
    from solarcal.timescale import format_utc

    site = form.site()
    geometry, limits, limited = _mount(form, site)
    asked = form.optional("year")
    if asked is None:
        asked = float(format_utc(form.now_utc_s)[:4])
    return year(
        int(asked),
        site,
        _collector(form, site.latitude_deg),
        (geometry, limits) if limited else None,
        lowest_deg=form.number("lowest"),
    )


def _energy(form: Form) -> "Answer":
    from solarcal.report.field.energy import energy
    from solarcal.sun.circular_orbit import days_after_march_equinox

    date = form.text("date")
    if date:
        noon = date if "T" in date else f"{date}T12:00Z"
        days = days_after_march_equinox(form.instant("date", noon))
    else:
        days = form.number("day")
    error, acceptance = form.optional("error"), form.optional("acceptance")
    if acceptance is not None and error is None:
        raise form.error("acceptance", "asks what an error costs: give the error too")
    latitude = form.number("lat")
    return energy(
        latitude,
        days,
        form.number("time"),
        _collector(form, latitude),
        pointing_error_deg=error,
        acceptance_deg=acceptance,
    )


CALCULATORS = (
    Calculator(
        "sun", "The Sun", "Sun position", "where the Sun is, and the axes that look at it",
        (
            *PLACE_FIELDS, TIME_FIELD,
            FormField(
                "model", "Model", default="precise",
                choices=("precise", "solartrak", "solartrak+", "noaa"),
            ),
            *GEOMETRY_FIELDS,
            FormField(
                "refraction", "Refraction", default="none",
                choices=("none", "hughes", "saemundsson"),
            ),
            FormField("pressure", "Station pressure", "hPa", hint="mean air"),
            FormField("temperature", "Temperature", "C", "15"),
            FormField("dut1", "UT1 - UTC", "s", "0"),
        ),
        _sun,
    ),
    Calculator(
        "day", "The Sun", "Day", "sunrise, noon, sunset; when the Sun is within limits",
        (
            *PLACE_FIELDS, TIME_FIELD, *GEOMETRY_FIELDS, *_LIMITS,
            FormField("every", "Table every", "min", hint="none"),
            FormField("method", "Method", default="precise", choices=("precise", "noaa")),
            FormField("altitude", "Rises at altitude", "deg", hint="-0.833"),
        ),
        _day,
    ),
    Calculator(
        "year", "The Sun", "Year", "the Sun month by month, hours within limits",
        (
            *PLACE_FIELDS, FormField("year", "Year", hint="this year"),
            *_COLLECTOR, *GEOMETRY_FIELDS, *_LIMITS,
        ),
        _year,
    ),
    Calculator(
        "energy", "The Sun", "Collector energy", "for the moment, the day and the year (SUNCALC)",
        (
            FormField("lat", "Latitude", "deg N", "42"),
            FormField("day", "Days after equinox", "d", "91"),
            FormField("date", "or the date", hint="YYYY-MM-DD"),
            FormField("time", "Solar time", "h", "12"),
            *_COLLECTOR,
            FormField("error", "Pointing error", "deg", hint="none"),
            FormField("acceptance", "Half acceptance", "deg", hint="none"),
        ),
        _energy,
    ),
)  # fmt: skip
