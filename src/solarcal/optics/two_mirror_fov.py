"""Field of view of a two-mirror tracker: what the diode can see, and what is left of the Sun."""

import math
from dataclasses import dataclass

from solarcal.errors import ConfigurationError
from solarcal.optics.two_mirror_diode import SUN_RADIUS_MRAD


@dataclass(frozen=True, slots=True)
class FieldOfView:
    """Full angles in milliradians. ``diode_mrad`` is FOV1, ``tracker_mrad`` FOV2."""

    diode_mrad: float
    tracker_mrad: float
    sun_mrad: float

    @property
    def field_mrad(self) -> float:
        """The smaller one limits."""
        return min(self.diode_mrad, self.tracker_mrad)

    @property
    def limited_by(self) -> str:
        return "diode" if self.diode_mrad <= self.tracker_mrad else "tracker"

    @property
    def any_light_mrad(self) -> float:
        """Largest pointing error at which the Sun's centre is still in the field."""
        return 0.5 * self.field_mrad

    @property
    def whole_sun_mrad(self) -> float:
        """Largest pointing error at which the whole Sun is; negative where it never fits."""
        return 0.5 * (self.field_mrad - self.sun_mrad)


def field_of_view(
    diode_diameter_mm: float = 6.0,
    focal_length_mm: float = 200.0,
    tracker_diameter_m: float = 0.10,
    distance_m: float = 5.0,
    sun_mrad: float = 2.0 * SUN_RADIUS_MRAD,
) -> FieldOfView:
    """FOV1 = atan(D_diode/f) and FOV2 = atan(D_tracker/L).

    The defaults give 30 and 20 mrad.

    Raises
    ------
    ConfigurationError
        A length that is not above zero.
    """
    for name, value in (
        ("the diode's diameter", diode_diameter_mm),
        ("the focal length", focal_length_mm),
        ("the tracker's diameter", tracker_diameter_m),
        ("the distance from tracker to instrument", distance_m),
        ("the Sun's diameter", sun_mrad),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise ConfigurationError(f"{name} must be above zero, not {value:g}")
    return FieldOfView(
        diode_mrad=1e3 * math.atan(diode_diameter_mm / focal_length_mm),
        tracker_mrad=1e3 * math.atan(tracker_diameter_m / distance_m),
        sun_mrad=sun_mrad,
    )
