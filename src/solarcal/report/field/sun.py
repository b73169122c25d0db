"""Where the Sun is, and which way that turns the axes."""

import numpy as np

from solarcal.mount.geometry import MountGeometry
from solarcal.report.field.answer import Answer, Drawing, paragraph
from solarcal.report.instrument_plots import Curve, curve_plot
from solarcal.report.scales import Theme
from solarcal.site import Site, Weather
from solarcal.sun import sun_position
from solarcal.timescale import format_utc

_DRAWN = 97


def clock_face(hours: float) -> str:
    """HH:MM:SS of [0, 24) hours, rounded to the second."""
    seconds = round(hours * 3600.0) % 86400
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


def sun(
    utc_s: float,
    site: Site,
    mount: MountGeometry,
    *,
    model: str = "precise",
    refraction: str = "none",
    weather: Weather | None = None,
    dut1_s: float = 0.0,
) -> Answer:
    """The Sun at an instant by one of the models, and the axes of a mount that look at it."""
    now = sun_position(
        model, utc_s, site, dut1_s=dut1_s, refraction=refraction, weather=weather or Weather()
    )
    ax1_deg, ax2_deg = mount.axes_from_horizontal(now.azimuth_deg, now.zenith_deg)
    solar_time = clock_face(now.solar_time_h)
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
    for label, value, unit in (
        ("azimuth (N through E)", f"{now.azimuth_deg:.4f}", "deg"),
        ("zenith angle", f"{now.zenith_deg:.4f}", "deg"),
        ("elevation", f"{now.elevation_deg:+.4f}", "deg"),
        ("declination", f"{now.declination_deg:+.4f}", "deg"),
        ("equation of time", f"{now.equation_of_time_min:+.3f}", "min"),
        ("apparent solar time", solar_time, ""),
        (f"AX1 ({mount.name})", f"{ax1_deg:+.4f}", "deg"),
        (f"AX2 ({mount.name})", f"{ax2_deg:.4f}", "deg"),
    ):
        lines.append(f"  {label:<24}{value:>10} {unit}".rstrip())

    def draw(width: int, height: int, colour: bool, theme: Theme) -> str:
        hours = np.linspace(0.0, 24.0, _DRAWN)
        times = utc_s + 3600.0 * (hours - now.solar_time_h)
        day = sun_position(model, times, site, dut1_s=dut1_s)
        up = day.elevation_deg >= 0.0
        kept = up if up.any() else np.ones_like(up)
        return curve_plot(
            "elevation, deg", hours[kept], [Curve("Sun", day.elevation_deg[kept], "●")],
            "apparent solar time, h", width, height, colour, theme, hours=True,
            marks=[(float(now.solar_time_h), "this moment")],
        )  # fmt: skip

    return Answer(document, (paragraph(*lines),), Drawing("that day", draw))
