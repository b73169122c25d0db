"""Stop, go on, give up for today, or look what is the matter."""

import json
import re

import numpy as np
import pytest
from made_up_trackers import JUNE, TRACKER, day_of, judge
from scipy.spatial.transform import Rotation

from solarcal.errors import ConfigurationError
from solarcal.model.analysis import analyse
from solarcal.model.cross_checks import (
    _order_probability,
    _spectrum,
    _spectrum_of_many,
    chance_above_zero,
    cross_check,
    order_limit,
)
from solarcal.model.finding import Finding
from solarcal.model.forecast import forecast
from solarcal.model.mechanism_solution import MechanismSolution, base_tilt, shim_heights, wind
from solarcal.model.methods import fit, fit_exact
from solarcal.model.planner import plan
from solarcal.model.points import Points
from solarcal.model.verdict import Verdict, assess, conclude
from solarcal.model.year_grid import year_grid
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.site import BoltCircle
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule, Unmodelled


def verdict_of(points: Points, context, **options) -> Verdict:
    solution = fit_exact(points, context)
    return judge(solution, forecast(solution), **options)


def mean_mechanism(solution: MechanismSolution) -> Mechanism:
    return Mechanism(*solution.posterior.mean.tolist())


class TestStates:
    def test_a_good_day_is_enough(self):
        context, points = day_of("azel", 14, noise_deg=0.02)
        verdict = verdict_of(points, context)
        assert verdict.state == "done"
        assert "95 %" in verdict.reasons[0]
        assert any("no trend in the residuals (p = " in reason for reason in verdict.reasons)

    def test_three_points_are_not(self):
        context, points = day_of("azel", 14)
        verdict = verdict_of(points.subset([0, 7, 13]), context)
        assert verdict.state == "continue"

    def test_nor_is_a_loose_tolerance_a_reason_to_stop_at_two(self):
        context, points = day_of("azel", 14)
        solution = fit_exact(points.subset([0, 13]), context)
        verdict = judge(solution, forecast(solution, rule=StoppingRule(20.0)))
        assert verdict.state == "continue"
        assert "only 2 points" in verdict.reasons[0]

    def test_four_points_can_contradict_each_other_three_cannot(self):
        context, points = day_of("azel", 14, noise_deg=0.01)
        for chosen, state in (([0, 6, 13], "continue"), ([0, 4, 9, 13], "done")):
            solution = fit_exact(points.subset(chosen), context)
            verdict = judge(solution, forecast(solution, rule=StoppingRule(5.0)))
            assert verdict.state == state
            too_few = any("at least 4 points are needed" in reason for reason in verdict.reasons)
            assert too_few == (state == "continue")

    def test_hopeless_is_what_the_plan_says(self):
        context, points = day_of("tiltroll-ew", 6, day=1)
        solution = fit_exact(points, context)
        expected = forecast(solution)
        day = plan(solution.posterior, context, float(points.utc_s[-1]))
        assert day.hopeless
        verdict = judge(solution, expected, planned=day)
        assert verdict.state == "not_today"
        assert verdict.reasons[0] == day.sentence
        assert judge(solution, expected).state == "continue"
        # Another day is of no use as long as points that are doubted stay among these.
        wrong = Finding(
            kind="answers", subject="points", sentence="points 5 and 6 read otherwise",
            direct=True, labels=(5, 6),
        )  # fmt: skip
        misread = assess(solution, expected, evidence=[wrong])
        assert any(wrong.sentence in r for r in conclude(misread, expected, day).reasons)

    def test_done_needs_the_probability_that_is_asked_for(self):
        context, points = day_of("azel", 9, JUNE)
        solution = fit_exact(points, context)
        p = forecast(solution, rule=StoppingRule(0.05)).probability_within_tolerance
        assert 0.5 < p < 0.99
        for asked, state in ((p - 0.005, "done"), (p + 0.005, "continue")):
            expected = forecast(solution, rule=StoppingRule(0.05, asked))
            assert judge(solution, expected).state == state
            assert expected.sure_words.endswith(f" % sure ({100.0 * asked:g} % needed)")

    def test_a_spot_nobody_could_read(self):
        context, points = day_of("azel", 12, noise_deg=0.4)
        verdict = verdict_of(points, context)
        assert verdict.state == "does_not_fit"
        assert "scatter by 0." in verdict.reasons[0]

    def test_sigmas_that_promise_too_much(self):
        context, points = day_of("azel", 20, noise_deg=0.1)
        proud = Points(
            geometry=points.geometry,
            ax1_deg=points.ax1_deg,
            ax2_deg=points.ax2_deg,
            err1_deg=points.err1_deg,
            err2_deg=points.err2_deg,
            sigma_deg=np.full(20, 0.01),
        )
        verdict = verdict_of(proud, context)
        assert verdict.state == "does_not_fit"
        assert "times as much as their sigmas say" in verdict.reasons[0]

    @pytest.mark.parametrize("size", [2.0, 50.0])
    def test_sigmas_that_are_a_thousand_times_too_large(self, size):
        context, points = day_of("azel", 13, noise_deg=0.02)
        verdict = verdict_of(points.replace(sigma_deg=np.full(13, size)), context)
        (said,) = [one for one in verdict.reasons if "correct sigma_deg" in one]
        of = r"the points' sigmas \(([0-9.]+) deg\) are ([0-9]+) times .* scatter \(([0-9.]+) deg\)"
        sigma, times, scatter = map(float, re.search(of, said).groups())
        assert sigma == size
        assert times == pytest.approx(size / scatter, rel=0.05)
        assert not any("the model lacks an effect" in one for one in verdict.reasons)
        honest = verdict_of(points.replace(sigma_deg=np.full(13, 0.1)), context)
        assert not any("correct sigma_deg" in one for one in honest.reasons)

    def test_sigmas_that_are_far_too_small_may_be_why_no_point_fits(self):
        context, points = day_of("azel", 13, noise_deg=0.02)
        verdict = verdict_of(points.replace(sigma_deg=np.full(13, 1e-5)), context)
        assert "or sigmas that are too small" in verdict.reasons[0]

    def test_residuals_that_follow_each_other(self):
        drooping = Mechanism(TRACKER.P1, nonperpendicularity_deg=1.5, collimation_deg=-1.0)
        context, points = day_of("azel", 14, JUNE, mechanism=drooping, noise_deg=0.01)
        verdict = verdict_of(points, context)
        assert verdict.state == "does_not_fit"
        assert any("trend in the residuals" in reason for reason in verdict.reasons)

    def test_points_without_noise_are_no_misfit(self):
        for geometry in ("azel", "tiltroll-ew", "tiltroll-ns", "polar"):
            context, points = day_of(geometry, 14, JUNE, noise_deg=0.0)
            for n in (6, 8, 11, 14):
                assert verdict_of(points.subset(list(range(n))), context).state != "does_not_fit"

    def test_every_reason_carries_its_number(self):
        context, points = day_of("azel", 14)
        for n in (1, 2, 5, 9, 14):
            for reason in verdict_of(points.subset(list(range(n))), context).reasons:
                assert any(character.isdigit() for character in reason)

    def test_manual_fits_are_judged_by_their_forecast(self):
        context, points = day_of("azel", 14, noise_deg=0.01)
        solution = fit(points, context, method="linear")
        verdict = judge(solution, forecast(solution, context))
        assert verdict.state == "done"
        assert json.loads(json.dumps(verdict.as_json()))["state"] == "done"


class TestLean:
    def test_shim_first(self):
        context, points = day_of("azel", 14, mechanism=Mechanism(P1=0.0, P3=5.0))
        verdict = verdict_of(points, context, bolt_circle=BoltCircle(400.0, 4))
        assert verdict.state == "does_not_fit"
        assert verdict.reasons[0].startswith("the controller's formula cannot hold 0.1 deg")
        assert "shim first" in verdict.reasons[0]
        highest = max(verdict.shims, key=lambda shim: shim.height_mm)
        assert highest.bolt_bearing_deg == 90.0
        assert highest.height_mm == pytest.approx(400.0 * np.sin(np.radians(5.0)), abs=0.5)
        assert any(reason.startswith("shims:") for reason in verdict.reasons)

    def test_two_degrees_need_no_shim(self):
        context, points = day_of("azel", 14, mechanism=Mechanism(P1=2.0))
        assert verdict_of(points, context).state == "done"


class TestShims:
    def test_the_side_the_top_leans_to_is_lifted(self):
        shims = shim_heights(2.0, 90.0, BoltCircle(500.0, 4))
        heights = {shim.bolt_bearing_deg: shim.height_mm for shim in shims}
        assert heights[270.0] == 0.0
        assert heights[90.0] == pytest.approx(500.0 * np.sin(np.radians(2.0)))
        assert heights[0.0] == pytest.approx(heights[90.0] / 2)

    @pytest.mark.parametrize("bolts", [3, 4, 6, 8])
    def test_shimmed_bolts_lie_in_a_level_plane(self, bolts):
        shims = shim_heights(3.0, 37.0, BoltCircle(600.0, bolts, 10.0))
        bearing = np.radians([s.bolt_bearing_deg for s in shims])
        east, north = 300.0 * np.sin(bearing), 300.0 * np.cos(bearing)
        towards = np.radians(37.0)
        slope = np.sin(np.radians(3.0))
        sunk = -slope * (east * np.sin(towards) + north * np.cos(towards))
        level = sunk + np.array([s.height_mm for s in shims])
        assert np.ptp(level) < 1e-9
        assert min(s.height_mm for s in shims) == 0.0

    @pytest.mark.parametrize("geometry", ["azel", "tiltroll-ns"])
    @pytest.mark.parametrize("bolts", [3, 5])
    def test_a_plate_rotated_as_fitted_is_level_on_its_shims(self, geometry, bolts):
        """Independent of the heights: the plate turned by the mechanism's rotation, and a plane
        fitted through its shimmed bolts."""
        mount = MountGeometry(geometry, 35.0)
        values = np.array([0.9, 0.0, -0.6, 0.0, 0.0, 0.0])
        turn = Rotation.from_rotvec(
            np.radians(mount.basis().T @ np.array([-values[2], -values[0], 0.0]))
        )
        base = base_tilt(values, mount)
        shims = shim_heights(base.tilt_deg, base.bearing_deg, BoltCircle(400.0, bolts, 20.0))
        bearing = np.radians([shim.bolt_bearing_deg for shim in shims])
        flat = 200.0 * np.column_stack((np.sin(bearing), np.cos(bearing), np.zeros(bolts)))
        plate = turn.apply(flat)
        shimmed = plate + np.outer([shim.height_mm for shim in shims], (0.0, 0.0, 1.0))

        def slope_deg(corners):
            plane = np.column_stack((corners[:, :2], np.ones(len(corners))))
            east, north, _ = np.linalg.lstsq(plane, corners[:, 2], rcond=None)[0]
            return float(np.degrees(np.hypot(east, north)))

        assert slope_deg(plate) == pytest.approx(base.tilt_deg, rel=1e-3)
        # What is left is of second order; the wrong sign would double the slope.
        assert slope_deg(shimmed) < 0.02 * base.tilt_deg

    def test_shims_are_given_for_a_lean_that_needs_none_too(self):
        context, points = day_of("azel", 12)
        plain = verdict_of(points, context)
        verdict = verdict_of(points, context, bolt_circle=BoltCircle(400.0, 4, 45.0))
        assert (plain.state, plain.reasons, plain.shims) == (verdict.state, verdict.reasons, ())
        assert [shim.bolt_bearing_deg for shim in verdict.shims] == [45.0, 135.0, 225.0, 315.0]
        assert verdict.as_json()["base"]["tilt_deg"] == pytest.approx(np.hypot(0.7, 0.3), abs=0.05)
        assert "shims" not in plain.as_json()

    def test_a_plate_has_three_bolts_at_least(self):
        with pytest.raises(ConfigurationError, match="number of bolts: 2 is not between 3 and 72"):
            BoltCircle(500.0, 2)
        with pytest.raises(ConfigurationError, match="diameter"):
            BoltCircle(0.0, 4)

    def test_winds(self):
        assert [wind(b) for b in (0.0, 22.5, 90.0, 225.0, 359.0)] == ["N", "NNE", "E", "SW", "N"]


class TestBase:
    def test_azel_leans_as_its_parameters_say(self):
        tilt = base_tilt(np.array([1.0, 0, 1.0, 0, 0, 0]), MountGeometry("azel", 35.0))
        assert tilt.tilt_deg == pytest.approx(np.sqrt(2.0))
        assert tilt.bearing_deg == pytest.approx(45.0)
        for north, east, bearing in ((-1.0, 1.0, 135.0), (-1.0, -1.0, 225.0), (1.0, -1.0, 315.0)):
            tilt = base_tilt(np.array([north, 0, east, 0, 0, 0]), MountGeometry("azel", 35.0))
            assert tilt.bearing_deg == pytest.approx(bearing)
        assert tilt.turn_deg == pytest.approx(0.0)

    def test_an_east_west_roller_sags_at_its_east_end_or_is_turned(self):
        """P1: east end down; P3: east end to the south, clockwise from above."""
        geometry = MountGeometry("tiltroll-ew", 35.0)
        down = base_tilt(np.array([1.0, 0, 0, 0, 0, 0]), geometry)
        assert (down.tilt_deg, down.bearing_deg) == pytest.approx((1.0, 90.0))
        turned = base_tilt(np.array([0, 0, 1.0, 0, 0, 0]), geometry)
        assert turned.tilt_deg == pytest.approx(0.0, abs=1e-12)
        assert turned.turn_deg == pytest.approx(-1.0)


class TestCrossChecks:
    def test_a_whole_day_of_clean_points_is_rarely_called_out_of_order(self):
        """One day in a hundred, judged after every point: at most one of 40 then. One day in ten
        would give more than one with a probability of 0.92."""
        alarms = 0
        for seed in range(40):
            context, points = day_of("azel", 14, JUNE, seed=seed)
            alarms += any(
                checks.order_probability < checks.order_limit
                for n in range(7, 15)
                for checks in [cross_check(fit_exact(points.subset(list(range(n))), context))]
            )
        assert alarms <= 1

    def test_the_limits_of_all_looks_add_up_to_one_percent(self):
        assert sum(order_limit(n) for n in range(7, 2000)) == pytest.approx(0.01, rel=0.01)

    def test_the_chance_of_a_sum_is_that_of_many_draws(self):
        rng = np.random.default_rng(3)
        for size in (6, 12, 24):
            weights = rng.standard_normal(size) - 0.4
            draws = rng.standard_normal((200_000, size)) ** 2 @ weights
            assert chance_above_zero(weights) == pytest.approx(np.mean(draws > 0.0), abs=0.015)

    def test_what_is_of_one_sign_is_certain(self):
        for weights, chance in (([1.0, 2.0], 1.0), ([-1.0, -2.0], 0.0), ([0.0, 0.0], 0.0)):
            assert chance_above_zero(np.array(weights)) == chance

    def test_the_saddle_point_goes_through_even_weights(self):
        """2 a^2 > b^2 + c^2, whose right side is exponential: 1 - 1/sqrt(3) of all cases."""
        for weights in ([2.0, -1.0, -1.0], [2.0, -1.0 + 1e-9, -1.0], [2.0, -1.002, -1.0]):
            found = chance_above_zero(np.array(weights))
            assert found == pytest.approx(1.0 - 1.0 / np.sqrt(3.0), abs=0.003)

    def test_leaving_out_by_algebra_is_leaving_out_in_deed(self):
        context, points = day_of("azel", 9, noise_deg=0.03)
        checks = cross_check(fit_exact(points, context))
        for index in (0, 4, 8):
            others = points.subset([i for i in range(9) if i != index])
            solution = fit_exact(others, context)
            e1, e2 = mean_mechanism(solution).errors_deg(
                points.geometry, points.ax1_deg[index], points.ax2_deg[index]
            )
            missed = np.hypot(
                (points.err1_deg[index] - e1) * np.sin(np.radians(points.ax2_deg[index])),
                points.err2_deg[index] - e2,
            )
            assert checks.left_out_deg[index] == pytest.approx(missed, rel=0.25, abs=0.004)

    def test_the_last_two_points_are_those_whose_absence_is_looked_at(self):
        context, points = day_of("azel", 9, noise_deg=0.03, seed=6)
        solution = fit_exact(points, context)

        def moved_deg(without: int) -> float:
            fewer = fit_exact(points.subset(list(range(9 - without))), context)
            grid = year_grid(context)
            seen = grid.sun.true1_deg, grid.sun.true2_deg
            with_all = mean_mechanism(solution).errors_deg(context.geometry, *seen)
            with_fewer = mean_mechanism(fewer).errors_deg(context.geometry, *seen)
            cross = (with_all[0] - with_fewer[0]) * np.sin(np.radians(seen[1]))
            return float(np.sqrt(np.mean(cross**2 + (with_all[1] - with_fewer[1]) ** 2)))

        one, two, three = (moved_deg(without) for without in (1, 2, 3))
        assert cross_check(solution).last_moved_deg == pytest.approx(two, rel=0.2)
        assert abs(one / two - 1.0) > 0.3
        assert abs(three / two - 1.0) > 0.3

    def test_nothing_before_the_last_two_is_nothing_to_compare(self):
        context, points = day_of("azel", 9)
        two = cross_check(fit_exact(points.subset([0, 8]), context))
        three = cross_check(fit_exact(points.subset([0, 4, 8]), context))
        assert two.last_moved_deg is None
        assert three.last_moved_deg is not None

    def test_noise_looks_random(self):
        low = 0
        for seed in range(60):
            context, points = day_of("azel", 10, seed=seed)
            probability = cross_check(fit_exact(points, context)).order_probability
            low += probability < 0.1
        assert 1 <= low <= 13

    def test_one_point_says_nothing_about_itself(self):
        context, points = day_of("azel", 1)
        checks = cross_check(fit_exact(points, context))
        assert checks.left_out_rms_deg is None
        assert checks.last_moved_deg is None
        assert checks.order_probability is None


@pytest.mark.parametrize("n", [40, 100])
def test_the_spectrum_of_many_points_gives_the_probability_of_all_eigenvalues(n):
    random = np.random.default_rng(n)
    angle = np.linspace(-1.5, 1.5, n)
    one, zero = np.ones(n), np.zeros(n)
    first = np.column_stack((one, zero, np.sin(angle), np.cos(angle), angle, zero))
    second = np.column_stack((zero, one, np.cos(angle), -np.sin(angle), zero, angle**2))
    design = np.stack((first, second), axis=1).reshape(2 * n, 6) / 0.03
    covariance = np.linalg.inv(design.T @ design + np.eye(6))
    for seen in random.uniform(-0.3, 0.3, 8):
        exact = chance_above_zero(_spectrum(design, covariance, seen))
        assert chance_above_zero(_spectrum_of_many(design, covariance, seen)) == pytest.approx(
            exact, rel=0.1, abs=1e-4
        )


def test_points_without_any_residual_have_no_order():
    rows, zero = np.random.default_rng(1).standard_normal((8, 2, 6)), np.zeros((8, 2))
    used = np.arange(8)
    nothing = _order_probability(rows, np.ones(8), np.eye(6), zero, used)
    assert nothing is None
    slight = 1e-3 * np.random.default_rng(2).standard_normal((8, 2))
    # Their scale does not matter: only which follows which.
    small, large = (
        _order_probability(rows, np.ones(8), np.eye(6), scale * slight, used)
        for scale in (1.0, 1.0 / np.sqrt(np.sum(slight**2)))
    )
    assert small is not None
    assert small == pytest.approx(large)


class TestScatter:
    """What the points scatter by beyond how well a spot is read may be the tracker's own."""

    @staticmethod
    def periodic(sigma_deg=None, rule=DEFAULT_RULE):
        context, points = day_of("azel", 40)
        error = 0.15 * np.sin(2.0 * np.pi * points.ax1_deg / 7.3)
        seen = Points(
            geometry=points.geometry,
            ax1_deg=points.ax1_deg,
            ax2_deg=points.ax2_deg,
            err1_deg=points.err1_deg + error,
            err2_deg=points.err2_deg + 0.15 * np.sin(2.0 * np.pi * points.ax2_deg / 7.3),
            utc_s=points.utc_s,
            sigma_deg=sigma_deg,
        )
        solution = fit_exact(seen, context)
        return judge(solution, forecast(solution, rule=rule))

    def test_an_error_of_the_wheel_is_not_averaged_away(self):
        verdict = self.periodic()
        assert verdict.state == "continue"
        assert "if the rest is the tracker's own, 95 % of its pointing" in verdict.reasons[0]
        # More points alone average nothing away, and readings of 0.04 deg leave most of it.
        assert "a spot is read to 0.04 deg" in self.periodic(np.full(40, 0.04)).reasons[0]
        assert verdict.first == "first settle what the verdict names"

    def test_readings_that_say_how_good_they_are_are_believed(self):
        coarse = StoppingRule(unmodelled=Unmodelled(spot_deg=0.1))
        for verdict in (self.periodic(np.full(40, 0.1)), self.periodic(rule=coarse)):
            assert not any("tracker's own" in reason for reason in verdict.reasons)


class TestGears:
    @pytest.mark.parametrize(
        ("geometry", "wrong", "said"),
        [
            ("azel", {"P5": 0.045}, "P5 = +0.045"),
            ("azel", {"P6": -0.03}, "P6 = -0.03"),
            ("tiltroll-ew", {"P5": 0.02}, "P5 = +0.02"),
        ],
    )
    def test_a_wrong_gear_ratio_is_named(self, geometry, wrong, said):
        mechanism = Mechanism(**({"P1": 0.2, "P2": -0.3, "P3": 0.1, "P4": 0.4} | wrong))
        context, points = day_of(geometry, 12, mechanism=mechanism)
        verdict = verdict_of(points, context)
        assert verdict.state == "does_not_fit"
        assert verdict.reasons[0].startswith(said)
        # The read-out is (1 - P) of the ideal angle: the axis turns by P more than it reads.
        way = "more" if "+" in said else "less"
        percent, way_said = re.search(r"turns (\S+) % (\w+) than", verdict.reasons[0]).groups()
        fitted = float(verdict.reasons[0].split()[2])
        assert (float(percent), way_said) == (pytest.approx(100.0 * abs(fitted), abs=0.06), way)

    def test_what_a_polar_day_does_not_show_is_said(self):
        """Declination stands still: P6 is known beforehand alone, and December needs it."""
        mechanism = Mechanism(0.05, 0.1, -0.04, -0.1, 0.0002, -0.0003)
        context, points = day_of("polar", 20, mechanism=mechanism, noise_deg=0.01)
        verdict = verdict_of(points, context)
        assert verdict.state == "done"
        (said,) = (reason for reason in verdict.reasons if "do not show P6" in reason)
        # 0.004 on the 46.9 deg from one solstice to the other: 0.188 deg.
        assert "95 % of the year would be within 0.1" in said

    def test_what_a_day_shows_is_not_doubted(self):
        context, points = day_of("azel", 14, noise_deg=0.02)
        assert not any("do not show" in reason for reason in verdict_of(points, context).reasons)


def test_a_plan_for_points_that_do_not_fit_ends_nowhere():
    wrong = Mechanism(0.2, -0.3, 0.1, 0.4, 0.03, 0.0)
    for mechanism, fits in ((TRACKER, True), (wrong, False)):
        context, points = day_of("azel", 14, mechanism=mechanism)
        taken = points.subset(range(7))
        day = analyse(taken, context, at_utc_s=float(taken.utc_s[-1])).plan
        assert day.stops
        assert day.sentence.startswith("first find why the points do not fit") != fits
        assert any(map(day.reached_by, day.stops)) == fits
