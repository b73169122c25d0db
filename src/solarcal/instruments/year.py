"""The Sun of one site month by month, and what a mount and a collector make of it."""

from typing import Any

import numpy as np

from solarcal.instruments.form import Answer, Drawing, Form, paragraph
from solarcal.instruments.mount_and_collector import (
    asked_collector,
    asked_mount,
    collector_document,
    collector_text,
)
from solarcal.mount.reach import reach_of_day
from solarcal.report.blocks import columns, number
from solarcal.report.instrument_plots import Curve, curve_plot
from solarcal.report.scales import Sheet
from solarcal.sun.circular_orbit import CircularDay, days_after_march_equinox
from solarcal.sun.day import DayEvents, day_events
from solarcal.sun.energy import day_percent, year_percent
from solarcal.timescale import SECONDS_PER_DAY, SECONDS_PER_SUN_DEG, format_utc, parse_utc

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
                "sunrise_utc": _iso(events.sunrise_utc_s),
                "transit_utc": _iso(events.transit_utc_s),
                "sunset_utc": _iso(events.sunset_utc_s),
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

    return Answer(document, (paragraph(*lines),), Drawing("over the year", draw))


def _iso(at_s: float | None) -> str | None:
    return None if at_s is None else format_utc(at_s)


def _month_lines(document: dict[str, Any]) -> list[str]:
    def clock(iso: str | None) -> str:
        return "-" if iso is None else iso[11:16]

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
