"""The sunspot device: an orifice plate over a mirror throws a spot of the Sun back onto itself.

With the plate at height H above the mirror the light travels F = 2H from hole to spot. When the
collector points exactly at the Sun, the spot surrounds the hole evenly and the distance E from the
edge of the hole to the edge of the spot is the difference of the radii, Rs - Ro, on every side. A
pointing error moves the spot: error = atan((E - (Rs - Ro)) / F).
"""

import math
from dataclasses import dataclass

from solarcal.decimals import require_positive
from solarcal.errors import ConfigurationError
from solarcal.units import RAD_PER_DEG, SUN_RADIUS_DEG

LARGEST_ERROR_RAD = 0.1
"""The relation is for small angles; beyond this the spot is not on any plate."""
IMAGE_WITHIN = 3.0
"""By which factor the Sun's image may seem larger or smaller: its edge is blurred, read by eye."""


def spot_error_deg(height: float, hole_diameter: float, spot_diameter: float, edge: float) -> float:
    """Pointing error along one direction of the plate.

    Parameters
    ----------
    height : H, orifice plate above the mirror.
    hole_diameter, spot_diameter : Do and Ds.
    edge : E, from the edge of the hole to the edge of the spot, on the side asked about; negative
        where the spot's edge lies within the hole.

    All four in one unit, whichever.

    Returns
    -------
    float
        Degrees on the sky, positive when the spot stands too far to that side.

    Raises
    ------
    ConfigurationError
        A height or diameter that no device has, a spot that is not the hole widened by the Sun's
        disc, or an error beyond 0.1 rad.
    """
    require_positive("the height H", height)
    require_positive("the hole's diameter Do", hole_diameter)
    require_positive("the spot's diameter Ds", spot_diameter)
    if spot_diameter <= hole_diameter:
        raise ConfigurationError(
            f"the spot's diameter Ds of {spot_diameter:g} is not larger than the hole's Do of "
            f"{hole_diameter:g}: check whether the two are swapped"
        )
    usual = _spot_diameter(height, hole_diameter)
    ratio = (spot_diameter - hole_diameter) / (usual - hole_diameter)
    if not 1.0 / IMAGE_WITHIN <= ratio <= IMAGE_WITHIN:
        raise ConfigurationError(
            f"with a height H of {height:g} and a hole of {hole_diameter:g} the spot's diameter Ds "
            f"is about {usual:.4g}, not {spot_diameter:g}; check that all four are in the same unit"
        )
    if not math.isfinite(edge):
        raise ConfigurationError(f"the edge distance E must be a number, not {edge:g}")
    error_rad = math.atan((edge - 0.5 * (spot_diameter - hole_diameter)) / (2.0 * height))
    if abs(error_rad) > LARGEST_ERROR_RAD:
        raise ConfigurationError(
            f"these readings mean an error of {error_rad / RAD_PER_DEG:.1f} deg, beyond what the "
            "device can show (0.1 rad); check that all four are in the same unit"
        )
    return error_rad / RAD_PER_DEG


def _spot_diameter(height: float, hole_diameter: float) -> float:
    """The hole widened by the Sun's disc over the way of the light."""
    return hole_diameter + 4.0 * height * math.tan(SUN_RADIUS_DEG * RAD_PER_DEG)


# --- designing one ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SunspotDesign:
    """A device and what can be seen with it; lengths in the unit they were given in.

    ``hole``, ``plate``, ``spot``: diameters. ``resolution_deg``: the error that moves the spot by
    the smallest shift read. ``range_deg``: the largest error with which the whole spot still lies
    on the plate. ``even_rim``: E on every side when there is no error.
    """

    height: float
    hole: float
    plate: float
    spot: float
    even_rim: float
    smallest_shift: float
    resolution_deg: float
    range_deg: float


def design_from_size(
    height: float, hole_diameter: float, plate_diameter: float, smallest_shift: float
) -> SunspotDesign:
    """What a device of this size shows. ``smallest_shift``: how finely E can be read.

    The spot is the hole widened by the Sun's disc over the way of the light: Ds = Do + 2 F tan of
    the Sun's radius. It is blurred by about as much as the hole, so a hole larger than the image
    of the Sun wastes what the height gives.

    Raises
    ------
    ConfigurationError
        A length that is not greater than zero, or a plate too small for the spot.
    """
    require_positive("the height H", height)
    require_positive("the hole's diameter Do", hole_diameter)
    require_positive("the plate's diameter", plate_diameter)
    require_positive("the smallest shift that can be read", smallest_shift)
    travel = 2.0 * height
    spot = _spot_diameter(height, hole_diameter)
    if plate_diameter <= spot:
        raise ConfigurationError(
            f"the plate of {plate_diameter:g} is too small for its spot of {spot:.4g}: make it "
            "larger or the height H less"
        )
    reach_rad = math.atan(0.5 * (plate_diameter - spot) / travel)
    return SunspotDesign(
        height=height,
        hole=hole_diameter,
        plate=plate_diameter,
        spot=spot,
        even_rim=0.5 * (spot - hole_diameter),
        smallest_shift=smallest_shift,
        resolution_deg=math.atan(smallest_shift / travel) / RAD_PER_DEG,
        range_deg=min(reach_rad, LARGEST_ERROR_RAD) / RAD_PER_DEG,
    )


def design_for(
    resolution_deg: float, range_deg: float, hole_diameter: float, smallest_shift: float
) -> SunspotDesign:
    """The smallest device that resolves ``resolution_deg`` and shows errors up to ``range_deg``.

    Raises
    ------
    ConfigurationError
        A wanted value that is not greater than zero, or a range beyond the small angles (0.1 rad).
    """
    require_positive("the resolution", resolution_deg)
    require_positive("the range", range_deg)
    require_positive("the smallest shift that can be read", smallest_shift)
    if range_deg * RAD_PER_DEG > LARGEST_ERROR_RAD:
        raise ConfigurationError(
            f"a range of {range_deg:g} deg is beyond the small angles of the device (5.7 deg)"
        )
    if resolution_deg > range_deg:
        raise ConfigurationError(
            f"a resolution of {resolution_deg:g} deg is coarser than the range of {range_deg:g}"
        )
    travel = smallest_shift / math.tan(resolution_deg * RAD_PER_DEG)
    spot = hole_diameter + 2.0 * travel * math.tan(SUN_RADIUS_DEG * RAD_PER_DEG)
    plate = spot + 2.0 * travel * math.tan(range_deg * RAD_PER_DEG)
    return design_from_size(0.5 * travel, hole_diameter, plate, smallest_shift)


# --- the device's own misalignment -------------------------------------------------------------


def two_position_check(first_deg: float, turned_deg: float) -> tuple[float, float]:
    """Separate the device's misalignment from the tracker's by turning it 180 deg on its seat.

    Both readings are taken along the same mark ON THE DEVICE, the tracker standing on the Sun as
    it is. The device's own error m turns with it, the tracker's p does not: first = p + m,
    turned = m - p.

    Returns
    -------
    (device, tracker)
        Degrees on the sky along the mark as it stood first.
    """
    return 0.5 * (first_deg + turned_deg), 0.5 * (first_deg - turned_deg)
