"""Site, unit and operator profiles: what the technician would otherwise type every morning.

And what a controller cannot tell and the technician does: how the mount is built and set up. A
SolarTrak answers for all of it. A rotator, or a controller without a line, does not: there it
stands in the profile, as the table ``[mount]``. Light, because the profile is read before the first
paint; ``station.described_unit`` makes a mount of it.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import msgspec

from solarcal.config import config_dir, read_toml, write_toml
from solarcal.decimals import Six, between, decimal, require_between
from solarcal.errors import ConfigurationError
from solarcal.site import BoltCircle, Inclinometer, Site, Weather
from solarcal.stopping_rule import DEFAULT_UNMODELLED, StoppingRule
from solarcal.unit.drivers import DEFAULT_DRIVER

DisplayShows = Literal["angles", "counts"]
GeometryName = Literal["azel", "tiltroll-ew", "tiltroll-ns", "polar"]

NOMINAL_DRIVE = "rotary:100"
"""Where no gearing is given: a count is the hundredth of a degree that many controllers show."""


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
        reference1_deg, reference2_deg = self.reference1_deg or 0.0, self.reference2_deg
        require_between("mount: centre of axis 1", self.ax1_centre_deg or 0.0, -360.0, 360.0)
        require_between("mount: update range", self.update_range_deg, 0.001, 5.0)
        require_between("mount: reference position of axis 1", reference1_deg, -540.0, 540.0)
        require_between("mount: reference position of axis 2", reference2_deg, -180.0, 360.0)
        require_between("mount: zone, hours west", self.zone_west_h, -14.0, 14.0)
        require_between("mount: decimals of P1..P4", self.tilt_decimals, 0, 9)
        require_between("mount: decimals of P5 and P6", self.scale_decimals, 0, 9)
        for axis, limits in ((1, self.limits1_deg), (2, self.limits2_deg)):
            if limits is not None and not limits[0] < limits[1]:
                raise ConfigurationError(
                    f"mount: limits of axis {axis}: {limits[0]:g} is not below {limits[1]:g}"
                )


NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _-]{0,39}")
"""What a profile may be called: its name is that of its file."""


class Profile(msgspec.Struct, frozen=True, kw_only=True):
    """One site with its unit and operator. What is ``None`` or empty is taken from the unit.

    ``mount`` describes a unit that cannot tell how it is built; one that can is never overruled.
    """

    name: str = "default"
    operator: str = ""
    pointing_device: str = ""
    tolerance_deg: float = 0.1
    done_probability: float = 0.95
    unmodelled: dict[str, float] = {}
    """Widths of what may be there beside P1..P6, by name; the usual ones where empty."""
    port: str = ""
    driver: str = DEFAULT_DRIVER
    baudrate: int = 9600
    site: Site | None = None
    weather: Weather | None = None
    inclinometer: Inclinometer | None = None
    last_coefficients: Six | None = None
    """P1..P6 of the calibration before; a fit takes them as known beforehand."""
    bolt_circle: BoltCircle | None = None
    mount: MountDescription | None = None

    def __post_init__(self) -> None:
        DEFAULT_UNMODELLED.changed(self.unmodelled)
        if self.last_coefficients is not None:
            checked_coefficients(self.last_coefficients)

    def rule(self, clock_s: float) -> StoppingRule:
        """When a calibration is done; ``clock_s`` is the laptop clock's where none is named."""
        usual = DEFAULT_UNMODELLED.with_clock(clock_s)
        return StoppingRule(
            self.tolerance_deg, self.done_probability, usual.changed(self.unmodelled)
        )

    def summary(self) -> str:
        """One line for the start screen."""
        parts = [f"profile {self.name}"]
        if self.site is not None:
            place = f"{self.site.latitude_deg:+z.4f} {self.site.longitude_deg:+z.4f}"
            parts.append(f"{self.site.name} {place}".strip())
        else:
            parts.append("site as the unit reports")
        parts.append(f"operator {self.operator}" if self.operator else "no operator named")
        if self.driver != DEFAULT_DRIVER:
            parts.append(f"driver {self.driver}")
        return ", ".join(parts)


_MOST = {"P1": 10.0, "P2": 30.0, "P3": 10.0, "P4": 30.0, "P5": 0.05, "P6": 0.05}
"""What is larger is no tracker's: the limits of "Parameters still unrealistic"."""


def checked_coefficients(values: Sequence[float]) -> Six:
    """P1..P6 of a unit.

    Raises
    ------
    ConfigurationError
        Not six, or one that is no tracker's.
    """
    if len(values) != len(_MOST):
        raise ConfigurationError(f"{len(values)} of the six numbers P1 to P6")
    for value, (name, most) in zip(values, _MOST.items(), strict=True):
        if not abs(value) <= most:
            raise ConfigurationError(f"{name} {value:+g} is not {between(-most, most)}")
    P1, P2, P3, P4, P5, P6 = values
    return P1, P2, P3, P4, P5, P6


def parse_coefficients(text: str) -> Six:
    """Six numbers with spaces or commas between; with spaces a decimal comma will do.

    Raises
    ------
    ConfigurationError
        As ``checked_coefficients``, or not a number.
    """
    parts = [part.rstrip(",;") for part in text.split()]
    if len(parts) != len(_MOST):
        parts = text.replace(",", " ").split()
    return checked_coefficients([decimal(part, comma=True) for part in parts])


def profiles_dir() -> Path:
    return config_dir() / "profiles"


def profile_names() -> list[str]:
    folder = profiles_dir()
    return sorted(path.stem for path in folder.glob("*.toml")) if folder.is_dir() else []


def load_profile(name: str) -> Profile:
    """A saved profile; the empty one when there is none of that name.

    Raises
    ------
    ConfigurationError
        The file is damaged or a value in it cannot be.
    """
    if not name:
        return Profile()
    path = _path(name)
    return read_toml(path, Profile) if path.exists() else Profile(name=name)


def load_site_file(path: Path) -> Profile:
    """The profile in a file of any place: what ``--site FILE`` names.

    Raises
    ------
    ConfigurationError
        There is no such file, it is damaged, or a value in it cannot be.
    """
    profile = read_toml(path, Profile)
    if profile.name == Profile().name:
        return msgspec.structs.replace(profile, name=path.stem)
    return profile


def save_profile(profile: Profile) -> Path:
    """Write a profile into the profiles folder, nowhere else.

    Raises
    ------
    ConfigurationError
        A name that is no file's, or the file cannot be written.
    """
    path = _path(profile.name)
    write_toml(path, profile)
    return path


def _path(name: str) -> Path:
    """The file of a profile. A name comes from a file too and must not lead out of the folder."""
    if not NAME.fullmatch(name):
        raise ConfigurationError(
            f"profile {name!r}: use 1 to 40 letters, digits, spaces, - and _ for a name"
        )
    return profiles_dir() / f"{name}.toml"
