"""Clocks, reference checks and read-outs speak for themselves."""

import made_up_trackers  # noqa: F401  (puts the benchmarks on the path)
import numpy as np
import pytest

from benchmarks.diagnosis import drift_found
from solarcal.model.evidence.clocks import (
    ClockSetting,
    clock_behaviour,
    clock_findings,
    laptop_finding,
)
from solarcal.model.evidence.read_outs import (
    Loss,
    Moment,
    frozen_findings,
    missed_counts_finding,
    play_of_a_switch,
)

HOURS = 3600.0 * np.arange(10.0)


def kinds(difference_s: list[float], settings: list[ClockSetting] | None = None) -> dict[str, str]:
    found = clock_findings(HOURS.tolist(), difference_s, settings or [], range(1, 11))
    # Two clocks that were read are evidence, no inference.
    assert all(finding.direct for finding in found)
    return {finding.kind: finding.sentence for finding in found}


def test_a_drift_of_40_s_per_day_is_named_and_a_steady_clock_is_not() -> None:
    assert all(drift_found(seed) for seed in range(20))
    assert all(drift_found(seed, 0.0) for seed in range(20))


def test_what_the_readings_scatter_by_is_no_drift() -> None:
    uneven = 3.0 * np.resize([1.0, -1.0], 10) + 24.0 * HOURS / 86400.0
    assert "clock_drift" not in kinds(uneven.tolist())
    clear = uneven / 2.0 + 60.0 * HOURS / 86400.0
    assert "clock_drift" in kinds(clear.tolist())


def test_a_step_is_named_with_the_point_it_precedes_and_is_no_drift() -> None:
    said = kinds([0.1] * 6 + [3.1] * 4)
    assert set(said) == {"clock_step", "clock_offset"}
    assert "+3.0 s before point 7, within 60 minutes: 0.013 deg of Sun" in said["clock_step"]


def test_a_step_on_top_of_a_drift_leaves_both() -> None:
    drift = 40.0 * HOURS / 86400.0
    said = kinds((drift + 5.0 * (HOURS > 4.5 * 3600.0)).tolist())
    assert "+40.0 +-" in said["clock_drift"]
    assert "+5.0 s before point 6" in said["clock_step"]


def test_setting_the_clock_is_neither_step_nor_drift() -> None:
    setting = ClockSetting(4.5 * 3600.0, 60.0, 0.0)
    said = kinds([60.0] * 5 + [0.0] * 5, [setting])
    assert set(said) == {"clock_offset"}


@pytest.mark.parametrize("at", [1, 4, 6, 9])
def test_a_step_is_found_between_any_two_readings_of_one_setting(at: int) -> None:
    """The clock was set between points 5 and 6: what differs there is the setting's."""
    setting = ClockSetting(4.5 * 3600.0, 0.0, 60.0)
    after = np.where(setting.utc_s < HOURS, 60.0, 0.0)
    stepped = after + 7.0 * (np.arange(10) >= at) * ((np.arange(10) > 4) == (at > 4))
    # What the setting found and left is a reading too.
    setting = ClockSetting(4.5 * 3600.0, 7.0 if at < 5 else 0.0, 60.0)
    assert f"+7.0 s before point {at + 1}" in kinds(stepped.tolist(), [setting])["clock_step"]


@pytest.mark.parametrize(
    ("kind", "difference_s", "least"),
    [
        ("clock_offset", np.ones(10), 1.0),
        ("clock_drift", HOURS / 86400.0, 2.0),
        ("clock_step", 1.0 * (HOURS > 4.5 * 3600.0), 0.5),
    ],
)
def test_a_clock_is_reported_from_these_limits_on(
    kind: str, difference_s: np.ndarray, least: float
) -> None:
    """A second is 0.0042 deg of Sun: less than one, or than two a day, is not reported."""
    assert kind not in kinds((0.9 * least * difference_s).tolist())
    assert kind in kinds((1.1 * least * difference_s).tolist())


def test_half_an_hour_between_settings_is_needed_to_show_a_drift() -> None:
    minutes = np.concatenate((np.arange(0.0, 25.0, 5.0), np.arange(30.0, 55.0, 5.0)))
    for minute_s, known in ((60.0, False), (120.0, True)):
        setting = ClockSetting(27.0 * minute_s, 0.0, 0.0)
        behaviour = clock_behaviour((minute_s * minutes).tolist(), [0.0] * 10, [setting])
        assert (behaviour is not None) == known


def test_a_whole_hour_is_said_to_be_one() -> None:
    assert "+1 h" in kinds([3600.2] * 10)["clock_offset"]


@pytest.mark.parametrize("n", [0, 1, 2])
def test_too_few_readings_tell_no_drift(n: int) -> None:
    assert not clock_findings(HOURS[:n].tolist(), [0.1, 0.9][:n])


def test_the_laptop_clock_is_known_by_a_time_signal_only() -> None:
    assert laptop_finding(None, None).certainty == "not_determinable"
    assert laptop_finding(-30.0, 0.5).certainty == "found"
    assert "0.125 deg of Sun are in the coefficients" in laptop_finding(-30.0, 0.5).sentence
    # Half a second where nobody said how well the signal was heard.
    assert (laptop_finding(2.0, None).sigma, laptop_finding(2.0, 0.1).sigma) == (0.5, 0.1)
    assert "correct the laptop's clock" in laptop_finding(-30.0, 0.5).sentence
    assert laptop_finding(0.2, 0.5).certainty == "not_determinable"


def test_missed_counts_name_check_axis_and_points() -> None:
    finding = missed_counts_finding(3, -412, Loss(2, -0.302, (4, 5, 6)), Moment(5, True))
    assert finding.labels == (5, 6)
    for words in (
        "check 3",
        "-412 counts",
        "axis 2",
        "before point 5",
        "points 5 and 6 read wrong",
    ):
        assert words in finding.sentence
    alone = missed_counts_finding(3, -412, Loss(2, -0.302, (4, 5, 6)), Moment(6, True))
    assert alone.labels == (6,)
    assert "before point 6; point 6 reads wrong by as much" in alone.sentence


def test_points_that_hardly_tell_when_leave_all_between_the_checks_in_doubt() -> None:
    finding = missed_counts_finding(3, 412, Loss(1, 0.3, (4, 5, 6)), Moment(5, False))
    assert finding.labels == (4, 5, 6)
    assert "hardly show when" in finding.sentence


@pytest.mark.parametrize(("counts", "angle"), [(3, 0.3), (400, 0.004)])
def test_a_switch_is_found_again_to_a_few_counts(counts: int, angle: float) -> None:
    assert play_of_a_switch(counts, angle)
    assert not play_of_a_switch(400, 0.3)


def read_outs(axis1: list[float]) -> tuple[np.ndarray, np.ndarray]:
    ideal = np.column_stack((np.linspace(-30.0, 30.0, 5), np.linspace(40.0, 30.0, 5)))
    reading = ideal + 0.1
    reading[:, 0] = axis1
    return reading, ideal


def test_a_dead_read_out_is_exactly_zero_all_day() -> None:
    (finding,) = frozen_findings(range(1, 6), *read_outs([0.0] * 5))
    assert finding.subject == "axis 1"
    assert "exactly zero" in finding.sentence
    assert "dead" in finding.sentence


@pytest.mark.parametrize("at_deg", [0.02, -0.02, 0.0])
def test_a_read_out_that_froze_for_two_points_names_them(at_deg: float) -> None:
    (finding,) = frozen_findings(range(1, 6), *read_outs([-30.0, -15.0, at_deg, at_deg, 30.0]))
    assert finding.labels == (3, 4)
    shown = f"{at_deg:.5f} deg" if at_deg else "zero"
    assert f"axis 1 read exactly {shown} at points 3 and 4 while the Sun moved 15.0 deg" in (
        finding.sentence
    )
    assert finding.sentence.endswith("its read-out is frozen")


def test_a_read_out_is_frozen_where_the_sun_moved_by_more_than_half_a_degree() -> None:
    for moved_deg, frozen in ((0.4, False), (0.6, True)):
        ideal = np.column_stack((10.0 + moved_deg * np.arange(2.0), [40.0, 41.0]))
        reading = np.column_stack((np.full(2, 10.0), ideal[:, 1]))
        assert bool(frozen_findings((1, 2), reading, ideal)) is frozen


def test_an_axis_that_had_nothing_to_follow_is_not_frozen() -> None:
    ideal = np.column_stack((np.full(5, 12.0), np.linspace(40.0, 30.0, 5)))
    assert not frozen_findings(range(1, 6), ideal, ideal)


def test_the_drift_of_a_clock_has_the_sigma_of_a_regression():
    # Half a second that no other test needs.
    from scipy.stats import linregress

    scatter_s = np.random.default_rng(5).normal(0.0, 0.4, 10)
    difference_s = 3.0 * HOURS / 86400.0 + scatter_s
    behaviour = clock_behaviour(HOURS.tolist(), difference_s.tolist(), ())
    line = linregress(HOURS / 86400.0, difference_s)
    assert behaviour.steps == ()
    assert behaviour.drift_s_per_day == pytest.approx(line.slope)
    assert behaviour.sigma_s_per_day == pytest.approx(line.stderr)
