"""What the controller believes: the time, its place, its Sun, and P and O on top of it."""

from typing import Protocol

import numpy as np

from solarcal.emulator.unit_settings import UnitSettings
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.limits import Limits
from solarcal.site import Site
from solarcal.sun.appendix_a import horizontal_deg
from solarcal.units import Angles, FloatArray


class Quartz(Protocol):
    """Seconds the unit's quartz has counted at so many true seconds since the start."""

    def __call__(self, now_s: Angles) -> Angles: ...


class EmulatedControllerModel:
    """Clock, site, Sun, coefficients and limits of one controller.

    Its Sun is Appendix A's, airless, for the site it was told and the time its own clock shows.
    A heliostat's ideal angles are those of the normal, from that Sun and the target it was told.
    """

    def __init__(
        self, settings: UnitSettings, site: Site, zone_west_h: float, quartz: Quartz, utc_s: float
    ) -> None:
        self._settings = settings
        self._quartz = quartz
        self.site = site
        self.zone_west_h = zone_west_h
        self.geometry = settings.mount(site)
        self.limits: Limits = settings.limits()
        self.heliostat = settings.heliostat()
        self.coefficients, self.offsets = settings.memory()
        self._clock_set_to_s = utc_s
        self._clock_set_at_s = 0.0

    def utc_s(self, now_s: Angles) -> Angles:
        """The unit's clock plus its zone."""
        counted = self._quartz(now_s) - self._quartz(self._clock_set_at_s)
        return self._clock_set_to_s + counted

    def set_clock(self, utc_s: float, now_s: float) -> None:
        self._clock_set_to_s = utc_s
        self._clock_set_at_s = now_s

    def set_site(self, site: Site, zone_west_h: float) -> None:
        """The clock shows local time and runs on: in another zone it means another UTC."""
        self._clock_set_to_s += (zone_west_h - self.zone_west_h) * 3600.0
        self.site, self.zone_west_h = site, zone_west_h
        self.geometry = self._settings.mount(site)

    def clock_error_s(self, now_s: FloatArray, true_start_utc_s: float) -> FloatArray:
        """Unit clock minus true time as the present setting runs on; before it, as just set."""
        since = np.maximum(now_s, self._clock_set_at_s)
        return self.utc_s(since) - (true_start_utc_s + since)

    def sun(self, now_s: float) -> tuple[float, float, float]:
        """Ideal axis angles and the Sun's elevation at one instant."""
        return self._ideal_deg(self.utc_s(now_s))

    def corrected_deg(self, ideal1_deg: float, ideal2_deg: float) -> tuple[float, float]:
        """Ideal angles plus E, without O."""
        e1, e2 = correction_deg(self.coefficients, ideal1_deg, ideal2_deg)
        return float(ideal1_deg + e1), float(ideal2_deg + e2)

    def readings_deg(self, utc_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Readings (2, n) to drive to when the clock says ``utc_s`` (n,), and the room left (n,).

        The room is the distance to the nearest limit or of the Sun to the horizon, negative beyond.
        """
        ideal1, ideal2, elevation = self._ideal_deg(utc_s)
        e1, e2 = correction_deg(self.coefficients, ideal1, ideal2)
        readings = np.stack([ideal1 + e1 + self.offsets.O1, ideal2 + e2 + self.offsets.O2])
        room = np.minimum(self.limits.distance_deg(readings[0], readings[1]), elevation)
        return readings, room

    def _ideal_deg(self, utc_s: Angles) -> tuple[Angles, Angles, Angles]:
        """Angles of the Sun, or of the normal that reflects it to the target; Sun's elevation."""
        sun = horizontal_deg(utc_s, self.site.latitude_deg, self.site.longitude_deg)
        aim = sun if self.heliostat is None else self.heliostat.controller_normal_deg(*sun)
        ideal1, ideal2 = self.geometry.axes_from_horizontal(*aim)
        return ideal1, ideal2, 90.0 - sun[1]

    def targets_deg(self, now_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``readings_deg`` at so many seconds since the start."""
        return self.readings_deg(self.utc_s(now_s))

    def keep_offsets(self, o1_deg: float, o2_deg: float) -> None:
        """Offsets as the unit keeps them, rounded."""
        decimals = self._settings.tilt_decimals
        self.offsets = Offsets(round(o1_deg, decimals) + 0.0, round(o2_deg, decimals) + 0.0)

    def keep_coefficients(self, coefficients: Coefficients) -> None:
        self.coefficients = coefficients.rounded(
            self._settings.tilt_decimals, self._settings.scale_decimals
        )
