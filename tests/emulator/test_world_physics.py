"""The hidden truth: what the spot shows, what slack and lost counts do, what the clocks do."""

import math

import numpy as np
import pytest

from solarcal.emulator.scenario import load_scenario, scenario_names
from solarcal.mount.formula import Coefficients
from solarcal.sun import sun_position
from solarcal.unit.tracker import Mode

EXACT = ("truth.noise_deg=0", "truth.switch_sigma_counts=0")


@pytest.mark.parametrize("name", scenario_names())
def test_at_the_readings_of_the_sun_the_spot_is_centred(rig, name):
    tracker = rig(name, *EXACT, "truth.backlash1_deg=0", "truth.backlash2_deg=0", referenced=True)
    status = tracker.status()
    tracker.drive_to(status.target1_deg, status.target2_deg)
    for _ in range(3):
        spot, status = tracker.spot(), tracker.status()
        tracker.drive_to(
            status.reading1_deg + spot.error1_deg, status.reading2_deg + spot.error2_deg
        )
    spot, status = tracker.spot(), tracker.status()
    assert spot.visible
    # One count, and the Sun's way during the last correction.
    assert abs(spot.error1_deg) * math.sin(math.radians(status.ideal2_deg)) < 0.004
    assert abs(spot.error2_deg) < 0.004


def test_the_sun_of_the_world_is_precise_and_refracted_that_of_the_unit_is_not(rig):
    tracker = rig("tijeras-azel", *EXACT)
    world = tracker.emulator.world
    ax1, ax2, elevation = world.sky.sun_now_deg(world.start_utc_s)
    airless = sun_position("precise", world.start_utc_s, world.site)
    assert elevation - airless.elevation_deg == pytest.approx(0.058, abs=0.005)
    assert tracker.status().ideal2_deg - ax2 == pytest.approx(0.058, abs=0.02)
    assert ax1 == pytest.approx(180.0 - airless.azimuth_deg, abs=1e-3)


def test_fast_and_slow_path_of_the_worlds_sun_agree(rig):
    world = rig("tijeras-azel").emulator.world
    times = world.start_utc_s + np.arange(0.0, 40000.0, 4000.0)
    path = np.array(world.sky.sun_path_deg(times))
    single = np.array([world.sky.sun_now_deg(float(t)) for t in times]).T
    np.testing.assert_allclose(path, single, atol=1e-4)


def test_the_world_can_be_given_the_controllers_own_sun(rig):
    tracker = rig("tijeras-azel", *EXACT, "truth.sun=solartrak", "truth.refraction=none")
    ax1, ax2, _ = tracker.emulator.world.sky.sun_now_deg(tracker.emulator.world.start_utc_s)
    status = tracker.status()
    assert (status.ideal1_deg, status.ideal2_deg) == pytest.approx((ax1, ax2), abs=1e-5)


def test_the_spot_is_seen_only_within_range_and_only_by_day(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    status = tracker.status()
    tracker.drive_to(status.ideal1_deg, status.ideal2_deg)
    assert tracker.spot().visible
    tracker.drive_to(status.ideal1_deg, status.ideal2_deg - 5.0)
    assert not tracker.spot().visible
    tracker.advance(14 * 3600.0)
    assert not tracker.spot().visible


def test_the_noise_of_the_eye_is_on_sky_and_so_larger_on_axis_1(rig):
    tracker = rig("tijeras-azel", "truth.noise_deg=0.02", start_utc_s=1780513200.0, referenced=True)
    status = tracker.status()
    tracker.drive_to(status.ideal1_deg, status.ideal2_deg)
    ax2 = math.radians(tracker.status().ideal2_deg)
    looks = np.array([[s.error1_deg, s.error2_deg] for s in (tracker.spot() for _ in range(400))])
    assert math.degrees(ax2) < 16.0
    assert looks[:, 0].std() * math.sin(ax2) == pytest.approx(0.02, rel=0.15)
    assert looks[:, 1].std() == pytest.approx(0.02, rel=0.15)


def test_slack_shows_only_on_reversal_and_then_in_full(rig):
    tracker = rig("backlash", *EXACT, "truth.sun=solartrak", referenced=True)
    motor = tracker.emulator.world.motors[0]
    now = tracker.emulator.now_s

    def lag_deg():
        return motor.collector_deg(now()) - motor.angle_deg(motor.position(now()))

    start = tracker.status()
    tracker.drive_to(start.reading1_deg - 2.0, start.reading2_deg)
    assert lag_deg() == pytest.approx(0.075, abs=1e-9)
    tracker.drive_to(start.reading1_deg - 3.0, start.reading2_deg)
    assert lag_deg() == pytest.approx(0.075, abs=1e-9)
    stood = motor.collector_deg(now())
    tracker.drive_to(start.reading1_deg - 2.9, start.reading2_deg)
    assert motor.collector_deg(now()) == pytest.approx(stood, abs=1e-9)
    tracker.drive_to(start.reading1_deg - 2.8, start.reading2_deg)
    assert lag_deg() == pytest.approx(-0.075, abs=1e-9)


def test_lost_counts_are_exactly_what_the_next_reference_check_finds(rig):
    tracker = rig("missed-counts", "truth.switch_sigma_counts=0", referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.advance(3 * 3600.0)
    again = tracker.reference()
    assert (again.difference1, again.difference2) == (0, 0)
    tracker.unlocked("MODE TRACK")
    tracker.advance(2 * 3600.0)
    found = tracker.reference()
    assert (found.number, found.difference1, found.difference2) == (3, 300, 0)
    assert tracker.reference().difference1 == 0


def test_counts_can_be_lost_at_a_rate(rig):
    tracker = rig(
        "tijeras-azel", "truth.missed_per_hour2=12", "truth.switch_sigma_counts=0", referenced=True
    )
    tracker.advance(3600.0)
    assert tracker.reference().difference2 == 12


def test_lost_counts_move_the_spot_by_as_much(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.advance(120.0)
    before, phase = tracker.spot(), tracker.status()
    tracker.ask("X FAULT miss1:40")
    assert tracker.status().counts1 == phase.counts1 + 40
    assert tracker.spot().error1_deg == pytest.approx(before.error1_deg, abs=1e-4)
    tracker.ask("X FAULT miss1:460")
    tracker.advance(1.0)
    # The unit believes to stand 0.5 deg too high and drives back by that: so must we, forward.
    assert tracker.spot().error1_deg == pytest.approx(0.5 + before.error1_deg, abs=0.11)


def test_the_switch_repeats_to_its_sigma(rig):
    tracker = rig("tijeras-azel", "truth.switch_sigma_counts=5", referenced=True)
    found = [tracker.reference().difference1 for _ in range(40)]
    # A difference is that of two readings of the switch.
    assert np.std(found) == pytest.approx(5.0 * math.sqrt(2.0), rel=0.35)


def test_the_unit_clock_drifts_from_its_last_setting_on(rig):
    tracker = rig("wrong-clock")
    model, world = tracker.emulator.controller.model, tracker.emulator.world

    def error_s():
        now_s = tracker.emulator.now_s()
        return model.utc_s(now_s) - world.true_utc_s(now_s)

    assert error_s() == pytest.approx(95.0)
    tracker.advance(43200.0)
    assert error_s() == pytest.approx(95.0 + 20.0)
    true, laptop, _ = tracker.ask("X TIME")
    assert (true[17:19], laptop[17:19]) == ("00", "24")
    local = laptop[:11].replace("-", "") + "090000.000"
    tracker.unlocked("CLOCK SET " + local)
    set_to = error_s()
    tracker.advance(21600.0)
    assert error_s() - set_to == pytest.approx(10.0)


@pytest.mark.parametrize(
    "name", ["tijeras-azel", "southern", "ns-tiltroll", "ew-tiltroll", "polar"]
)
def test_true_error_with_the_true_coefficients_is_the_formulas_own(rig, name):
    tracker = rig(
        name, *EXACT, "truth.lean_deg=0.1", "truth.sun=solartrak", "truth.refraction=none"
    )
    before = [float(f) for f in tracker.ask("X TRUTH")]
    tracker.load(tracker.true_coefficients())
    after = [float(f) for f in tracker.ask("X TRUTH")]
    assert before[6] > 0.2
    assert after[6] < 0.002
    assert after[7] < 0.005
    assert after[8] < 0.002


def test_true_error_of_a_pure_zero_offset_is_that_offset(rig):
    tracker = rig(
        "tijeras-azel", "truth.sun=solartrak", "truth.refraction=none", "truth.lean_deg=0",
        "truth.P2=0", "truth.P4=0.3", "truth.P5=0", "truth.P6=0",
    )  # fmt: skip
    p4, day_rms, day_max, year_rms = (float(tracker.ask("X TRUTH")[i]) for i in (3, 6, 7, 8))
    assert p4 == 0.3
    assert (day_rms, day_max, year_rms) == pytest.approx((0.3, 0.3, 0.3), abs=1e-5)
    tracker.load(Coefficients(P4=0.1))
    assert float(tracker.ask("X TRUTH")[6]) == pytest.approx(0.2, abs=1e-5)


def test_true_error_sees_the_clock(rig):
    plain = ("truth.sun=solartrak", "truth.refraction=none", "truth.lean_deg=0.1")
    tracker = rig("tijeras-azel", *plain, "truth.unit_offset_s=24")
    tracker.load(tracker.true_coefficients())
    # 24 s are 0.1 deg of hour angle, seen under the cosine of the declination.
    expected_deg = 0.1 * math.cos(math.radians(22.3))
    assert float(tracker.ask("X TRUTH")[6]) == pytest.approx(expected_deg, abs=2e-3)


def test_a_screwjack_of_another_length_is_right_at_the_reference_only(rig):
    tracker = rig("screwjack", *EXACT, referenced=True)
    motor, now_s = tracker.emulator.world.motors[0], tracker.emulator.now_s
    assert motor.collector_deg(now_s()) == pytest.approx(tracker.status().reading1_deg, abs=1e-3)
    status = tracker.status()
    tracker.drive_to(0.0, status.reading2_deg)
    assert 0.05 < abs(motor.collector_deg(now_s()) - tracker.status().reading1_deg) < 1.0


def test_every_scenario_begins_in_the_morning_with_the_sun_in_reach(rig):
    for name in scenario_names():
        tracker = rig(name)
        scenario = load_scenario(name)
        # The start screen shows it whole on 80 columns.
        assert 0 < len(scenario.summary) <= 54
        assert scenario.start_utc_s() % 60.0 == 0.0
        status = tracker.status()
        assert status.mode is Mode.MANUAL
        limits = tracker.emulator.controller.model.limits
        assert limits.distance_deg(status.target1_deg, status.target2_deg) > 1.0, name
        sun = sun_position("precise", scenario.start_utc_s(), tracker.emulator.world.site)
        assert 11.99 <= sun.elevation_deg < 12.4
        assert 5.5 < sun.solar_time_h < 9.0
