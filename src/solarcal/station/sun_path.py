"""How the unit's Sun moves in the axes, and the side an axis has to come from."""

from solarcal.mount.controller import ideal_axes_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.optics.aiming import Heliostat
from solarcal.site import Site
from solarcal.units import wrap_deg

SUN_STANDS_DEG_PER_S = 2e-5
"""Slower than this the Sun has no side to come from (an axis at its turning point)."""

RATE_OVER_S = 30.0

Pair = tuple[float, float]


def sun_moves_deg(
    geometry: MountGeometry,
    site: Site,
    from_utc_s: float,
    to_utc_s: float,
    heliostat: Heliostat | None = None,
) -> Pair:
    """How far the ideal angles of a unit at ``site`` move between two instants, degrees."""
    start = ideal_axes_deg(geometry, site, from_utc_s, heliostat)
    end = ideal_axes_deg(geometry, site, to_utc_s, heliostat)
    return float(wrap_deg(end[0] - start[0])), end[1] - start[1]


def sun_rates_deg_per_s(
    geometry: MountGeometry, site: Site, unit_utc_s: float, heliostat: Heliostat | None = None
) -> Pair:
    """How fast the unit's Sun moves in the axes, central difference."""
    half_s = 0.5 * RATE_OVER_S
    move1, move2 = sun_moves_deg(
        geometry, site, unit_utc_s - half_s, unit_utc_s + half_s, heliostat
    )
    return move1 / RATE_OVER_S, move2 / RATE_OVER_S


def forward_sense(rate_deg_per_s: float, approach: int) -> int:
    """The sense an axis comes from behind in: the Sun's, or its last where the Sun stands."""
    if abs(rate_deg_per_s) < SUN_STANDS_DEG_PER_S:
        return -1 if approach < 0 else 1
    return -1 if rate_deg_per_s < 0.0 else 1
