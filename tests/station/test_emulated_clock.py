"""The clock of an emulated unit: by leaps at speed 0, really waiting at any other speed."""

import itertools
from typing import cast

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.errors import LinkError, UnitRefused
from solarcal.station.clocks import EmulatedClock
from solarcal.timescale import SystemClock
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Emulation


def emulated(speed: float) -> tuple[SolarTrakUnit, Emulation]:
    """An open unit; a hundredth of a real second passes every time the emulator looks."""
    ticks = itertools.count()
    emulator = Emulator(
        load_scenario("tijeras-azel", []), speed=speed, monotonic=lambda: 0.01 * next(ticks)
    )
    unit = SolarTrakUnit(lambda: InProcessLink(emulator))
    unit.open()
    emulation = unit.emulation
    assert emulation is not None
    return unit, emulation


def test_at_speed_zero_time_moves_only_by_waiting_and_exactly_so() -> None:
    _, emulation = emulated(0.0)
    clock = EmulatedClock(emulation)
    before = clock.utc_s()
    assert clock.utc_s() == before
    clock.wait(123.4567)
    assert clock.utc_s() - before == pytest.approx(123.457, abs=1e-6)


def test_a_paced_emulator_is_never_advanced_but_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    _, emulation = emulated(50_000.0)
    monkeypatch.setattr(type(emulation), "advance", lambda *_: pytest.fail("advanced"))
    clock = EmulatedClock(emulation)
    before = clock.utc_s()
    clock.wait(2_000.0)
    assert clock.utc_s() - before >= 2_000.0


def test_a_silent_emulator_is_not_waited_for_twice_in_a_row() -> None:
    """A lost line is recorded and shown after one wait; then it is asked anew."""
    now_s, asked = 0.0, 0

    class Silent:
        def time(self) -> tuple[float, float]:
            nonlocal now_s, asked
            now_s += 4.5
            asked += 1
            raise LinkError("no answer")

    class Laptop:
        def utc_s(self) -> float:
            return now_s

    clock = EmulatedClock(cast(Emulation, Silent()))
    clock._real = cast(SystemClock, Laptop())
    assert [clock.utc_s() for _ in range(3)] == [0.0] * 3
    assert asked == 1
    now_s += 1.0
    clock.utc_s()
    assert asked == 2


def test_the_speed_can_be_changed_and_asked_for() -> None:
    _, emulation = emulated(0.0)
    assert emulation.speed() == 0.0
    assert emulation.set_speed(2.5) == 2.5
    assert emulation.speed() == 2.5
    first = emulation.time()[0]
    assert emulation.time()[0] > first
    emulation.set_speed(0.0)
    assert emulation.time() == emulation.time()


def test_a_new_speed_does_not_reach_back() -> None:
    """The real time before the change counts at the old speed."""
    _, emulation = emulated(0.0)
    before = emulation.time()[0]
    emulation.set_speed(10.0)
    # Looks of the emulator since: the change itself, and this one; a hundredth of a second each.
    assert emulation.time()[0] - before == pytest.approx(0.1, abs=0.21)


def test_a_speed_beyond_reason_is_refused() -> None:
    _, emulation = emulated(0.0)
    with pytest.raises(UnitRefused, match="speed"):
        emulation.set_speed(2e6)


def test_a_wait_ends_when_the_emulator_is_stopped_meanwhile(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Somebody sets speed 0 during a wait: the rest is advanced instead of waited for ever."""
    _, emulation = emulated(1_000.0)
    clock = EmulatedClock(emulation)
    before = clock.utc_s()
    speeds = iter([1_000.0, 0.0])
    monkeypatch.setattr(type(emulation), "speed", lambda _: next(speeds))
    clock.wait(40_000.0)
    assert clock.utc_s() - before >= 40_000.0


def test_a_line_that_is_gone_ends_a_wait_but_still_tells_the_last_time() -> None:
    unit, emulation = emulated(0.0)
    clock = EmulatedClock(emulation)
    told = clock.utc_s()
    unit.close()
    assert clock.utc_s() == told
    with pytest.raises(LinkError):
        clock.wait(1.0)
