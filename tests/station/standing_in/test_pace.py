"""The thread that keeps a unit going between commands."""

import threading

from solarcal.station.standing_in.pace import ThreadPace


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
