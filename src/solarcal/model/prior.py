"""What is known of a tracker before the first point is taken, and of a mechanism after the points.

The posterior is a mixture of normals over the noise scale.
"""

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import msgspec
import numpy as np

from solarcal.decimals import Six
from solarcal.errors import ConfigurationError
from solarcal.model.terms import LEAN_PRIOR_DEG, SCALE_PRIOR, ZERO_PRIOR_DEG
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients
from solarcal.units import FloatArray


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
    means, sigmas : of P1..P6.
    widths : (factor on all sigmas, chance) pairs; the chances add up to one.
    last : the unit's last coefficients, where it is about them.

    Raises
    ------
    ConfigurationError
        A mean that is not finite or a sigma that is not positive.
    """

    means: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    sigmas: Six = sigmas_of(LEAN_PRIOR_DEG, ZERO_PRIOR_DEG, SCALE_PRIOR)
    widths: tuple[tuple[float, float], ...] = ((1.0, 0.5), (0.4, 0.5))
    last: Coefficients | None = None

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
        return Prior(tuple(means), tuple(sigmas), self.widths, self.last)  # type: ignore[arg-type]

    @classmethod
    def of_last_coefficients(cls, last: Coefficients) -> "Prior":
        """About what the unit held last."""
        return cls(last.as_tuple(), SINCE_LAST, PLAIN, last)

    def words(self) -> str:
        """What it is about, in one clause."""
        if self.last is None:
            return "what towers, zeros and gears are like"
        tilts = " ".join(f"{value:+z.4f}" for value in self.last.as_tuple()[:4])
        scales = " ".join(f"{value:+z.6f}" for value in self.last.as_tuple()[4:])
        return f"the unit's last coefficients {tilts} {scales}"

    def as_json(self) -> dict[str, Any]:
        """``prior`` of the fit's document."""
        return msgspec.to_builtins(self)  # type: ignore[no-any-return]

    def mean_array(self) -> FloatArray:
        """(6,)"""
        return np.array(self.means)

    def sigma_array(self) -> FloatArray:
        """(6,)"""
        return np.array(self.sigmas)


SEED = 20261123
SAMPLES = 256


# No slots: cached properties live in the instance's dictionary.
@dataclass(frozen=True, eq=False)
class MechanismPosterior:
    """q normals in the six numbers P1..P6 of the exact mechanism.

    Attributes
    ----------
    weights : (q,), sum to one.
    means : (q, 6)
    covariances : (q, 6, 6)
    noise_deg : (q,), noise of one point on sky, per axis, that goes with each normal.
    point_weights : (q, n), of the points fitted, where there are any.

    With what may be there beside the six numbers (``unmodelled``) the normals have more than six
    dimensions; P1..P6 come first.
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray
    noise_deg: FloatArray
    point_weights: FloatArray | None = None

    @cached_property
    def mean(self) -> FloatArray:
        """(6,)"""
        mean: FloatArray = self.weights @ self.means
        return mean

    @cached_property
    def covariance(self) -> FloatArray:
        """Of the whole mixture, (6, 6)."""
        away = self.means - self.mean
        inner: FloatArray = np.einsum("q,qij->ij", self.weights, self.covariances)
        inner += np.einsum("q,qi,qj->ij", self.weights, away, away)
        return inner

    @cached_property
    def noise_rms_deg(self) -> float:
        """Root mean square of the noise scale."""
        return float(np.sqrt(self.weights @ self.noise_deg**2))

    @cached_property
    def noise_median_deg(self) -> float:
        """Half of the weight lies below."""
        order = np.argsort(self.noise_deg)
        reached = np.cumsum(self.weights[order])
        return float(np.exp(np.interp(0.5, reached, np.log(self.noise_deg[order]))))

    def samples(self, count: int = SAMPLES, seed: int = SEED) -> FloatArray:
        """Draws (count, k), the same for the same posterior: mixture parts in proportion."""
        part = np.searchsorted(np.cumsum(self.weights), (np.arange(count) + 0.5) / count)
        part = np.minimum(part, len(self.weights) - 1)
        draws = standard_normals(count, seed, self.means.shape[1])
        away = (self._factors[part] @ draws[..., np.newaxis])[..., 0]
        return self.means[part] + away

    @cached_property
    def _factors(self) -> FloatArray:
        """L with L L.T the covariance (q, k, k), also for one that is singular to rounding.

        From the symmetric root of the correlations, of which there is one: eigenvectors alone have
        either sign, and neighbouring ones turn, as the rounding of another machine will have it.
        """
        scale = np.sqrt(np.einsum("qii->qi", self.covariances))
        scale = np.where(scale > 0.0, scale, 1.0)
        values, vectors = np.linalg.eigh(
            self.covariances / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
        )
        factors: FloatArray = scale[:, :, np.newaxis] * symmetric_root(values, vectors)
        return factors


def symmetric_root(values: FloatArray, vectors: FloatArray) -> FloatArray:
    """The one symmetric root (..., k, k) of a matrix with these eigenvalues (..., k) and
    eigenvectors (..., k, k), none of them below zero but for rounding."""
    roots = np.sqrt(np.maximum(values, 0.0))
    root: FloatArray = (vectors * roots[..., np.newaxis, :]) @ np.swapaxes(vectors, -1, -2)
    return root


@cache
def standard_normals(count: int, seed: int = SEED, dimensions: int = 6) -> FloatArray:
    """Standard normals (count, k) in random order; mean zero, unit covariance."""
    generator = np.random.default_rng(seed)
    normals: FloatArray = generator.standard_normal((count, dimensions))
    # Exactly so: a forecast's rms then has no sampling error.
    normals -= normals.mean(axis=0)
    normals = normals @ np.linalg.inv(np.linalg.cholesky(normals.T @ normals / count)).T
    normals.flags.writeable = False
    return normals
