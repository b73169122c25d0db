"""Sigmas that are permitted and absurd, or very unlike each other: an answer, and no traceback."""

import numpy as np
import pytest
from made_up_trackers import day_of

from solarcal.model.analysis import Analysis, analyse
from solarcal.model.least_squares import inverse, solution_of
from solarcal.model.points import SIGMA_HIGH_DEG, SIGMA_LOW_DEG

METHODS = ("robust", "exact", "linear")


def analysed(sigma_deg: np.ndarray, method: str) -> Analysis:
    context, points = day_of("azel", len(sigma_deg), noise_deg=0.02)
    at_utc_s = None if points.utc_s is None else float(points.utc_s[-1])
    return analyse(points.replace(sigma_deg=sigma_deg), context, at_utc_s=at_utc_s, method=method)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", [SIGMA_LOW_DEG, 1e-8, 1e-6, SIGMA_HIGH_DEG])
def test_sigmas_at_the_ends_of_their_range(size: float, method: str) -> None:
    analysis = analysed(np.full(13, size), method)
    assert analysis.verdict.state != "done"
    assert np.isfinite(analysis.solution.values).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("few", [1, 2, 5])
def test_sigmas_very_unlike_each_other(few: int, method: str) -> None:
    sigma = np.full(13, 90.0)
    sigma[:few] = SIGMA_LOW_DEG
    analysis = analysed(sigma, method)
    assert analysis.verdict.state != "done"
    assert np.isfinite(analysis.forecast.year_rms_deg)


@pytest.mark.parametrize("n", [1, 2, 4, 10])
@pytest.mark.parametrize("size", [1e-8, 1e-6])
def test_few_points_with_tiny_sigmas(n: int, size: float) -> None:
    assert np.isfinite(analysed(np.full(n, size), "robust").forecast.year_rms_deg)


@pytest.mark.parametrize("seed", range(6))
def test_any_mixture_of_sigmas(seed: int) -> None:
    sigma: np.ndarray = 10.0 ** np.random.default_rng(seed).integers(-9, 2, 10)
    assert np.isfinite(analysed(sigma, "robust").forecast.year_rms_deg)


def test_a_matrix_that_rounding_left_singular_has_an_inverse() -> None:
    column = np.array([1.0, 2.0, 3.0])
    singular = 1e20 * np.outer(column, column)
    assert (np.diagonal(inverse(singular)) > 0.0).all()
    assert np.isfinite(solution_of(singular, column)).all()
    regular = np.diag([1.0, 4.0])
    np.testing.assert_array_equal(inverse(np.stack([regular] * 2))[1], np.diag([1.0, 0.25]))
    np.testing.assert_array_equal(solution_of(regular, np.array([1.0, 2.0])), [1.0, 0.5])
