"""A station behind a line with faults, and a technician who does not give up."""

from collections.abc import Callable
from pathlib import Path

from direct_line import OrderedLine
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.line_faults import LineFaults
from solarcal.emulator.scenario import load_scenario
from solarcal.errors import LinkError, ProcedureRefused
from solarcal.mount.formula import Coefficients
from solarcal.session.journal import Journal
from solarcal.session.records import Header
from solarcal.session.view import SessionView, read_session
from solarcal.station.centring import SunCentring
from solarcal.station.clocks import EmulatedClock
from solarcal.station.headless import Calibration, calibrate
from solarcal.station.procedure import Station
from solarcal.station.technician import Schedule
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Mode

UPLOADED = Coefficients(0.1234, -0.2345, 0.3456, 0.0123, 0.000123, -0.000234)
SCENARIO = "tijeras-azel"
MOST_TRIES = 40


def faulty_line(faults: LineFaults | None = None, seed: int = 0, *settings: str) -> OrderedLine:
    emulator = Emulator(load_scenario(SCENARIO, list(settings)), seed=3)
    return OrderedLine(emulator, faults, seed=seed)


def calibrated(line: OrderedLine, path: Path, points: int = 4) -> tuple[Calibration, bytes]:
    """The whole headless procedure over this line, and the session file it left."""
    done = calibrate(
        SolarTrakUnit(line.connect),
        lambda header: Journal.create(path, header),
        Schedule(points=points, checks=1),
        method="linear",
        # Four points may be no better than none beyond their uncertainty: not without a reason.
        force="a trial of the line",
    )
    return done, path.read_bytes()


class PersistentTechnician:
    """Takes the procedure step by step; after a lost line reconnects and goes on.

    ``trouble`` is called with the name of every step before it is tried, and may arrange for one.
    """

    def __init__(
        self,
        line: OrderedLine,
        path: Path,
        trouble: Callable[[str], None],
        create: Callable[[Path, Header], Journal] = Journal.create,
    ) -> None:
        self.line = line
        self.unit = SolarTrakUnit(line.connect)
        self.unit.open()
        emulation = self.unit.emulation
        assert emulation is not None
        self.station = Station(self.unit, EmulatedClock(emulation))
        self.station.connect()
        self.path = path
        self.station.open_session(lambda header: create(path, header))
        self.sight = SunCentring(self.station, emulation.spot, eye_sigma_deg=0.02)
        self.losses: list[str] = []
        self._trouble = trouble

    def whole_procedure(self, points: int) -> SessionView:
        station = self.station
        self.step("clock", station.set_unit_clock)
        self.step("reference check", self.reference_check)
        self.step("initialise", lambda: station.initialise(confirmed=True))
        for _ in range(points):
            self.point(check=False)
            self.step("wait", lambda: station.clock.wait(1800.0))
        self.step("upload", lambda: station.upload(UPLOADED, method="linear"))
        self.point(check=True)
        self.step("rollback", station.rollback)
        self.station.close()
        return read_session(self.path)

    def reference_check(self) -> None:
        assert self.station.ref_check().complete
        self.station.track()

    def point(self, *, check: bool) -> None:
        """One point; when the line is lost on the way, from its beginning."""
        kind = "check " if check else ""
        steps: tuple[tuple[str, Callable[[], object]], ...] = (
            ("centre", self.sight.centre),
            ("sun offset", self.station.set_sun_offset),
            ("watch", self.sight.watch),
            ("questions", lambda: self.questions(check)),
            ("gather", self.station.gather_point),
            ("store", lambda: self.station.store(True)),
        )
        for _ in range(MOST_TRIES):
            if all(self.once(kind + name, action) for name, action in steps):
                return
        raise AssertionError(f"no {kind}point in {MOST_TRIES} tries")

    def questions(self, check: bool) -> bool:
        self.station.begin_point(check=check)
        for _ in range(3):
            self.station.answer(True)
        return True

    def step(self, name: str, action: Callable[[], object]) -> None:
        while not self.once(name, action):
            pass

    def once(self, name: str, action: Callable[[], object]) -> bool:
        """Whether the step was done; after a lost line the station is connected again."""
        self._trouble(name)
        try:
            return action() is not False
        except LinkError as error:
            self.losses.append(name)
            self.station.link_lost(error)
        while True:
            try:
                self.station.reconnect()
                self.back_to_tracking()
                return False
            except LinkError as error:
                self.losses.append("reconnect")
                self.station.link_lost(error)

    def back_to_tracking(self) -> None:
        """What a technician does first when the line is back: let a check end, then track."""
        while (status := self.station.poll()).mode is Mode.REF:
            self.station.clock.wait(10.0)
        if status.referenced:
            self.station.track()


def refused(action: Callable[[], object]) -> str:
    """What a step that must not be allowed says."""
    try:
        action()
    except ProcedureRefused as refusal:
        return str(refusal)
    raise AssertionError("the step was allowed")
