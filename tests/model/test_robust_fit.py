"""The exact mechanism from few, noisy and sometimes wrong points."""

import numpy as np
import pytest
from made_up_trackers import JUNE, MARCH, TRACKER, context_of, day_of, true_year

from solarcal.errors import ConfigurationError, FitError
from solarcal.model import noise_mixture
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_PRIOR, fit, fit_exact
from solarcal.model.mixture_climb import Linearised
from solarcal.model.noise_mixture import solve_mixtures
from solarcal.model.points import Points
from solarcal.model.prior import PLAIN, Prior, sigmas_of
from solarcal.model.terms import CONTROLLER_TERMS, TERMS
from solarcal.model.year_grid import controller_coefficients
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import GEOMETRIES
from solarcal.mount.mechanism import Mechanism

VALUES = (TRACKER.P1, TRACKER.P2, TRACKER.P3, TRACKER.P4, TRACKER.P5, TRACKER.P6)


def with_errors(points: Points, err1: np.ndarray, err2: np.ndarray, **changed) -> Points:
    kept = {"geometry": points.geometry, "ax1_deg": points.ax1_deg, "ax2_deg": points.ax2_deg}
    kept |= {"labels": points.labels, "utc_s": points.utc_s}
    return Points(err1_deg=err1, err2_deg=err2, **(kept | changed))


class TestClosure:
    @pytest.mark.parametrize("geometry", ["azel", "tiltroll-ns"])
    @pytest.mark.parametrize("lean_deg", [0.0, 2.0, 8.0])
    def test_points_without_noise_give_the_mechanism_back(self, geometry, lean_deg):
        mechanism = Mechanism(lean_deg, 0.3, -0.5 * lean_deg, -0.7, 0.001, -0.0007)
        context, points = day_of(geometry, 24, mechanism=mechanism, noise_deg=0.0)
        solution = fit_exact(points, context, use_prior=False)
        found = solution.posterior.mean
        assert found[[0, 2]] == pytest.approx([lean_deg, -0.5 * lean_deg], abs=2e-3)
        assert solution.sky_max_deg < 1e-3

    @pytest.mark.parametrize("geometry", GEOMETRIES)
    def test_known_physics_is_not_taken_for_the_mount(self, geometry):
        """Refraction and the controller's own Sun leave the mechanism alone."""
        _, apparent = day_of(geometry, 12, noise_deg=0.0)
        plain = fit_exact(apparent, context_of(geometry))
        for ideal in ("airless", "solartrak"):
            context, points = day_of(geometry, 12, noise_deg=0.0, ideal=ideal)
            told = fit_exact(points, context)
            untold = fit_exact(points, context_of(geometry))
            step = np.abs(told.posterior.mean - plain.posterior.mean)
            assert step[:4].max() < 2e-3
            assert np.abs(untold.posterior.mean - plain.posterior.mean)[:4].max() > 4 * step.max()

    def test_the_uploaded_numbers_make_up_for_missing_refraction(self):
        context, points = day_of("azel", 12, noise_deg=0.0, ideal="airless")
        solution = fit_exact(points, context)
        left = true_year(context, TRACKER, solution.coefficients()).rms_deg
        untouched = true_year(context, TRACKER, Coefficients(*VALUES)).rms_deg
        assert left < 0.4 * untouched


class TestFewPoints:
    @pytest.mark.parametrize("geometry", GEOMETRIES)
    @pytest.mark.parametrize("method", ["robust", "exact"])
    def test_answers_from_one_point_on(self, geometry, method):
        for n in (1, 2, 3):
            context, points = day_of(geometry, n)
            solution = fit(points, context, method=method)
            assert np.isfinite(solution.values).all()
            assert (solution.sigmas > 0.0).all()
            assert solution.rank <= 2 * n

    @pytest.mark.parametrize(
        ("method", "n", "fixed"), [("robust", 1, 2), ("robust", 2, 4), ("exact", 2, 4)]
    )
    def test_what_the_points_leave_open_is_said_with_where_it_comes_from(self, method, n, fixed):
        """Each point fixes two numbers; the rest comes from the prior, where there is one."""
        context, points = day_of("azel", n)
        (note,) = fit(points, context, method=method).notes
        assert f"fix {fixed} of the 6 numbers" in note
        assert ("usual errors of towers, zeros and gears" in note) == (method == "robust")
        assert ("smallest values were taken" in note) == (method == "exact")

    def test_points_that_fix_all_six_numbers_need_no_note(self):
        context, points = day_of("azel", 12)
        assert not [note for note in fit(points, context).notes if "of the 6 numbers" in note]

    def test_before_the_first_point_a_mount_is_known_as_well_as_the_page_says(self):
        assert DEFAULT_PRIOR.sigmas == (2.0, 5.0, 2.0, 5.0, 0.002, 0.002)

    def test_one_point_leaves_the_prior_where_it_says_nothing(self):
        context, points = day_of("azel", 1)
        solution = fit_exact(points, context, prior=Prior(widths=PLAIN))
        sigmas = np.sqrt(np.diag(solution.posterior.covariance))
        assert sigmas[4] == pytest.approx(0.002, rel=0.02)
        assert solution.sky_rms_deg < 0.01

    def test_no_point_is_refused(self):
        context, points = day_of("azel", 3)
        with pytest.raises(FitError, match="no points"):
            fit(points.subset([]), context)

    def test_points_in_the_haze_are_left_out_and_named(self):
        context, points = day_of("azel", 6)
        low = Points(
            geometry=points.geometry,
            ax1_deg=np.append(points.ax1_deg, 100.0),
            ax2_deg=np.append(points.ax2_deg, 87.0),
            err1_deg=np.append(points.err1_deg, 3.0),
            err2_deg=np.append(points.err2_deg, 3.0),
        )
        solution = fit(low, context)
        assert solution.n_points == 6
        assert "point 7" in solution.notes[0]
        assert solution.values == pytest.approx(fit(points, context).values, abs=1e-12)


def plain_prior(lean_deg: float, offset_deg: float, scale: float) -> Prior:
    return Prior(sigmas=sigmas_of(lean_deg, offset_deg, scale), widths=PLAIN)


class TestPrior:
    @pytest.mark.parametrize("sigma", [0.0, -2.0, np.nan, np.inf])
    def test_a_sigma_is_a_number_above_zero(self, sigma):
        with pytest.raises(ConfigurationError, match="prior sigma of P3"):
            Prior(sigmas=(2.0, 5.0, sigma, 5.0, 0.002, 0.002))

    def test_it_knows_of_no_direction_beforehand(self):
        assert Prior().means == (0.0,) * 6
        assert Prior().sigmas == (2.0, 5.0, 2.0, 5.0, 0.002, 0.002)

    def test_an_inclinometer_pins_the_lean(self):
        context, points = day_of("azel", 2)
        prior = Prior().with_inclinometer(0.7, 0.3, 0.02)
        lean = fit_exact(points, context, prior=prior).mechanism
        assert lean.lean_deg == pytest.approx(np.hypot(0.7, 0.3), abs=0.06)
        assert lean.lean_sigma_deg < 0.03
        assert fit_exact(points, context).mechanism.lean_sigma_deg > 0.1

    def test_the_last_coefficients_are_where_a_second_visit_starts(self):
        context, points = day_of("tiltroll-ew", 1, MARCH)
        informed = fit_exact(
            points, context, prior=Prior.of_last_coefficients(Coefficients(*VALUES))
        )
        blank = fit_exact(points, context)
        better = true_year(context, TRACKER, informed.coefficients()).rms_deg
        assert better < 0.3 * true_year(context, TRACKER, blank.coefficients()).rms_deg

    def test_many_points_overrule_any_prior(self):
        context, points = day_of("azel", 60, noise_deg=0.01)
        narrow = fit_exact(points, context, prior=plain_prior(1.0, 3.0, 0.002))
        wide = fit_exact(points, context, prior=plain_prior(8.0, 20.0, 0.02))
        assert narrow.values == pytest.approx(wide.values, abs=2e-3)

    @pytest.mark.parametrize(
        "wrong",
        [
            {"sigmas": (2.0, 5.0, 2.0, 5.0, 0.0, 0.002)},
            {"means": (float("nan"), 0.0, 0.0, 0.0, 0.0, 0.0)},
            {"widths": ((1.0, 0.5),)},
        ],
    )
    def test_a_prior_that_cannot_be_is_refused(self, wrong):
        with pytest.raises(ConfigurationError, match="prior"):
            Prior(**wrong)


class TestBlunders:
    def test_two_bad_points_of_twelve_are_named_and_harmless(self):
        for geometry in ("azel", "tiltroll-ew"):
            for seed in range(6):
                context, points = day_of(geometry, 12, seed=seed)
                err1, err2 = points.err1_deg.copy(), points.err2_deg.copy()
                i, j = np.random.default_rng(seed).choice(12, 2, replace=False)
                err2[i] += 0.5
                err1[j] -= 0.5 / np.sin(np.radians(points.ax2_deg[j]))
                spoiled = fit_exact(with_errors(points, err1, err2), context)
                assert set(spoiled.outliers) == {points.labels[i], points.labels[j]}
                clean = true_year(context, TRACKER, fit(points, context).coefficients()).rms_deg
                left = true_year(context, TRACKER, spoiled.coefficients()).rms_deg
                assert left < max(1.5 * clean, 0.06)
                named = f"point {points.labels[i]} has a residual of"
                assert any(named in note for note in spoiled.notes)

    def test_a_point_that_either_kind_explains_as_well_is_a_blunder_in_two_of_a_hundred(self):
        """Where both densities are equal only what is known beforehand tells."""
        noise_deg, thrown_deg = 0.03, 0.7
        good, bad = noise_deg**2, noise_deg**2 + thrown_deg**2
        # Normal in two dimensions: exp(-d^2/2g)/g = exp(-d^2/2b)/b.
        equal_deg = np.sqrt(2.0 * np.log(bad / good) / (1.0 / good - 1.0 / bad))
        at = Linearised(
            residuals=np.array([[[equal_deg, 0.0, 0.0], [0.0, equal_deg, 0.0]]]),
            slopes=np.zeros((1, 2, 3, 6)),
            offset=np.zeros((1, 6)),
            widths=((1.0, 1.0),),
            sigma_deg=np.full((1, 3), noise_deg),
            log_scale_mean=np.zeros(1),
            log_scale_sd=np.full(1, 1e-6),
        )
        mixture = solve_mixtures(at)
        of_scale_one = int(np.argmin(np.abs(mixture.log_scales[0])))
        assert abs(mixture.log_scales[0, of_scale_one]) < 1e-9
        blunder = mixture.blunder[0, of_scale_one]
        assert blunder[:2] == pytest.approx([0.02, 0.02], rel=1e-3)
        assert blunder[2] < 1e-4

    def test_clean_days_name_nobody(self):
        named = 0
        for seed in range(40):
            context, points = day_of("azel", 8, seed=seed)
            named += bool(fit_exact(points, context).outliers)
        assert named <= 1


class TestNoise:
    @pytest.mark.parametrize("noise_deg", [0.01, 0.03, 0.1])
    def test_the_noise_is_found(self, noise_deg):
        context, points = day_of("azel", 40, noise_deg=noise_deg)
        assert fit_exact(points, context).noise_deg == pytest.approx(noise_deg, rel=0.25)

    def test_given_sigmas_weigh_the_points(self):
        context, points = day_of("azel", 10)
        err2 = points.err2_deg.copy()
        err2[4] += 0.3
        sigma = np.full(10, 0.03)
        sigma[4] = 1.0
        trusted = fit_exact(with_errors(points, points.err1_deg, err2, sigma_deg=sigma), context)
        assert trusted.outliers == ()
        assert trusted.values == pytest.approx(fit(points, context).values, abs=0.05)

    def test_the_order_of_the_points_does_not_matter(self):
        context, points = day_of("azel", 9)
        turned = points.subset([4, 2, 8, 0, 6, 1, 7, 3, 5])
        assert fit(turned, context).values == pytest.approx(fit(points, context).values, abs=1e-6)


class TestUploadedNumbers:
    @pytest.mark.parametrize("method", ["robust", "exact"])
    def test_their_covariance_is_that_of_the_numbers_themselves(self, method):
        """The six to upload follow from the mechanism; so does what is not known of them."""
        leaning = Mechanism(P1=3.0, P2=-0.5, P3=-2.0, P4=1.2, P5=0.001, P6=-0.0005)
        context, points = day_of("azel", 14, mechanism=leaning)
        solution = fit_exact(points, context, use_prior=method == "robust")
        mean, known = solution.posterior.mean, solution.posterior.covariance
        steps = 1e-4 * np.diag(solution.prior.sigma_array())
        jacobian = np.array(
            [
                controller_coefficients(mean + step, context, solution.prior)
                - controller_coefficients(mean - step, context, solution.prior)
                for step in steps
            ]
        ).T / (2.0 * np.diag(steps))
        there = jacobian @ known @ jacobian.T
        unit = np.sqrt(np.outer(np.diag(there), np.diag(there)))
        assert solution.covariance / unit == pytest.approx(there / unit, abs=1e-4)
        # Not that of the mechanism, from which the formula differs by the lean.
        assert np.abs((solution.covariance - known) / unit).max() > 0.01


class TestMechanism:
    @pytest.mark.parametrize("bearing_deg", [20.0, 110.0, 250.0])
    def test_lean_and_its_bearing(self, bearing_deg):
        lean = 3.0
        north, east = np.cos(np.radians(bearing_deg)), np.sin(np.radians(bearing_deg))
        context, points = day_of("azel", 12, mechanism=Mechanism(P1=lean * north, P3=lean * east))
        found = fit_exact(points, context).mechanism
        assert abs(found.lean_deg - lean) < 3.0 * found.lean_sigma_deg
        assert abs(found.lean_bearing_deg - bearing_deg) < 3.0 * found.lean_bearing_sigma_deg
        assert found.lean_sigma_deg < 0.1

    def test_the_document_has_the_contracts_keys(self):
        context, points = day_of("azel", 8)
        document = fit(points, context).as_json()
        assert document["method"] == "robust"
        assert set(document["coefficients"]) == {"P1", "P2", "P3", "P4", "P5", "P6"}
        keys = {"lean_deg", "lean_bearing_deg", "offsets_deg", "scales"}
        assert keys <= set(document["mechanism"])
        assert document["outliers"] == []

    def test_what_is_uploaded_beats_manual_on_a_tower_that_leans(self):
        for geometry in ("azel", "tiltroll-ew"):
            mechanism = Mechanism(3.5, 0.4, -3.5, 0.8, 0.001)
            context, points = day_of(geometry, 12, mechanism=mechanism, day=JUNE)
            errors = [
                true_year(context, mechanism, fit(points, context, method=m).coefficients()).rms_deg
                for m in ("robust", "linear")
            ]
            assert errors[0] < errors[1]


class TestFrontDoor:
    def test_robust_is_the_default(self):
        context, points = day_of()
        assert isinstance(fit(points, context), MechanismSolution)
        assert fit(points).method == "robust"

    def test_manual_is_what_it_was(self):
        context, points = day_of()
        manual = fit(points, context, method="linear", terms=("P1", "P2", "P3", "P4"))
        assert manual.method == "linear"
        assert manual.terms == ("P1", "P2", "P3", "P4")

    def test_wrong_questions_are_refused_in_one_line(self):
        context, points = day_of()
        with pytest.raises(FitError, match="unknown method"):
            fit(points, context, method="magic")
        with pytest.raises(FitError, match="use --method linear"):
            fit(points, context, terms=("P1", "P2"))

    def test_a_controllers_sun_needs_the_times(self):
        context, points = day_of(ideal="solartrak")
        undated = with_errors(points, points.err1_deg, points.err2_deg, utc_s=None)
        with pytest.raises(FitError, match="point 1 has no time"):
            fit(undated, context)


@pytest.mark.parametrize("method", ["linear", "robust", "exact"])
def test_a_point_given_three_times_counts_once(method):
    context, points = day_of("azel", 9)
    once, thrice = (
        fit(points.subset(order), context, method=method)
        for order in (list(range(9)), [*range(9), 3, 3])
    )
    assert thrice.n_points == 9
    assert thrice.values == pytest.approx(once.values)
    assert any("a measurement counts once" in note for note in thrice.notes)


def test_the_blunders_of_a_large_set_are_found_and_harmless():
    context, points = day_of("azel", 4000, noise_deg=0.02)
    err2 = points.err2_deg.copy()
    err2[::20] += 0.8
    solution = fit_exact(with_errors(points, points.err1_deg, err2), context)
    assert set(solution.outliers) == set(range(1, 4001, 20))
    clean = fit_exact(points, context).posterior.mean
    assert np.abs(solution.posterior.mean - clean)[:4].max() < 0.005
    assert solution.noise_deg == pytest.approx(0.02, rel=0.05)


def test_what_towers_zeros_and_gears_are_like():
    """One sigma: a lean of 2 deg a component, zeros of 5 deg, scales of 0.002."""
    assert Prior().sigmas == (2.0, 5.0, 2.0, 5.0, 0.002, 0.002)


@pytest.mark.parametrize(("sigma_deg", "expected_deg"), [(None, 0.03), (0.01, 0.01), (0.1, 0.1)])
def test_before_the_points_tell_the_noise_is_the_usual_or_the_given(sigma_deg, expected_deg):
    context, points = day_of("azel", 1)
    if sigma_deg is not None:
        points = points.replace(sigma_deg=np.full(1, sigma_deg))
    assert fit(points, context).noise_deg == pytest.approx(expected_deg, rel=0.2)


def test_scales_climbed_a_few_at_a_time_give_the_same_answer(monkeypatch):
    """As it is done with very many points."""
    context, points = day_of("azel", 12)
    together = fit(points, context).posterior
    monkeypatch.setattr(noise_mixture, "MOST_NUMBERS", 5 * 12)
    one_by_one = fit(points, context).posterior
    assert one_by_one.means == pytest.approx(together.means, rel=1e-9)
    assert one_by_one.weights == pytest.approx(together.weights, rel=1e-9)


def test_the_prior_is_what_towers_zeros_and_gears_are_like():
    """Lean 2 deg a component, zeros 5 deg, scales 0.002, one sigma: for the robust fit, and as the
    units in which a linear fit without enough points takes the smallest answer."""
    widths = (2.0, 5.0, 2.0, 5.0, 0.002, 0.002)
    assert Prior().sigmas == widths
    assert tuple(TERMS[name].prior_sigma for name in CONTROLLER_TERMS) == widths


def test_the_usual_prior_is_as_wide_as_the_documents_say():
    usual = Prior()
    assert usual.sigmas == (2.0, 5.0, 2.0, 5.0, 0.002, 0.002)
    assert usual.widths == ((1.0, 0.5), (0.4, 0.5))
