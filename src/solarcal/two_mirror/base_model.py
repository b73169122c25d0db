"""The model a two-mirror tracker's controller works with: its own Sun, and the base it fitted."""

import math
from dataclasses import dataclass

import numpy as np

from solarcal.errors import FitError
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun import apparent_zenith_deg
from solarcal.sun.appendix_a import horizontal_deg
from solarcal.two_mirror.base import BaseSolution, MirrorPoints, fit_base
from solarcal.two_mirror.mirrors import EulerBase
from solarcal.two_mirror.scenario import Sky

RATE_SPAN_S = 20.0
LEAST_LOG_ELEVATION_DEG = 5.0
"""Lower the air bends the light by more than any formula knows."""


@dataclass(frozen=True, slots=True)
class LoggedPoint:
    """The Sun the controller computed and where its axes stood with the spot centred, degrees."""

    utc_s: float
    sun1_deg: float
    sun2_deg: float
    axis1_deg: float
    axis2_deg: float


class BaseModel:
    """The Sun by the controller's formula and air, and the Euler angles as known so far.

    Parameters
    ----------
    base : the Euler angles it begins with.
    log_every_s : how often a point is kept.
    sky : another target than the Sun, airless.

    Until three points tell the base, ``offset_deg`` is what to add to the calculated axis angles:
    how far off the spot was found.
    """

    def __init__(
        self, base: EulerBase, site: Site, log_every_s: float, sky: Sky | None = None
    ) -> None:
        self.base = base
        self.solution: BaseSolution | None = None
        self.log: list[LoggedPoint] = []
        self.offset_deg = (0.0, 0.0)
        self._site = site
        self._sky = sky
        self._weather = Weather(pressure_hpa=standard_pressure_hpa(site.elevation_m))
        self._log_every_s = log_every_s

    def sun_deg(self, utc_s: float) -> tuple[float, float]:
        """The controller's own apparent Sun, AX1 and AX2."""
        if self._sky is not None:
            azimuth, zenith = self._sky.horizontal_deg(utc_s)
        else:
            azimuth, zenith = horizontal_deg(
                utc_s, self._site.latitude_deg, self._site.longitude_deg, plus=True
            )
        return 180.0 - azimuth, apparent_zenith_deg(zenith, "saemundsson", self._weather)

    def calculated_deg(self, utc_s: float) -> tuple[float, float]:
        """Axis angles of the Sun by the base as known so far."""
        return self.base.axes_deg(*self.sun_deg(utc_s))

    def rates_deg_s(self, utc_s: float) -> tuple[float, float]:
        """How fast the Sun moves in both axes."""
        before = self.calculated_deg(utc_s - 0.5 * RATE_SPAN_S)
        after = self.calculated_deg(utc_s + 0.5 * RATE_SPAN_S)
        return (
            math.remainder(after[0] - before[0], 360.0) / RATE_SPAN_S,
            (after[1] - before[1]) / RATE_SPAN_S,
        )

    def keep_point(
        self, utc_s: float, to_go: tuple[float, float], axis1_deg: float, axis2_deg: float
    ) -> None:
        """Log a point when one is due, and learn the base from all of them."""
        if self.log and utc_s - self.log[-1].utc_s < self._log_every_s:
            return
        sun1, sun2 = self.sun_deg(utc_s)
        if sun2 > 90.0 - LEAST_LOG_ELEVATION_DEG and self.solution is not None:
            return
        # What the diode still shows is not lost: it is added by the same ray trace.
        centred = axis1_deg + to_go[0], axis2_deg + to_go[1]
        self.log.append(LoggedPoint(utc_s, sun1, sun2, *centred))
        try:
            self.solution = fit_base(self.points())
        except FitError:
            # Too few yet, or too near one another: what is known stands.
            calculated = self.base.axes_deg(sun1, sun2)
            if self.solution is None:
                self.offset_deg = (
                    math.remainder(centred[0] - calculated[0], 360.0),
                    centred[1] - calculated[1],
                )
            return
        self.base, self.offset_deg = self.solution.base, (0.0, 0.0)

    def points(self) -> MirrorPoints:
        """The log as points of a fit."""
        rows = np.array([[p.sun1_deg, p.sun2_deg, p.axis1_deg, p.axis2_deg] for p in self.log])
        sun1, sun2, axis1, axis2 = rows.reshape(-1, 4).T
        return MirrorPoints(sun1, sun2, axis1, axis2, tuple(range(1, len(self.log) + 1)))
