"""The world of a two-mirror tracker: the true Sun, the turned base, two motors, and the diode.

The controller gets four signals and two axis read-outs out of it, and puts two rates in.
"""

import math

import numpy as np

from solarcal.mount.geometry import rotated
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun import apparent_zenith_deg
from solarcal.sun.energy import disc_share
from solarcal.two_mirror.mirrors import (
    Components,
    EulerBase,
    direction_components,
    fixed_mirrors_matrix,
    ray_from_sky,
)
from solarcal.two_mirror.scenario import MirrorTruth, Sky

_MRAD = 1e3
_NOISE_BLOCK = 4096


class MirrorMotor:
    """One axis: its rate follows the command with a lag; the read-out counts whole counts."""

    def __init__(self, angle_deg: float, fastest_deg_s: float, lag_s: float, counts_per_deg: float):
        self.angle_deg = angle_deg
        self._rate_deg_s = 0.0
        self._fastest_deg_s = fastest_deg_s
        self._lag_s = lag_s
        self._counts_per_deg = counts_per_deg

    def run(self, command_deg_s: float, seconds: float) -> None:
        """Let the command act for so long; the first-order lag is integrated exactly."""
        wanted = max(-self._fastest_deg_s, min(self._fastest_deg_s, command_deg_s))
        self.angle_deg += wanted * seconds
        if self._lag_s:
            left = math.exp(-seconds / self._lag_s)
            missing = self._rate_deg_s - wanted
            self.angle_deg += missing * self._lag_s * (1.0 - left)
            self._rate_deg_s = wanted + missing * left

    def reading_deg(self) -> float:
        return round(self.angle_deg * self._counts_per_deg) / self._counts_per_deg


class MirrorWorld:
    """Everything that is true of one day at one tracker.

    Parameters
    ----------
    sky : where the target stands from ``first_utc_s`` on.
    axis1_deg, axis2_deg : where the axes stand at first.
    seed : of the diode's noise.
    """

    def __init__(
        self,
        truth: MirrorTruth,
        site: Site,
        sky: Sky,
        first_utc_s: float,
        axis1_deg: float,
        axis2_deg: float,
        seed: int,
    ) -> None:
        self.truth = truth
        self.base: EulerBase = truth.base()
        self.motors = (
            MirrorMotor(axis1_deg, truth.axis1_deg_s, truth.lag_s, truth.counts_per_deg),
            MirrorMotor(axis2_deg, truth.axis2_deg_s, truth.lag_s, truth.counts_per_deg),
        )
        self._first_utc_s = first_utc_s
        self._sky = sky
        self._weather = Weather(
            pressure_hpa=standard_pressure_hpa(site.elevation_m), temperature_c=truth.temperature_c
        )
        self._inverse_fixed = fixed_mirrors_matrix(truth.fixed_mirrors).T.tolist()
        self._random = np.random.default_rng([seed, 6])
        self._noise: list[list[float]] = []
        # Every update asks for the same instant some times.
        self._sun_at = (math.nan, 0.0, 0.0)
        self._ray_at: tuple[float, Components] = (math.nan, (0.0, 0.0, 1.0))

    def sun_deg(self, utc_s: float) -> tuple[float, float]:
        """AX1, AX2 of the apparent Sun in the Earth's frame."""
        if utc_s != self._sun_at[0]:
            azimuth, zenith = self._sky.horizontal_deg(utc_s)
            apparent_deg = apparent_zenith_deg(zenith, "hughes", self._weather)
            self._sun_at = utc_s, 180.0 - azimuth, apparent_deg
        return self._sun_at[1], self._sun_at[2]

    def spot(self, utc_s: float) -> tuple[float, float]:
        """Where the spot is: d1/d3 and d2/d3 of the ray traced back, mrad. Inf: behind."""
        return self.spot_from(utc_s, self.motors[0].angle_deg, self.motors[1].angle_deg)

    def spot_from(self, utc_s: float, t1_deg: float, t2_deg: float) -> tuple[float, float]:
        """The same if the axes stood there."""
        if utc_s != self._ray_at[0]:
            of_earth = direction_components(*self.sun_deg(utc_s))
            self._ray_at = utc_s, self.base.of_tracker(of_earth)
        x, y, z = ray_from_sky(self._ray_at[1], t1_deg, t2_deg)
        if self.truth.fixed_mirrors:
            x, y, z = rotated(self._inverse_fixed, (x, y, z))
        if z <= 0.0:
            return math.inf, math.inf
        return _MRAD * x / z, _MRAD * y / z

    def signals(self, utc_s: float) -> tuple[float, float, float, float]:
        """A, B, C, D; their sum is 1 with the whole Sun in the field."""
        noise = self._next_noise()
        d1, d2 = self.spot(utc_s)
        minutes = (utc_s - self._first_utc_s) / 60.0
        clouded = any(begins <= minutes < ends for begins, ends in self.truth.clouds)
        radius = self.truth.sun_radius_mrad
        away = math.hypot(d1, d2)
        light = 0.0
        if not clouded and away < 0.5 * self.truth.field_mrad + radius:
            light = disc_share(away, radius, 0.5 * self.truth.field_mrad)
        if light:
            if self.truth.flip1:
                d1 = -d1
            if self.truth.flip2:
                d2 = -d2
            a, b, c, d = (light * part for part in quadrant_parts(d1 / radius, d2 / radius))
        else:
            a = b = c = d = 0.0
        return a + noise[0], b + noise[1], c + noise[2], d + noise[3]

    def readings_deg(self) -> tuple[float, float]:
        return self.motors[0].reading_deg(), self.motors[1].reading_deg()

    def run(self, rate1_deg_s: float, rate2_deg_s: float, seconds: float) -> None:
        """Let both motors run."""
        self.motors[0].run(rate1_deg_s, seconds)
        self.motors[1].run(rate2_deg_s, seconds)

    def _next_noise(self) -> list[float]:
        if not self._noise:
            block = self._random.standard_normal((_NOISE_BLOCK, 4)) * self.truth.signal_noise
            self._noise = block.tolist()
        return self._noise.pop()


def half_disc(u: float) -> float:
    """Part of a unit disc centred at u that lies beyond 0."""
    if u <= -1.0:
        return 0.0
    if u >= 1.0:
        return 1.0
    return 0.5 + (u * math.sqrt(1.0 - u * u) + math.asin(u)) / math.pi


def quadrant_parts(u1: float, u2: float) -> tuple[float, float, float, float]:
    """Parts of a unit disc centred at (u1, u2) in the quadrants A(-,+) B(+,+) C(+,-) D(-,-)."""
    right, top = half_disc(u1), half_disc(u2)
    if u1 * u1 + u2 * u2 >= 1.0:
        # The corner lies outside the disc: no circle segment is cut in two.
        if u1 <= 0.0 and u2 <= 0.0:
            both = 0.0
        elif u1 <= 0.0:
            both = right
        elif u2 <= 0.0:
            both = top
        else:
            both = right + top - 1.0
    else:
        # The integral of sqrt(1 - x^2) + u2 from the split to where the disc's edge meets it.
        edge = math.sqrt(1.0 - u2 * u2)
        area = 0.5 * (edge * abs(u2) + math.asin(edge)) + 0.5 * (
            u1 * math.sqrt(1.0 - u1 * u1) + math.asin(u1)
        )
        both = (area + u2 * (edge + u1)) / math.pi
        if u2 > 0.0:
            # Beyond that edge the whole height of the disc lies above the split.
            both += (math.acos(edge) - edge * math.sqrt(1.0 - edge * edge)) / math.pi
    return top - both, both, right - both, 1.0 - right - top + both
