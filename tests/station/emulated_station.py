"""A station on an emulated unit in this process, its session in memory."""

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.procedure import Station
from solarcal.unit.drivers.solartrak import SolarTrakUnit


def emulated_station(
    scenario: str = "tijeras-azel", *settings: str, start: str = "2026-06-03T16:00:00Z"
) -> tuple[Station, Emulator]:
    """Connected, referenced and tracking; time moves only by the station's clock."""
    emulator = Emulator(load_scenario(scenario, [f"start={start}", *settings]), seed=7)
    unit = SolarTrakUnit(lambda: InProcessLink(emulator))
    unit.open()
    emulation = unit.emulation
    assert emulation is not None
    station = Station(unit, EmulatedClock(emulation))
    station.connect()
    station.open_session(Journal.memory)
    station.ref_check()
    station.track()
    station.clock.wait(120.0)
    station.poll()
    return station, emulator
