"""Configuration of an emulated tracker's controller: the ``[unit]`` table of a scenario."""

import msgspec

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import Drive, parse_drive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.limits import AxisLimits, Limits
from solarcal.optics.aiming import Heliostat
from solarcal.optics.heliostat import Target
from solarcal.optics.offset_mirror import MirrorOffset
from solarcal.site import Site
from solarcal.unit.parameters import RANGES


class UnitSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Factory and installation settings. Readings in degrees; drives as in ``docs/protocol.md``.

    ``latitude_deg``, ``longitude_deg``, ``zone_west_h`` are the unit's own settings; left out, it
    has the true ones of ``[site]``.

    With a ``target`` (azimuth, zenith angle, distance) it is a heliostat: AX1, AX2 are the angles
    of the mirror's normal. ``mirror_offset``: AzimPivot_R, PivotRefl_R, PivotRefl_Z, in the unit of
    the distance.
    """

    geometry: str = "azel"
    ax1_centre_deg: float = 0.0
    drive1: str = "rotary:1000"
    drive2: str = "rotary:1000"
    limits1_deg: tuple[float, float] = (-130.0, 130.0)
    limits2_deg: tuple[float, float] = (3.0, 88.0)
    reference1_deg: float = 120.0
    reference2_deg: float = 80.0
    stow1_deg: float = 0.0
    stow2_deg: float = 5.0
    update_range_deg: float = 0.1
    tilt_decimals: int = 4
    scale_decimals: int = 6
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    zone_west_h: float | None = None
    coefficients: tuple[float, float, float, float, float, float] = (0.0,) * 6
    offsets: tuple[float, float] = (0.0, 0.0)
    serial: str = "0001"
    target: tuple[float, float, float] | None = None
    mirror_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("limits1_deg", "limits2_deg"):
            low, high = getattr(self, name)
            if not low < high:
                raise ConfigurationError(f"unit.{name}: {low:g} is not below {high:g}")
            least, most = RANGES[f"axis{name[6]}.limits"]
            if low < least or high > most:
                raise ConfigurationError(f"unit.{name} must lie between {least:g} and {most:g}")
        for name, of_unit in (
            ("update_range_deg", "update_range"),
            ("tilt_decimals", "tilt_decimals"),
            ("scale_decimals", "scale_decimals"),
            ("reference1_deg", "axis1.reference"),
            ("reference2_deg", "axis2.reference"),
        ):
            low, high = RANGES[of_unit]
            if not low <= getattr(self, name) <= high:
                raise ConfigurationError(f"unit.{name} must lie between {low:g} and {high:g}")
        if any(self.mirror_offset) and (self.target is None or self.geometry != "azel"):
            raise ConfigurationError(
                "unit.mirror_offset belongs to a heliostat with a target on an azel mount"
            )
        self.heliostat()

    def believed_site(self, true_site: Site) -> Site:
        latitude, longitude = self.latitude_deg, self.longitude_deg
        return Site(
            true_site.latitude_deg if latitude is None else latitude,
            true_site.longitude_deg if longitude is None else longitude,
            true_site.elevation_m,
        )

    def mount(self, site: Site) -> MountGeometry:
        return MountGeometry(self.geometry, site.latitude_deg, self.ax1_centre_deg)

    def drives(self) -> tuple[Drive, Drive]:
        return parse_drive(self.drive1), parse_drive(self.drive2)

    def limits(self) -> Limits:
        return Limits(AxisLimits(*self.limits1_deg), AxisLimits(*self.limits2_deg))

    def heliostat(self) -> Heliostat | None:
        """The configured target and mirror; ``None`` for a tracker."""
        if self.target is None:
            return None
        return Heliostat(Target(*self.target), MirrorOffset(*self.mirror_offset))

    def memory(self) -> tuple[Coefficients, Offsets]:
        """P and O as they are when the emulation begins, in both memories."""
        return Coefficients(*self.coefficients), Offsets(*self.offsets)
