"""What a controller cannot tell and the technician does: how the mount is built and set up.

A SolarTrak answers for all of it. A rotator, or a controller without a line, does not: there it
stands in the profile, as the table ``[mount]``. Light, because the profile is read before the first
paint; ``station.described_unit`` makes a mount of it.
"""

from typing import Literal

import msgspec

from solarcal.errors import ConfigurationError

DisplayShows = Literal["angles", "counts"]
GeometryName = Literal["azel", "tiltroll-ew", "tiltroll-ns", "polar"]

NOMINAL_DRIVE = "rotary:100"
"""Where no gearing is given: a count is the hundredth of a degree that many
controllers show."""


class MountDescription(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A mount in the technician's words. Angles in degrees, read-outs absolute.

    Parameters
    ----------
    unit_name : what the unit is called in sessions; by default the driver's word for it.
    geometry : ``azel``, ``tiltroll-ew``, ``tiltroll-ns`` or ``polar``.
    ax1_centre_deg : centre of the branch of axis 1; by default what keeps the Sun's path whole.
    drive1, drive2 : nominal drives, as in ``docs/protocol.md``: ``rotary:COUNTS_PER_DEG`` or
        ``screwjack:R1:R2:R3:BETA:COUNTS_PER_LENGTH:SIGN``.
    limits1_deg, limits2_deg : software limits; by default what the unit tells, or the whole axis.
    update_range_deg : the Sun is followed in steps of this size.
    reference1_deg, reference2_deg : the read-outs of the reference position; axis 1 by default at
        the centre of its branch.
    zone_west_h : hours the unit's clock is behind UTC.
    tilt_decimals, scale_decimals : how many are kept of P1..P4 and of P5, P6.
    display : what a display read by a person gives of an axis: ``angles``, or ``counts`` since the
        last reference.
    display_sun : it gives the Sun's axis angles too.

    Raises
    ------
    ConfigurationError
        A number that no mount has.
    """

    unit_name: str = ""
    geometry: GeometryName = "azel"
    ax1_centre_deg: float | None = None
    drive1: str = NOMINAL_DRIVE
    drive2: str = NOMINAL_DRIVE
    limits1_deg: tuple[float, float] | None = None
    limits2_deg: tuple[float, float] | None = None
    update_range_deg: float = 0.1
    reference1_deg: float | None = None
    reference2_deg: float = 80.0
    zone_west_h: float = 0.0
    tilt_decimals: int = 4
    scale_decimals: int = 6
    display: DisplayShows = "angles"
    display_sun: bool = False

    def __post_init__(self) -> None:
        for what, value, low, high in (
            ("centre of axis 1", self.ax1_centre_deg or 0.0, -360.0, 360.0),
            ("update range", self.update_range_deg, 0.001, 5.0),
            ("reference position of axis 1", self.reference1_deg or 0.0, -540.0, 540.0),
            ("reference position of axis 2", self.reference2_deg, -180.0, 360.0),
            ("zone, hours west", self.zone_west_h, -14.0, 14.0),
            ("decimals of P1..P4", self.tilt_decimals, 0, 9),
            ("decimals of P5 and P6", self.scale_decimals, 0, 9),
        ):
            if not low <= value <= high:
                raise ConfigurationError(
                    f"mount: {what} {value:g} is not between {low:g} and {high:g}"
                )
        for axis, limits in ((1, self.limits1_deg), (2, self.limits2_deg)):
            if limits is not None and not limits[0] < limits[1]:
                raise ConfigurationError(
                    f"mount: limits of axis {axis}: {limits[0]:g} is not below {limits[1]:g}"
                )
