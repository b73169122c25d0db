"""The batched fit says what the single fit says, session by session."""

import numpy as np
import pytest

from solarcal.model.fleet_fit import ManyPoints, fit_many
from solarcal.model.methods import fit_mechanism
from solarcal.model.prior import Prior
from solarcal.model.sky_context import TruePoints
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism

SESSIONS = 12
TOLERANCE_SIGMA = 1e-6
"""Both take the same steps: what is left is where least squares is content."""


def fleet(n: int, given_sigmas: bool = False) -> ManyPoints:
    """Trackers of different lean; a tenth of the points are blunders."""
    rng = np.random.default_rng([7, n])
    geometry = MountGeometry("azel", 35.0)
    ax1 = np.linspace(-100.0, 100.0, n) if n > 1 else np.array([-40.0])
    ax2 = 75.0 - 60.0 * np.cos(np.radians(ax1 * 0.75))
    rows1, rows2 = [], []
    for _ in range(SESSIONS):
        P1, P2, P3, P4 = rng.normal(0.0, (1.0, 3.0, 1.0, 3.0)).tolist()
        e1, e2 = Mechanism(P1, P2, P3, P4, 0.001, -0.002).errors_deg(geometry, ax1, ax2)
        blunders = (rng.random(n) < 0.1) * rng.normal(0.0, 1.0, n)
        noise1, noise2 = rng.normal(0.0, 0.03, (2, n))
        rows1.append(e1 + (noise1 + blunders) / np.sin(np.radians(ax2)))
        rows2.append(e2 + noise2)
    each = np.ones((SESSIONS, 1))
    sigma = np.linspace(0.02, 0.06, n) if given_sigmas else np.full(n, np.nan)
    return ManyPoints(
        ax1_deg=each * ax1,
        ax2_deg=each * ax2,
        err1_deg=np.array(rows1),
        err2_deg=np.array(rows2),
        sigma_deg=each * sigma,
        prior_mean=each * Prior().mean_array(),
        prior_sigma=each * Prior().sigma_array(),
    )


@pytest.mark.parametrize(
    ("n", "given_sigmas"),
    [(1, False), (2, False), (3, False), (12, False), (12, True), (15, False), (40, False)],
)
def test_every_session_is_fitted_as_it_would_be_alone(n: int, given_sigmas: bool) -> None:
    points = fleet(n, given_sigmas)
    many = fit_many(points)
    geometry = MountGeometry("azel", 35.0)
    for i in range(SESSIONS):
        alone = fit_mechanism(
            TruePoints(
                points.ax1_deg[i],
                points.ax2_deg[i],
                points.err1_deg[i],
                points.err2_deg[i],
                np.full(n, 45.0),
            ),
            geometry,
            points.sigma_deg[i] if given_sigmas else None,
            Prior(),
        )
        sigma = np.sqrt(np.diag(alone.posterior.covariance))
        assert np.abs((many.mean[i] - alone.posterior.mean) / sigma).max() < TOLERANCE_SIGMA
        spread = (many.covariance[i] - alone.posterior.covariance) / np.outer(sigma, sigma)
        assert np.abs(spread).max() < TOLERANCE_SIGMA
        assert many.noise_deg[i] == pytest.approx(
            alone.posterior.noise_median_deg, rel=TOLERANCE_SIGMA
        )
        assert many.blunder[i] == pytest.approx(alone.blunder, abs=TOLERANCE_SIGMA)
        assert many.residual1_deg[i] == pytest.approx(alone.residuals_deg[0], abs=TOLERANCE_SIGMA)
        assert many.residual2_deg[i] == pytest.approx(alone.residuals_deg[1], abs=TOLERANCE_SIGMA)


def test_a_tower_that_leans_far_comes_out_as_it_leans() -> None:
    """Steps are held short on the way there, not given up."""
    geometry = MountGeometry("azel", 35.0)
    ax1 = np.linspace(-100.0, 100.0, 12)
    ax2 = 75.0 - 60.0 * np.cos(np.radians(ax1 * 0.75))
    true = Mechanism(14.0, 1.0, -9.0, 0.5, 0.001, -0.002)
    e1, e2 = true.errors_deg(geometry, ax1, ax2)
    wide = Prior(sigmas=(20.0, 5.0, 20.0, 5.0, 0.002, 0.002))
    points = ManyPoints(
        ax1_deg=ax1[np.newaxis],
        ax2_deg=ax2[np.newaxis],
        err1_deg=e1[np.newaxis],
        err2_deg=e2[np.newaxis],
        sigma_deg=np.full((1, 12), np.nan),
        prior_mean=wide.mean_array()[np.newaxis],
        prior_sigma=wide.sigma_array()[np.newaxis],
    )
    assert fit_many(points).mean[0, :4] == pytest.approx([14.0, 1.0, -9.0, 0.5], abs=0.05)


def test_the_company_a_session_is_in_does_not_matter() -> None:
    points = fleet(12)
    together = fit_many(points).mean
    for i in (0, 5):
        alone = fit_many(points.take(slice(i, i + 1))).mean[0]
        assert together[i] == pytest.approx(alone, abs=1e-9)
