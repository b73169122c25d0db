"""Whether an axis moves, from its read-outs alone."""

from solarcal.station.standing_in.motion_watch import LOOK_S, START_S, MotionWatch


def seen(*looks):
    watch = MotionWatch(0.015)
    for utc_s, reading in looks:
        watch.seen(utc_s, reading)
    return watch


def test_an_axis_that_was_looked_at_once_or_stands_is_at_rest():
    assert seen((0.0, 10.0)).moving == 0
    assert seen((0.0, 10.0), (5.0, 10.01), (9.0, 10.0)).moving == 0


def test_it_moves_until_it_has_stood_for_a_while():
    watch = seen((0.0, 10.0), (1.0, 10.5))
    assert (watch.moving, watch.approach) == (1, 0)
    watch.seen(1.0 + 0.5 * LOOK_S, 10.5)
    assert watch.moving == 1
    watch.seen(1.0 + 1.1 * LOOK_S, 10.5)
    assert (watch.moving, watch.approach) == (0, 1)


def test_creeping_is_a_motion_once_it_has_added_up():
    watch = seen((0.0, 10.0), (1.0, 9.99))
    assert watch.moving == 0
    watch.seen(2.0, 9.98)
    assert watch.moving == -1


def test_an_axis_that_was_sent_is_given_time_to_set_out():
    watch = seen((0.0, 10.0))
    watch.set_out(1.0, 12.0)
    assert watch.moving == 1
    watch.seen(1.0 + 0.9 * START_S, 10.0)
    assert watch.moving == 1
    watch.seen(1.0 + 1.1 * START_S, 10.0)
    assert watch.moving == 0


def test_an_axis_at_its_goal_is_at_rest_at_once():
    watch = seen((0.0, 10.0))
    watch.set_out(1.0, 12.0)
    watch.seen(2.5, 11.99)
    assert (watch.moving, watch.approach) == (0, 1)
    watch.set_out(3.0, 12.0)
    assert watch.moving == 0


def test_what_coasts_after_a_stop_still_moves():
    watch = seen((0.0, 10.0))
    watch.set_out(0.0, 12.0)
    watch.seen(1.0, 11.0)
    watch.halt()
    watch.seen(1.2, 11.2)
    assert watch.moving == 1
    watch.seen(2.0, 11.2)
    assert watch.moving == 0


def test_a_clock_that_was_set_back_does_not_hold_it_in_motion():
    watch = seen((1000.0, 10.0), (1001.0, 10.5))
    watch.seen(400.0, 10.5)
    assert watch.moving == 0
