"""A collector in words, as JSON, and one that is tilted from level."""

import math
from typing import Any

from solarcal.errors import ConfigurationError
from solarcal.report.columns import number
from solarcal.sun.energy import Collector, FixedCollector, OneAxisCollector


def tilted(tilt_deg: float, facing_deg: float | None, latitude_deg: float) -> FixedCollector:
    """Fixed, tilted from level towards an azimuth; without one towards the equator's side.

    Raises
    ------
    ConfigurationError
        A tilt beyond 0..180 or an azimuth that is none.
    """
    if not 0.0 <= tilt_deg <= 180.0:
        raise ConfigurationError(f"tilt {tilt_deg:g} deg is not between 0 and 180")
    if facing_deg is None:
        facing_deg = 180.0 if latitude_deg >= 0.0 else 0.0
    if not math.isfinite(facing_deg):
        raise ConfigurationError(f"facing {facing_deg:g} is not an azimuth in degrees")
    tilt, facing = math.radians(tilt_deg), math.radians(facing_deg)
    return FixedCollector(
        (
            math.sin(tilt) * math.cos(facing),
            math.sin(tilt) * math.sin(facing),
            math.cos(tilt),
        )
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
