"""What a year brings: the Sun month by month, and what a collector catches of it.

``energy`` follows SUNCALC: at a moment, over a day, over a year.
"""

import math
from typing import Any

import numpy as np

from solarcal.instruments.form import Answer, Form, answered
from solarcal.instruments.mount_and_collector import (
    asked_collector,
    asked_mount,
    collector_document,
    collector_text,
)
from solarcal.instruments.sun import iso
from solarcal.mount.reach import reach_of_day
from solarcal.report.blocks import columns, number
from solarcal.report.instrument_plots import Curve, curve_plot
from solarcal.report.scales import Sheet
from solarcal.sun.circular_orbit import CircularDay, days_after_march_equinox
from solarcal.sun.day import DayEvents, day_events
from solarcal.sun.energy import (
    SUNCALC_W_M2,
    day_kwh_m2,
    day_percent,
    disc_percent,
    moment_percent,
    moment_w_m2,
    pointing_loss,
    suncalc_day_percent,
    year_percent,
)
from solarcal.timescale import (
    SECONDS_PER_DAY,
    SECONDS_PER_SUN_DEG,
    format_utc,
    parse_utc,
    time_of_day,
)

_MONTH_DAY = 21
_WEEK_S = 7.0 * SECONDS_PER_DAY


def year(form: Form) -> Answer:
    """The 21st of each month, and the whole year."""
    site = form.site()
    collector = asked_collector(form, site.latitude_deg)
    geometry, limits, limited = asked_mount(form, site)
    mount = (geometry, limits) if limited else None
    lowest_deg, asked = form.number("lowest"), form.optional("year")
    if asked is not None and asked != int(asked):
        raise form.error("year", f"{asked:g} is not a whole number")
    number_of_year = int(format_utc(form.now_utc_s)[:4]) if asked is None else int(asked)

    def noon_utc_s(date: str) -> float:
        return parse_utc(f"{date}T12:00:00Z") - SECONDS_PER_SUN_DEG * site.longitude_deg

    def reach_h(events: DayEvents) -> float | None:
        if mount is None:
            return None
        return reach_of_day(site, *mount, events.transit_utc_s, lowest_deg=lowest_deg).hours

    months = []
    for month in range(1, 13):
        date = f"{number_of_year}-{month:02d}-{_MONTH_DAY}"
        noon_s = noon_utc_s(date)
        events = day_events(noon_s, site)
        day = CircularDay(site.latitude_deg, days_after_march_equinox(noon_s))
        months.append(
            {
                "date": date,
                "sunrise_utc": iso(events.sunrise_utc_s),
                "transit_utc": iso(events.transit_utc_s),
                "sunset_utc": iso(events.sunset_utc_s),
                "daylight_h": events.daylight_s / 3600.0,
                "transit_elevation_deg": events.transit_elevation_deg,
                "polar": events.polar,
                "within_limits_h": reach_h(events),
                "energy_percent": day_percent(collector, day),
            }
        )
    first_s = noon_utc_s(f"{number_of_year}-01-01")
    weeks = [day_events(first_s + week * _WEEK_S, site) for week in range(52)]
    days = 366 if number_of_year % 4 == 0 else 365
    reaches = [reach_h(events) for events in weeks]
    document: dict[str, Any] = {
        "year": number_of_year,
        "latitude_deg": site.latitude_deg,
        "longitude_deg": site.longitude_deg,
        "collector": collector_document(collector),
        "months": months,
        "whole_year": {
            "daylight_h": sum(events.daylight_s for events in weeks) / 3600.0 * days / len(weeks),
            "within_limits_h": None
            if mount is None
            else sum(reach or 0.0 for reach in reaches) * days / len(weeks),
            "energy_percent": year_percent(collector, site.latitude_deg),
        },
    }
    lines = [
        f"{number_of_year} at latitude {site.latitude_deg:g}, longitude {site.longitude_deg:g}; "
        "times UTC",
        "Energy in percent of full Sun all day and night",
        f"Collector {collector_text(collector)}",
        "",
        *_month_lines(document),
    ]

    def draw(sheet: Sheet) -> str:
        curves = [Curve("daylight", np.array([m["daylight_h"] for m in months]), "●")]
        if mount is not None:
            curves.append(
                Curve("within limits", np.array([m["within_limits_h"] for m in months]), "+")
            )
        return curve_plot("hours a day", np.arange(1.0, 13.0), curves, "month", sheet)

    return answered(document, lines, "over the year", draw)


def _month_lines(document: dict[str, Any]) -> list[str]:
    def clock(iso: str | None) -> str:
        return "-" if iso is None else time_of_day(parse_utc(iso))

    lines = [
        [
            month["date"],
            clock(month["sunrise_utc"]),
            clock(month["transit_utc"]),
            clock(month["sunset_utc"]),
            number(month["daylight_h"], 2),
            number(month["transit_elevation_deg"], 2, signed=True),
            number(month["within_limits_h"], 2),
            number(month["energy_percent"], 2),
            {"day": "day", "night": "night", None: ""}[month["polar"]],
        ]
        for month in document["months"]
    ]
    whole = document["whole_year"]
    lines.append(
        [
            "whole year",
            "",
            "",
            "",
            number(whole["daylight_h"], 0),
            "",
            number(whole["within_limits_h"], 0),
            number(whole["energy_percent"], 2),
            "",
        ]
    )
    headings = ["date", "rise", "noon", "set", "day h", "high", "limits h", "energy %", "polar"]
    shown = len(headings) if any(line[-1] for line in lines) else len(headings) - 1
    rows = [line[:shown] for line in lines]
    return columns(headings[:shown], rows, "<<<<>>>><"[:shown])


SEASON_DAYS = (0, 91, 182, 273)
SEASONS = ("March equinox", "June solstice", "September equinox", "December solstice")
_DRAWN_HOURS = 97


def energy(form: Form) -> Answer:
    """A collector at a latitude, some days after the March equinox."""
    latitude_deg, solar_time_h = form.number("lat"), form.number("time")
    collector = asked_collector(form, latitude_deg)
    pointing_error_deg, acceptance_deg = form.optional("error"), form.optional("acceptance")
    if acceptance_deg is not None and pointing_error_deg is None:
        raise form.error(
            "acceptance", f"needs the error whose cost is computed: give {form.label('error')} too"
        )
    date = form.text("date")
    if date:
        noon = date if "T" in date else f"{date}T12:00Z"
        days = days_after_march_equinox(form.instant("date", noon))
    else:
        days = form.number("day")
    day = CircularDay(latitude_deg, days)
    moment = moment_percent(collector, day, solar_time_h)
    north, east, up = day.direction_neu(solar_time_h).tolist()
    pointing = None
    if pointing_error_deg is not None:
        loss = pointing_loss(collector, day, pointing_error_deg)
        pointing = {
            "error_deg": loss.error_deg,
            "lost_percent": loss.lost_percent,
            "worst_bearing_deg": loss.worst_bearing_deg,
            "disc_percent": None
            if acceptance_deg is None
            else disc_percent(acceptance_deg, pointing_error_deg),
        }
    percent: dict[str, Any] = {
        "moment": moment,
        "day": suncalc_day_percent(collector, day),
        "day_integrated": day_percent(collector, day),
        "year": year_percent(collector, latitude_deg),
        "seasons": {
            str(number): suncalc_day_percent(collector, CircularDay(latitude_deg, number))
            for number in SEASON_DAYS
        },
    }
    turbidity, height_m = form.number("turbidity"), form.number("height")
    irradiance = {
        "outside_w_m2": SUNCALC_W_M2,
        "moment_outside_w_m2": moment / 100.0 * SUNCALC_W_M2,
        "day_outside_kwh_m2": percent["day_integrated"] / 100.0 * 24.0 * SUNCALC_W_M2 / 1e3,
        "clear_sky_w_m2": moment_w_m2(collector, day, solar_time_h, turbidity, height_m),
        "clear_sky_kwh_m2": day_kwh_m2(collector, day, turbidity, height_m),
        "turbidity": turbidity,
    }
    document: dict[str, Any] = {
        "latitude_deg": latitude_deg,
        "day": day.day,
        "solar_time_h": solar_time_h,
        "collector": collector_document(collector),
        "sun": {
            "north": north,
            "east": east,
            "up": up,
            "elevation_deg": day.elevation_deg(solar_time_h),
            "high_sun_deg": day.high_sun_deg,
            "sunrise_bearing_deg": day.sunrise_bearing_deg,
            "never_sets": day.never_sets,
        },
        "daylight_h": day.daylight_h,
        "dawn_h": day.dawn_h,
        "dusk_h": day.dusk_h,
        "due_east_h": day.due_east_h,
        "due_west_h": day.due_west_h,
        "percent": percent,
        "irradiance": irradiance,
        "pointing": pointing,
    }
    rows = [
        ("Sun towards", f"N {north:+z.6f}  E {east:+z.6f}  U {up:+z.6f}"),
        ("elevation", f"{day.elevation_deg(solar_time_h):z.6f} deg"),
        ("highest", f"{day.high_sun_deg:.6f} deg at noon"),
        *_horizon_rows(day),
        ("due east, due west", _due_text(day)),
        ("caught now", f"{moment:.6f} % of full Sun"),
        ("over the day", f"{percent['day']:.6f} % (SUNCALC's 100 steps)"),
        ("", f"{percent['day_integrated']:.6f} % (integrated)"),
        ("over the year", f"{percent['year']:.6f} %"),
    ]
    for season, name in zip(SEASON_DAYS, SEASONS, strict=True):
        rows.append((f"day {season}", f"{percent['seasons'][str(season)]:.6f} % ({name})"))
    rows += [
        (
            "outside the air",
            f"{irradiance['moment_outside_w_m2']:.0f} W/m2 of 1.40 kW/m2 now, "
            f"{irradiance['day_outside_kwh_m2']:.2f} kWh/m2 a day",
        ),
        (
            "direct, clear sky",
            f"{irradiance['clear_sky_w_m2']:.0f} W/m2 now, "
            f"{irradiance['clear_sky_kwh_m2']:.2f} kWh/m2 a day (Linke turbidity {turbidity:g})",
        ),
        ("to sight the Sun", _sighting(day, solar_time_h)),
    ]
    rows += _pointing_rows(pointing, acceptance_deg)
    lines = [
        f"Latitude {latitude_deg:g}, {day.day:g} days after the March equinox, "
        f"{solar_time_h:g} h solar",
        f"Collector {collector_text(collector)}",
        "",
        *(f"  {label:<20}{text}" for label, text in rows),
    ]

    def draw(sheet: Sheet) -> str:
        hours = np.linspace(0.0, 24.0, _DRAWN_HOURS)
        caught = np.array([moment_percent(collector, day, float(one)) for one in hours])
        return curve_plot(
            "caught, % of full Sun", hours, [Curve("collector", caught, "●")],
            "solar time, h", sheet, hours=True, marks=[(solar_time_h, "the time asked")],
        )  # fmt: skip

    return answered(document, lines, "over the day", draw)


def _horizon_rows(day: CircularDay) -> list[tuple[str, str]]:
    if day.never_sets == "day":
        return [("daylight", f"24 h: the Sun shines all day, lowest {day.low_sun_deg:.3f} deg")]
    if day.dawn_h is None or day.dusk_h is None or day.sunrise_bearing_deg is None:
        return [("daylight", "none: the Sun is hidden all day")]
    bearing = day.sunrise_bearing_deg
    return [
        ("rises", f"{bearing:.6f} deg from East towards North"),
        ("dawn, dusk", f"{day.dawn_h:.6f} h, {day.dusk_h:.6f} h solar time"),
        ("daylight", f"{day.daylight_h:.6f} h"),
    ]


def _sighting(day: CircularDay, solar_time_h: float) -> str:
    """Where to look: bearing from North through East, and height."""
    north, east, _ = day.direction_neu(solar_time_h).tolist()
    height = day.elevation_deg(solar_time_h)
    if height <= 0.0:
        return f"it is below the horizon, {-height:.3f} deg"
    bearing = math.degrees(math.atan2(east, north)) % 360.0
    return f"look towards bearing {bearing:.3f}, {height:z.3f} deg up"


def _due_text(day: CircularDay) -> str:
    if day.due_east_h is None or day.due_west_h is None:
        side = "North" if day.declination_deg > day.latitude_deg else "South"
        return f"never: the Sun stays in the {side}"
    times = f"{day.due_east_h:.6f} h, {day.due_west_h:.6f} h solar time"
    height = day.elevation_deg(day.due_east_h)
    where = "below the horizon" if height < -1e-9 else f"{abs(height):.3f} deg high"
    return f"{times}, {where}"


def _pointing_rows(
    pointing: dict[str, float | None] | None, acceptance_deg: float | None
) -> list[tuple[str, str]]:
    if pointing is None:
        return []
    bearing = pointing["worst_bearing_deg"]
    rows = [
        (
            "pointing error",
            f"{pointing['error_deg']:g} deg costs {pointing['lost_percent']:.6f} % "
            "of the day's energy",
        )
    ]
    if bearing is not None:
        rows.append(("", f"at worst: tipped towards azimuth {bearing:.1f}"))
    if acceptance_deg is not None:
        rows.append(
            (
                "concentrator",
                f"accepting {acceptance_deg:g} deg sees {pointing['disc_percent']:.3f} % "
                "of the Sun's disc",
            )
        )
    return rows
