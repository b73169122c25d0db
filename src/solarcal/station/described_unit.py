"""A unit that cannot be asked: its mount as it was described, its controller as it was typed."""

from dataclasses import dataclass, field
from typing import cast

import msgspec

from solarcal.decimals import Pair
from solarcal.errors import ConfigurationError
from solarcal.mount.controller import ControllerModel, ideal_axes_deg
from solarcal.mount.drive import Drive, format_drive, parse_drive, reading_deg, register
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry, default_ax1_centre
from solarcal.profiles import GeometryName, MountDescription, Profile
from solarcal.session.records import Header
from solarcal.site import Site
from solarcal.station.sun_path import forward_sense, sun_rates_deg_per_s
from solarcal.station.typed.forms import Values
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.unit.tracker import UnitParameters, UnitSite
from solarcal.units import Angles, wrap_deg

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

    ``unit_limits``: what the unit itself tells; nothing described goes beyond it.

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


def described_by_session(profile: Profile, header: Header) -> Profile:
    """The profile of a session that is gone on with: the header's site and mount where it has none.

    Not for a unit whose display is read: the header does not tell what it shows.
    """
    unit = header.unit
    mount = MountDescription(
        unit_name=unit.serial,
        geometry=cast(GeometryName, header.geometry),
        ax1_centre_deg=header.ax1_centre_deg,
        drive1=format_drive(unit.drive1),
        drive2=format_drive(unit.drive2),
        limits1_deg=(unit.limits.axis1.low_deg, unit.limits.axis1.high_deg),
        limits2_deg=(unit.limits.axis2.low_deg, unit.limits.axis2.high_deg),
        update_range_deg=unit.update_range_deg,
        reference1_deg=unit.reference1_deg,
        reference2_deg=unit.reference2_deg,
        zone_west_h=unit.zone_west_h,
        tilt_decimals=unit.tilt_decimals,
        scale_decimals=unit.scale_decimals,
    )
    return msgspec.structs.replace(
        profile, site=profile.site or unit.site, mount=profile.mount or mount
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


@dataclass(frozen=True, slots=True)
class TypedControllerModel:
    """A unit as its technician described and typed it.

    Attributes
    ----------
    unit_site, parameters : place, mount and set-up, as described.
    shows_counts : the display gives counts since the last reference, not degrees.
    unit_minus_laptop_s : difference of the clocks as typed last.
    coefficients, offsets : in force, as typed last.
    """

    unit_site: UnitSite
    parameters: UnitParameters
    shows_counts: bool = False
    unit_minus_laptop_s: float = 0.0
    coefficients: Coefficients = field(default_factory=Coefficients)
    offsets: Offsets = field(default_factory=Offsets)

    @property
    def geometry(self) -> MountGeometry:
        told = self.unit_site
        return MountGeometry(told.geometry, told.site.latitude_deg, told.ax1_centre_deg)

    def unit_utc_s(self, laptop_utc_s: Angles) -> Angles:
        """What the unit's clock makes of an instant (or of several), as UTC."""
        return laptop_utc_s + self.unit_minus_laptop_s

    def unit_day_s(self, laptop_utc_s: float) -> float:
        """Seconds since midnight on the unit's clock."""
        local_s = self.unit_utc_s(laptop_utc_s) - 3600.0 * self.unit_site.zone_west_h
        return local_s % SECONDS_PER_DAY

    def clock_off_s(self, shown_s: float, laptop_utc_s: float) -> float:
        """By how much a shown time of day is ahead of what the unit's clock was taken for."""
        return (
            shown_s - self.unit_day_s(laptop_utc_s) + SECONDS_PER_DAY / 2.0
        ) % SECONDS_PER_DAY - SECONDS_PER_DAY / 2.0

    def ideal_deg(self, laptop_utc_s: float) -> Pair:
        """The Sun the unit computes at that instant of the laptop's clock."""
        return ideal_axes_deg(self.geometry, self.unit_site.site, self.unit_utc_s(laptop_utc_s))

    def rates_deg_per_s(self, laptop_utc_s: float) -> Pair:
        """How fast that Sun moves in the axes."""
        return sun_rates_deg_per_s(
            self.geometry, self.unit_site.site, self.unit_utc_s(laptop_utc_s)
        )

    def senses(self, laptop_utc_s: float, came: tuple[int, int] = (0, 0)) -> tuple[int, int]:
        """The sense in which each axis comes from behind the Sun."""
        rate1, rate2 = self.rates_deg_per_s(laptop_utc_s)
        return forward_sense(rate1, came[0]), forward_sense(rate2, came[1])

    def target_deg(self, laptop_utc_s: float, offsets: Offsets | None = None) -> Pair:
        """Where the unit drives its axes: ideal + E(P in force) + O."""
        in_force = ControllerModel(
            self.parameters.limits,
            coefficients=self.coefficients,
            offsets=self.offsets if offsets is None else offsets,
        )
        target1, target2 = in_force.target_deg(*self.ideal_deg(laptop_utc_s))
        return float(target1), float(target2)

    def reading_deg(self, axis: int, shown: float) -> float:
        """Absolute read-out of axis 0 or 1 from what the display shows, AX1 on its branch."""
        angle = shown
        if self.shows_counts:
            angle = float(reading_deg(*self._drive(axis), shown))
        if axis == 0:
            return float(wrap_deg(angle, self.unit_site.ax1_centre_deg))
        return angle

    def counts(self, axis: int, reading: float) -> int:
        """Counts since the last reference at a read-out."""
        return register(*self._drive(axis), reading)

    def _drive(self, axis: int) -> tuple[Drive, float]:
        """What drives an axis, and its reference position."""
        told = self.parameters
        return ((told.drive1, told.reference1_deg), (told.drive2, told.reference2_deg))[axis]

    def moment_s(self, values: Values, read_utc_s: float) -> float:
        """The laptop's UTC of a reading: by the unit's clock where it was typed with it."""
        shown_s = values.get("time")
        if shown_s is None:
            return read_utc_s
        return read_utc_s + self.clock_off_s(float(shown_s), read_utc_s)
