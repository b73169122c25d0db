"""One day: rise, transit and set of Sun or Moon, the solar clock, when a mount can follow."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from solarcal.instruments.form import Answer, Drawing, Form
from solarcal.instruments.mount_and_collector import asked_mount
from solarcal.instruments.sun import iso, moon_not_usable, moon_phase, solar_clock
from solarcal.mount.reach import AxisPath, axis_path, reach_of_day
from solarcal.report.blocks import columns, number
from solarcal.report.instrument_plots import Curve, DayTrack, curve_plot, day_chart
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
from solarcal.sun.moon import LUNAR_DAY_S, MoonDay, moon_day, moon_position
from solarcal.timescale import format_utc
from solarcal.units import FloatArray

_CHART_STEP_S = 300.0
_HALF_DAY_S = 43200.0
_DRAWN = 149


def day(form: Form) -> Answer:
    """The solar day nearest to the instant asked about."""
    site = form.site()
    utc_s = form.day_utc_s("at", site)
    if form.choice("target") == "moon":
        return moon_passage(form, utc_s, site)
    geometry, limits, limited = asked_mount(form, site)
    method, altitude_deg = form.choice("method"), form.optional("altitude")
    lowest_deg, dut1_s = form.number("lowest"), form.number("dut1")
    every_min = form.optional("every")
    if method == "noaa":
        altitude_deg = NOAA_SUNRISE_ALTITUDE_DEG if altitude_deg is None else altitude_deg
        events = noaa_day_events(utc_s, site, altitude_deg=altitude_deg)
    else:
        altitude_deg = SUNRISE_ALTITUDE_DEG if altitude_deg is None else altitude_deg
        events = day_events(utc_s, site, altitude_deg=altitude_deg, dut1_s=dut1_s)
    now = sun_position(method, utc_s, site, dut1_s=dut1_s)
    document: dict[str, Any] = {
        "utc": iso(utc_s),
        "method": method,
        "altitude_deg": altitude_deg,
        "sunrise_utc": iso(events.sunrise_utc_s),
        "transit_utc": iso(events.transit_utc_s),
        "sunset_utc": iso(events.sunset_utc_s),
        "transit_elevation_deg": events.transit_elevation_deg,
        "daylight_h": events.daylight_s / 3600.0,
        "polar": events.polar,
        "solar_time": solar_clock(now.solar_time_h),
        "equation_of_time_min": now.equation_of_time_min,
    }
    lines = _event_lines(document, events)
    if limited:
        reach = reach_of_day(
            site, geometry, limits, events.transit_utc_s, lowest_deg=lowest_deg, dut1_s=dut1_s
        )
        document["within_limits"] = {
            "hours": reach.hours,
            "spans_utc": [[iso(first), iso(last)] for first, last in reach.spans_utc_s],
            "crosses_branch": reach.crosses_branch,
        }
        lines += _reach_lines(document["within_limits"], geometry.name)

    def path(first_s: float, last_s: float, step_s: float) -> AxisPath:
        """The Sun from one instant to another, at whole multiples of the step in UTC."""
        count = math.floor(last_s / step_s) - math.ceil(first_s / step_s) + 1
        times = (math.ceil(first_s / step_s) + np.arange(max(count, 1), dtype=np.float64)) * step_s
        return axis_path(site, geometry, limits, times, lowest_deg=lowest_deg, dut1_s=dut1_s)

    if every_min is not None:
        rows: list[dict[str, Any]] = []
        if events.span_utc_s is not None:
            rows = _sun_rows(path(*events.span_utc_s, 60.0 * every_min), site, dut1_s)
        document["table"] = rows
        lines += ["", *_table_lines("Sun", "that day", _SUN_COLUMNS, rows, geometry.name, limited)]

    def draw(sheet: Sheet) -> str:
        transit_s = events.transit_utc_s
        drawn = path(transit_s - _HALF_DAY_S, transit_s + _HALF_DAY_S, _CHART_STEP_S)
        sun = sun_position("precise", drawn.utc_s, site, dut1_s=dut1_s)
        since_h = (drawn.utc_s - transit_s) / 3600.0
        # Nearly midnight at either end: the clock must not jump over it.
        solar_h = 12.0 + np.mod(sun.solar_time_h - 12.0 - since_h + 12.0, 24.0) - 12.0
        track = DayTrack(
            solar_time_h=solar_h + since_h,
            azimuth_deg=drawn.azimuth_deg,
            elevation_deg=drawn.elevation_deg,
            within_limits=drawn.margin_deg >= 0.0 if limited else None,
            latitude_deg=site.latitude_deg,
        )
        return day_chart(track, sheet)

    return _with_chart(form, document, lines, Drawing("the day", draw, None))


def _with_chart(
    form: Form, document: dict[str, Any], lines: Sequence[str], chart: Drawing
) -> Answer:
    """The chart below the text where it is asked for, else for a screen only."""
    if form.choice("chart") == "yes":
        return Answer(document, ("\n".join([*lines, ""]), chart))
    return Answer(document, ("\n".join(lines),), chart)


def _sun_rows(path: AxisPath, site: Site, dut1_s: float) -> list[dict[str, Any]]:
    sun = sun_position("precise", path.utc_s, site, dut1_s=dut1_s)
    return _rows(
        {
            "utc": map(format_utc, path.utc_s.tolist()),
            "solar_time": map(solar_clock, sun.solar_time_h.tolist()),
            "azimuth_deg": path.azimuth_deg.tolist(),
            "elevation_deg": path.elevation_deg.tolist(),
            "ax1_deg": path.ax1_deg.tolist(),
            "ax2_deg": path.ax2_deg.tolist(),
            "within_limits": (path.margin_deg >= 0.0).tolist(),
        }
    )


def _rows(by_name: Mapping[str, Iterable[Any]]) -> list[dict[str, Any]]:
    """Columns as rows, each a part of the document."""
    return [dict(zip(by_name, row, strict=True)) for row in zip(*by_name.values(), strict=True)]


def _event_lines(document: dict[str, Any], events: DayEvents) -> list[str]:
    altitude_deg = document["altitude_deg"]
    lines = [
        f"The solar day nearest to {document['utc']}, by {document['method']}",
        f"  sunrise  {document['sunrise_utc'] or 'none'}",
        f"  transit  {document['transit_utc']}  {events.transit_elevation_deg:+z.3f} deg high",
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
        f"(equation of time {document['equation_of_time_min']:+z.3f} min)"
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


_SUN_COLUMNS = ("UTC", "solar", "azimuth", "elevation", "AX1", "AX2")
_MOON_COLUMNS = ("UTC", "azimuth", "elevation", "lit %", "AX1", "AX2")
_CELLS: dict[str, tuple[str, Callable[[dict[str, Any]], str]]] = {
    "UTC": ("<", lambda row: str(row["utc"][:16].replace("T", " "))),
    "solar": ("<", lambda row: str(row["solar_time"])),
    "azimuth": (">", lambda row: number(row["azimuth_deg"], 3)),
    "elevation": (">", lambda row: number(row["elevation_deg"], 3, signed=True)),
    "lit %": (">", lambda row: number(100.0 * row["illuminated"], 1)),
    "AX1": (">", lambda row: number(row["ax1_deg"], 3, signed=True)),
    "AX2": (">", lambda row: number(row["ax2_deg"], 3)),
    "limits": ("<", lambda row: "" if row["within_limits"] else "beyond"),
}
"""Heading -> side of the cells, and a cell of a row."""


def _table_lines(
    body: str, when: str, names: tuple[str, ...], rows: list[dict[str, Any]], geometry: str,
    limited: bool,
) -> list[str]:  # fmt: skip
    if not rows:
        return [f"The {body} is not up {when}: no table."]
    names += ("limits",) if limited else ()
    sides = "".join(_CELLS[name][0] for name in names)
    cells = [[_CELLS[name][1](row) for name in names] for row in rows]
    return [f"Airless {body}, degrees; AX1 and AX2 of {geometry}", *columns(names, cells, sides)]


def moon_passage(form: Form, utc_s: float, site: Site) -> Answer:
    """Rise, transit and set of the passage nearest to an instant, and when the Moon is usable."""
    if form.choice("method") != "precise":
        raise form.error("method", "NOAA's formulas are of the Sun; leave it out for the Moon")
    mount, limits, limited = asked_mount(form, site)
    dut1_s, every_min = form.number("dut1"), form.optional("every")
    day = moon_day(utc_s, site, altitude_deg=form.optional("altitude"), dut1_s=dut1_s)
    best = day.at_transit
    document: dict[str, Any] = {
        "target": "moon",
        "utc": format_utc(utc_s),
        "moonrise_utc": iso(day.rise_utc_s),
        "transit_utc": iso(day.transit_utc_s),
        "moonset_utc": iso(day.set_utc_s),
        "transit_elevation_deg": float(best.elevation_deg),
        **moon_phase(best),
        "usable_utc": None if day.usable_utc_s is None else list(map(iso, day.usable_utc_s)),
    }
    lines = [
        f"The Moon's passage nearest to {document['utc']}",
        f"  moonrise {document['moonrise_utc'] or 'none'}",
        f"  transit  {document['transit_utc']}  {float(best.elevation_deg):+z.3f} deg high",
        f"  moonset  {document['moonset_utc'] or 'none'}",
        f"  {100.0 * float(best.illuminated):.1f} % lit, {'waxing' if best.waxing else 'waning'}",
    ]
    if day.usable_utc_s is None:
        lines.append(f"  {moon_not_usable(best)}")
    else:
        first, last = document["usable_utc"]
        lines.append(f"  high and bright enough from {first} to {last}")
    if every_min is not None:
        times = _passage_times(day, site, 60.0 * every_min, dut1_s)
        at = moon_position(times, site, dut1_s)
        ax1, ax2 = mount.axes_from_horizontal(at.azimuth_deg, at.zenith_deg)
        rows = _rows(
            {
                "utc": map(format_utc, times.tolist()),
                "azimuth_deg": at.azimuth_deg.tolist(),
                "elevation_deg": at.elevation_deg.tolist(),
                "illuminated": at.illuminated.tolist(),
                "ax1_deg": ax1.tolist(),
                "ax2_deg": ax2.tolist(),
                "within_limits": (limits.distance_deg(ax1, ax2) >= 0.0).tolist(),
            }
        )
        document["table"] = rows
        where = "in this passage"
        lines += ["", *_table_lines("Moon", where, _MOON_COLUMNS, rows, mount.name, limited)]

    def draw(sheet: Sheet) -> str:
        hours = np.linspace(-0.5, 0.5, _DRAWN) * LUNAR_DAY_S / 3600.0
        path = moon_position(day.transit_utc_s + 3600.0 * hours, site, dut1_s)
        up = path.elevation_deg >= 0.0
        kept = up if up.any() else np.ones_like(up)
        return curve_plot(
            "elevation, deg", hours[kept], [Curve("Moon", path.elevation_deg[kept], "●")],
            "hours from transit", sheet,
        )  # fmt: skip

    return _with_chart(form, document, lines, Drawing("the passage", draw, None))


def _passage_times(day: MoonDay, site: Site, step_s: float, dut1_s: float) -> FloatArray:
    """Whole multiples of the step in UTC with the Moon up, within the passage."""
    first_s, last_s = (day.transit_utc_s + half * LUNAR_DAY_S for half in (-0.5, 0.5))
    times = step_s * np.arange(np.ceil(first_s / step_s), np.floor(last_s / step_s) + 1.0)
    return times[moon_position(times, site, dut1_s).elevation_deg >= 0.0]
