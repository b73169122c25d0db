"""The Moon as target: where it is, whether a tracker can use it, and its passage of one day."""

from typing import Any

import numpy as np

from solarcal.instruments.form import Answer, Drawing, Form, paragraph
from solarcal.instruments.mount_and_collector import asked_mount
from solarcal.mount.geometry import MountGeometry
from solarcal.report.blocks import columns, number
from solarcal.report.instrument_plots import Curve, curve_plot
from solarcal.report.scales import Sheet
from solarcal.site import Site
from solarcal.sun.moon import (
    BRIGHT_ENOUGH,
    HIGH_ENOUGH_DEG,
    LUNAR_DAY_S,
    MoonDay,
    MoonPosition,
    moon_day,
    moon_position,
)
from solarcal.timescale import format_utc

_DRAWN = 149


def moon(form: Form, utc_s: float, site: Site, mount: MountGeometry) -> Answer:
    """The Moon at an instant, and whether a tracker can use it."""
    now = moon_position(utc_s, site, form.number("dut1"))
    ax1_deg, ax2_deg = mount.axes_from_horizontal(float(now.azimuth_deg), float(now.zenith_deg))
    document = {
        "target": "moon",
        "utc": format_utc(utc_s),
        "azimuth_deg": float(now.azimuth_deg),
        "zenith_deg": float(now.zenith_deg),
        "elevation_deg": float(now.elevation_deg),
        "distance_km": float(now.distance_km),
        "semidiameter_deg": float(now.semidiameter_deg),
        **_phase(now),
        "usable": bool(now.usable),
        "geometry": mount.name,
        "ax1_deg": float(ax1_deg),
        "ax2_deg": float(ax2_deg),
    }
    lines = [f"Moon, airless, seen from the site, {document['utc']}"]
    for label, value, unit in (
        ("azimuth (N through E)", f"{now.azimuth_deg:.4f}", "deg"),
        ("zenith angle", f"{now.zenith_deg:.4f}", "deg"),
        ("elevation", f"{now.elevation_deg:+.4f}", "deg"),
        ("distance", f"{now.distance_km:.0f}", "km"),
        ("semidiameter", f"{now.semidiameter_deg:.4f}", "deg"),
        ("illuminated", f"{100.0 * now.illuminated:.1f}", "%"),
        (f"AX1 ({mount.name})", f"{ax1_deg:+.4f}", "deg"),
        (f"AX2 ({mount.name})", f"{ax2_deg:.4f}", "deg"),
    ):
        lines.append(f"  {label:<24}{value:>10} {unit}".rstrip())
    lines.append(
        f"  {'waxing' if now.waxing else 'waning'}; "
        + (_not_usable(now) or "high and bright enough to follow")
    )
    return Answer(document, (paragraph(*lines),), None)


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
        "moonrise_utc": _iso(day.rise_utc_s),
        "transit_utc": _iso(day.transit_utc_s),
        "moonset_utc": _iso(day.set_utc_s),
        "transit_elevation_deg": float(best.elevation_deg),
        **_phase(best),
        "usable_utc": None if day.usable_utc_s is None else list(map(_iso, day.usable_utc_s)),
    }
    lines = [
        f"The Moon's passage nearest to {document['utc']}",
        f"  moonrise {document['moonrise_utc'] or 'none'}",
        f"  transit  {document['transit_utc']}  {float(best.elevation_deg):+.3f} deg high",
        f"  moonset  {document['moonset_utc'] or 'none'}",
        f"  {100.0 * float(best.illuminated):.1f} % lit, {'waxing' if best.waxing else 'waning'}",
    ]
    if day.usable_utc_s is None:
        lines.append(f"  {_not_usable(best)}")
    else:
        first, last = document["usable_utc"]
        lines.append(f"  high and bright enough from {first} to {last}")
    if every_min is not None:
        rows = _rows(day, site, 60.0 * every_min, dut1_s)
        at = moon_position(rows, site, dut1_s)
        axes = mount.axes_from_horizontal(at.azimuth_deg, at.zenith_deg)
        within = limits.distance_deg(*axes) >= 0.0
        document["table"] = [
            {
                "utc": format_utc(float(rows[i])),
                "azimuth_deg": float(at.azimuth_deg[i]),
                "elevation_deg": float(at.elevation_deg[i]),
                "illuminated": float(at.illuminated[i]),
                "ax1_deg": float(axes[0][i]),
                "ax2_deg": float(axes[1][i]),
                "within_limits": bool(within[i]),
            }
            for i in range(rows.size)
        ]
        lines += ["", *_table_lines(document["table"], mount.name, limited)]

    def draw(sheet: Sheet) -> str:
        hours = np.linspace(-0.5, 0.5, _DRAWN) * LUNAR_DAY_S / 3600.0
        path = moon_position(day.transit_utc_s + 3600.0 * hours, site, dut1_s)
        up = path.elevation_deg >= 0.0
        kept = up if up.any() else np.ones_like(up)
        return curve_plot(
            "elevation, deg", hours[kept], [Curve("Moon", path.elevation_deg[kept], "●")],
            "hours from transit", sheet,
        )  # fmt: skip

    chart = Drawing("the passage", draw, None)
    if form.choice("chart") == "yes":
        return Answer(document, (paragraph(*lines, ""), chart))
    return Answer(document, (paragraph(*lines),), chart)


def _phase(at: MoonPosition) -> dict[str, Any]:
    return {
        "phase_deg": float(at.phase_deg),
        "illuminated": float(at.illuminated),
        "waxing": bool(at.waxing),
    }


def _not_usable(at: MoonPosition) -> str:
    """Why a tracker cannot use it; empty where it can."""
    reasons = [
        text
        for text, lacking in (
            (f"lower than {HIGH_ENOUGH_DEG:g} deg", at.elevation_deg < HIGH_ENOUGH_DEG),
            (f"less than {BRIGHT_ENOUGH:.0%} lit", at.illuminated < BRIGHT_ENOUGH),
        )
        if lacking
    ]
    return f"not usable: {', '.join(reasons)}" if reasons else ""


def _rows(
    day: MoonDay, site: Site, step_s: float, dut1_s: float
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Whole multiples of the step in UTC with the Moon up, within the passage."""
    first_s, last_s = (day.transit_utc_s + half * LUNAR_DAY_S for half in (-0.5, 0.5))
    times = step_s * np.arange(np.ceil(first_s / step_s), np.floor(last_s / step_s) + 1.0)
    return times[moon_position(times, site, dut1_s).elevation_deg >= 0.0]


def _iso(at_s: float | None) -> str | None:
    return None if at_s is None else format_utc(at_s)


def _table_lines(rows: list[dict[str, Any]], geometry: str, limited: bool) -> list[str]:
    if not rows:
        return ["The Moon is not up in this passage: no table."]
    headings = ["UTC", "azimuth", "elevation", "lit %", "AX1", "AX2"]
    lines = [
        [
            row["utc"][:16].replace("T", " "),
            number(row["azimuth_deg"], 3),
            number(row["elevation_deg"], 3, signed=True),
            number(100.0 * row["illuminated"], 1),
            number(row["ax1_deg"], 3, signed=True),
            number(row["ax2_deg"], 3),
            *(["" if row["within_limits"] else "beyond"] if limited else []),
        ]
        for row in rows
    ]
    headings += ["limits"] if limited else []
    align = "<>>>>>" + ("<" if limited else "")
    return [f"Airless Moon, degrees; AX1 and AX2 of {geometry}", *columns(headings, lines, align)]
