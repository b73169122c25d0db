"""Ziegler and Nichols' experiment on the simulated loop: raise Kp until the loop just swings on.

One axis is driven by the proportional part alone and knocked off the Sun by a milliradian; the
other is held by a low gain. With too low a gain the swing dies, with too high a one it grows.
"""

import math
from dataclasses import dataclass

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.two_mirror.control import Pid, PidGains, ziegler_nichols
from solarcal.two_mirror.diode import QuadrantDiode, quadrant_errors
from solarcal.two_mirror.mirrors import EulerBase
from solarcal.two_mirror.scenario import MirrorScenario
from solarcal.two_mirror.world import MirrorWorld
from solarcal.units import FloatArray

KNOCK_MRAD = 1.0
HOLDING_PARTS = 0.1
"""The other axis is held by this part of one period's whole correction."""

SETTLED = 0.6
"""A knock that has fallen to this part of itself is over."""

REDUCTION = 0.8
HIGH_DEG = 30.0
"""The experiment begins when the target is so high."""
UPDATES = 80
EARLY, LATE = 12, 24
RATE_SPAN_S = 60.0
TRIALS = 24


@dataclass(frozen=True, slots=True)
class LoopTuning:
    """What the experiment found on one axis. ``trials``: (gain, growth of the swing).

    ``reduced``: 1, or the part of Ziegler and Nichols' gains with which the loop settles. Their
    rules are of continuous control; sampled slowly a loop can swing with them.
    """

    axis: int
    critical_gain: float
    critical_period_s: float
    gains: PidGains
    trials: tuple[tuple[float, float], ...]
    reduced: float = 1.0

    def gains_document(self) -> dict[str, float]:
        """What a JSON document has of it."""
        return {
            "critical_gain_per_s": self.critical_gain,
            "critical_period_s": self.critical_period_s,
            "kp_per_s": self.gains.kp,
            "ki_per_s2": self.gains.ki,
            "kd": self.gains.kd,
        }


def tune(scenario: MirrorScenario, *, seed: int = 0, axis: int = 2) -> LoopTuning:
    """Find the critical gain and period of axis 1 or 2, and the PID gains from them.

    Raises
    ------
    ConfigurationError
        The Sun does not get 30 deg high that day, or no gain makes the loop swing.
    """
    up = scenario.above(HIGH_DEG)
    period_s = scenario.loop.period_s
    low, high = 0.05 / period_s, 12.0 / period_s
    trials = []
    for _ in range(TRIALS):
        gain = math.sqrt(low * high)
        growth = _growth(_swing_deg(scenario, up[0], PidGains(gain), axis, seed))
        trials.append((gain, growth))
        low, high = (gain, high) if growth < 1.0 else (low, gain)
    critical = math.sqrt(low * high)
    growths = [growth for _, growth in trials]
    if min(growths) >= 1.0:
        raise ConfigurationError(
            "the error grows at every gain, even the lowest: a quadrant's sign or an axis' sense "
            "is reversed, or the Sun is clouded; nothing can be tuned"
        )
    if max(growths) < 1.0:
        raise ConfigurationError("no gain makes this loop swing; its lag is too short to matter")
    swing_deg = _swing_deg(scenario, up[0], PidGains(critical), axis, seed)
    critical_period_s = _period_s(swing_deg, period_s)
    full = ziegler_nichols(critical, critical_period_s)
    gains, reduced = full, 1.0
    while _growth(_swing_deg(scenario, up[0], gains, axis, seed)) > SETTLED:
        reduced *= REDUCTION
        gains = PidGains(reduced * full.kp, reduced**2 * full.ki, reduced * full.kd)
        if reduced < 0.05:
            raise ConfigurationError("with no PID gains does this loop settle; sample it faster")
    return LoopTuning(axis, critical, critical_period_s, gains, tuple(trials), reduced)


def _swing_deg(
    scenario: MirrorScenario, begin_utc_s: float, gains: PidGains, axis: int, seed: int
) -> FloatArray:
    """The error of the knocked axis by the diode, (updates,) degrees; cut short when it is lost."""
    period_s = scenario.loop.period_s
    last_utc_s = begin_utc_s + max(UPDATES * period_s, RATE_SPAN_S)
    sky = scenario.sky(begin_utc_s - 1.0, last_utc_s + 1.0)
    world = MirrorWorld(scenario.truth, scenario.site.place(), sky, begin_utc_s, 0.0, 0.0, seed)
    stands = list(world.base.axes_deg(*world.sun_deg(begin_utc_s)))
    knock_deg = math.degrees(1e-3 * KNOCK_MRAD)
    stands[axis - 1] += knock_deg / (math.sin(math.radians(stands[1])) if axis == 1 else 1.0)
    for motor, angle_deg in zip(world.motors, stands, strict=True):
        motor.angle_deg = angle_deg
    diode = QuadrantDiode.with_fixed_mirrors(scenario.truth.fixed_mirrors)
    # The experiment is the swing about the Sun's motion, which is no part of it: both axes get the
    # Sun's own rate.
    rates = _sun_rates_deg_s(world.base, world, begin_utc_s)
    truth = scenario.truth
    pids = [Pid(PidGains(HOLDING_PARTS / period_s), period_s, truth.axis1_deg_s)] * 2
    pids[axis - 1] = Pid(gains, period_s, (truth.axis1_deg_s, truth.axis2_deg_s)[axis - 1])
    errors = []
    for number in range(UPDATES):
        signals = world.signals(begin_utc_s + number * period_s)
        if sum(signals) < 0.3:
            break
        to_go = diode.corrections_deg(*quadrant_errors(signals), *world.readings_deg())
        errors.append(to_go[axis - 1])
        world.run(
            pids[0].rate_deg_s(to_go[0]) + rates[0],
            pids[1].rate_deg_s(to_go[1]) + rates[1],
            period_s,
        )
    return np.array(errors)


def _sun_rates_deg_s(base: EulerBase, world: MirrorWorld, utc_s: float) -> tuple[float, float]:
    before = base.axes_deg(*world.sun_deg(utc_s))
    after = base.axes_deg(*world.sun_deg(utc_s + RATE_SPAN_S))
    return math.remainder(after[0] - before[0], 360.0) / RATE_SPAN_S, (
        after[1] - before[1]
    ) / RATE_SPAN_S


def _growth(swing_deg: FloatArray) -> float:
    """Amplitude late over amplitude early; infinite when the spot was lost.

    Early is while the knock still shows at any gain: later a swing that died would compare the
    noise of the diode with itself.
    """
    if len(swing_deg) < UPDATES:
        return math.inf
    return float(np.std(swing_deg[-LATE:])) / max(float(np.std(swing_deg[:EARLY])), 1e-9)


def _period_s(swing_deg: FloatArray, period_s: float) -> float:
    """Of a sustained swing, by the zero crossings of its error, interpolated."""
    swing = swing_deg - swing_deg.mean()
    before, after = swing[:-1], swing[1:]
    rising = np.flatnonzero((before < 0.0) & (after >= 0.0))
    if len(rising) < 3:
        raise ConfigurationError("the loop did not swing at its critical gain")
    at = rising + before[rising] / (before[rising] - after[rising])
    return float((at[-1] - at[0]) / (len(at) - 1) * period_s)
