"""Several sessions of one unit: one calibration, unless something moved between them."""

import re

import made_up_trackers  # noqa: F401  (puts the benchmarks on the path)
import msgspec
import numpy as np
import pytest

from benchmarks.diagnosis import DECEMBER, JUNE, changed, merged
from benchmarks.judgement_trackers import (
    context_of,
    daylight_s,
    measured,
    random_mechanism,
    true_year,
)
from solarcal.errors import FitError
from solarcal.model.earlier_sessions import merge_sessions
from solarcal.model.methods import fit_exact

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
    assert last > first


def test_one_session_is_compared_with_nothing_and_none_is_an_error() -> None:
    context = context_of("azel")
    rng = np.random.default_rng(53)
    part = measured(context, random_mechanism(rng), np.linspace(*daylight_s(context, JUNE), 6), rng)
    assert merge_sessions([part], context).change == "same"
    with pytest.raises(FitError, match="no session"):
        merge_sessions([], context)
