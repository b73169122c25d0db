"""How wrong the tracker will be: the contract's definitions, and whether they come true."""

import numpy as np
import pytest
from made_up_trackers import JUNE, TRACKER, context_of, day_of, random_mechanism, true_year

from solarcal.errors import ConfigurationError
from solarcal.model.forecast import forecast, forecast_of, upper_quantile
from solarcal.model.methods import fit
from solarcal.model.prior import MechanismPosterior, Prior, standard_normals, symmetric_root
from solarcal.model.sky_context import SkyContext, sun_directions
from solarcal.model.year_grid import controller_coefficients, year_grid
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.site import Site

DAY_S = 86400.0


def certain(mechanism: Mechanism) -> MechanismPosterior:
    values = [[mechanism.P1, mechanism.P2, mechanism.P3, mechanism.P4, mechanism.P5, mechanism.P6]]
    return MechanismPosterior(np.ones(1), np.array(values), np.zeros((1, 6, 6)), np.array([0.03]))


class TestGrid:
    def test_every_half_hour_above_ten_degrees_every_seventh_day(self):
        grid = year_grid(context_of("azel"))
        assert (grid.sun.elevation_deg > 10.0).all()
        assert np.diff(grid.days_utc_s) == pytest.approx(7 * DAY_S)
        assert len(grid.days_utc_s) == 53
        same_day = np.diff(grid.day) == 0
        assert np.diff(grid.utc_s)[same_day] == pytest.approx(1800.0)
        # Half the year the Sun is up; at latitude 35 a little less of it above 10 deg.
        assert 53 * 48 * 0.40 < len(grid) < 53 * 48 * 0.46

    def test_only_within_limits(self):
        limits = Limits(AxisLimits(-60.0, 60.0), AxisLimits(0.0, 75.0))
        free = context_of("azel")
        grid = year_grid(SkyContext(free.site, free.geometry, limits))
        assert np.abs(grid.sun.ideal1_deg).max() <= 60.0
        assert len(grid) < len(year_grid(free))

    def test_no_sun_within_limits_is_said(self):
        limits = Limits(AxisLimits(-5.0, 5.0), AxisLimits(0.0, 1.0))
        with pytest.raises(ConfigurationError, match="never above 10 deg and within"):
            year_grid(SkyContext(Site(60.0, 0.0), MountGeometry("azel", 60.0), limits))

    def test_warm_use_costs_nothing(self):
        assert year_grid(context_of("azel")) is year_grid(context_of("azel"))

    def test_the_three_kinds_of_ideal_differ_by_refraction_and_ephemeris(self):
        times = year_grid(context_of("azel")).utc_s
        kinds = {k: sun_directions(context_of("azel", k), times) for k in ("airless", "solartrak")}
        lift = kinds["airless"].ideal2_deg - kinds["airless"].true2_deg
        assert 0.0 < lift.min() < 0.01
        assert 0.08 < lift.max() < 0.10
        ephemeris = kinds["solartrak"].ideal2_deg - kinds["airless"].ideal2_deg
        assert 1e-4 < np.abs(ephemeris).max() < 0.0146


class TestDefinitions:
    def test_a_known_mechanism_leaves_what_the_formula_cannot_follow(self):
        for lean, low, high in ((2.0, 0.02, 0.04), (5.0, 0.15, 0.23), (8.0, 0.35, 0.6)):
            mechanism = Mechanism(P1=lean)
            context = context_of("azel")
            posterior = certain(mechanism)
            best = controller_coefficients(posterior.mean, context, Prior())
            expected = forecast_of(posterior, Coefficients(*best), year_grid(context))
            assert low < expected.year_rms_deg < high
            assert expected.year_rms_deg == pytest.approx(expected.known_rms_deg)
            actual = true_year(context, mechanism, Coefficients(*best))
            assert expected.year_rms_deg == pytest.approx(actual.rms_deg, rel=0.01)
            assert expected.year_max_deg == pytest.approx(actual.sky_deg.max(), rel=0.05)
            p95 = float(np.quantile(actual.sky_deg, 0.95))
            assert expected.year_p95_deg == pytest.approx(p95, rel=0.03)

    def test_rms_p95_and_max_are_over_posterior_and_grid(self):
        context, points = day_of("azel", 6)
        expected = forecast(fit(points, context))
        sky = np.hypot(*np.moveaxis(expected.errors.of(), 1, 0))
        assert expected.year_rms_deg == pytest.approx(float(np.sqrt(np.mean(sky**2))))
        assert expected.year_p95_deg == pytest.approx(float(np.quantile(sky, 0.95)), rel=1e-3)
        largest = float(np.quantile(sky.max(axis=1), 0.95))
        assert expected.year_max_deg == pytest.approx(largest, rel=1e-3)
        parts = np.hypot(expected.parameters_rms_deg, expected.known_rms_deg)
        assert expected.year_rms_deg == pytest.approx(parts, rel=1e-6)

    def test_the_best_coefficients_are_best(self):
        context = context_of("tiltroll-ew", "airless")
        posterior = certain(Mechanism(2.0, 1.0, -3.0, 0.5, 0.001, 0.002))
        best = controller_coefficients(posterior.mean, context, Prior())
        left = forecast_of(posterior, Coefficients(*best), year_grid(context)).year_rms_deg
        for index in range(6):
            for sign in (-1.0, 1.0):
                other = best.copy()
                other[index] += sign * (0.02 if index < 4 else 0.0005)
                worse = forecast_of(posterior, Coefficients(*other), year_grid(context))
                assert worse.year_rms_deg > left

    def test_the_same_question_gives_the_same_answer(self):
        context, points = day_of("azel", 5)
        first, second = (forecast(fit(points, context)).as_json() for _ in range(2))
        assert first == second

    def test_rounding_of_what_is_uploaded_shows(self):
        context, points = day_of("azel", 20, noise_deg=0.005)
        solution = fit(points, context)
        exact = forecast(solution)
        rounded = exact.uploading(solution.coefficients().rounded(1, 3))
        fine = exact.uploading(solution.coefficients().rounded(4, 6))
        assert rounded.year_rms_deg > 1.5 * exact.year_rms_deg
        assert fine.year_rms_deg == pytest.approx(exact.year_rms_deg, rel=0.02)

    def test_missing_refraction_counts(self):
        errors = {}
        for ideal in ("apparent", "airless"):
            context, points = day_of("azel", 12, ideal=ideal)
            errors[ideal] = forecast(fit(points, context)).known_rms_deg
        assert errors["airless"] > errors["apparent"] + 0.002


class TestMap:
    def test_a_row_a_day_a_column_half_an_hour(self):
        context, points = day_of("azel", 5)
        expected = forecast(fit(points, context))
        assert expected.map_rms_deg.shape == (53, 48)
        assert np.isnan(expected.map_rms_deg[:, 0]).all()
        assert np.isfinite(expected.map_rms_deg[:, 24]).all()
        # Winter days are short.
        assert (
            np.isfinite(expected.map_rms_deg[0]).sum() < np.isfinite(expected.map_rms_deg[25]).sum()
        )
        mean = np.nanmean(expected.map_rms_deg**2)
        assert np.sqrt(mean) == pytest.approx(expected.year_rms_deg)

    def test_where_the_points_were_is_where_it_is_good(self):
        context, points = day_of("azel", 6, JUNE)
        expected = forecast(fit(points, context))
        day = int(np.argmin(np.abs(expected.days_utc_s - points.utc_s[0])))
        assert np.nanmean(expected.map_rms_deg[day]) < np.nanmean(expected.map_rms_deg[0])

    def test_the_json_has_null_where_there_is_no_sun(self):
        context, points = day_of("azel", 5)
        rows = forecast(fit(points, context)).map_json()["rms_deg"]
        assert rows[0][0] is None
        assert isinstance(rows[0][24], float)


class TestManual:
    def test_a_manual_fit_is_forecast_too_and_wider(self):
        context, points = day_of("azel", 5)
        manual = forecast(fit(points, context, method="linear"), context)
        robust = forecast(fit(points, context))
        assert manual.year_rms_deg > robust.year_rms_deg


class TestItComesTrue:
    @pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew"])
    def test_the_forecast_is_neither_modest_nor_bold(self, geometry):
        """Squared true errors average to squared forecasts: forty trackers, seven points."""
        ratios = []
        for seed in range(40):
            mechanism = random_mechanism(np.random.default_rng([3, seed]))
            context, points = day_of(geometry, 7, day=9 * seed, mechanism=mechanism, seed=seed)
            solution = fit(points, context)
            actual = true_year(context, mechanism, solution.coefficients()).rms_deg
            ratios.append(actual / forecast(solution).year_rms_deg)
        assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.3

    def test_the_tracker_of_these_tests(self):
        context, points = day_of("azel", 12)
        solution = fit(points, context)
        actual = true_year(context, TRACKER, solution.coefficients()).rms_deg
        assert actual < forecast(solution).year_rms_below_deg(0.99)


@pytest.mark.parametrize("share", [0.01, 0.5, 0.95, 1.0])
@pytest.mark.parametrize("n", [1, 7, 40_000])
def test_a_quantile_is_the_smallest_value_that_so_many_do_not_exceed(n, share):
    values = np.random.default_rng(n).normal(size=n)
    found = upper_quantile(values, share)
    assert found in values
    assert np.mean(values <= found) >= share
    assert np.mean(values < found) < share


def test_no_pointing_is_wrong_by_more_than_half_a_turn():
    wide = np.diag([1.0, 150.0, 1.0, 150.0, 1e-6, 1e-6]) ** 2
    unknown = MechanismPosterior(np.ones(1), np.zeros((1, 6)), wide[np.newaxis], np.array([0.03]))
    expected = forecast_of(unknown, Coefficients(), year_grid(context_of("azel")))
    assert expected.year_max_deg == pytest.approx(180.0)
    assert expected.year_p95_deg <= 180.0


def test_rms_percentile_and_largest_are_those_of_posterior_and_grid_together():
    """The contract's definitions, over every draw at every moment."""
    context, points = day_of("azel", 8, JUNE)
    expected = forecast(fit(points, context))
    square = np.sum(expected.errors.of() ** 2, axis=1)
    assert expected.year_rms_deg == pytest.approx(np.sqrt(square.mean()))
    assert np.mean(square <= expected.year_p95_deg**2 * (1.0 + 1e-9)) >= 0.95
    assert np.mean(square < expected.year_p95_deg**2 * (1.0 - 1e-9)) < 0.95
    assert expected.year_max_deg == pytest.approx(np.sqrt(np.quantile(square.max(axis=1), 0.95)))


def test_standard_normals_are_exactly_standard_and_shared_by_all():
    normals = standard_normals(64, dimensions=3)
    np.testing.assert_allclose(normals.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(normals.T @ normals / 64, np.eye(3), atol=1e-12)
    with pytest.raises(ValueError, match="read-only"):
        normals[0, 0] = 1.0


def test_draws_do_not_hang_on_which_eigenvectors_a_machine_finds():
    """Their signs are free, and so is the basis where two eigenvalues are equal."""
    vectors = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    values = np.array([2.0, 2.0, 0.5])
    root = symmetric_root(values, vectors)
    assert root @ root.T == pytest.approx(vectors * values @ vectors.T)
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, -1.0]])
    assert symmetric_root(values, vectors @ turn) == pytest.approx(root, abs=1e-15)
    assert symmetric_root(np.array([1.0, 1.0, -1e-17]), np.eye(3))[2, 2] == 0.0
