"""Closing the loop of a two-mirror tracker: steps, PID, its tuning, sign watch, spiral, zenith.

Errors are axis degrees still to go, commands axis degrees per second held for one update period.

Near its primary axis a tracker's azimuth follows from the diode only with much noise, and the Sun
passes it faster than the axis turns. Within a few degrees the azimuth therefore goes by
calculation, in the one sense in which the Sun turns there, at the best rate of the axis.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from solarcal.errors import ConfigurationError
from solarcal.two_mirror.mirrors import direction_components
from solarcal.units import RAD_PER_DEG

GROWING_STEPS = 5
"""An error that grows over so many corrections in a row is made worse by them."""

GROWN_MRAD = 0.5
"""A growth within the noise of the diode is none."""


def step_rate_deg_s(error_deg: float, step_deg: float, sun_deg_s: float, period_s: float) -> float:
    """Step control: sgn(error) k, as a rate over one update period.

    Raises
    ------
    ConfigurationError
        The step is smaller than what the Sun moves in a period: the spot would run away.
    """
    needed_deg = abs(sun_deg_s) * period_s
    if step_deg < needed_deg:
        raise ConfigurationError(
            f"a step of {step_deg:.5f} deg is less than the Sun moves in one update period "
            f"({needed_deg:.5f} deg in {period_s:g} s); make the step larger or the period shorter"
        )
    return math.copysign(step_deg, error_deg) / period_s if error_deg else 0.0


@dataclass(frozen=True, slots=True)
class PidGains:
    """Kp in 1/s, Ki in 1/s^2, Kd without unit: the command is a rate, the error an angle."""

    kp: float
    ki: float = 0.0
    kd: float = 0.0


def ziegler_nichols(critical_gain: float, critical_period_s: float) -> PidGains:
    """Kp = 0.6 Kc, Ki = 2 Kp/Tc, Kd = Kp Tc/8."""
    kp = 0.6 * critical_gain
    return PidGains(kp, 2.0 * kp / critical_period_s, kp * critical_period_s / 8.0)


class Pid:
    """One axis. The integral holds the rate of the Sun; it stands while the axis is at its limit,
    ``fastest_deg_s``."""

    def __init__(self, gains: PidGains, period_s: float, fastest_deg_s: float) -> None:
        self.gains = gains
        self._period_s = period_s
        self._fastest_deg_s = fastest_deg_s
        self._integral_deg_s = 0.0
        self._previous_deg: float | None = None

    def begin(self, rate_deg_s: float) -> None:
        """Take over an axis that should already move at this rate."""
        self._integral_deg_s = rate_deg_s
        self._previous_deg = None

    def rate_deg_s(self, error_deg: float) -> float:
        """The rate for the next period."""
        before = error_deg if self._previous_deg is None else self._previous_deg
        self._previous_deg = error_deg
        integral = self._integral_deg_s + self.gains.ki * error_deg * self._period_s
        slope_deg_s = (error_deg - before) / self._period_s
        wanted = self.gains.kp * error_deg + integral + self.gains.kd * slope_deg_s
        if abs(wanted) <= self._fastest_deg_s:
            self._integral_deg_s = integral
            return wanted
        return math.copysign(self._fastest_deg_s, wanted)


class GrowthWatch:
    """Notices corrections that make the error larger: a quadrant sign or an axis is reversed."""

    def __init__(self) -> None:
        self._errors_mrad: list[float] = []

    def forget(self) -> None:
        """Corrections were interrupted: what comes is not their doing."""
        self._errors_mrad.clear()

    def growing(self, error_mrad: float) -> bool:
        """Take the error after one more correction; whether it grew over five in a row."""
        errors = self._errors_mrad
        if errors and error_mrad <= errors[-1]:
            errors.clear()
        errors.append(error_mrad)
        return len(errors) > GROWING_STEPS and errors[-1] - errors[0] > GROWN_MRAD

    def sentence(self) -> str:
        """What was noticed and what to look at."""
        first, last = self._errors_mrad[0], self._errors_mrad[-1]
        return (
            f"the error grew over {len(self._errors_mrad) - 1} corrections, from {first:.2f} to "
            f"{last:.2f} mrad: {REVERSED}"
        )


REVERSED = (
    "they drive the spot away; a quadrant's sign or an axis' sense is reversed, an axis does not "
    "move, or the gains are far too high. Stopped; check the wiring of the four quadrants and the "
    "sense of both axes"
)

ARM_SPACING = 1.3
"""Between two arms, in radii of the field: a spot between them is seen from both."""

LOOK_SPACING = 1.0
"""Between two looks along an arm, in radii of the field."""


def spiral_deg(field_radius_deg: float, limit_deg: float) -> Iterator[tuple[float, float]]:
    """Offsets (x, y) on the sky, from the centre outwards along an Archimedean spiral.

    Any direction within ``limit_deg`` lies within ``field_radius_deg`` of one of them.
    """
    growth = ARM_SPACING * field_radius_deg / (2.0 * math.pi)
    turn = 0.0
    # The last arm passes outside the limit by half a spacing, so that the edge is covered.
    while growth * turn <= limit_deg + 0.5 * ARM_SPACING * field_radius_deg:
        radius = growth * turn
        yield radius * math.cos(turn), radius * math.sin(turn)
        turn += LOOK_SPACING * field_radius_deg / math.hypot(radius, growth)


def beside(t1_deg: float, t2_deg: float, x_deg: float, y_deg: float) -> tuple[float, float, float]:
    """The unit vector x_deg farther from the axis and y_deg across from the direction (t1, t2).

    On the tangent plane: near the primary axis a spiral in the axis angles themselves would
    collapse.
    """
    px, py, pz = direction_components(t1_deg, t2_deg)
    t1, t2 = t1_deg * RAD_PER_DEG, t2_deg * RAD_PER_DEG
    c1, s1, c2, s2 = math.cos(t1), math.sin(t1), math.cos(t2), math.sin(t2)
    away = math.hypot(x_deg, y_deg)
    if away == 0.0:
        return px, py, pz
    c, s = math.cos(away * RAD_PER_DEG), math.sin(away * RAD_PER_DEG) / away
    x, y = s * x_deg, s * y_deg
    return (c * px + x * c2 * c1 - y * s1, c * py + x * c2 * s1 + y * c1, c * pz - x * s2)


def sense_of_turn(azimuths_deg: Sequence[float]) -> int:
    """+1 or -1: the sense of a path of calculated azimuths, each the short way from the last."""
    steps = (
        math.remainder(after - before, 360.0) for before, after in itertools.pairwise(azimuths_deg)
    )
    return -1 if sum(steps) < 0.0 else 1


class ZenithPassage:
    """One passage: the azimuth asked of axis 1, monotone from entry to exit.

    Parameters
    ----------
    axis1_deg : where axis 1 stands at the entry, unwrapped.
    path_deg : calculated azimuths from entry to exit, dense enough to tell the sense.
    """

    def __init__(self, axis1_deg: float, path_deg: Sequence[float]) -> None:
        self.sense = sense_of_turn(path_deg)
        self._asked_deg = axis1_deg

    def azimuth_deg(self, calculated_deg: float) -> float:
        """The next azimuth to ask for, unwrapped: the calculated one, or where it already was."""
        ahead = math.remainder(calculated_deg - self._asked_deg, 360.0)
        if ahead * self.sense > 0.0:
            self._asked_deg += ahead
        return self._asked_deg

    def rate_deg_s(self, axis1_deg: float, asked_deg: float, period_s: float) -> float:
        """Rate of axis 1 that brings it there in one period; never backward."""
        rate = (asked_deg - axis1_deg) / period_s
        return rate if rate * self.sense > 0.0 else 0.0
