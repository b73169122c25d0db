"""Which mount and which collector a form describes; a collector in words and as JSON."""

import math
from typing import Any

from solarcal.instruments.form import Form
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry, default_ax1_centre
from solarcal.report.blocks import number
from solarcal.site import Site
from solarcal.sun.energy import Collector, FixedCollector, OneAxisCollector, TrackingCollector

DRAWN_LATITUDE_DEG = 45.0
"""Which way round the sky is drawn while no place is given."""


def asked_geometry(form: Form, latitude_deg: float | None) -> MountGeometry:
    """The mount of the fields geometry and centre."""
    name, centre = form.choice("geometry"), form.optional("centre")
    if latitude_deg is None:
        if name == "polar":
            raise form.missing("lat")
        latitude_deg = 0.0
    if centre is None:
        centre = default_ax1_centre(name, latitude_deg)
    return MountGeometry(name, latitude_deg, centre)


def asked_mount(form: Form, site: Site) -> tuple[MountGeometry, Limits, bool]:
    """The mount, its limits, and whether any were given."""
    geometry = asked_geometry(form, site.latitude_deg)
    first, second = form.pair("limits1"), form.pair("limits2")
    centre = geometry.ax1_centre_deg
    limits = Limits(
        AxisLimits(*(first or (centre - 180.0, centre + 180.0))),
        AxisLimits(*(second or (0.0, 180.0))),
    )
    return geometry, limits, first is not None or second is not None


def drawn_latitude_deg(form: Form) -> float:
    """The latitude given, or one north of the tropics."""
    latitude = form.optional("lat")
    return DRAWN_LATITUDE_DEG if latitude is None else latitude


def asked_collector(form: Form, latitude_deg: float) -> Collector:
    """The collector of the fields collector, tilt, facing and vector."""
    kind = form.choice("collector")
    if form.of_command and kind != "tilted" and form.text("facing"):
        raise form.error("facing", "says where a --tilt leans to; give both, or --normal")
    if kind == "tracking":
        return TrackingCollector()
    if kind == "tilted":
        return _tilted(form.number("tilt"), form.optional("facing"), latitude_deg)
    if kind == "level":
        return FixedCollector()
    vector = form.numbers("vector")
    if vector is None:
        raise form.error("vector", "write North, East and Up parts, like 1 0 0")
    parts = (vector[0], vector[1], vector[2])
    return FixedCollector(parts) if kind == "normal" else OneAxisCollector(parts)


def _tilted(tilt_deg: float, facing_deg: float | None, latitude_deg: float) -> FixedCollector:
    """Fixed, tilted from level towards an azimuth; without one towards the equator's side."""
    if facing_deg is None:
        facing_deg = 180.0 if latitude_deg >= 0.0 else 0.0
    tilt, facing = math.radians(tilt_deg), math.radians(facing_deg)
    return FixedCollector(
        (math.sin(tilt) * math.cos(facing), math.sin(tilt) * math.sin(facing), math.cos(tilt))
    )


def collector_text(collector: Collector) -> str:
    """What it is, in words."""
    if isinstance(collector, FixedCollector):
        kind, vector = "fixed, facing", collector.normal_neu
    elif isinstance(collector, OneAxisCollector):
        kind, vector = "turning about", collector.axis_neu
    else:
        return "facing the Sun on two axes"
    north, east, up = (number(part, 4) for part in vector)
    return f"{kind} N {north}  E {east}  U {up}"


def collector_document(collector: Collector) -> dict[str, Any]:
    """The same for a JSON document."""
    if isinstance(collector, FixedCollector):
        return {"kind": "fixed", "normal_neu": list(collector.normal_neu)}
    if isinstance(collector, OneAxisCollector):
        return {"kind": "one-axis", "axis_neu": list(collector.axis_neu)}
    return {"kind": "tracking"}
