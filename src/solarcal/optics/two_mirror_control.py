"""Closing the loop of a two-mirror tracker: steps, PID, its tuning, and the watch over the signs.

Errors are axis degrees still to go, commands axis degrees per second held for one update period.
"""

import math
from dataclasses import dataclass

from solarcal.errors import ConfigurationError

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
    """Kp = 0.6 Kc, Ki = 2 Kp/Tc, Kd = Kp Tc/8.

    Raises
    ------
    ConfigurationError
        A critical gain or period that is not above zero.
    """
    if not (critical_gain > 0.0 and critical_period_s > 0.0):
        raise ConfigurationError("the critical gain and period must be above zero")
    kp = 0.6 * critical_gain
    return PidGains(kp, 2.0 * kp / critical_period_s, kp * critical_period_s / 8.0)


class Pid:
    """One axis. The integral holds the rate of the Sun; it stands while the axis is at its limit.

    Parameters
    ----------
    fastest_deg_s : the axis' greatest rate.
    """

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
