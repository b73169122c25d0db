"""Set Sun Offset by hand: aims that follow the Sun, and which side an axis came from."""

import math
from itertools import pairwise

import msgspec
import pytest
from emulated_station import emulated_station

from solarcal.errors import ProcedureRefused
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import MountGeometry
from solarcal.site import Site
from solarcal.station.jogging import (
    STEPS_DEG,
    TAKEN_UP_DEG,
    ApproachWatch,
    JogView,
    SunOffsetJog,
)
from solarcal.station.procedure import Station
from solarcal.station.question_evidence import question_evidence
from solarcal.station.sun_path import forward_sense, sun_rates_deg_per_s
from solarcal.unit.tracker import Mode, Spot


def renew(jog: SunOffsetJog, seconds: float) -> JogView:
    """What the screen does: look, and renew, every second."""
    for _ in range(int(seconds)):
        jog.station.clock.wait(1.0)
        view = jog.look()
    return view


def on_sky(station: Station, spot: Spot) -> float:
    zenith = math.radians(station.poll().ideal2_deg)
    return math.hypot(spot.error1_deg * math.sin(zenith), spot.error2_deg)


def looked(jog: SunOffsetJog, looks: int = 40) -> Spot:
    """The mean of many looks, in one instant."""
    emulation = jog.station.tracker.emulation
    assert emulation is not None
    spots = [emulation.spot() for _ in range(looks)]
    return Spot(
        all(s.visible for s in spots),
        sum(s.error1_deg for s in spots) / looks,
        sum(s.error2_deg for s in spots) / looks,
    )


def test_the_unit_computes_the_sun_moving_a_quarter_of_a_degree_a_minute() -> None:
    """Near the equator's horizon at the equinox: 15 deg an hour straight up, none in azimuth."""
    geometry = MountGeometry("azel", 0.0)
    rate1, rate2 = sun_rates_deg_per_s(geometry, Site(0.0, 0.0, 0.0), 1_774_000_800.0)
    assert rate2 == pytest.approx(-15.0 / 3600.0, rel=0.01)
    assert abs(rate1) < 1e-4


def test_forward_is_the_suns_way_or_the_last_one_where_the_sun_stands() -> None:
    assert forward_sense(-0.004, 1) == -1
    assert forward_sense(0.004, -1) == 1
    assert forward_sense(1e-6, -1) == -1
    assert forward_sense(0.0, 0) == 1


def test_the_steps_go_from_a_last_digit_to_a_degree_each_about_twice_the_one_before() -> None:
    assert (STEPS_DEG[0], STEPS_DEG[-1]) == (0.005, 1.0)
    for smaller, larger in pairwise(STEPS_DEG):
        assert 1.99 < larger / smaller < 2.51


def test_nothing_moves_before_the_first_arrow_key() -> None:
    station, _ = emulated_station()
    jog = SunOffsetJog(station)
    view = renew(jog, 20)
    assert view.status.mode is Mode.TRACK
    assert view.target_deg is None
    assert not jog.jogging
    assert jog.leave() is False


def test_an_axis_that_tracking_brought_came_from_behind() -> None:
    station, _ = emulated_station()
    jog = SunOffsetJog(station)
    assert jog.look().watch.from_behind == (True, True)
    with pytest.raises(ProcedureRefused, match="both axes already came from behind"):
        jog.go_behind()


def test_a_step_back_makes_the_axis_unfit_until_it_has_come_forward_far_enough() -> None:
    station, _ = emulated_station()
    jog = SunOffsetJog(station)
    jog.look()
    back = jog.look().senses[0] * -0.1
    jog.nudge(back, 0.0)
    view = renew(jog, 5)
    assert view.watch.from_behind == (False, True)
    jog.nudge(-back + 0.01 * view.senses[0], 0.0)
    view = renew(jog, 5)
    assert view.watch.forward_deg[0] < TAKEN_UP_DEG
    assert view.watch.from_behind[0] is False
    # The unit itself saw it move forward last: the record and question 2 say what was seen here.
    record = jog.set_here()
    assert record.approach[0] == view.senses[0]
    assert record.slack_axes == (1,)
    assert jog.look().watch.from_behind == (False, True)
    station.poll()
    said = question_evidence(1, station.session, station.state.live)
    told = [fact.sentence for fact in said if fact.against]
    assert told == ["Axis 1 came forward by less than 0.3 deg: its backlash may be in the error."]
    assert "Axis 2 came from behind the Sun." in [fact.sentence for fact in said]
    jog.look()
    jog.nudge(-0.2 * view.senses[0], 0.0)
    renew(jog, 5)
    jog.go_behind()
    renew(jog, 12)
    assert jog.set_here().slack_axes == ()


def test_going_behind_ends_on_the_same_aim_from_the_right_side() -> None:
    station, _ = emulated_station("backlash")
    jog = SunOffsetJog(station)
    sense = jog.look().senses[0]
    jog.nudge(-0.2 * sense, 0.0)
    wanted = renew(jog, 5).aim
    assert wanted is not None
    jog.go_behind()
    view = renew(jog, 12)
    assert view.watch.from_behind[0]
    assert view.aim is not None
    assert view.aim.behind == (False, False)
    assert view.status.reading1_deg - view.status.ideal1_deg == pytest.approx(
        wanted.wanted_deg[0], abs=0.01
    )


def test_a_followed_aim_keeps_the_spot_where_it_is() -> None:
    """A minute, in which the Sun moves a quarter of a degree."""
    station, _ = emulated_station("tijeras-azel", "truth.noise_deg=0.0")
    jog = SunOffsetJog(station)
    jog.nudge(0.0, 0.01)
    before = renew(jog, 6).spot
    after = renew(jog, 60).spot
    assert before is not None
    assert after is not None
    assert after.error1_deg == pytest.approx(before.error1_deg, abs=0.02)
    assert after.error2_deg == pytest.approx(before.error2_deg, abs=0.02)


def test_a_look_that_comes_late_does_not_send_a_followed_axis_backward() -> None:
    """The next looks are early again; the target that was sent for a late one lies before them."""
    station, _ = emulated_station("tijeras-azel", "truth.noise_deg=0.0")
    jog = SunOffsetJog(station)
    jog.look()
    jog.nudge(0.0, 0.01)
    renew(jog, 6)
    jog.go_behind()
    assert all(renew(jog, 20).watch.from_behind)
    for seconds in (4.0, 1.0, 0.5, 0.1, 0.1, 4.5, 0.5, 1.0, 1.0, 1.0):
        station.clock.wait(seconds)
        view = jog.look()
        assert all(view.watch.from_behind)
    assert view.status.off_ideal_deg == pytest.approx(view.aim.wanted_deg, abs=0.02)
    # A step back is still a step back.
    jog.nudge(-0.05 * view.senses[0], 0.0)
    assert renew(jog, 3).watch.from_behind == (False, True)


def test_a_standing_aim_lets_the_sun_go_by() -> None:
    station, _ = emulated_station()
    stood1_deg, stood2_deg = station.poll().reading_deg
    jog = SunOffsetJog(station, follows=False)
    jog.nudge(0.0, 0.02)
    first = renew(jog, 6).status
    view = renew(jog, 60)
    later = view.status
    assert view.target_deg == pytest.approx((stood1_deg, stood2_deg + 0.02), abs=0.02)
    assert (later.reading1_deg, later.reading2_deg) == (first.reading1_deg, first.reading2_deg)
    assert abs(later.ideal1_deg - first.ideal1_deg) > 0.1
    # Told to follow, it keeps its distance from the Sun as it is now.
    followed = jog.follow(True).aim
    assert followed is not None
    assert followed.follows
    assert followed.wanted_deg == pytest.approx(later.off_ideal_deg, abs=0.01)


def test_to_follow_or_to_stand_is_no_aim_yet() -> None:
    station, _ = emulated_station()
    jog = SunOffsetJog(station)
    assert jog.follow(False).aim is None
    assert jog.follow(True).aim is None


def test_setting_leaves_the_offset_the_spot_asked_for_and_the_unit_tracking() -> None:
    """Centred by the spot with slack in both axes: what is left is less than a hundredth."""
    station, _ = emulated_station("backlash", "truth.noise_deg=0.0")
    jog = SunOffsetJog(station)
    view = jog.look()
    for _ in range(4):
        spot = view.spot
        assert spot is not None
        jog.nudge(spot.error1_deg, spot.error2_deg)
        view = renew(jog, 8)
        if not all(view.watch.from_behind):
            jog.go_behind()
            view = renew(jog, 16)
    record = jog.set_here()
    assert on_sky(station, looked(jog)) < 0.01
    assert station.poll().mode is Mode.TRACK
    assert station.session.sun_offsets == (record,)
    assert record.approach == view.senses
    assert not jog.jogging


def test_a_spot_that_is_centred_already_is_set_without_a_jog() -> None:
    station, _ = emulated_station()
    record = SunOffsetJog(station).set_here()
    assert station.session.sun_offsets == (record,)
    assert station.poll().mode is Mode.TRACK


def test_a_wrong_offset_is_taken_back_and_no_point_is_taken_on_it() -> None:
    station, _ = emulated_station()
    first = SunOffsetJog(station).set_here().offsets
    before = station.tracker.stored()
    jog = SunOffsetJog(station)
    jog.nudge(0.5, -0.3)
    renew(jog, 4)
    wrong = jog.set_here()
    assert wrong.offsets != first
    assert station.replaced_offsets == first
    jog.nudge(0.1, 0.0)
    void = jog.take_back()
    assert void.voids == wrong.seq
    assert "taken back" in void.reason
    assert station.tracker.stored() == before
    assert station.session.fresh_sun_offset is not None
    assert station.session.fresh_sun_offset.offsets == first
    assert not jog.jogging
    # One step further back: to what the unit was found with.
    jog.take_back()
    assert station.poll().offsets == Offsets()
    assert station.session.fresh_sun_offset is None
    with pytest.raises(ProcedureRefused, match="no Set Sun Offset to take back"):
        jog.take_back()


def test_offsets_that_the_unit_no_longer_holds_are_not_taken_back() -> None:
    station, _ = emulated_station()
    SunOffsetJog(station).set_here()
    at_the_unit = Offsets(0.2, 0.1)
    station.tracker.write_coefficients(Coefficients(), at_the_unit)
    with pytest.raises(ProcedureRefused, match="holds other offsets"):
        station.take_back_sun_offset()
    assert station.poll().offsets == at_the_unit
    assert len(station.session.sun_offsets) == 1


def test_leaving_writes_nothing_and_lets_a_unit_that_tracked_track_again() -> None:
    station, _ = emulated_station()
    before = station.poll().offsets
    jog = SunOffsetJog(station)
    jog.look()
    jog.nudge(0.3, 0.0)
    renew(jog, 4)
    assert jog.leave() is True
    status = station.poll()
    assert status.mode is Mode.TRACK
    assert status.offsets == before
    assert station.session.sun_offsets == ()


def test_a_stop_ends_the_jog_and_leaving_does_not_move_it_again() -> None:
    station, _ = emulated_station()
    jog = SunOffsetJog(station)
    jog.look()
    jog.nudge(1.0, 0.0)
    station.stop()
    view = renew(jog, 3)
    assert not jog.jogging
    assert view.status.moving == (0, 0)
    with pytest.raises(ProcedureRefused, match="STOP"):
        jog.nudge(0.1, 0.0)
    jog.leave()
    assert station.poll().mode is Mode.STOP


def test_an_aim_beyond_a_limit_is_refused_and_forgotten() -> None:
    station, _ = emulated_station()
    jog = SunOffsetJog(station)
    jog.nudge(0.01, 0.0)
    aim = jog.look().aim
    with pytest.raises(ProcedureRefused, match="beyond a limit"):
        jog.nudge(300.0, 0.0)
    assert jog.look().aim == aim


def test_the_watch_counts_forward_travel_only() -> None:
    station, _ = emulated_station()
    status = station.poll()
    before = (status.reading1_deg - 0.2, status.reading2_deg + 0.2)
    watch = ApproachWatch(before, (0.2, 0.2), (1, 1))
    seen = watch.seen(status, (1, 1))
    assert seen.forward_deg == (pytest.approx(0.4), 0.0)
    assert seen.from_behind == (True, False)
    # The way that was backward is forward now: what counts is the motion that ended.
    down = msgspec.structs.replace(status, approach=(1, -1))
    assert watch.seen(down, (1, -1)).from_behind == (True, True)
    assert (
        watch.seen(msgspec.structs.replace(down, approach=(1, 1)), (1, -1)).from_behind[1] is False
    )


def test_an_axis_in_which_the_sun_stands_came_the_way_the_unit_drove_it() -> None:
    """Polar: the unit drives 6 deg downwards onto a Sun that stands in axis 2."""
    station, _ = emulated_station("polar")
    station.ref_check()
    jog = SunOffsetJog(station)
    jog.look()
    jog.track()
    renew(jog, 60)
    assert jog.set_here().slack_axes == ()


def test_where_the_sun_stands_in_an_axis_going_behind_ends() -> None:
    """Polar distance, 1e-6 deg/s: the way behind must not turn the side it is then behind of."""
    station, _ = emulated_station("polar")
    jog = SunOffsetJog(station)
    view = jog.look()
    assert abs(view.rates_deg_per_s[1]) < 2e-5
    jog.go_to((0.3, 0.2))
    view = renew(jog, 120)
    assert view.aim is not None
    assert view.aim.behind == (False, False)
    assert view.watch.from_behind == (True, True)
    off1, off2 = (
        view.status.reading1_deg - view.status.ideal1_deg,
        view.status.reading2_deg - view.status.ideal2_deg,
    )
    assert off1 == pytest.approx(0.3, abs=0.005)
    assert off2 == pytest.approx(0.2, abs=0.005)


def test_where_the_sun_stands_in_an_axis_one_way_behind_takes_up_both() -> None:
    """The axis came the way the unit drove it, which is not the way of what little the Sun moves:
    both go behind, at once."""
    station, _ = emulated_station("polar", start="2026-07-10T16:00:00Z")
    jog = SunOffsetJog(station)
    assert jog.look().watch.from_behind == (True, True)
    jog.nudge(-0.5 * jog.look().senses[0], 0.0)
    assert renew(jog, 10).watch.from_behind == (False, True)
    view = jog.go_behind()
    assert view.aim is not None
    assert view.aim.behind == (True, True)
    view = renew(jog, 40)
    assert view.watch.from_behind == (True, True)
    assert view.aim.behind == (False, False)


def test_at_a_limit_nothing_is_set() -> None:
    """The axes stand where they may go no farther, not on the Sun."""
    station, _ = emulated_station(start="2026-06-04T01:40:00Z")
    station.clock.wait(1200.0)
    assert station.poll().mode is Mode.LIMIT
    stored = station.tracker.stored()
    jog = SunOffsetJog(station)
    with pytest.raises(ProcedureRefused, match="waits at an axis limit"):
        jog.set_here()
    assert station.tracker.stored() == stored
    assert not station.session.sun_offsets
