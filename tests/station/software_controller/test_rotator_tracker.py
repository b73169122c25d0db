"""A rotator commanded by the station in the place of a controller."""

import msgspec
import pytest
from rotator_bench import RotatorBench

from solarcal.errors import ConfigurationError, LinkError, ProcedureRefused, UnitRefused
from solarcal.model.evidence.unit_state import check_unit_sun
from solarcal.mount.drive import RotaryDrive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits
from solarcal.station.software_controller.coefficient_store import FileStore
from solarcal.unit.frames import Code
from solarcal.unit.tracker import ROTATOR, Mode

P = Coefficients(0.2, -0.3, 0.5, 0.2, 0.0007, 0.0)


# -- connecting --------------------------------------------------------------------------------


def test_nothing_moves_because_it_was_connected():
    bench = RotatorBench()
    tracker = bench.tracker
    identity = tracker.open()
    stood = bench.reading()
    status = bench.wait(600.0)
    assert (identity.model, identity.serial) == ("Emulated Rotator", "0001")
    assert status.mode is Mode.MANUAL
    assert bench.reading() == stood
    assert bench.cable.motions() == []


def test_read_outs_are_the_rotators_own_and_counts_their_nominal_ones():
    bench = RotatorBench(reference1_deg=100.0, reference2_deg=80.0, drive1="rotary:250")
    status = bench.open().status()
    azimuth, elevation = bench.rotator.stands_deg()
    assert (status.reading1_deg, status.reading2_deg) == pytest.approx(
        (180.0 - azimuth, 90.0 - elevation), abs=0.0051
    )
    assert status.counts1 == round((status.reading1_deg - 100.0) * 250.0)
    assert status.counts2 == round((status.reading2_deg - 80.0) * 100.0)
    parameters = bench.tracker.parameters()
    assert parameters.drive1 == RotaryDrive(250.0)
    assert parameters.limits.axis1 == AxisLimits(-128.0, 128.0)
    assert not bench.tracker.capabilities.has_switches
    assert bench.tracker.capabilities == msgspec.structs.replace(ROTATOR, emulated=True)


def test_its_sun_is_a_solartraks():
    bench = RotatorBench()
    status = bench.open().status()
    unit, utc_s = bench.tracker.site(), status.unit_utc_s
    ideal_deg = (status.ideal1_deg, status.ideal2_deg)
    sun = check_unit_sun(unit, unit.site, utc_s, ideal_deg, utc_s)
    assert sun.agrees


def test_another_mount_than_azel_cannot_be_driven():
    with pytest.raises(ConfigurationError, match="a polar mount cannot be driven by it"):
        RotatorBench(geometry="polar").tracker.open()


def test_two_stations_do_not_drive_one_rotator(tmp_path):
    first = RotatorBench(store=FileStore(tmp_path / "rotor.toml"))
    second = RotatorBench(store=FileStore(tmp_path / "rotor.toml"))
    first.open()
    first.open()
    with pytest.raises(ProcedureRefused, match="rotor is driven by another program") as caught:
        second.tracker.open()
    assert "two stations must not move one unit" in str(caught.value)
    first.tracker.close()
    second.tracker.open()
    second.tracker.close()


# -- jogging -----------------------------------------------------------------------------------


def test_a_jog_goes_there_and_ends_in_manual():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.jog(110.5, 74.25)
    status = bench.wait(1.0)
    assert (status.mode, status.moving) == (Mode.JOG, (-1, -1))
    status = bench.wait(3.5)
    assert (status.mode, status.moving) == (Mode.MANUAL, (0, 0))
    assert (status.reading1_deg, status.reading2_deg) == pytest.approx((110.5, 74.25), abs=0.011)
    assert status.approach == (-1, -1)


def test_a_rotator_under_way_is_looked_at_twice_a_second():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.jog(60.0, 76.0)
    bench.cable.sent.clear()
    bench.clock.wait(4.0)
    assert 7 <= bench.cable.sent.count("+\\get_pos") <= 9


def test_a_jog_that_is_not_renewed_is_stopped_after_five_seconds():
    bench = RotatorBench()
    bench.open().jog(60.0, 76.0)
    bench.clock.wait(4.9)
    assert bench.cable.motions() == ["+\\set_pos 120.000000 14.000000"]
    bench.clock.wait(0.2)
    assert bench.cable.motions() == ["+\\stop"]
    first = bench.wait(1.0)
    assert first.mode is Mode.MANUAL
    assert 112.0 - 0.8 * 5.3 < first.reading1_deg < 112.0 - 0.8 * 4.9
    assert bench.wait(30.0).reading1_deg == first.reading1_deg


def test_a_jog_that_is_renewed_goes_on():
    bench = RotatorBench()
    tracker = bench.open()
    for _ in range(6):
        tracker.jog(104.0, 76.0)
        bench.clock.wait(2.0)
    assert bench.reading()[0] == pytest.approx(104.0, abs=0.011)
    assert set(bench.cable.motions()) == {"+\\set_pos 76.000000 14.000000"}


@pytest.mark.parametrize("target", [(128.5, 70.0), (100.0, 1.5), (-129.0, 70.0), (100.0, 88.1)])
def test_no_target_beyond_a_limit_goes_out(target):
    bench = RotatorBench()
    with pytest.raises(UnitRefused, match="is beyond") as caught:
        bench.open().jog(*target)
    assert caught.value.code == Code.BEYOND_LIMIT
    assert bench.cable.motions() == []


def test_a_described_limit_holds_where_the_rotator_could_go_further():
    bench = RotatorBench(limits1_deg=(-100.0, 100.0))
    with pytest.raises(UnitRefused, match=r"axis 1: 110.000 is beyond -100..100"):
        bench.open().jog(110.0, 70.0)


# -- STOP --------------------------------------------------------------------------------------


def test_stop_ends_everything_and_a_renewed_jog_does_not_undo_it():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.jog(60.0, 76.0)
    bench.clock.wait(1.0)
    tracker.stop()
    bench.cable.motions()
    with pytest.raises(UnitRefused, match="stopped") as caught:
        tracker.jog(60.0, 76.0)
    assert caught.value.code == Code.STOPPED
    status = bench.wait(60.0)
    assert (status.mode, status.moving) == (Mode.STOP, (0, 0))
    assert bench.cable.motions() == []


def test_stop_while_tracking_ends_the_tracking():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    bench.clock.wait(200.0)
    tracker.stop()
    bench.cable.motions()
    stood = bench.reading()
    assert bench.wait(1800.0).mode is Mode.STOP
    assert bench.reading() == stood
    assert bench.cable.motions() == []


def test_stow_is_the_rotators_own_parking():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    tracker.stow()
    assert bench.cable.motions()[-1] == "+\\park"
    status = bench.wait(300.0)
    assert status.mode is Mode.STOW
    assert (status.reading1_deg, status.reading2_deg) == pytest.approx((0.0, 5.0), abs=0.011)


# -- tracking ----------------------------------------------------------------------------------


def test_it_follows_the_sun_in_steps_of_the_update_range():
    bench = RotatorBench(update_range_deg=0.2)
    tracker = bench.open()
    tracker.write_coefficients(P, Offsets(0.05, -0.03))
    tracker.set_mode(Mode.TRACK)
    bench.clock.wait(200.0)
    bench.cable.motions()
    off, phases = [], []
    for _ in range(180):
        status = bench.wait(10.0)
        assert status.mode is Mode.TRACK
        off.append(
            max(
                abs(status.reading1_deg - status.target1_deg),
                abs(status.reading2_deg - status.target2_deg),
            )
        )
        phases.append(status.update_phase)
    # Half the range on either side, the last digit, and what the Sun runs until it is looked at.
    assert max(off) < 0.1 + 0.01 + 0.01
    assert max(off) > 0.08
    assert min(phases) < 0.15
    assert 0.85 < max(phases) <= 1.0
    moves = bench.cable.motions()
    assert {move.split()[0] for move in moves} == {"+\\set_pos"}
    # Half an hour of morning Sun: 5 deg of axis 1 and 6 of axis 2, in steps of 0.2 deg.
    assert 45 < len(moves) < 70


def test_every_step_is_forward_of_the_sun():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    bench.clock.wait(300.0)
    for _ in range(60):
        status = bench.wait(7.0)
        assert status.approach == (-1, -1)


def test_at_a_limit_it_waits_and_goes_on_when_the_sun_is_back():
    bench = RotatorBench(start="2026-06-03T23:00:00Z", limits1_deg=(-94.0, 128.0))
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    assert bench.wait(200.0).mode is Mode.TRACK
    low = 0.0
    for _ in range(30):
        low = min(low, bench.wait(60.0).reading1_deg)
    status = tracker.status()
    assert status.mode is Mode.LIMIT
    assert -94.011 <= low < -93.0
    bench.clock.wait(20 * 3600.0)
    assert tracker.status().mode is Mode.TRACK


def test_a_laptop_clock_that_is_set_back_does_not_leave_the_sun_unfollowed(monkeypatch):
    bench = RotatorBench()
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    bench.clock.wait(200.0)
    honest = bench.clock.utc_s
    monkeypatch.setattr(bench.clock, "utc_s", lambda: honest() - 1800.0)
    tracker.act()
    status = bench.wait(60.0)
    # Whatever the time is, the axes are where a unit with this clock believes the Sun.
    assert status.reading_deg == pytest.approx((status.target1_deg, status.target2_deg), abs=0.1)


def test_no_tracking_is_begun_at_night():
    bench = RotatorBench(start="2026-06-03T08:00:00Z")
    with pytest.raises(UnitRefused, match="below the horizon"):
        bench.open().set_mode(Mode.TRACK)


def test_new_coefficients_move_the_axes_at_once():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    before = bench.wait(300.0)
    tracker.write_coefficients(Coefficients(P2=1.0, P4=-0.5), Offsets())
    after = bench.wait(5.0)
    assert after.reading1_deg - before.reading1_deg == pytest.approx(1.0, abs=0.2)
    assert after.reading2_deg - before.reading2_deg == pytest.approx(-0.5, abs=0.2)


# -- Set Sun Offset, P and O -------------------------------------------------------------------


def test_set_sun_offset_takes_the_stand_as_the_suns():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.write_coefficients(P, Offsets())
    tracker.jog(109.0, 73.0)
    bench.clock.wait(4.8)
    status = tracker.set_sun_offset()
    assert (status.target1_deg, status.target2_deg) == pytest.approx(
        (status.reading1_deg, status.reading2_deg), abs=2e-6
    )
    assert tracker.stored().offsets == status.offsets


def test_no_sun_offset_while_an_axis_moves():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.jog(100.0, 70.0)
    bench.clock.wait(1.0)
    with pytest.raises(UnitRefused, match="moving"):
        tracker.set_sun_offset()


def test_p_and_o_are_kept_through_a_restart_of_the_program(tmp_path):
    store = FileStore(tmp_path / "rotor.toml")
    first = RotatorBench(store=store)
    first.open().write_coefficients(P, Offsets(0.01, 0.02))
    first.tracker.close()
    again = RotatorBench(store=FileStore(store.path))
    stored = again.open().stored()
    assert (stored.coefficients, stored.offsets) == (P, Offsets(0.01, 0.02))
    again.tracker.close()


# -- the reference check -----------------------------------------------------------------------


def test_a_reference_check_goes_to_the_reference_position_and_says_how_far_it_is():
    bench = RotatorBench(reference1_deg=100.0, reference2_deg=70.0)
    tracker = bench.open()
    assert (tracker.ref_check_result().number, tracker.ref_check_result().running) == (0, False)
    tracker.start_ref_check()
    assert tracker.status().mode is Mode.REF
    assert tracker.ref_check_result().running
    with pytest.raises(UnitRefused, match="busy"):
        tracker.jog(90.0, 70.0)
    assert bench.wait(30.0).mode is Mode.MANUAL
    result = tracker.ref_check_result()
    assert (result.number, result.complete, result.running) == (1, True, False)
    assert abs(result.difference1) <= 1
    assert abs(result.difference2) <= 1
    # It stands there already: that is found out as well.
    tracker.start_ref_check()
    assert bench.wait(2.0).mode is Mode.MANUAL
    assert tracker.ref_check_result().number == 2
    assert tracker.ref_check_result().complete


def test_a_check_that_does_not_get_there_is_not_complete():
    bench = RotatorBench(reference1_deg=0.0, reference2_deg=70.0)
    tracker = bench.open()
    tracker.start_ref_check()
    bench.clock.wait(5.0)
    # A fuse: the motors stand, whatever they are told.
    for axis in bench.rotator._axes:
        axis.stop(bench.rotator.now_s())
    bench.clock.wait(10.0)
    result = tracker.ref_check_result()
    assert (result.number, result.complete, result.running) == (1, False, False)
    assert result.difference1 > 9000


@pytest.mark.parametrize(("off_deg", "complete"), [(0.6, True), (1.4, False)])
def test_a_check_gets_there_to_within_a_degree(off_deg, complete):
    bench = RotatorBench(reference1_deg=100.0, reference2_deg=70.0)
    tracker = bench.open()
    tracker.start_ref_check()
    bench.wait(30.0)
    tracker.jog(100.0 + off_deg, 70.0)
    bench.wait(4.0)
    tracker.start_ref_check()
    for axis in bench.rotator._axes:
        axis.stop(bench.rotator.now_s())
    bench.clock.wait(10.0)
    assert tracker.ref_check_result().complete is complete
    assert bench.reading()[0] == pytest.approx(100.0 + off_deg, abs=0.2)


def test_a_check_that_was_stopped_is_not_complete():
    bench = RotatorBench(reference1_deg=0.0)
    tracker = bench.open()
    tracker.start_ref_check()
    bench.clock.wait(2.0)
    tracker.stop()
    result = tracker.ref_check_result()
    assert (result.complete, result.running) == (False, False)
    # Broken off before a switch was reached: no difference was measured.
    assert (result.difference1, result.difference2) == (0, 0)


# -- clock and line ----------------------------------------------------------------------------


def test_its_clock_is_the_laptops_corrected_by_a_time_tick():
    bench = RotatorBench()
    tracker = bench.open()
    assert tracker.status().unit_utc_s == pytest.approx(bench.clock.utc_s(), abs=1e-6)
    tracker.set_clock(bench.clock.utc_s() + 3.0)
    assert tracker.status().unit_utc_s == pytest.approx(bench.clock.utc_s() + 3.0, abs=1e-6)
    bench.open()
    assert tracker.status().unit_utc_s == pytest.approx(bench.clock.utc_s() + 3.0, abs=1e-6)


def test_after_a_lost_line_it_is_stopped_first_and_moves_only_when_told():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.set_mode(Mode.TRACK)
    bench.clock.wait(5.0)
    bench.cable.pulled = True
    with pytest.raises(LinkError):
        tracker.status()
    bench.clock.wait(20.0)
    with pytest.raises(LinkError):
        tracker.open()
    bench.cable.pulled = False
    bench.cable.motions()
    tracker.open()
    assert bench.cable.motions() == ["+\\stop"]
    assert bench.wait(600.0).mode is Mode.MANUAL
    assert bench.cable.motions() == []
    tracker.set_mode(Mode.TRACK)
    assert bench.wait(300.0).mode is Mode.TRACK


def test_a_stop_that_could_not_be_sent_is_the_first_thing_on_the_new_line():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.jog(60.0, 76.0)
    bench.cable.pulled = True
    with pytest.raises(LinkError):
        tracker.stop()
    bench.cable.pulled = False
    bench.cable.motions()
    tracker.open()
    assert bench.cable.motions() == ["+\\stop"]


def test_leaving_ends_a_jog_and_leaves_a_rotator_that_stands_alone():
    bench = RotatorBench()
    tracker = bench.open()
    tracker.close()
    assert bench.cable.motions() == []
    tracker = bench.open()
    tracker.jog(60.0, 76.0)
    bench.cable.motions()
    tracker.close()
    assert bench.cable.motions() == ["+\\stop"]
    with pytest.raises(LinkError, match="connect first"):
        tracker.status()


def test_a_silent_rotator_is_a_lost_line():
    bench = RotatorBench()
    tracker = bench.open()
    bench.world.fault("mute")
    with pytest.raises(LinkError, match="no answer from rotctld"):
        tracker.status()
    bench.world.fault("none")
    tracker.open()
    assert tracker.status().mode is Mode.MANUAL
