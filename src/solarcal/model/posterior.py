"""What is known of a mechanism after the points: a mixture of normals over the noise scale."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solarcal.units import FloatArray

SEED = 20261123
SAMPLES = 256


# No slots: cached properties live in the instance's dictionary.
@dataclass(frozen=True, eq=False)
class MechanismPosterior:
    """q normals in the six numbers P1..P6 of the exact mechanism.

    Attributes
    ----------
    weights : (q,)
        Sum to one.
    means : (q, 6)
    covariances : (q, 6, 6)
    noise_deg : (q,)
        Noise of one point on sky, per axis, that goes with each normal.
    point_weights : (q, n)
        Of the points fitted, where there are any.

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
        factors = _factors(self.covariances)
        draws = standard_normals(count, seed, self.means.shape[1])
        away: FloatArray = np.einsum("nij,nj->ni", factors[part], draws)
        return self.means[part] + away


def _factors(covariances: FloatArray) -> FloatArray:
    """L with L L.T the covariance (q, 6, 6), also for one that is singular to rounding."""
    scale = np.sqrt(np.einsum("qii->qi", covariances))
    scale = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(
        covariances / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    )
    roots = np.sqrt(np.maximum(values, 0.0))[:, np.newaxis, :]
    factors: FloatArray = scale[:, :, np.newaxis] * vectors * roots
    return factors


_drawn: dict[tuple[int, int, int], FloatArray] = {}


def standard_normals(count: int, seed: int = SEED, dimensions: int = 6) -> FloatArray:
    """Standard normals (count, k) in random order; mean zero, unit covariance."""
    key = (count, seed, dimensions)
    if key not in _drawn:
        generator = np.random.default_rng(seed)
        normals = generator.standard_normal((count, dimensions))
        # Exactly so: a forecast's rms then has no sampling error.
        normals -= normals.mean(axis=0)
        normals = normals @ np.linalg.inv(np.linalg.cholesky(normals.T @ normals / count)).T
        normals.flags.writeable = False
        _drawn[key] = normals
    return _drawn[key]
