"""Whether an axis moves, from its read-outs alone."""

import threading

from solarcal.station.software_controller.motion import LOOK_S, START_S, MotionWatch, ThreadPace


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


class Unit:
    def __init__(self):
        self.acted = threading.Event()

    def act(self):
        self.acted.set()


def test_it_has_the_unit_act_until_it_is_ended():
    pace, unit = ThreadPace(), Unit()
    pace.begin(unit)
    assert unit.acted.wait(10.0)
    unit.acted.clear()
    assert unit.acted.wait(10.0)
    pace.end()
    pace.end()


def test_while_time_is_moved_by_somebody_else_it_only_waits():
    asked = threading.Semaphore(0)

    def speed():
        asked.release()
        return 0.0

    pace, unit = ThreadPace(speed), Unit()
    pace.begin(unit)
    for _ in range(2):
        assert asked.acquire(timeout=10.0)
    pace.end()
    assert not unit.acted.is_set()


def test_a_unit_that_nobody_uses_any_more_is_let_go():
    pace = ThreadPace()
    unit = Unit()
    acted = unit.acted
    pace.begin(unit)
    assert acted.wait(10.0)
    (thread,) = (thread for thread in threading.enumerate() if _is_of(thread, pace))
    del unit
    thread.join(10.0)
    assert not thread.is_alive()


def _is_of(thread, pace):
    target = getattr(thread, "_target", None)
    return getattr(target, "__self__", None) is pace
