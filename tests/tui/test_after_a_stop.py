"""What comes after a STOP: it stands, and the way on is open and said."""

import threading

from procedure_bench import START, on_loop, shows, until, workstation

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.news import Done, StepFailed, Stopped, Tracking
from solarcal.station.procedure import Station
from solarcal.station.worker import StationWorker
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Mode


class Asked(Done[object], name="asked"): ...


def morning() -> Station:
    """A unit just switched on: no reference check yet."""
    emulator = Emulator(load_scenario("tijeras-azel", [f"start={START}"]), seed=7)
    unit = SolarTrakUnit(lambda: InProcessLink(emulator), port="test")
    unit.open()
    assert unit.emulation is not None
    station = Station(unit, EmulatedClock(unit.emulation))
    station.connect()
    station.open_session(Journal.memory)
    station.poll()
    return station


@on_loop
async def test_stopped_before_the_first_reference_check_the_day_can_begin() -> None:
    station = morning()
    async with workstation(station) as (app, pilot):
        below = app.screen
        await pilot.press("s")
        await until(pilot, lambda: station.poll().mode is Mode.STOP)
        await pilot.press("f6")
        await shows(pilot, "has no reference", "reference check [F5]")
        await pilot.press("escape")
        await until(pilot, lambda: app.screen is below)
        await pilot.press("f5")
        await shows(pilot, "is stopped", "Start lets it move")
        await pilot.press("enter")
        await shows(pilot, "complete, recorded")
    assert station.session.ref_checks[-1].complete


def test_what_was_asked_for_before_a_stop_does_not_undo_it() -> None:
    station, told = morning(), []
    station.ref_check()
    worker = StationWorker(station, told.append)
    entered, go_on, all_done = threading.Event(), threading.Event(), threading.Event()

    def slow(_: Station) -> None:
        entered.set()
        go_on.wait(30.0)

    worker.submit(Asked, slow)
    worker.start()
    assert entered.wait(30.0)
    worker.submit(Tracking, lambda s: s.track(), moves=True)
    worker.submit(Asked, lambda _: all_done.set())
    worker.stop_motion()
    go_on.set()
    assert all_done.wait(30.0)
    worker.close()
    assert station.poll().mode is Mode.STOP
    failed = [str(message.error) for message in told if isinstance(message, StepFailed)]
    assert failed == ["track: not done, STOP was pressed"]


def test_a_stop_that_passes_a_command_on_the_line_has_the_last_word() -> None:
    station, told = morning(), []
    station.ref_check()
    worker = StationWorker(station, told.append)
    stopped = threading.Event()

    def tell(message: object) -> None:
        if isinstance(message, Stopped):
            stopped.set()

    worker._post = tell

    def passed(s: Station) -> None:
        worker.stop_motion()
        assert stopped.wait(30.0)
        s.track()

    worker.submit(Tracking, passed, moves=True)
    all_done = threading.Event()
    worker.submit(Asked, lambda _: all_done.set())
    worker.start()
    assert all_done.wait(30.0)
    worker.close()
    assert station.poll().mode is Mode.STOP
