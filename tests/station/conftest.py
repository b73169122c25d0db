"""A station on an emulated tracker, in process."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.procedure import Station
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.unit.drivers.solartrak import SolarTrakUnit


class Bench:
    """One emulator, one station, one technician, one session file."""

    def __init__(
        self, folder: Path, scenario: str, settings: list[str], seed: int, noise_deg: float
    ) -> None:
        self.emulator = Emulator(load_scenario(scenario, settings), seed=seed, noise_deg=noise_deg)
        self.unit = SolarTrakUnit(lambda: InProcessLink(self.emulator))
        self.unit.open()
        emulation = self.unit.emulation
        assert emulation is not None
        self.emulation = emulation
        self.station = Station(self.unit, EmulatedClock(emulation))
        self.station.connect()
        self.folder = folder
        self.path = folder / "session.jsonl"
        self.journal = self.station.open_session(lambda h: Journal.create(self.path, h))
        self.said: list[str] = []
        self.technician = AutomaticTechnician(
            self.station,
            emulation.spot,
            Schedule(points=6),
            eye_sigma_deg=noise_deg,
            say=self.said.append,
        )

    def on_sun(self) -> None:
        """Prepared, initialised, centred, with a fresh Set Sun Offset, tracking."""
        if self.station.session.initialised is None:
            self.technician.prepare()
        assert self.technician.sight.centre()
        self.station.set_sun_offset()
        assert self.technician.sight.watch()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Callable[..., Bench]]:
    made: list[Bench] = []

    def make(
        scenario: str = "tijeras-azel",
        *settings: str,
        seed: int = 1,
        noise_deg: float = 0.02,
    ) -> Bench:
        folder = tmp_path / str(len(made))
        folder.mkdir()
        made.append(Bench(folder, scenario, list(settings), seed, noise_deg))
        return made[-1]

    yield make
    for one in made:
        one.journal.close()
        one.unit.close()
