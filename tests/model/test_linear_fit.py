"""The linear fit: closure, independent oracles, and what every least-squares fit must obey."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from calibration_days import (
    DECEMBER,
    EQUINOX,
    JUNE,
    TRUTH,
    design_of,
    points_of_day,
    sky_rms_deg,
    year_axes,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from solarcal.errors import FitError
from solarcal.model.fit import fit_linear
from solarcal.model.least_squares import solve
from solarcal.model.points import Points
from solarcal.model.terms import CONTROLLER_TERMS, TERMS
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.mount.mechanism import Mechanism

ALL_OWN = (*CONTROLLER_TERMS, "C", "N", "SAG")


def weighted_design(points: Points, terms: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The textbook's X and y: rows of axis 1 times sin AX2, each divided by its sigma."""
    columns = [design_of(TERMS[t], points.geometry, points.ax1_deg, points.ax2_deg) for t in terms]
    sigma = np.ones(len(points)) if points.sigma_deg is None else points.sigma_deg
    cross, along = np.sin(np.radians(points.ax2_deg)) / sigma, 1.0 / sigma
    x = np.vstack(
        (
            np.column_stack([c[:, 0] * cross for c in columns]),
            np.column_stack([c[:, 1] * along for c in columns]),
        )
    )
    return x, np.concatenate((points.err1_deg * cross, points.err2_deg * along))


@pytest.mark.parametrize("name", ["azel", "tiltroll-ew", "tiltroll-ns"])
@settings(derandomize=True, max_examples=25, deadline=None)
@given(
    values=st.tuples(*[st.floats(-3, 3)] * 4, *[st.floats(-0.01, 0.01)] * 2),
    latitude=st.floats(20.0, 55.0),
)
def test_errors_of_the_formula_give_its_coefficients_back(
    name: str, values: tuple[float, ...], latitude: float
) -> None:
    truth = Coefficients(*values)
    points = points_of_day(name, JUNE, 9, truth=truth, latitude_deg=latitude, hours=7.0)
    found = fit_linear(points).coefficients().as_tuple()
    np.testing.assert_allclose(found, truth.as_tuple(), atol=1e-10)


def test_predictions_are_the_controllers_own_correction() -> None:
    solution = fit_linear(points_of_day("azel", JUNE, 9, noise_deg=0.02))
    ax1, ax2 = np.meshgrid([-80.0, 0.0, 70.0], [20.0, 55.0])
    e1, e2 = solution.predict_deg(ax1, ax2)
    f1, f2 = correction_deg(solution.coefficients(), ax1, ax2)
    np.testing.assert_allclose(e1, f1, atol=1e-12)
    np.testing.assert_allclose(e2, f2, atol=1e-12)
    assert np.shape(solution.predict_deg(10.0, 50.0)[0]) == ()


@pytest.mark.parametrize("terms", [CONTROLLER_TERMS, ("P2", "P4"), ("P6", "P1", "P3"), ALL_OWN])
def test_values_agree_with_plain_lstsq(terms: tuple[str, ...]) -> None:
    points = points_of_day("azel", EQUINOX, 12, noise_deg=0.03)
    x, y = weighted_design(points, terms)
    expected = np.linalg.lstsq(x, y, rcond=None)[0]
    np.testing.assert_allclose(fit_linear(points, terms).values, expected, rtol=1e-8, atol=1e-11)


@pytest.mark.parametrize("given_sigma", [True, False])
def test_covariance_agrees_with_curve_fit(given_sigma: bool) -> None:
    from scipy.optimize import curve_fit

    sigma = np.linspace(0.01, 0.05, 12)
    clean = points_of_day("azel", EQUINOX, 12, noise_deg=0.03)
    points = Points(
        geometry=clean.geometry,
        ax1_deg=clean.ax1_deg,
        ax2_deg=clean.ax2_deg,
        err1_deg=clean.err1_deg,
        err2_deg=clean.err2_deg,
        sigma_deg=sigma if given_sigma else None,
    )
    x, y = weighted_design(points, CONTROLLER_TERMS)
    values, covariance = curve_fit(
        lambda _, *p: x @ np.array(p),
        np.arange(len(y)),
        y,
        p0=np.zeros(6),
        sigma=np.ones(len(y)),
        absolute_sigma=given_sigma,
        jac=lambda _, *p: x,
        method="lm",
        ftol=1e-14,
        xtol=1e-14,
    )
    solution = fit_linear(points)
    assert solution.sigma_source == ("given" if given_sigma else "residuals")
    np.testing.assert_allclose(solution.values, values, rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(solution.covariance, covariance, rtol=1e-5, atol=1e-12)
    sigmas = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(solution.sigmas, sigmas, rtol=1e-5)
    correlation = covariance[3, 5] / (sigmas[3] * sigmas[5])
    assert solution.correlations["P4,P6"] == pytest.approx(correlation, abs=1e-6)
    assert len(solution.correlations) == 15


@pytest.mark.parametrize("sigma_deg", [0.02, None])
def test_covariance_is_the_scatter_over_many_days(sigma_deg: float | None) -> None:
    runs = 600
    distance = []
    for seed in range(runs):
        points = points_of_day("azel", JUNE, 8, noise_deg=0.02, sigma_deg=sigma_deg, seed=seed)
        solution = fit_linear(points)
        off = solution.values - np.array(TRUTH.as_tuple())
        assert solution.covariance is not None
        distance.append(off @ np.linalg.solve(solution.covariance, off))
    # Squared Mahalanobis distance: chi-square with 6 degrees of freedom, or 6 F(6, dof).
    spare = 16 - 6
    expected = 6.0 if sigma_deg else 6.0 * spare / (spare - 2)
    spread = np.sqrt(12.0 / runs) if sigma_deg else np.std(distance) / np.sqrt(runs)
    assert np.mean(distance) == pytest.approx(expected, abs=4.0 * spread)


def test_predicted_sigma_is_the_scatter_of_predictions() -> None:
    place = (np.array([-100.0, 0.0, 95.0]), np.array([75.0, 30.0, 50.0]))
    solutions = [
        fit_linear(points_of_day("azel", EQUINOX, 8, noise_deg=0.02, sigma_deg=0.02, seed=seed))
        for seed in range(500)
    ]
    scatter = np.std([solution.predict_deg(*place) for solution in solutions], axis=0)
    predicted = np.array(solutions[0].predict_sigma_deg(*place))
    np.testing.assert_allclose(predicted, scatter, rtol=0.12)


def test_residuals_are_measured_minus_predicted_per_axis_and_on_sky() -> None:
    points = points_of_day("azel", JUNE, 12, noise_deg=0.02)
    solution = fit_linear(points)
    e1, e2 = solution.predict_deg(points.ax1_deg, points.ax2_deg)
    r1, r2 = points.err1_deg - e1, points.err2_deg - e2
    sky = np.hypot(r1 * np.sin(np.radians(points.ax2_deg)), r2)
    np.testing.assert_allclose(solution.residual1_deg, r1, atol=1e-12)
    np.testing.assert_allclose(solution.residual2_deg, r2, atol=1e-12)
    np.testing.assert_allclose(solution.sky_deg, sky, atol=1e-12)
    assert solution.axis1_rms_deg == pytest.approx(np.sqrt(np.mean(r1**2)))
    assert solution.axis2_rms_deg == pytest.approx(np.sqrt(np.mean(r2**2)))
    assert solution.sky_rms_deg == pytest.approx(np.sqrt(np.mean(sky**2)))
    assert solution.sky_max_deg == pytest.approx(sky.max())
    assert solution.population_sd_deg == pytest.approx(np.sqrt(np.sum(sky**2) / (12 - 6)))
    assert fit_linear(points.subset(range(6))).population_sd_deg is None


def test_the_order_of_points_does_not_matter() -> None:
    points = points_of_day("tiltroll-ew", JUNE, 12, noise_deg=0.02, sigma_deg=0.02)
    order = np.random.default_rng(5).permutation(12)
    straight, shuffled = fit_linear(points), fit_linear(points.subset(order))
    np.testing.assert_allclose(shuffled.values, straight.values, atol=1e-11)
    np.testing.assert_allclose(shuffled.covariance, straight.covariance, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(shuffled.sky_deg, straight.sky_deg[order], atol=1e-11)
    assert shuffled.labels == tuple(i + 1 for i in order)


def test_the_order_of_terms_does_not_matter() -> None:
    points = points_of_day("azel", JUNE, 12, noise_deg=0.02)
    backwards = fit_linear(points, tuple(reversed(CONTROLLER_TERMS)))
    assert backwards.terms[0] == "P6"
    np.testing.assert_allclose(backwards.values[::-1], fit_linear(points).values, atol=1e-11)


def test_a_subset_of_terms_leaves_the_others_at_zero() -> None:
    points = points_of_day("azel", JUNE, 12, truth=Coefficients(P2=0.3, P4=-0.2))
    solution = fit_linear(points, ["P2", "P4"])
    np.testing.assert_allclose(solution.coefficients().as_tuple(), (0, 0.3, 0, -0.2, 0, 0))
    assert solution.sigma_coefficients() is not None
    with pytest.raises(FitError, match=r"none of P1\.\.P6 was fitted"):
        fit_linear(points, ["C"]).coefficients()


def test_equal_sigmas_do_not_move_the_values_and_scale_the_covariance() -> None:
    bare = points_of_day("azel", JUNE, 12, noise_deg=0.02)
    fine = points_of_day("azel", JUNE, 12, noise_deg=0.02, sigma_deg=0.01)
    coarse = points_of_day("azel", JUNE, 12, noise_deg=0.02, sigma_deg=0.04)
    np.testing.assert_allclose(fit_linear(fine).values, fit_linear(bare).values, atol=1e-11)
    np.testing.assert_allclose(fit_linear(coarse).values, fit_linear(bare).values, atol=1e-11)
    np.testing.assert_allclose(
        fit_linear(coarse).covariance, 16.0 * fit_linear(fine).covariance, rtol=1e-8
    )


def test_half_the_sigma_counts_as_much_as_the_point_taken_four_times() -> None:
    points = points_of_day("azel", JUNE, 10, noise_deg=0.02, sigma_deg=0.02)
    sigma = np.full(10, 0.02)
    sigma[3] = 0.01
    weighted = Points(
        geometry=points.geometry,
        ax1_deg=points.ax1_deg,
        ax2_deg=points.ax2_deg,
        err1_deg=points.err1_deg,
        err2_deg=points.err2_deg,
        sigma_deg=sigma,
    )
    repeated = points.subset([*range(10), 3, 3, 3])
    np.testing.assert_allclose(fit_linear(weighted).values, fit_linear(repeated).values, atol=1e-10)


@pytest.mark.parametrize("name", ["azel", "tiltroll-ns", "tiltroll-ew"])
def test_a_slightly_leaning_exact_mechanism_is_found(name: str) -> None:
    day = points_of_day(name, JUNE, 12)
    mechanism = Mechanism(P1=0.06, P2=0.3, P3=-0.08, P4=-0.2, P5=0.0008, P6=-0.0005)
    e1, e2 = mechanism.errors_deg(day.geometry, day.ax1_deg, day.ax2_deg)
    solution = fit_linear(
        Points(
            geometry=day.geometry,
            ax1_deg=day.ax1_deg,
            ax2_deg=day.ax2_deg,
            err1_deg=e1,
            err2_deg=e2,
        )
    )
    np.testing.assert_allclose(solution.values[:4], [0.06, 0.3, -0.08, -0.2], atol=0.005)
    np.testing.assert_allclose(solution.values[4:], [0.0008, -0.0005], atol=1e-4)


def test_southern_branch_keeps_the_gear_error() -> None:
    geometry = MountGeometry("azel", -33.9, ax1_centre_deg=180.0)
    ax1 = np.linspace(80.0, 280.0, 11)
    ax2 = 30.0 + 0.004 * (ax1 - 180.0) ** 2
    e1, e2 = correction_deg(Coefficients(P5=0.001), ax1, ax2)
    wrapped = np.where(ax1 > 180.0, ax1 - 360.0, ax1)
    solution = fit_linear(
        Points(geometry=geometry, ax1_deg=wrapped, ax2_deg=ax2, err1_deg=e1, err2_deg=e2)
    )
    np.testing.assert_allclose(solution.coefficients().P5, 0.001, atol=1e-10)
    assert any("off the mount's branch" in note for note in solution.notes)


class TestTooFewToJudge:
    def test_fewer_than_three_points_are_refused(self) -> None:
        points = points_of_day("azel", JUNE, 5)
        with pytest.raises(FitError, match=r"^2 points to fit, at least 3 are needed"):
            fit_linear(points.subset([0, 1]))
        with pytest.raises(FitError, match=r"^0 points"):
            fit_linear(points.subset([]))

    def test_as_many_unknowns_as_numbers_give_no_sigma_and_say_so(self) -> None:
        points = points_of_day("azel", JUNE, 8, noise_deg=0.02).subset([0, 2, 5])
        solution = fit_linear(points)
        assert solution.rank == 6
        assert solution.sigma_source == "none"
        assert solution.sigmas is None
        assert solution.covariance is None
        assert solution.population_sd_deg is None
        assert solution.sigma_coefficients() is None
        assert np.isinf(solution.predict_sigma_deg(0.0, 40.0)).all()
        assert "6 numbers determine 6 unknowns" in solution.notes[0]
        assert solution.as_json()["coefficients"]["P1"]["sigma"] is None

    def test_given_sigmas_carry_even_when_nothing_is_left_over(self) -> None:
        day = points_of_day("azel", JUNE, 8, noise_deg=0.02, sigma_deg=0.02)
        solution = fit_linear(day.subset([0, 2, 5]))
        assert solution.sigma_source == "given"
        assert solution.sigmas is not None
        assert np.isfinite(solution.sigmas).all()
        assert solution.notes == ()

    def test_more_terms_than_numbers_still_fit_the_points(self) -> None:
        points = points_of_day("azel", JUNE, 8, noise_deg=0.02).subset([0, 2, 5])
        solution = fit_linear(points, ALL_OWN)
        assert solution.rank == 6
        assert solution.sky_max_deg < 1e-10
        assert solution.inseparable
        # Nothing tells the noise, so data and prior cannot be brought into one matrix.
        assert solution.correlations == {}


class TestWhatIsSaidAboutSigmas:
    def test_scaled_by_residuals(self) -> None:
        solution = fit_linear(points_of_day("azel", JUNE, 12, noise_deg=0.02))
        assert "scaled by the residuals" in solution.notes[0]

    def test_given_and_plausible_is_not_worth_a_word(self) -> None:
        points = points_of_day("azel", JUNE, 12, noise_deg=0.02, sigma_deg=0.02)
        assert fit_linear(points).notes == ()

    def test_given_but_far_too_small(self) -> None:
        points = points_of_day("azel", JUNE, 12, noise_deg=0.05, sigma_deg=0.01)
        assert "times the given sigmas" in fit_linear(points).notes[0]

    def test_points_without_noise(self) -> None:
        silent = points_of_day("azel", JUNE, 12, truth=Coefficients())
        assert "points without noise" in fit_linear(silent).notes[0]
        assert np.isfinite(list(fit_linear(silent).correlations.values())).all()


@pytest.mark.parametrize("name", GEOMETRIES)
def test_json_has_the_contracts_keys_and_only_finite_numbers(name: str) -> None:
    import json

    solution = fit_linear(points_of_day(name, DECEMBER, 10, noise_deg=0.02))
    document = json.loads(json.dumps(solution.as_json(), allow_nan=False))
    assert set(document) == {
        "geometry", "method", "coefficients", "residuals", "rank", "condition_number",
        "correlations", "message", "notes", "inseparable", "sigma_source",
    }  # fmt: skip
    assert document["geometry"] == name
    assert document["method"] == "linear"
    assert document["coefficients"]["P5"]["unit"] == "deg/deg"
    assert set(document["residuals"]) == {
        "axis1_rms_deg", "axis2_rms_deg", "sky_rms_deg", "sky_max_deg", "population_sd_deg",
    }  # fmt: skip
    assert (document["condition_number"] is None) == (name == "polar")


def test_a_solution_cannot_be_changed() -> None:
    solution = fit_linear(points_of_day("azel", JUNE, 12, noise_deg=0.02))
    with pytest.raises(FrozenInstanceError):
        solution.method = "better"  # type: ignore[misc]


def test_one_noisy_day_predicts_that_day() -> None:
    points = points_of_day("azel", JUNE, 12, noise_deg=0.02)
    solution = fit_linear(points)
    year1, year2 = year_axes(points.geometry)
    found = np.array(solution.predict_deg(points.ax1_deg, points.ax2_deg))
    true = np.array(correction_deg(TRUTH, points.ax1_deg, points.ax2_deg))
    assert sky_rms_deg(points.ax2_deg, *(found - true)) < 0.02
    found, true = (
        np.array(solution.predict_deg(year1, year2)),
        np.array(correction_deg(TRUTH, year1, year2)),
    )
    assert sky_rms_deg(year2, *(found - true)) < 0.1


@pytest.mark.parametrize(("share", "is_a_column"), [(0.5e-9, False), (2e-9, True)])
def test_a_column_that_is_rounding_is_no_parameter(share: float, is_a_column: bool) -> None:
    """Below a thousand millionth of the data's weight at one prior sigma nothing is measured:
    cos 90 deg is 6e-17, and dividing by it would make a tracker turn by a million degrees."""
    weights, prior_sigma = np.ones(8), np.array([2.0, 5.0])
    data_weight = float(np.sqrt(weights @ weights))
    slight = share / prior_sigma[1] * np.array([1.0, -1.0] * 4)
    rows = np.array((weights, slight))
    solved = solve(rows, 0.3 * weights + 7.0 * slight, prior_sigma, data_weight)
    assert solved.values[0] == pytest.approx(0.3)
    assert solved.rank == (2 if is_a_column else 1)
    if is_a_column:
        assert solved.values[1] == pytest.approx(7.0, rel=1e-4)
    else:
        assert solved.values[1] == 0.0
        assert solved.prior_covariance is not None
        assert solved.prior_covariance[1, 1] == pytest.approx(prior_sigma[1] ** 2)
