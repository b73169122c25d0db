"""How a tower stands, and what to put under it."""

import math
from dataclasses import dataclass

import numpy as np

from solarcal.mount.geometry import MountGeometry
from solarcal.units import FloatArray

SHIM_FIRST_DEG = 3.5
"""With more lean the controller's first-order formula leaves more than 0.1 deg somewhere."""


@dataclass(frozen=True, slots=True)
class BaseTilt:
    """How the base of a mount stands. ``tilt_deg`` from level, the top gone towards
    ``bearing_deg`` (North through East); ``turn_deg`` about the vertical, positive from North
    towards West (counterclockwise from above)."""

    tilt_deg: float
    bearing_deg: float
    turn_deg: float


def base_tilt(values: FloatArray, geometry: MountGeometry) -> BaseTilt:
    """From the mechanism's P1 and P3: the rotation (-P3, -P1, 0) about native x, y, seen in ENU.

    For ``azel`` this is the lean itself; on the other mounts part of it is a turned base.
    """
    native = np.array([-values[2], -values[0], 0.0])
    east, north, up = (geometry.basis().T @ native).tolist()
    # A rotation w moves the tower's top by w x up = (w_n, -w_e, 0).
    top_east, top_north = north, -east
    return BaseTilt(
        tilt_deg=math.hypot(top_east, top_north),
        bearing_deg=math.degrees(math.atan2(top_east, top_north)) % 360.0,
        turn_deg=up,
    )


@dataclass(frozen=True, slots=True)
class Shim:
    """What to put under the base at one bolt."""

    bolt_bearing_deg: float
    height_mm: float


def shim_heights(
    lean_deg: float,
    bearing_deg: float,
    bolt_circle_diameter_mm: float,
    bolts: int,
    first_bolt_bearing_deg: float = 0.0,
) -> tuple[Shim, ...]:
    """Heights that bring a leaning tower upright; the highest corner gets nothing.

    Parameters
    ----------
    lean_deg, bearing_deg
        How far, and towards which compass bearing, the top leans.
    bolt_circle_diameter_mm
        Of the bolts in the base plate.
    bolts
        At least three, equally spaced.
    first_bolt_bearing_deg
        Compass bearing of one of them.

    Raises
    ------
    ValueError
        Fewer than three bolts, or a circle without a diameter.
    """
    if bolts < 3 or not bolt_circle_diameter_mm > 0.0:
        raise ValueError("a base plate has at least three bolts on a circle of some diameter")
    radius = bolt_circle_diameter_mm / 2.0
    bearings = [(first_bolt_bearing_deg + 360.0 * i / bolts) % 360.0 for i in range(bolts)]
    # The plate is low on the side the top leans to: that side is lifted.
    rises = [
        radius * math.sin(math.radians(lean_deg)) * math.cos(math.radians(b - bearing_deg))
        for b in bearings
    ]
    lowest = min(rises)
    return tuple(Shim(b, r - lowest) for b, r in zip(bearings, rises, strict=True))


_WINDS = ("N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE")
_ALL_WINDS = (*_WINDS, "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW")


def wind(bearing_deg: float) -> str:
    """Compass point of a bearing: 'NNE'."""
    return _ALL_WINDS[round(bearing_deg / 22.5) % 16]
