"""A mount from the technician's description of it: what a unit would have answered if asked."""

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import Drive, parse_drive
from solarcal.mount.geometry import AxisLimits, Limits, default_ax1_centre
from solarcal.profiles import MountDescription
from solarcal.site import Site
from solarcal.unit.tracker import UnitParameters, UnitSite

HALF_TURN_DEG = 180.0


def centre_deg(description: MountDescription, site: Site) -> float:
    """Centre of the branch of axis 1 at a site."""
    if description.ax1_centre_deg is not None:
        return description.ax1_centre_deg
    return default_ax1_centre(description.geometry, site.latitude_deg)


def unit_site(description: MountDescription, site: Site) -> UnitSite:
    """Where the unit stands, and how it is mounted."""
    return UnitSite(
        site, description.zone_west_h, description.geometry, centre_deg(description, site)
    )


def unit_parameters(
    description: MountDescription, site: Site, unit_limits: Limits | None = None
) -> UnitParameters:
    """Drives, limits and reference position.

    Parameters
    ----------
    unit_limits : what the unit itself tells; nothing described goes beyond it.

    Raises
    ------
    ConfigurationError
        A drive that none is, or limits that leave an axis no room.
    """
    centre = centre_deg(description, site)
    told = unit_limits or Limits(
        AxisLimits(centre - HALF_TURN_DEG, centre + HALF_TURN_DEG), AxisLimits(0.0, HALF_TURN_DEG)
    )
    return UnitParameters(
        drive1=_drive(description.drive1, 1),
        drive2=_drive(description.drive2, 2),
        limits=Limits(
            _within(description.limits1_deg, told.axis1, 1),
            _within(description.limits2_deg, told.axis2, 2),
        ),
        update_range_deg=description.update_range_deg,
        reference1_deg=centre if description.reference1_deg is None else description.reference1_deg,
        reference2_deg=description.reference2_deg,
        tilt_decimals=description.tilt_decimals,
        scale_decimals=description.scale_decimals,
    )


def _drive(text: str, axis: int) -> Drive:
    try:
        return parse_drive(text)
    except ConfigurationError as error:
        raise ConfigurationError(f"mount: axis {axis}: {error}") from None


def _within(described: tuple[float, float] | None, told: AxisLimits, axis: int) -> AxisLimits:
    if described is None:
        return told
    low, high = max(described[0], told.low_deg), min(described[1], told.high_deg)
    if not low < high:
        raise ConfigurationError(
            f"mount: limits of axis {axis}, {described[0]:g} to {described[1]:g} deg, lie outside "
            f"what the unit can do ({told.low_deg:g} to {told.high_deg:g})"
        )
    return AxisLimits(low, high)
