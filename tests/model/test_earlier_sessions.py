"""Earlier sessions of a unit: merged, unless something moved between them; or their last
coefficients as a prior, which saves points and gives way where it is wrong."""

import re

import msgspec
import numpy as np
import pytest
from made_up_trackers import TRACKER, day_of

from benchmarks.diagnosis import DECEMBER, JUNE, changed, merged
from benchmarks.judgement_trackers import (
    context_of,
    daylight_s,
    measured,
    random_mechanism,
    true_year,
)
from solarcal.errors import FitError
from solarcal.model.earlier_sessions import (
    _moved,
    last_prior,
    merge_sessions,
    weigh_inclinometer,
    weigh_last,
)
from solarcal.model.finding import Finding
from solarcal.model.forecast import forecast
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_PRIOR, fit_exact
from solarcal.model.points import Points
from solarcal.model.prior import PLAIN, SINCE_LAST, Prior
from solarcal.model.sky_context import SkyContext
from solarcal.model.year_grid import controller_coefficients, mechanism_of
from solarcal.mount.formula import Coefficients

SEEDS = 10


@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew"])
def test_changes_are_told_apart(geometry: str) -> None:
    def judged(**change: float) -> list[str]:
        return [merged(seed, geometry=geometry, **change).change for seed in range(SEEDS)]

    # Of the ten on azel two mistake noise for a move; the benchmark counts a hundred.
    assert judged().count("same") >= 8
    assert judged(lean_deg=0.3).count("tower") >= 9
    assert judged(zero_deg=0.3).count("zeros") >= 8


def test_the_shift_is_measured_within_its_sigma() -> None:
    result = merged(3, lean_deg=0.3, zero_deg=0.2)
    assert result.change == "tower"
    # Before less after.
    off = (result.shifts[0] - [-0.3, -0.2, 0.0, 0.0]) / result.shift_sigmas[0]
    assert np.abs(off).max() < 4.0
    (finding,) = result.findings
    assert finding.kind == "moved"
    assert finding.subject == "tower"
    assert "the tower moved" in finding.sentence
    assert finding.number == pytest.approx(0.3, abs=0.1)


def test_the_lean_that_changed_is_told_with_the_sign_of_each_component() -> None:
    context = context_of("azel")
    rng = np.random.default_rng([37, 3])
    after = random_mechanism(rng)
    before = msgspec.structs.replace(after, P1=after.P1 - 0.3, P3=after.P3 + 0.4)
    parts = [
        measured(context, mechanism, np.linspace(*daylight_s(context, day), n), rng)
        for mechanism, day, n in ((before, JUNE, 10), (after, JUNE + 30, 6))
    ]
    (finding,) = merge_sessions(parts, context).findings
    told = re.search(r"changed by (\S+) .* \(P1 (\S+), P3 (\S+)\)", finding.sentence)
    assert told is not None
    lean, north, east = (float(number) for number in told.groups())
    assert (lean, north, east) == pytest.approx((0.5, 0.3, -0.4), abs=0.15)


@pytest.mark.parametrize("seed", range(4))
def test_a_lean_read_after_the_tower_moved_is_held_against_the_last_session_alone(seed) -> None:
    """The points before it say what moved, whatever an inclinometer reads since."""
    context = context_of("azel")
    rng = np.random.default_rng([41, seed])
    after = random_mechanism(rng)
    before = msgspec.structs.replace(after, P1=after.P1 - 0.3, P3=after.P3 + 0.4)
    parts = [
        measured(context, mechanism, np.linspace(*daylight_s(context, day), 11), rng)
        for mechanism, day in ((before, JUNE), (after, JUNE + 30))
    ]
    read = DEFAULT_PRIOR.with_inclinometer(after.P1 + 0.01, after.P3 - 0.01, 0.02)
    with_it, without = (merge_sessions(parts, context, prior=one) for one in (read, DEFAULT_PRIOR))
    alone = fit_exact(parts[1], context, prior=read)
    assert with_it.change == "tower"
    assert with_it.shifts == pytest.approx(without.shifts, abs=0.06)
    posterior = with_it.solution.posterior
    off = posterior.mean[[0, 2]] - [after.P1, after.P3]
    assert np.abs(off).max() < 0.05
    assert (
        np.sqrt(np.diag(posterior.covariance))[:4].max()
        <= 1.05 * np.sqrt(np.diag(alone.posterior.covariance))[:4].max()
    )
    assert with_it.solution.noise_deg < 0.06


@pytest.mark.parametrize(
    ("north_deg", "east_deg", "sigma_deg"),
    [(0.3, 0.0, 0.01), (0.0, -0.3, 0.03), (0.3, 0.3, 0.0224)],
)
def test_the_sigma_of_a_move_is_that_of_its_own_direction(north_deg, east_deg, sigma_deg) -> None:
    shift, sigma = np.array([north_deg, 0.1, east_deg, 0.2]), np.array([0.01, 0.02, 0.03, 0.04])
    finding = _moved("tower", "a", "b", shift, sigma)
    assert finding.number == pytest.approx(np.hypot(north_deg, east_deg))
    assert finding.sigma == pytest.approx(sigma_deg, abs=1e-4)


def test_an_inclinometer_that_contradicts_the_points_is_off_by_so_many_sigmas() -> None:
    """The sigma is one direction's, of points and reading together."""
    context, points = day_of("azel", 14, noise_deg=0.01)
    read = DEFAULT_PRIOR.with_inclinometer(TRACKER.P1 + 0.6, TRACKER.P3 - 0.8, 0.1)
    prior, (finding,) = weigh_inclinometer(
        read, lambda prior: fit_exact(points, context, prior=prior)
    )
    assert prior == DEFAULT_PRIOR
    assert finding.number == pytest.approx(1.0, abs=0.05)
    assert finding.sigma == pytest.approx(0.1, abs=0.01)


def test_the_errors_of_an_earlier_session_are_predicted_as_it_was_then() -> None:
    context, rng = context_of("azel"), np.random.default_rng([37, 3])
    after = random_mechanism(rng)
    before = msgspec.structs.replace(after, P1=after.P1 - 0.3, P3=after.P3 + 0.4)
    parts = [
        measured(context, mechanism, np.linspace(*daylight_s(context, day), 12), rng)
        for mechanism, day in ((before, JUNE), (after, JUNE + 30))
    ]
    solution = merge_sessions(parts, context, names=("old", "new")).solution
    ax1, ax2 = np.array([-60.0, 10.0, 80.0, np.nan]), np.array([60.0, 40.0, 70.0, np.nan])
    for name, mechanism in (("old", before), ("new", after)):
        found = np.stack(solution.predict_of_deg([name] * 4, ax1, ax2))[:, :3]
        true = np.stack(mechanism.errors_deg(context.geometry, ax1[:3], ax2[:3]))
        assert found == pytest.approx(true, abs=0.1)
    mixed = solution.predict_of_deg(["old", "new", "old", "old"], ax1, ax2)
    assert [e[1] for e in mixed] == [e[1] for e in solution.predict_deg(ax1, ax2)]


def test_an_unchanged_unit_is_fitted_as_one_set_of_points() -> None:
    result = merged(1)
    assert result.change == "same"
    assert result.solution.n_points == 16
    assert "agree" in result.sentence


def test_a_moved_unit_is_better_known_with_its_old_session_than_without() -> None:
    context = context_of("azel")
    both, alone = [], []
    for seed in range(SEEDS):
        rng = np.random.default_rng([41, seed])
        after = random_mechanism(rng)
        before = type(after)(after.P1 + 0.3, after.P2, after.P3, after.P4, after.P5, after.P6)
        parts = [
            measured(context, mechanism, np.linspace(*daylight_s(context, day), n), rng)
            for mechanism, day, n in ((before, JUNE, 12), (after, DECEMBER, 5))
        ]
        result = merge_sessions(parts, context)
        assert result.change != "same"
        both.append(true_year(context, after, result.solution.coefficients()).rms_deg)
        alone.append(true_year(context, after, fit_exact(parts[1], context).coefficients()).rms_deg)
    assert np.median(both) < np.median(alone)


@pytest.mark.parametrize("change", [{"P2": 0.4}, {"P1": 0.3, "P3": -0.4, "P4": 0.5}])
def test_the_forecast_after_a_move_comes_true(change: dict[str, float]) -> None:
    """What a day cannot exclude widens it, and takes nothing of the move for a collimation."""
    context, ratios = context_of("azel"), []
    for seed in range(SEEDS // 2):
        rng = np.random.default_rng([42, seed])
        after = random_mechanism(rng)
        before = msgspec.structs.replace(
            after, **{name: getattr(after, name) + by for name, by in change.items()}
        )
        parts = [
            measured(context, mechanism, np.linspace(*daylight_s(context, day), 12), rng)
            for mechanism, day in ((before, JUNE), (after, DECEMBER))
        ]
        solution = merge_sessions(parts, context).solution
        expected = forecast(solution)
        ratios.append(
            true_year(context, after, solution.coefficients()).rms_deg / expected.year_rms_deg
        )
        known = expected.posterior
        numbers = msgspec.structs.astuple(after)[:6]
        assert (
            np.abs(known.mean[:6] - numbers) < 4.0 * np.sqrt(np.diag(known.covariance)[:6])
        ).all()
    assert 0.5 < np.median(ratios) < 1.5
    assert max(ratios) < 3.0


def test_the_shifts_widen_what_is_known() -> None:
    moved, still = merged(5, zero_deg=0.3), merged(5)
    assert moved.solution.sigmas is not None
    assert still.solution.sigmas is not None
    assert moved.solution.sigmas[1] > still.solution.sigmas[1]


def test_a_single_bad_point_is_no_move() -> None:
    context = context_of("azel")
    rng = np.random.default_rng(43)
    mechanism = random_mechanism(rng)
    parts = [
        measured(context, mechanism, np.linspace(*daylight_s(context, JUNE + 30 * k), 8), rng)
        for k in range(2)
    ]
    more = np.zeros((2, 8))
    more[1, 3] = 0.6
    result = merge_sessions([parts[0], changed(parts[1], *more)], context)
    assert result.change == "same"
    assert result.solution.outliers


def test_two_points_a_session_cannot_tell_whether_the_tower_moved() -> None:
    context = context_of("azel")
    rng = np.random.default_rng(47)
    mechanism = random_mechanism(rng)
    first, last = daylight_s(context, JUNE)
    parts = [
        measured(context, mechanism, np.array([first, first + 1800.0]) + 86400.0 * k, rng)
        for k in range(2)
    ]
    result = merge_sessions(parts, context, names=("monday.jsonl", "tuesday.jsonl"))
    (finding,) = result.findings
    assert finding.certainty == "not_determinable"
    assert "monday.jsonl and tuesday.jsonl" in finding.sentence
    assert finding.number is None
    (finding,) = merge_sessions(parts, context).findings
    assert "session 1 and session 2" in finding.sentence
    assert last > first


def test_one_session_is_compared_with_nothing_and_none_is_an_error() -> None:
    context = context_of("azel")
    rng = np.random.default_rng(53)
    part = measured(context, random_mechanism(rng), np.linspace(*daylight_s(context, JUNE), 6), rng)
    assert merge_sessions([part], context).change == "same"
    with pytest.raises(FitError, match="no session"):
        merge_sessions([], context)


TRUTH = np.array([0.7, -0.5, 0.3, 1.2, 0.001, -0.0005])
A_YEAR = np.array([-0.1, 0.3, 0.08, -0.2, 0.0002, -0.0003])
"""How far the mechanism of the calibration before was from today's."""


def held(context: SkyContext, mechanism: np.ndarray) -> Coefficients:
    """What a calibration of that mechanism would have loaded."""
    return Coefficients(*controller_coefficients(mechanism, context, Prior()).tolist())


def fitted(
    points: Points, context: SkyContext, last: Coefficients
) -> tuple[MechanismSolution, tuple[Finding, ...]]:
    prior, findings = weigh_last(
        last, context, DEFAULT_PRIOR, lambda one: fit_exact(points, context, prior=one)
    )
    return fit_exact(points, context, prior=prior), findings


@pytest.mark.parametrize("ideal", ["apparent", "airless", "solartrak"])
@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
def test_the_mechanism_is_the_one_whose_coefficients_they_are(geometry, ideal):
    context, _ = day_of(geometry, 1, ideal=ideal)
    assert mechanism_of(held(context, TRUTH), context) == pytest.approx(TRUTH, abs=1e-9)


def test_without_them_and_with_impossible_ones_the_numbers_are_finite():
    context, _ = day_of("azel", 1)
    for values in ((0.0,) * 6, (10.0, 30.0, -10.0, 30.0, 0.05, -0.05)):
        assert np.isfinite(mechanism_of(Coefficients(*values), context)).all()


@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
def test_near_the_truth_fewer_points_reach_the_same_sigma(geometry):
    context, points = day_of(geometry, 12, ideal="solartrak")
    last = held(context, TRUTH + A_YEAR)
    blank_deg, informed_deg = [], []
    for k in (1, 2, 3, 4, 6, 9):
        part = points.subset(range(k))
        informed, findings = fitted(part, context, last)
        assert findings == ()
        assert informed.prior.last == last
        blank_deg.append(forecast(fit_exact(part, context), context).year_rms_deg)
        informed_deg.append(forecast(informed, context).year_rms_deg)
    assert (np.array(informed_deg) <= blank_deg).all()
    assert np.argmax(np.array(informed_deg) < 0.7) < np.argmax(np.array(blank_deg) < 0.7)


@pytest.mark.parametrize("n", [1, 2, 5, 12])
@pytest.mark.parametrize("away", [(4, 0, 0, 0, 0, 0), (0, 0, -4, 0, 0, 0), (3, -8, -3, 8, 0, 0)])
def test_far_from_the_truth_the_points_win_and_a_finding_reports_it(n, away):
    context, points = day_of("azel", n)
    solution, findings = fitted(points, context, held(context, TRUTH + np.array(away)))
    alone = fit_exact(points, context)
    assert solution.values.tolist() == alone.values.tolist()
    sigmas = np.sqrt(np.diag(solution.posterior.covariance))
    assert (np.abs(solution.posterior.mean - TRUTH) < 3.0 * sigmas).all()
    (finding,) = findings
    assert finding.kind == "last_coefficients"
    assert finding.sentence.startswith("the last coefficients do not fit these points (p = ")


def test_five_times_as_far_as_a_unit_changes_is_far_where_the_points_are_many():
    context, points = day_of("azel", 12)
    away = np.array([5.0 * SINCE_LAST[0], 0.0, 0.0, 0.0, 0.0, 0.0])
    _, (finding,) = fitted(points, context, held(context, TRUTH + away))
    assert finding.kind == "last_coefficients"
    assert re.search(r"P1 is \+\d\.\d\d by them and \+\d\.\d\d deg by the points", finding.sentence)


def test_a_little_off_they_stay_and_the_truth_is_within_the_band():
    context, points = day_of("azel", 5)
    moved = np.array([0.5, -0.8, -0.4, 1.0, 0.0004, -0.0004])
    solution, findings = fitted(points, context, held(context, TRUTH + moved))
    assert findings == ()
    sigmas = np.sqrt(np.diag(solution.posterior.covariance))
    assert (np.abs(solution.posterior.mean - TRUTH) < 3.0 * sigmas).all()


def test_a_lean_read_today_counts_beside_them_by_its_sigma():
    context, _ = day_of("azel", 1)
    last = held(context, TRUTH)
    plain = last_prior(last, context, DEFAULT_PRIOR)
    assert (plain.sigmas, plain.widths) == (SINCE_LAST, PLAIN)
    read = last_prior(last, context, DEFAULT_PRIOR.with_inclinometer(0.0, 0.0, 0.3))
    assert read.means[0] == pytest.approx(0.35, abs=1e-6)
    assert read.sigmas[0] == pytest.approx(0.3 / np.sqrt(2.0))
    assert read.means[1] == plain.means[1]


def test_the_fit_reports_what_its_prior_was():
    context, points = day_of("azel", 5)
    last = held(context, TRUTH)
    solution, _ = fitted(points, context, last)
    (note,) = [note for note in solution.notes if note.startswith("prior: ")]
    assert note.startswith(f"prior: the unit's last coefficients {last.P1:+.4f} {last.P2:+.4f} ")
    assert solution.as_json()["prior"]["last"]["P1"] == last.P1
    blank = fit_exact(points, context)
    assert not any("prior:" in note for note in blank.notes)
    assert blank.as_json()["prior"]["last"] is None
    assert fit_exact(points, context, use_prior=False).as_json()["prior"] is None
