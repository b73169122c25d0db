"""Which parameters a day can tell apart, and what is done and said where it cannot."""

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

from solarcal.model.fit import fit_linear
from solarcal.model.parameter_checks import correlation_text
from solarcal.model.points import Points
from solarcal.model.terms import CONTROLLER_TERMS, TERMS
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import MountGeometry


def condition(name: str, declination_deg: float, hours: float) -> float:
    points = points_of_day(name, declination_deg, 10, noise_deg=0.03, hours=hours)
    return fit_linear(points).condition_number


class TestConditionOfADay:
    """Ten points of one day at latitude 35; the ranges are those of the design's section 3."""

    def test_azel_is_worst_in_december(self) -> None:
        june, equinox, december = (condition("azel", d, 7.0) for d in (JUNE, EQUINOX, DECEMBER))
        assert 8.0 < june < equinox < december < 90.0

    def test_north_south_tilt_roll(self) -> None:
        for declination in (JUNE, EQUINOX, DECEMBER):
            assert 29.0 < condition("tiltroll-ns", declination, 8.0) < 141.0

    def test_east_west_tilt_roll_is_hopeless_at_the_equinox_only(self) -> None:
        assert 55.0 < condition("tiltroll-ew", JUNE, 7.0) < 105.0
        assert condition("tiltroll-ew", EQUINOX, 10.0) > 3000.0

    def test_units_do_not_matter(self) -> None:
        points = points_of_day("azel", JUNE, 10, noise_deg=0.03)
        degrees = fit_linear(points, ("P1", "P2", "P3", "P4", "C"))
        arcsec = fit_linear(points, ("AN", "IA", "AW", "IE", "CA"))
        assert arcsec.condition_number == pytest.approx(degrees.condition_number, rel=1e-9)


class TestPolarDay:
    """AX2 stays put all day: zero and scale of axis 2 are one number."""

    def test_is_rank_deficient_and_names_the_pair(self) -> None:
        solution = fit_linear(points_of_day("polar", JUNE, 10, noise_deg=0.03))
        assert solution.rank == 5
        assert solution.condition_number == np.inf
        assert solution.inseparable == (
            "declination zero (P4) and declination scale (P6) cannot be separated with these "
            "points: only one combination of them is fixed",
        )
        assert any("got the smallest values" in note for note in solution.notes)

    def test_points_of_that_day_are_fitted_all_the_same(self) -> None:
        points = points_of_day("polar", JUNE, 10)
        assert fit_linear(points).sky_max_deg < 1e-10

    def test_takes_the_smallest_values_in_prior_units(self) -> None:
        solution = fit_linear(points_of_day("polar", JUNE, 10))
        p = solution.coefficients()
        ax2 = 90.0 - JUNE
        # Of all P4, P6 with the same P4 - P6*AX2 the one nearest zero in (5 deg, 0.002).
        combination = TRUTH.P4 - TRUTH.P6 * ax2
        direction = np.array([5.0**2, -ax2 * 0.002**2])
        expected = direction * combination / (direction[0] - ax2 * direction[1])
        np.testing.assert_allclose([p.P4, p.P6], expected, atol=1e-9)
        np.testing.assert_allclose(
            [p.P1, p.P2, p.P3, p.P5], [TRUTH.P1, TRUTH.P2, TRUTH.P3, TRUTH.P5], atol=1e-9
        )

    def test_prior_units_serve_the_year_better_than_plain_minimum_norm(self) -> None:
        rng = np.random.default_rng(3)
        geometry = MountGeometry("polar", 35.0)
        year = year_axes(geometry)
        ours, plain = [], []
        for _ in range(60):
            truth = Coefficients(*(rng.standard_normal(6) * [0.7, 1, 0.7, 1, 0.001, 0.001]))
            points = points_of_day("polar", rng.uniform(6.0, 23.4), 10, truth=truth)
            columns = np.array(
                [
                    design_of(TERMS[t], geometry, points.ax1_deg, points.ax2_deg).T.ravel()
                    for t in CONTROLLER_TERMS
                ]
            )
            errors = np.concatenate((points.err1_deg, points.err2_deg))
            unscaled = np.linalg.lstsq(columns.T, errors, rcond=1e-9)[0]
            true = np.array(correction_deg(truth, *year))
            for results, found in (
                (ours, fit_linear(points).coefficients()),
                (plain, Coefficients(*unscaled)),
            ):
                off = np.array(correction_deg(found, *year)) - true
                results.append(sky_rms_deg(year[1], *off))
        assert np.median(ours) < 0.04
        assert np.median(plain) > 3.0 * np.median(ours)

    def test_the_covariance_admits_what_the_day_cannot_know(self) -> None:
        points = points_of_day("polar", JUNE, 10, noise_deg=0.02, sigma_deg=0.02)
        solution = fit_linear(points)
        that_day = np.array(solution.predict_sigma_deg(20.0, 90.0 - JUNE))
        half_a_year_on = np.array(solution.predict_sigma_deg(20.0, 90.0 - DECEMBER))
        assert that_day[1] < 0.02
        # 46.8 deg of declination away a scale known to 0.002 only is off by 0.09 deg.
        assert half_a_year_on[1] == pytest.approx(0.002 * (JUNE - DECEMBER), rel=0.05)
        assert solution.correlations["P4,P6"] > 0.99


class TestEquinoxTiltRoll:
    """Near the equinox the tilt of an east-west tilt-roll stands still."""

    def test_tilt_zero_and_tilt_scale_are_named(self) -> None:
        solution = fit_linear(points_of_day("tiltroll-ew", EQUINOX, 10, noise_deg=0.03))
        assert solution.rank == 6
        assert abs(solution.correlations["P2,P5"]) > 0.99
        (sentence,) = [s for s in solution.inseparable if "P2" in s]
        assert sentence.startswith(
            "tilt zero (P2) and tilt scale (P5) can hardly be separated with these points (r = "
        )
        assert "1.0" not in sentence

    def test_june_day_has_nothing_to_name(self) -> None:
        assert fit_linear(points_of_day("tiltroll-ew", JUNE, 10, noise_deg=0.03)).inseparable == ()


def test_a_term_without_effect_is_named_not_made_up() -> None:
    # At AX2 = 90 deg exactly, 1/tan(AX2) is 6e-17: a column of rounding, not a measurement.
    geometry = MountGeometry("polar", 35.0)
    ax1 = np.linspace(-60.0, 60.0, 8)
    noise = 0.02 * np.random.default_rng(2).standard_normal((2, 8))
    points = Points(
        geometry=geometry,
        ax1_deg=ax1,
        ax2_deg=np.full(8, 90.0),
        err1_deg=0.1 + noise[0],
        err2_deg=noise[1],
    )
    solution = fit_linear(points, ("P2", "N"))
    assert solution.rank == 1
    assert solution.values[1] == 0.0
    assert solution.inseparable == ("these points say nothing about axes not square (N)",)
    assert solution.sigmas is not None
    assert solution.sigmas[1] == pytest.approx(TERMS["N"].prior_sigma)


def test_a_term_under_two_names_is_found_out() -> None:
    points = points_of_day("azel", JUNE, 10, noise_deg=0.03)
    solution = fit_linear(points, ("P1", "P2", "P3", "P4", "AN"))
    assert solution.rank == 4
    assert solution.inseparable == (
        "north lean (P1) and north-south lean (AN) cannot be separated with these points: "
        "only one combination of them is fixed",
    )


def test_all_points_at_one_place_fix_two_numbers() -> None:
    day = points_of_day("azel", JUNE, 10, noise_deg=0.03)
    here = Points(
        geometry=day.geometry,
        ax1_deg=np.full(5, 30.0),
        ax2_deg=np.full(5, 40.0),
        err1_deg=np.array([0.1, 0.12, 0.09, 0.11, 0.1]),
        err2_deg=np.array([0.2, 0.21, 0.19, 0.2, 0.22]),
    )
    solution = fit_linear(here)
    assert solution.rank == 2
    (sentence,) = solution.inseparable
    assert "only 2 combinations of them are fixed" in sentence


@pytest.mark.parametrize(
    ("r", "shown"),
    [
        (0.5, "+0.50"),
        (-0.994, "-0.99"),
        (0.9961, "+0.9961"),
        (-0.9999996, "-0.9999"),
        (0.99999, "+0.9999"),
    ],
)
def test_no_correlation_of_measured_points_reads_as_a_perfect_one(r: float, shown: str) -> None:
    assert correlation_text(r) == shown
