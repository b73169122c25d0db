"""One solar day: sunrise, transit, sunset, the solar clock, when the Sun is within limits."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from solarcal.instruments.form import Answer, Drawing, Form, paragraph
from solarcal.instruments.moon import moon_passage
from solarcal.instruments.mount_and_collector import asked_mount
from solarcal.instruments.sun import clock_face
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.limits import Limits
from solarcal.mount.reach import AxisPath, axis_path, reach_of_day
from solarcal.report.blocks import columns, number
from solarcal.report.instrument_plots import DayTrack, day_chart
from solarcal.report.scales import Sheet
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.day import (
    NOAA_SUNRISE_ALTITUDE_DEG,
    SUNRISE_ALTITUDE_DEG,
    DayEvents,
    day_events,
    noaa_day_events,
)
from solarcal.timescale import format_utc

_CHART_STEP_S = 300.0
_HALF_DAY_S = 43200.0


@dataclass(frozen=True, slots=True)
class AskedDay:
    """Which day, where, and for which mount.

    ``limited``: the mount's limits were asked about; ``table_every_min``: rows of a table.
    ``altitude_deg`` counts as rising and setting; None takes the method's own.
    """

    utc_s: float
    site: Site
    geometry: MountGeometry
    limits: Limits
    limited: bool = False
    method: str = "precise"
    altitude_deg: float | None = None
    lowest_deg: float = 0.0
    dut1_s: float = 0.0
    table_every_min: float | None = None
    chart: bool = False

    def events(self) -> tuple[float, DayEvents]:
        """The altitude that counts as rising, and what happens."""
        altitude = self.altitude_deg
        if self.method == "noaa":
            altitude = NOAA_SUNRISE_ALTITUDE_DEG if altitude is None else altitude
            return altitude, noaa_day_events(self.utc_s, self.site, altitude_deg=altitude)
        altitude = SUNRISE_ALTITUDE_DEG if altitude is None else altitude
        events = day_events(self.utc_s, self.site, altitude_deg=altitude, dut1_s=self.dut1_s)
        return altitude, events

    def path(self, first_s: float, last_s: float, step_s: float) -> AxisPath:
        """The Sun from one instant to another, at whole multiples of the step in UTC."""
        count = math.floor(last_s / step_s) - math.ceil(first_s / step_s) + 1
        times = (math.ceil(first_s / step_s) + np.arange(max(count, 1), dtype=np.float64)) * step_s
        return axis_path(
            self.site, self.geometry, self.limits, times,
            lowest_deg=self.lowest_deg, dut1_s=self.dut1_s,
        )  # fmt: skip


def day(form: Form) -> Answer:
    """The solar day nearest to the instant asked about."""
    site = form.site()
    utc_s = form.day_utc_s("at", site)
    if form.choice("target") == "moon":
        return moon_passage(form, utc_s, site)
    geometry, limits, limited = asked_mount(form, site)
    asked = AskedDay(
        utc_s,
        site,
        geometry,
        limits,
        limited=limited,
        method=form.choice("method"),
        altitude_deg=form.optional("altitude"),
        lowest_deg=form.number("lowest"),
        dut1_s=form.number("dut1"),
        table_every_min=form.optional("every"),
        chart=form.choice("chart") == "yes",
    )
    altitude_deg, events = asked.events()
    now = sun_position(asked.method, asked.utc_s, asked.site, dut1_s=asked.dut1_s)
    document: dict[str, Any] = {
        "utc": _iso(asked.utc_s),
        "method": asked.method,
        "altitude_deg": altitude_deg,
        "sunrise_utc": _iso(events.sunrise_utc_s),
        "transit_utc": _iso(events.transit_utc_s),
        "sunset_utc": _iso(events.sunset_utc_s),
        "transit_elevation_deg": events.transit_elevation_deg,
        "daylight_h": events.daylight_s / 3600.0,
        "polar": events.polar,
        "solar_time": clock_face(now.solar_time_h),
        "equation_of_time_min": now.equation_of_time_min,
    }
    lines = _event_lines(document, events)
    if asked.limited:
        reach = reach_of_day(
            asked.site,
            asked.geometry,
            asked.limits,
            events.transit_utc_s,
            lowest_deg=asked.lowest_deg,
            dut1_s=asked.dut1_s,
        )
        document["within_limits"] = {
            "hours": reach.hours,
            "spans_utc": [[_iso(first), _iso(last)] for first, last in reach.spans_utc_s],
            "crosses_branch": reach.crosses_branch,
        }
        lines += _reach_lines(document["within_limits"], asked.geometry.name)
    if asked.table_every_min is not None:
        document["table"] = _rows(asked, events, asked.table_every_min)
        lines += ["", *_table_lines(document["table"], asked.geometry.name, asked.limited)]
    chart = Drawing("the day", lambda sheet: _chart(asked, events, sheet), None)
    if asked.chart:
        return Answer(document, (paragraph(*lines, ""), chart))
    return Answer(document, (paragraph(*lines),), chart)


def _iso(at_s: float | None) -> str | None:
    return None if at_s is None else format_utc(at_s)


def _rows(asked: AskedDay, events: DayEvents, every_min: float) -> list[dict[str, Any]]:
    span = events.span_utc_s
    if span is None:
        return []
    path = asked.path(*span, 60.0 * every_min)
    sun = sun_position("precise", path.utc_s, asked.site, dut1_s=asked.dut1_s)
    return [
        {
            "utc": format_utc(float(path.utc_s[i])),
            "solar_time": clock_face(float(sun.solar_time_h[i])),
            "azimuth_deg": float(path.azimuth_deg[i]),
            "elevation_deg": float(path.elevation_deg[i]),
            "ax1_deg": float(path.ax1_deg[i]),
            "ax2_deg": float(path.ax2_deg[i]),
            "within_limits": bool(path.margin_deg[i] >= 0.0),
        }
        for i in range(path.utc_s.size)
    ]


def _event_lines(document: dict[str, Any], events: DayEvents) -> list[str]:
    altitude_deg = document["altitude_deg"]
    lines = [
        f"The solar day nearest to {document['utc']}, by {document['method']}",
        f"  sunrise  {document['sunrise_utc'] or 'none'}",
        f"  transit  {document['transit_utc']}  {events.transit_elevation_deg:+.3f} deg high",
        f"  sunset   {document['sunset_utc'] or 'none'}",
    ]
    if events.polar == "day":
        lines.append(
            f"  polar day: the Sun stays above {altitude_deg:.3f} deg from midnight to midnight"
        )
    elif events.polar == "night":
        lines.append(f"  polar night: the Sun stays below {altitude_deg:.3f} deg all day")
    else:
        lines.append(f"  {document['daylight_h']:.3f} h above {altitude_deg:.3f} deg")
    lines.append(
        f"  solar time {document['solar_time']} at the given time "
        f"(equation of time {document['equation_of_time_min']:+.3f} min)"
    )
    return lines


def _reach_lines(within: dict[str, Any], geometry: str) -> list[str]:
    if not within["spans_utc"]:
        return [f"  {geometry}: the Sun is never within the limits that day"]
    lines = [f"  {geometry}: {within['hours']:.3f} h within limits"]
    lines += [f"    {first} to {last}" for first, last in within["spans_utc"]]
    if within["crosses_branch"]:
        lines.append("    axis 1 crosses the edge of its branch: one range cannot cover this day")
    return lines


def _table_lines(rows: list[dict[str, Any]], geometry: str, limited: bool) -> list[str]:
    if not rows:
        return ["The Sun is not up that day: no table."]
    headings = ["UTC", "solar", "azimuth", "elevation", "AX1", "AX2"]
    lines = [
        [
            row["utc"][:16].replace("T", " "),
            row["solar_time"],
            number(row["azimuth_deg"], 3),
            number(row["elevation_deg"], 3, signed=True),
            number(row["ax1_deg"], 3, signed=True),
            number(row["ax2_deg"], 3),
            *(["" if row["within_limits"] else "beyond"] if limited else []),
        ]
        for row in rows
    ]
    align = "<<>>>>" + ("<" if limited else "")
    headings += ["limits"] if limited else []
    return [f"Airless Sun, degrees; AX1 and AX2 of {geometry}", *columns(headings, lines, align)]


def _chart(asked: AskedDay, events: DayEvents, sheet: Sheet) -> str:
    transit_s = events.transit_utc_s
    path = asked.path(transit_s - _HALF_DAY_S, transit_s + _HALF_DAY_S, _CHART_STEP_S)
    sun = sun_position("precise", path.utc_s, asked.site, dut1_s=asked.dut1_s)
    since_h = (path.utc_s - transit_s) / 3600.0
    # Nearly midnight at either end: the clock must not jump over it.
    solar_h = 12.0 + np.mod(sun.solar_time_h - 12.0 - since_h + 12.0, 24.0) - 12.0
    track = DayTrack(
        solar_time_h=solar_h + since_h,
        azimuth_deg=path.azimuth_deg,
        elevation_deg=path.elevation_deg,
        within_limits=path.margin_deg >= 0.0 if asked.limited else None,
        latitude_deg=asked.site.latitude_deg,
    )
    return day_chart(track, sheet)
