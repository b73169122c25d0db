"""The controller: tracking in steps, jogs, reference checks, limits."""

from itertools import pairwise

import numpy as np
import pytest

from solarcal.unit.tracker import Mode

EXACT = ("truth.noise_deg=0", "truth.switch_sigma_counts=0")
FORMULA_IS_TRUE = (
    *EXACT, "truth.lean_deg=0.1", "truth.sun=solartrak", "truth.refraction=none",
)  # fmt: skip


def test_nothing_that_needs_counts_works_before_the_first_reference_check(rig):
    tracker = rig()
    tracker.ask("UNLOCK")
    assert not tracker.status().referenced
    for request in ("MODE TRACK", "OFFSET SET", "JOG 100 70"):
        assert tracker.refusal(request) == 24
    assert tracker.ask("REF") == ("0", "NONE", "0", "0")


def test_a_reference_check_takes_its_time_and_keeps_offsets_and_coefficients(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.unlocked("COEF SET 0.1 0.2 0.3 0.4 0 0 0.5 0.6")
    tracker.drive_to(18.0, 60.0)
    held = tracker.ask("COEF")
    begun = tracker.emulator.now_s()
    assert tracker.unlocked("REF START") == ("2",)
    assert tracker.ask("REF")[1] == "RUNNING"
    assert tracker.refusal("JOG 0 40") == 22
    assert tracker.refusal("MODE MANUAL") == 22
    assert tracker.refusal("OFFSET SET") == 22
    while tracker.ask("REF")[1] == "RUNNING":
        tracker.advance(1.0)
    # 100 deg at 0.8 deg/s, half a degree back, and the same again at a quarter of the speed.
    took = tracker.emulator.now_s() - begun
    assert took == pytest.approx(100 / 0.8 + 0.5 / 0.8 + 0.5 / 0.2, abs=1.1)
    status = tracker.status()
    assert (status.mode, status.counts1, status.counts2) == (Mode.MANUAL, 0, 0)
    assert (status.reading1_deg, status.reading2_deg) == (118.0, 80.0)
    assert status.approach == (1, 1)
    assert tracker.ask("COEF") == held


def test_a_reference_check_can_be_broken_off(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.drive_to(90.0, 60.0)
    tracker.unlocked("REF START")
    tracker.advance(3.0)
    tracker.ask("STOP")
    assert tracker.ask("REF") == ("2", "BROKEN", "0", "0")
    assert tracker.status().referenced
    tracker.unlocked("MODE MANUAL")
    assert tracker.reference().difference1 == 0


def test_tracking_stays_within_half_the_update_range_and_goes_ahead_of_the_sun(rig):
    tracker = rig("tijeras-azel", *FORMULA_IS_TRUE, referenced=True)
    tracker.load(tracker.true_coefficients())
    tracker.unlocked("MODE TRACK")
    tracker.advance(120.0)
    lags, spots = [], []
    for _ in range(400):
        tracker.advance(97.0)
        status, spot = tracker.status(), tracker.spot()
        assert status.mode is Mode.TRACK
        assert spot.visible
        lag1_deg = status.target1_deg - status.reading1_deg
        lags.append((lag1_deg, status.target2_deg - status.reading2_deg))
        spots.append((spot.error1_deg * np.sin(np.radians(status.ideal2_deg)), spot.error2_deg))
    largest = np.abs(lags).max(axis=0)
    assert (largest < 0.052).all()
    assert (largest > 0.045).all()
    assert np.ptp(np.sign(lags)) == 2.0
    assert np.abs(spots).max() < 0.055


def test_between_updates_nothing_moves(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.advance(300.0)
    seen = []
    for _ in range(600):
        tracker.advance(1.0)
        seen.append(tracker.status())
    assert sum(status.moving == (0, 0) for status in seen) > 550
    updates = 0
    for before, after in pairwise(seen):
        stood = (before.counts1, before.counts2) == (after.counts1, after.counts2)
        # The phase grows while both axes stand and begins anew with an update of either.
        assert after.update_phase >= before.update_phase or not stood
        updates += after.update_phase < before.update_phase
    # The Sun takes about 0.15 deg of each axis a minute.
    assert 25 < updates < 60


def test_a_coarse_encoder_does_not_trap_the_tracking(rig):
    tracker = rig("tijeras-azel", *EXACT, "unit.drive1=rotary:2", "unit.drive2=rotary:2")
    tracker.reference()
    tracker.unlocked("MODE TRACK")
    tracker.advance(7200.0)
    status = tracker.status()
    assert abs(status.target1_deg - status.reading1_deg) < 0.6


def test_a_jog_expires_on_a_whole_count_unless_renewed(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.unlocked("JOG 60.0 78.0")
    assert tracker.status().mode is Mode.JOG
    tracker.advance(4.999)
    assert tracker.status().moving == (-1, 0)
    tracker.advance(0.001)
    status = tracker.status()
    assert (status.mode, status.moving, status.approach) == (Mode.MANUAL, (0, 0), (-1, -1))
    assert status.counts1 == -4000
    assert status.reading1_deg == pytest.approx(114.0)
    tracker.advance(100.0)
    assert tracker.status().counts1 == -4000


def test_a_renewed_jog_arrives_and_becomes_manual(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    for _ in range(4):
        tracker.unlocked("JOG 110.0 78.0")
        tracker.advance(4.0)
    status = tracker.status()
    assert (status.mode, status.reading1_deg, status.reading2_deg) == (Mode.MANUAL, 110.0, 78.0)


def test_a_jog_beyond_a_limit_is_refused_and_says_which(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.ask("UNLOCK")
    reply = tracker.reply("JOG 129.0 60.0")
    assert reply.code == 21
    assert "axis 1" in reply.text
    assert tracker.reply("JOG 100.0 1.0").text.startswith("axis 2")
    assert tracker.status().mode is Mode.MANUAL


def test_the_offset_holds_at_the_instant_it_was_set(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.load(tracker.true_coefficients())
    status = tracker.status()
    tracker.drive_to(status.ideal1_deg + 1.0, status.ideal2_deg - 2.0)
    answer = tracker.unlocked("OFFSET SET")
    status = tracker.status()
    assert answer[10] == f"{status.offsets.O1:.4f}"
    assert (status.target1_deg, status.target2_deg) == pytest.approx(
        (status.reading1_deg, status.reading2_deg), abs=1e-4
    )
    tracker.unlocked("JOG 90 60")
    assert tracker.refusal("OFFSET SET") == 23


def test_tracking_waits_at_a_limit_and_goes_on_behind_it(rig):
    tracker = rig("tijeras-azel", *EXACT, "unit.limits2_deg=[40.0,88.0]", referenced=True)
    tracker.unlocked("MODE TRACK")
    modes, low = [], []
    for _ in range(11 * 4):
        tracker.advance(900.0)
        status = tracker.status()
        modes.append(status.mode)
        low.append(status.reading2_deg)
    first, last = modes.index(Mode.LIMIT), len(modes) - modes[::-1].index(Mode.LIMIT)
    assert set(modes[:first]) == {Mode.TRACK}
    assert set(modes[first:last]) == {Mode.LIMIT}
    assert Mode.TRACK in modes[last:]
    assert min(low) >= 40.0


def test_the_sun_sets_on_a_tracking_unit(rig):
    tracker = rig("tijeras-azel", *EXACT, "unit.limits2_deg=[2.0,120.0]", referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.advance(16 * 3600.0)
    assert tracker.status().mode is Mode.LIMIT
    tracker.unlocked("MODE MANUAL")
    assert tracker.refusal("MODE TRACK") == 25
    assert tracker.refusal("OFFSET SET") == 25


def test_the_tropical_path_crosses_the_branch_and_is_taken_up_again_beyond(rig):
    tracker = rig("tropical", *EXACT, referenced=True)
    tracker.unlocked("MODE TRACK")
    readings = []
    for _ in range(66):
        tracker.advance(600.0)
        if tracker.status().mode is Mode.TRACK:
            readings.append(tracker.status().reading1_deg)
    assert max(readings) > 150.0
    assert min(readings) < -150.0
    assert all(abs(reading) <= 178.0 for reading in readings)


def test_stow_before_the_first_check_goes_to_the_switches(rig):
    tracker = rig("tijeras-azel", *EXACT)
    tracker.ask("STOW")
    tracker.advance(60.0)
    motors = tracker.emulator.world.motors
    assert [motor.position(tracker.emulator.now_s()) for motor in motors] == [0, 0]
    assert not tracker.status().referenced


def test_stow_drives_to_the_stow_position(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.ask("STOW")
    tracker.advance(300.0)
    status = tracker.status()
    assert (status.mode, status.reading1_deg, status.reading2_deg) == (Mode.STOW, 0.0, 5.0)


def test_new_coefficients_are_driven_to_at_once_while_tracking(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.advance(60.0)
    before = tracker.status()
    tracker.unlocked("COEF SET 0 1.0 0 0 0 0 0 0")
    tracker.advance(10.0)
    after = tracker.status()
    assert after.reading1_deg - before.reading1_deg == pytest.approx(1.0, abs=0.15)


def test_setting_the_clock_moves_the_sun_and_the_axes(rig):
    tracker = rig("tijeras-azel", *EXACT, referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.advance(60.0)
    before = tracker.status()
    tracker.unlocked("CLOCK SET 20260603T090000.000")
    tracker.advance(120.0)
    after = tracker.status()
    assert after.mode is Mode.TRACK
    assert before.reading2_deg - after.reading2_deg > 20.0


def test_a_screwjack_axis_moves_on_whole_counts_of_its_nominal_triangle(rig):
    tracker = rig("screwjack", *EXACT, referenced=True)
    status = tracker.status()
    tracker.drive_to(40.0, 60.0)
    status = tracker.status()
    # A count is about a thousandth of a degree at these arms.
    assert (status.reading1_deg, status.reading2_deg) == pytest.approx((40.0, 60.0), abs=1e-3)
    assert status.approach == (-1, -1)


def test_a_jack_jams_before_its_dead_point_and_the_unit_lives_on(rig):
    tracker = rig("screwjack", *EXACT, referenced=True)
    tracker.unlocked("MODE TRACK")
    tracker.ask("X FAULT miss1:-100000")
    tracker.advance(3600.0)
    assert tracker.status().mode is Mode.TRACK
    motor = tracker.emulator.world.motors[0]
    # One degree short of the flat triangle: beta is 90 deg.
    assert motor.collector_deg(tracker.emulator.now_s()) == pytest.approx(89.0, abs=0.02)


def test_drives_that_cannot_reach_their_limits_are_refused(rig):
    tracker = rig("screwjack", *EXACT)
    tracker.ask("UNLOCK")
    assert tracker.refusal("PARAM axis1.limits -95.0:70.0") == 13
    assert tracker.refusal("PARAM axis1.drive screwjack:1:1:5:90:4000:-") == 13
