"""What is known of a tracker before the first point is taken."""

import math

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.terms import LEAN_PRIOR_DEG, SCALE_PRIOR, ZERO_PRIOR_DEG
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients
from solarcal.units import FloatArray

Six = tuple[float, float, float, float, float, float]


def sigmas_of(lean_deg: float, offset_deg: float, scale: float) -> Six:
    """One sigma of P1..P6 from those of a component of lean, of a zero and of a scale."""
    return (lean_deg, offset_deg, lean_deg, offset_deg, scale, scale)


SINCE_LAST = sigmas_of(0.3, 1.0, 0.0005)
"""How far a tower, its references and its gears may have moved since the last calibration."""


PLAIN = ((1.0, 1.0),)
"""One normal, as wide as it says."""


class Prior(msgspec.Struct, frozen=True):
    """A prior on the six numbers of a mechanism, P1..P4 in degrees, P5, P6 in deg/deg.

    The default is what towers, offsets and gears are like: a lean of 2 deg a component, zeros of
    5 deg and scales of 0.002, one sigma, about zero. Who levels a tower well mostly sets its zeros
    well, too: so it is as likely as not that all sigmas of a unit are 0.4 times that, and the
    points tell which.

    Parameters
    ----------
    means, sigmas
        Of P1..P6.
    widths
        (factor on all sigmas, chance) pairs; the chances add up to one.

    Raises
    ------
    ConfigurationError
        A mean that is not finite or a sigma that is not positive.
    """

    means: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    sigmas: Six = sigmas_of(LEAN_PRIOR_DEG, ZERO_PRIOR_DEG, SCALE_PRIOR)
    widths: tuple[tuple[float, float], ...] = ((1.0, 0.5), (0.4, 0.5))

    def __post_init__(self) -> None:
        for name, mean, sigma in zip(COEFFICIENT_NAMES, self.means, self.sigmas, strict=True):
            if not math.isfinite(mean):
                raise ConfigurationError(f"the prior mean of {name} is {mean:g}, not a number")
            if not (sigma > 0.0 and math.isfinite(sigma)):
                raise ConfigurationError(
                    f"the prior sigma of {name} is {sigma:g}; it must be greater than zero"
                )

        if not all(factor > 0.0 and chance > 0.0 for factor, chance in self.widths) or not (
            math.isclose(sum(chance for _, chance in self.widths), 1.0)
        ):
            raise ConfigurationError(
                "the widths of the prior must be (factor, chance) pairs greater than zero whose "
                "chances add up to one"
            )

    def with_inclinometer(self, P1_deg: float, P3_deg: float, sigma_deg: float) -> "Prior":
        """The lean as read from an inclinometer, with the uncertainty of the reading."""
        means, sigmas = list(self.means), list(self.sigmas)
        means[0], means[2] = P1_deg, P3_deg
        sigmas[0] = sigmas[2] = sigma_deg
        return Prior(tuple(means), tuple(sigmas), self.widths)  # type: ignore[arg-type]

    @classmethod
    def of_last_coefficients(cls, last: Coefficients, sigmas: Six = SINCE_LAST) -> "Prior":
        """About what the unit held last; ``sigmas`` is how far it may have moved since."""
        return cls(last.as_tuple(), sigmas, PLAIN)

    def mean_array(self) -> FloatArray:
        """(6,)"""
        return np.array(self.means)

    def sigma_array(self) -> FloatArray:
        """(6,)"""
        return np.array(self.sigmas)
