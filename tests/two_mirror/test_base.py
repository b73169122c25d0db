"""The base's Euler angles: from three positions, then from all."""

import numpy as np
import pytest

from solarcal.errors import FitError
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc
from solarcal.two_mirror.base import MirrorPoints, base_from_three, fit_base
from solarcal.two_mirror.mirrors import EulerBase

PUBLISHED = EulerBase(9.96, 0.888, 0.174)
"""10-physics.md section 6: alpha, beta, gamma at Saint-Denis, 12 September 2011."""


def day_points(base: EulerBase, n: int, noise_deg: float = 0.0, seed: int = 1) -> MirrorPoints:
    """n positions of that day at Saint-Denis (20.9 S, 55.5 E); noise per axis, on sky."""
    times = parse_utc("2011-09-12T03:00:00Z") + np.linspace(0.0, 10.5 * 3600.0, n)
    sun = sun_position("precise", times, Site(-20.9, 55.5))
    sun1, sun2 = 180.0 - sun.azimuth_deg, sun.zenith_deg
    axes = np.array([base.axes_deg(a, b) for a, b in zip(sun1, sun2, strict=True)])
    noise = np.random.default_rng(seed).standard_normal((n, 2)) * noise_deg
    across = noise[:, 0] / np.sin(np.radians(sun2))
    return MirrorPoints(sun1, sun2, axes[:, 0] + across, axes[:, 1] + noise[:, 1])


def test_the_published_case() -> None:
    """About 100 points give 9.96, 0.888, 0.174 deg, leaving at most 0.5 deg.

    With reading noise that leaves about that much, the angles come back within three sigmas.
    """
    solution = fit_base(day_points(PUBLISHED, 100, noise_deg=0.13))
    assert 0.3 < solution.sky_max_deg <= 0.5
    assert solution.sigma_deg is not None
    for value, true, sigma in zip(
        (solution.base.alpha_deg, solution.base.beta_deg, solution.base.gamma_deg),
        (9.96, 0.888, 0.174),
        solution.sigma_deg,
        strict=True,
    ):
        assert abs(value - true) < 3.0 * sigma
        assert sigma < 0.05


def test_three_positions_are_enough_and_exact() -> None:
    base = base_from_three(day_points(PUBLISHED, 3))
    assert base.alpha_deg == pytest.approx(9.96, abs=1e-9)
    assert base.beta_deg == pytest.approx(0.888, abs=1e-9)
    assert base.gamma_deg == pytest.approx(0.174, abs=1e-9)


def test_all_points_are_better_than_three() -> None:
    """The start is off by the noise of three readings; all points by a fraction of it."""
    solutions = [fit_base(day_points(PUBLISHED, 100, 0.1, seed)) for seed in range(10)]

    def rms(which: str) -> float:
        off = [
            np.subtract((b.alpha_deg, b.beta_deg, b.gamma_deg), (9.96, 0.888, 0.174))
            for b in (getattr(s, which) for s in solutions)
        ]
        return float(np.sqrt(np.mean(np.square(off))))

    assert rms("base") < 0.4 * rms("start")


@pytest.mark.parametrize(
    "base",
    [EulerBase(), EulerBase(170.0, -20.0, 35.0), EulerBase(-90.0, 60.0, 10.0)],
)
def test_any_base_comes_back(base: EulerBase) -> None:
    """The instrument may stand anyhow on its roof."""
    found = fit_base(day_points(base, 20)).base
    np.testing.assert_allclose(found.matrix(), base.matrix(), atol=1e-11)


def test_the_solution_is_the_least_squares_one() -> None:
    """Turning the base a little any way leaves more."""
    points = day_points(PUBLISHED, 40, noise_deg=0.1)
    best = fit_base(points).base

    def left(base: EulerBase) -> float:
        return float(np.sum((points.seen() - points.suns() @ base.matrix().T) ** 2))

    for d in ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01)):
        for sign in (-1.0, 1.0):
            moved = EulerBase(
                best.alpha_deg + sign * d[0],
                best.beta_deg + sign * d[1],
                best.gamma_deg + sign * d[2],
            )
            assert left(moved) > left(best)


def test_the_worst_point_is_named() -> None:
    points = day_points(PUBLISHED, 20)
    points.axis2_deg[7] += 0.3
    assert fit_base(points).worst_label == 8


def test_too_few_too_near_or_below_the_horizon() -> None:
    points = day_points(PUBLISHED, 30)
    below = points.rows([1, 2, 3])
    below.sun2_deg[1] = 91.0
    nan = points.rows([1, 2, 3])
    nan.axis1_deg[2] = np.nan
    same = points.rows([5, 5, 5])
    for wrong, said in (
        (points.rows([0, 1]), "at least 3"),
        (points.rows([]), "at least 3"),
        (same, "within 0.00 deg of one another"),
        (below, "below the horizon"),
        (nan, "must be numbers"),
    ):
        with pytest.raises(FitError, match=said):
            fit_base(wrong)


@pytest.mark.parametrize("seed", range(5))
def test_an_axis_whose_sense_is_reversed_is_refused(seed: int) -> None:
    """No turn of the base makes a Sun that goes the other way round."""
    right = day_points(PUBLISHED, 30, 0.1, seed)
    reversed_ = MirrorPoints(right.sun1_deg, right.sun2_deg, -right.axis1_deg, right.axis2_deg)
    with pytest.raises(FitError, match="sense of both axes"):
        fit_base(reversed_)
