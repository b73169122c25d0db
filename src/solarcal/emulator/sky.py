"""The Sun as it truly stands in the world: exact and refracted, or whatever the truth says.

For a heliostat the axes belong to the mirror's normal that throws this Sun onto its target.
"""

from functools import cache

from solarcal.emulator.truth import WorldTruth
from solarcal.mount.geometry import MountGeometry
from solarcal.optics.aiming import Heliostat
from solarcal.site import Site
from solarcal.sun import apparent_zenith_deg, sun_position
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import Angles, FloatArray

_STRETCH_S = 30.0 * SECONDS_PER_DAY


class Sky:
    """Ideal axis angles of the apparent Sun (or its normal) over one site, for one mount."""

    def __init__(
        self,
        truth: WorldTruth,
        site: Site,
        geometry: MountGeometry,
        heliostat: Heliostat | None = None,
    ) -> None:
        self._truth = truth
        self._site = site
        self._geometry = geometry
        self._heliostat = heliostat
        self._weather = truth.weather(site)
        self._stretch = cache(self._prepared)

    def sun_now_deg(self, utc_s: float) -> tuple[float, float, float]:
        """AX1, AX2 and the Sun's elevation at one true instant."""
        if self._truth.sun == "precise":
            # Stretches are fixed in time: their interpolation must not depend on who asked first.
            azimuth, zenith = self._stretch(int(utc_s // _STRETCH_S)).horizontal_deg(utc_s)
        else:
            sun = sun_position(self._truth.sun, utc_s, self._site, dut1_s=self._truth.dut1_s)
            azimuth, zenith = sun.azimuth_deg, sun.zenith_deg
        return self._seen(azimuth, zenith)

    def sun_path_deg(self, utc_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The same for true instants (n,), in rising order."""
        if self._truth.sun == "precise":
            ephemeris = SiteEphemeris(
                self._site, float(utc_s[0]), float(utc_s[-1]), self._truth.dut1_s
            )
            azimuth, zenith = ephemeris.horizontal_deg(utc_s)
        else:
            sun = sun_position(self._truth.sun, utc_s, self._site, dut1_s=self._truth.dut1_s)
            azimuth, zenith = sun.azimuth_deg, sun.zenith_deg
        return self._seen(azimuth, zenith)

    def _seen(self, azimuth_deg: Angles, zenith_deg: Angles) -> tuple[Angles, Angles, Angles]:
        zenith_deg = apparent_zenith_deg(zenith_deg, self._truth.refraction, self._weather)
        elevation_deg = 90.0 - zenith_deg
        if self._heliostat is not None:
            azimuth_deg, zenith_deg = self._heliostat.true_normal_deg(azimuth_deg, zenith_deg)
        ax1, ax2 = self._geometry.axes_from_horizontal(azimuth_deg, zenith_deg)
        return ax1, ax2, elevation_deg

    def _prepared(self, stretch: int) -> SiteEphemeris:
        begins_s = stretch * _STRETCH_S
        return SiteEphemeris(self._site, begins_s, begins_s + _STRETCH_S, self._truth.dut1_s)
