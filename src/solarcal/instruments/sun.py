"""Where Sun and Moon are, and which way that turns the axes."""

from typing import Any

import numpy as np

from solarcal.instruments.form import Answer, Form, answered, labelled
from solarcal.instruments.mount_and_collector import asked_geometry
from solarcal.mount.geometry import MountGeometry
from solarcal.report.instrument_plots import Curve, curve_plot
from solarcal.report.scales import Sheet
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun import SunPosition, sun_position
from solarcal.sun.moon import BRIGHT_ENOUGH, HIGH_ENOUGH_DEG, MoonPosition, moon_position
from solarcal.sun.position import compare_models
from solarcal.timescale import clock_face, format_utc
from solarcal.units import Angles

_DRAWN = 97


def solar_clock(hours: float) -> str:
    """HH:MM:SS of [0, 24) hours, rounded to the second."""
    return clock_face(hours * 3600.0)


def iso(at_s: float | None) -> str | None:
    """An instant for a document; None where there is none."""
    return None if at_s is None else format_utc(at_s)


def apparent_sun(utc_s: Angles, site: Site, refraction: str) -> SunPosition[Angles]:
    """The Sun whose light falls on a mirror: precise, refracted by mean air."""
    air = Weather(standard_pressure_hpa(site.elevation_m))
    return sun_position("precise", utc_s, site, refraction=refraction, weather=air)


def asked_sun_deg(form: Form) -> tuple[float, float]:
    """Azimuth and zenith angle: given, or the apparent ones of place and time."""
    given = form.pair("sun")
    if given is not None:
        if not (abs(given[0]) <= 360.0 and 0.0 <= given[1] <= 180.0):
            raise form.error("sun", "give azimuth (-360 to 360) and zenith angle (0 to 180)")
        return given
    if form.of_command and form.optional("lat") is None and form.optional("lon") is None:
        raise form.error("sun", "give the Sun, or place and time")
    sun = apparent_sun(form.utc_s("at"), form.site(), form.choice("refraction"))
    return float(sun.azimuth_deg), float(sun.zenith_deg)


def sun(form: Form) -> Answer:
    """The Sun at an instant by one of the models, and the axes of a mount that look at it."""
    utc_s, site = form.utc_s("at"), form.site()
    mount = asked_geometry(form, site.latitude_deg)
    if form.choice("target") == "moon":
        return moon(form, utc_s, site, mount)
    model, refraction, dut1_s = form.choice("model"), form.choice("refraction"), form.number("dut1")
    pressure = form.optional("pressure")
    if pressure is None:
        pressure = standard_pressure_hpa(site.elevation_m)
    weather = Weather(pressure, form.number("temperature"))
    now = sun_position(model, utc_s, site, dut1_s=dut1_s, refraction=refraction, weather=weather)
    ax1_deg, ax2_deg = mount.axes_from_horizontal(now.azimuth_deg, now.zenith_deg)
    solar_time = solar_clock(now.solar_time_h)
    document = {
        "utc": format_utc(now.utc_s),
        "model": model,
        "azimuth_deg": now.azimuth_deg,
        "zenith_deg": now.zenith_deg,
        "elevation_deg": now.elevation_deg,
        "declination_deg": now.declination_deg,
        "equation_of_time_min": now.equation_of_time_min,
        "solar_time": solar_time,
        "geometry": mount.name,
        "ax1_deg": float(ax1_deg),
        "ax2_deg": float(ax2_deg),
    }
    air = "airless" if refraction == "none" else f"refracted ({refraction})"
    lines = [f"Sun by {model}, {air}, {document['utc']}"]
    lines += labelled(
        ("azimuth (N through E)", f"{now.azimuth_deg:.4f}", "deg"),
        ("zenith angle", f"{now.zenith_deg:.4f}", "deg"),
        ("elevation", f"{now.elevation_deg:+z.4f}", "deg"),
        ("declination", f"{now.declination_deg:+z.4f}", "deg"),
        ("equation of time", f"{now.equation_of_time_min:+z.3f}", "min"),
        ("apparent solar time", solar_time, ""),
        (f"AX1 ({mount.name})", f"{ax1_deg:+z.4f}", "deg"),
        (f"AX2 ({mount.name})", f"{ax2_deg:z.4f}", "deg"),
    )

    def draw(sheet: Sheet) -> str:
        hours = np.linspace(0.0, 24.0, _DRAWN)
        times = utc_s + 3600.0 * (hours - now.solar_time_h)
        day = sun_position(model, times, site, dut1_s=dut1_s)
        up = day.elevation_deg >= 0.0
        kept = up if up.any() else np.ones_like(up)
        return curve_plot(
            "elevation, deg", hours[kept], [Curve("Sun", day.elevation_deg[kept], "●")],
            "apparent solar time, h", sheet, hours=True,
            marks=[(float(now.solar_time_h), "this moment")],
        )  # fmt: skip

    return answered(document, lines, "that day", draw)


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
        **moon_phase(now),
        "usable": bool(now.usable),
        "geometry": mount.name,
        "ax1_deg": float(ax1_deg),
        "ax2_deg": float(ax2_deg),
    }
    lines = [f"Moon, airless, seen from the site, {document['utc']}"]
    lines += labelled(
        ("azimuth (N through E)", f"{now.azimuth_deg:.4f}", "deg"),
        ("zenith angle", f"{now.zenith_deg:.4f}", "deg"),
        ("elevation", f"{now.elevation_deg:+z.4f}", "deg"),
        ("distance", f"{now.distance_km:.0f}", "km"),
        ("semidiameter", f"{now.semidiameter_deg:.4f}", "deg"),
        ("illuminated", f"{100.0 * now.illuminated:.1f}", "%"),
        (f"AX1 ({mount.name})", f"{ax1_deg:+z.4f}", "deg"),
        (f"AX2 ({mount.name})", f"{ax2_deg:z.4f}", "deg"),
    )
    lines.append(
        f"  {'waxing' if now.waxing else 'waning'}; "
        + (moon_not_usable(now) or "high and bright enough to follow")
    )
    return Answer(document, ("\n".join(lines),), None)


def moon_phase(at: MoonPosition) -> dict[str, Any]:
    """The part of a document about its light."""
    return {
        "phase_deg": float(at.phase_deg),
        "illuminated": float(at.illuminated),
        "waxing": bool(at.waxing),
    }


def moon_not_usable(at: MoonPosition) -> str:
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


def compare(form: Form) -> Answer:
    """Two models over years: worst and rms of altitude and azimuth, and a chart of the years."""
    site = form.site()
    models = [one.strip() for one in form.text("models").split(",")]
    if len(models) != 2:
        raise form.error("models", "name two, for example noaa,precise")
    first, last = int(form.number("from_year")), int(form.number("to_year"))
    found = compare_models(models[0], models[1], site, first, last)
    summary = found.summary()
    years, altitude, cross = found.by_year()
    document = {
        "models": models,
        "from_year": first,
        "to_year": last,
        **summary,
        "positions": int(summary["positions"]),
        "years": [
            {"year": int(year), "altitude_worst_deg": up, "cross_worst_deg": aside}
            for year, up, aside in zip(
                years.tolist(), altitude.tolist(), cross.tolist(), strict=True
            )
        ],
    }
    lines = [
        f"{models[0]} minus {models[1]}, {first} to {last}, {int(summary['positions'])} positions "
        "with the Sun up, airless",
        f"  {'':<18}{'worst':>8}{'rms':>8}   deg",
        *(
            f"  {label:<18}{summary[f'{name}_worst_deg']:8.3f}{summary[f'{name}_rms_deg']:8.3f}"
            for label, name in (
                ("altitude", "altitude"), ("azimuth", "azimuth"), ("azimuth on sky", "cross")
            )
        ),
    ]  # fmt: skip

    curves = [Curve("altitude", altitude, "●"), Curve("azimuth on sky", cross, "+")]

    def draw(sheet: Sheet) -> str:
        return curve_plot("worst of the year, deg", years, curves, "year", sheet)

    return answered(document, lines, "year by year", draw)
