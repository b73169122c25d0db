"""A fit may be smooth and its points wrong all the same: what was seen beside them counts."""

import pytest
from made_up_trackers import day_of, judge

from solarcal.model.finding import Finding
from solarcal.model.forecast import forecast
from solarcal.model.methods import fit_exact

USED = tuple(range(1, 15))


@pytest.fixture(scope="module")
def good_day():
    context, points = day_of("azel", 14, noise_deg=0.02)
    solution = fit_exact(points, context)
    assert tuple(solution.points.labels) == USED
    return solution, forecast(solution)


def seen(kind, number, labels=(), **more):
    return Finding(
        kind=kind, subject="it", sentence=f"SEEN {number:g}", number=number, labels=labels,
        **{"direct": True, **more},
    )  # fmt: skip


def verdict(good_day, *evidence):
    return judge(*good_day, evidence=evidence)


def test_nothing_seen_is_nothing_said(good_day):
    assert verdict(good_day).as_json() == judge(*good_day).as_json()
    assert verdict(good_day).state == "done"


@pytest.mark.parametrize("lost_deg", [-0.3, 0.06])
def test_points_read_with_missed_counts_are_to_be_struck_out_before_anybody_stops(
    good_day, lost_deg
):
    """Of more than half the tolerance: on one axis, and between points that are right."""
    said = verdict(good_day, seen("missed_counts", lost_deg, (3, 7)))
    assert said.state == "continue"
    assert said.reasons[0] == f"SEEN {lost_deg:g}; take others, then strike these out"


def test_struck_out_already_or_lost_between_the_points_they_are_no_reason_any_more(good_day):
    assert verdict(good_day, seen("missed_counts", 0.3, (99,))).state == "done"
    assert verdict(good_day, seen("missed_counts", 0.3)).state == "done"


@pytest.mark.parametrize("evidence", [
    seen("missed_counts", 0.04, (3,)), seen("unit_sun", 0.09), seen("laptop_clock", 11.9),
    seen("clock_drift", 23.0), seen("clock_offset", 90.0),
])  # fmt: skip
def test_what_is_within_the_tolerance_is_no_reason(good_day, evidence):
    assert verdict(good_day, evidence).as_json() == verdict(good_day).as_json()


@pytest.mark.parametrize("evidence", [
    seen("frozen", 0.0, (3, 4)), seen("unit_sun", 15.0), seen("laptop_clock", 12.1),
])  # fmt: skip
def test_a_unit_that_is_not_what_the_fit_takes_it_for_does_not_fit(good_day, evidence):
    said = verdict(good_day, evidence)
    assert said.state == "does_not_fit"
    assert said.reasons[0] == evidence.sentence


@pytest.mark.parametrize("kind", ["clock_drift", "clock_step"])
def test_a_clock_that_runs_away_leaves_the_coefficients_right_but_is_said(good_day, kind):
    said = verdict(good_day, seen(kind, 40.0))
    assert said.state == "done"
    assert said.reasons[1] == "SEEN 40"


def test_what_is_only_inferred_or_cannot_be_told_is_left_to_the_fits_own_checks(good_day):
    for more in ({"direct": False}, {"certainty": "not_determinable"}):
        said = verdict(good_day, seen("frozen", 0.0, (3, 4), **more))
        assert said.as_json() == verdict(good_day).as_json()
