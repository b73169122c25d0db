"""An emulated rotator commanded by the station, on a cable that can be pulled."""

from solarcal.emulator.rotator import EmulatedRotator, RotatorWorld
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.errors import LinkError
from solarcal.profiles import MountDescription
from solarcal.station.clocks import EmulatedClock
from solarcal.station.software_controller.coefficient_store import MemoryStore
from solarcal.station.software_controller.motion import ThreadPace
from solarcal.station.software_controller.rotator_tracker import RotatorTracker
from solarcal.unit.drivers.rotctld import RotctldRotator

MORNING = "2026-06-03T16:00:00Z"


class Cable:
    """Every request that went through, and a way to cut it."""

    def __init__(self, rotator):
        self.rotator = rotator
        self.pulled = False
        self.sent = []

    def open(self):
        if self.pulled:
            raise LinkError("no answer from the emulated rotator")
        return _Link(self)

    def motions(self):
        """Requests that move or stop, since the last time this was asked."""
        moves = [line for line in self.sent if not line.startswith(("+\\get", "+\\dump"))]
        self.sent.clear()
        return moves


class _Link(InProcessLink):
    def __init__(self, cable):
        super().__init__(cable.rotator)
        self._cable = cable

    def write(self, data):
        if self._cable.pulled:
            raise LinkError("the line to the emulated rotator was lost")
        self._cable.sent.append(data.decode().strip())
        super().write(data)


class RotatorBench:
    def __init__(
        self, *settings, scenario="tijeras-azel", start=MORNING, store=None, rotator=None, **mount
    ):
        self.rotator = rotator or EmulatedRotator(
            load_scenario(scenario, [f"start={start}", *settings]), seed=7
        )
        self.world = RotatorWorld(self.rotator)
        self.cable = Cable(self.rotator)
        self.clock = EmulatedClock(self.world)
        kept = store or MemoryStore()
        unit = self.rotator.scenario.unit
        described = {"ax1_centre_deg": unit.ax1_centre_deg, "update_range_deg": 0.1, **mount}
        self.tracker = RotatorTracker(
            RotctldRotator(self.cable.open, "the emulated rotator"),
            "0001",
            MountDescription(**described),
            self.rotator.scenario.site.place(),
            self.clock,
            lambda model, serial: kept,
            emulation=self.world,
            pace=ThreadPace(self.world.speed),
        )
        self.world.stand_in = self.tracker

    def open(self):
        self.tracker.open()
        self.cable.motions()
        return self.tracker

    def wait(self, seconds):
        self.clock.wait(seconds)
        return self.tracker.status()

    def reading(self):
        status = self.tracker.status()
        return status.reading1_deg, status.reading2_deg
