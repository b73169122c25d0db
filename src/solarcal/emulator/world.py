"""The hidden truth at work: the Sun or Moon, the machine, the eye. Knows nothing of the controller.

``Sky`` is the Sun as it truly stands there: exact and refracted, or whatever the truth says; and
the light on the sunspot device, the Sun's or the Moon's. For a heliostat the axes belong to the
mirror's normal that throws this light onto its target.
"""

import heapq
import math
from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple
from zlib import crc32

import numpy as np

from solarcal.emulator.motor import NEVER_S, Motor
from solarcal.emulator.truth import WorldTruth, after_start_s
from solarcal.mount.drive import Drive
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.optics.offset_mirror import Heliostat
from solarcal.site import Site
from solarcal.sun import apparent_zenith_deg, sun_position
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.moon import MoonLight
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import RAD_PER_DEG, Angles, FloatArray, wrap_deg

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
        self._moon_of_day = cache(self._prepared_moon)

    def sun_now_deg(self, utc_s: float) -> tuple[float, float, float]:
        """AX1, AX2 and the Sun's elevation at one true instant."""
        if self._truth.sun == "precise":
            # Stretches are fixed in time: their interpolation must not depend on who asked first.
            return self._seen(*self._stretch(int(utc_s // _STRETCH_S)).horizontal_deg(utc_s))
        return self._seen(*self._by_formula_deg(utc_s))

    def light_now_deg(self, utc_s: float) -> tuple[float, float] | None:
        """AX1, AX2 of the light at one true instant; None: below the horizon, or a thin Moon."""
        if self._truth.light == "moon":
            moon = self._moon_of_day(int(utc_s // SECONDS_PER_DAY))
            if not moon.bright_enough:
                return None
            ax1, ax2, elevation = self._seen(*moon.horizontal_deg(utc_s))
        else:
            ax1, ax2, elevation = self.sun_now_deg(utc_s)
        return None if elevation <= 0.0 else (ax1, ax2)

    def sun_path_deg(self, utc_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The same for true instants (n,), in rising order."""
        if self._truth.sun == "precise":
            ephemeris = SiteEphemeris(
                self._site, float(utc_s[0]), float(utc_s[-1]), self._truth.dut1_s
            )
            return self._seen(*ephemeris.horizontal_deg(utc_s))
        return self._seen(*self._by_formula_deg(utc_s))

    def _by_formula_deg(self, utc_s: Angles) -> tuple[Angles, Angles]:
        sun = sun_position(self._truth.sun, utc_s, self._site, dut1_s=self._truth.dut1_s)
        return sun.azimuth_deg, sun.zenith_deg

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

    def _prepared_moon(self, day: int) -> MoonLight:
        begins_s = day * SECONDS_PER_DAY
        return MoonLight(self._site, begins_s, begins_s + SECONDS_PER_DAY, self._truth.dut1_s)


class Seen(NamedTuple):
    """What the eye makes of the spot: how far each axis must move, axis degrees."""

    visible: bool
    error1_deg: float
    error2_deg: float


class Happening(NamedTuple):
    """Something an encoder or a switch tells the controller; ``axis`` 0 or 1."""

    axis: int
    stopped: bool


class _Loss(NamedTuple):
    at_s: float
    axis: int
    counts: int


def random_stream(seed: int, purpose: str) -> np.random.Generator:
    """A generator of its own for each purpose: drawing from one never disturbs another."""
    entropy = np.random.SeedSequence([seed, crc32(purpose.encode())])
    return np.random.Generator(np.random.Philox(entropy))


class World:
    """Everything that is true independently of the controller's model.

    Times ``now_s`` are true seconds since ``start_utc_s`` and must not decrease between commands.
    """

    def __init__(
        self,
        truth: WorldTruth,
        site: Site,
        geometry: MountGeometry,
        drives: tuple[Drive, Drive],
        switches_deg: tuple[float, float],
        start_utc_s: float,
        seed: int,
        heliostat: Heliostat | None = None,
    ) -> None:
        self.truth = truth
        self.site = site
        self.geometry = geometry
        self.start_utc_s = start_utc_s
        self.mechanism: Mechanism = truth.mechanism()
        self.sky = Sky(truth, site, geometry, heliostat)
        self._eye = random_stream(seed, "eye")
        stands = (truth.stands1_deg, truth.stands2_deg)
        speeds = (truth.motor_speed1_deg_s, truth.motor_speed2_deg_s)
        slacks = (truth.backlash1_deg, truth.backlash2_deg)
        self.motors = tuple(
            Motor(
                drives[axis], switches_deg[axis], stands[axis], speeds[axis], slacks[axis],
                int(random_stream(seed, f"power-up {axis + 1}").integers(-900, 901)),
                self._switch_noise(random_stream(seed, f"switch {axis + 1}")),
            )
            for axis in (0, 1)
        )  # fmt: skip
        self._losses = self._scheduled_losses()
        self._next_loss = next(self._losses, None)

    def true_utc_s(self, now_s: float) -> float:
        return self.start_utc_s + now_s

    def laptop_utc_s(self, now_s: float) -> float:
        return self.true_utc_s(now_s) + self.truth.laptop_offset_s

    def quartz_s(self, now_s: Angles) -> Angles:
        """Seconds the unit's quartz has counted since the start."""
        return now_s * (1.0 + self.truth.unit_drift_s_per_day / SECONDS_PER_DAY)

    # --- events -------------------------------------------------------------------------------

    def next_event_s(self) -> float:
        """When a motion ends or an encoder loses counts next."""
        loss_s = self._next_loss.at_s if self._next_loss else NEVER_S
        return min(loss_s, *(motor.stops_s for motor in self.motors))

    def happen(self, now_s: float) -> list[Happening]:
        """Let everything due at ``now_s`` (= ``next_event_s``) happen, in a fixed order."""
        happenings = []
        for axis, motor in enumerate(self.motors):
            if motor.stops_s <= now_s:
                motor.arrive()
                happenings.append(Happening(axis, stopped=True))
        while self._next_loss and self._next_loss.at_s <= now_s:
            loss = self._next_loss
            self.motors[loss.axis].lose(loss.counts, now_s)
            happenings.append(Happening(loss.axis, stopped=False))
            self._next_loss = next(self._losses, None)
        return happenings

    def _scheduled_losses(self) -> Iterator[_Loss]:
        single = sorted(
            _Loss(after_start_s(m.at), m.axis - 1, m.counts) for m in self.truth.missed_counts
        )
        rates = (self.truth.missed_per_hour1, self.truth.missed_per_hour2)
        return heapq.merge(single, *(_steady(axis, rate) for axis, rate in enumerate(rates)))

    def _switch_noise(self, stream: np.random.Generator) -> Callable[[], float]:
        """Counts by which the switch trips late, another number a call."""
        return lambda: float(stream.standard_normal()) * self.truth.switch_sigma_counts

    # --- the light and the eye ----------------------------------------------------------------

    def collector_axes_deg(self, now_s: float) -> tuple[float, float]:
        """Ideal axis angles of the direction the collector really looks at."""
        ax1, ax2 = self.mechanism.pointing_deg(
            self.geometry, *(motor.collector_deg(now_s) for motor in self.motors)
        )
        return float(ax1), float(ax2)

    def pointing_deg(self, counts1: FloatArray, counts2: FloatArray) -> tuple[FloatArray, ...]:
        """Ideal axis angles the collector looks at with the motors at these counts, no slack."""
        motor1, motor2 = self.motors
        return self.mechanism.pointing_deg(
            self.geometry, motor1.angles_deg(counts1), motor2.angles_deg(counts2)
        )

    def spot(self, now_s: float) -> Seen:
        """One look at the sunspot device, or at the beam on a heliostat's target board.

        Every look draws new noise of the eye.
        """
        noise1, noise2 = self._eye.standard_normal(2) * self.truth.noise_deg
        light = self.sky.light_now_deg(self.true_utc_s(now_s))
        if light is None:
            return Seen(False, 0.0, 0.0)
        away_deg = self.geometry.sky_separation_deg(*light, *self.collector_axes_deg(now_s))
        if away_deg > self.truth.spot_range_deg:
            return Seen(False, 0.0, 0.0)
        wanted1, wanted2 = self.mechanism.readings_deg(self.geometry, *light)
        stands1, stands2 = (motor.collector_deg(now_s) for motor in self.motors)
        # On the target plate a cross error shows as an angle on the sky, whatever the axis must
        # turn for it; near the primary axis that is much more.
        on_sky = max(math.sin(light[1] * RAD_PER_DEG), 1e-6)
        return Seen(
            True,
            float(wrap_deg(float(wanted1) - stands1)) + float(noise1) / on_sky,
            float(wanted2) - stands2 + float(noise2),
        )


def _steady(axis: int, per_hour: float) -> Iterator[_Loss]:
    """One lost count at a time, evenly, for ever."""
    number = 1
    while per_hour > 0.0:
        yield _Loss(number * 3600.0 / per_hour, axis, 1)
        number += 1
