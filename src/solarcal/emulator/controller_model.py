"""The controller's own model: its time, place and Sun, with P and O applied."""

from typing import Protocol

import msgspec
import numpy as np

from solarcal.emulator.settings import UnitSettings
from solarcal.mount.controller import ControllerModel, ideal_and_elevation_deg
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.limits import Limits
from solarcal.site import Site
from solarcal.units import Angles, FloatArray


class Quartz(Protocol):
    """Seconds the unit's quartz has counted at so many true seconds since the start."""

    def __call__(self, now_s: Angles) -> Angles: ...


class EmulatedControllerModel:
    """Clock, site, Sun, coefficients and limits of one controller.

    Its Sun is Appendix A's, airless, for its configured site and the time its own clock shows.
    A heliostat's ideal angles are those of the normal, from that Sun and its configured target.
    """

    def __init__(
        self, settings: UnitSettings, site: Site, zone_west_h: float, quartz: Quartz, utc_s: float
    ) -> None:
        self._settings = settings
        self._quartz = quartz
        self.site = site
        self.zone_west_h = zone_west_h
        self.geometry = settings.mount(site)
        self.heliostat = settings.heliostat()
        coefficients, offsets = settings.memory()
        self.formula = ControllerModel(
            settings.limits(),
            settings.tilt_decimals,
            settings.scale_decimals,
            coefficients,
            offsets,
        )
        self._clock_set_to_s = utc_s
        self._clock_set_at_s = 0.0

    @property
    def limits(self) -> Limits:
        return self.formula.limits

    def set_limits(self, limits: Limits) -> None:
        self.formula = msgspec.structs.replace(self.formula, limits=limits)

    @property
    def coefficients(self) -> Coefficients:
        return self.formula.coefficients

    @property
    def offsets(self) -> Offsets:
        return self.formula.offsets

    def remember(self, coefficients: Coefficients, offsets: Offsets) -> None:
        """P and O from a memory, as they stand there."""
        self.formula = msgspec.structs.replace(
            self.formula, coefficients=coefficients, offsets=offsets
        )

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

    def readings_deg(self, utc_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Readings (2, n) to drive to when the clock says ``utc_s`` (n,), and the room left (n,).

        The room is the distance to the nearest limit or of the Sun to the horizon, negative beyond.
        """
        ideal1, ideal2, elevation = self._ideal_deg(utc_s)
        readings = np.stack(self.formula.target_deg(ideal1, ideal2))
        room = np.minimum(self.limits.distance_deg(readings[0], readings[1]), elevation)
        return readings, room

    def _ideal_deg(self, utc_s: Angles) -> tuple[Angles, Angles, Angles]:
        """Angles of the Sun, or of the normal that reflects it to the target; Sun's elevation."""
        return ideal_and_elevation_deg(self.geometry, self.site, utc_s, self.heliostat)

    def targets_deg(self, now_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``readings_deg`` at so many seconds since the start."""
        return self.readings_deg(self.utc_s(now_s))
