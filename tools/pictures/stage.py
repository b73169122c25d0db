"""What a picture needs before it can be taken: a station somewhere in its day, and its screen.

Everything is seeded and virtual time stands but for the station's own waits, so that the same
version draws the same picture.
"""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

from textual.pilot import Pilot

from solarcal.config import Settings
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.errors import LinkError
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.procedure import Station
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.timescale import format_utc
from solarcal.tui.app import SolarcalApp
from solarcal.tui.palette import DEFAULT_THEME
from solarcal.tui.workstation.screen import WorkstationScreen
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.link import Link
from solarcal.unit.tracker import Emulation
from tools.pictures.screen_svg import screen_svg

SMALL, LARGE = (80, 24), (140, 45)
SCENARIO, SEED = "tijeras-azel", 1
OPERATOR = "J. Example"
TURNS, TURN_S = 1500, 0.02
"""How long something is waited for before a picture is given up."""
STILL_TURNS = 8


class Cable:
    """The line to the pictured unit; ``pulled``, it is silent."""

    def __init__(self, emulator: Emulator) -> None:
        self.emulator = emulator
        self.pulled = False

    def open(self) -> Link:
        if self.pulled:
            raise LinkError("/dev/ttyUSB0 is not there; check the cable")
        return _PullableLink(self)


class _PullableLink(InProcessLink):
    def __init__(self, cable: Cable) -> None:
        super().__init__(cable.emulator)
        self._cable = cable

    def write(self, data: bytes) -> None:
        if self._cable.pulled:
            raise LinkError("the line to /dev/ttyUSB0 was lost; check the cable and the unit")
        super().write(data)


class _PicturedUnit(SolarTrakUnit):
    """A unit that can be told not to let the screens know that it is an emulator."""

    real = False

    @property
    def emulation(self) -> Emulation | None:
        return None if self.real else super().emulation


class Day:
    """A station on the emulated tracker, taken through its day; its file in ``folder``.

    ``real``: the screens are to take the unit for a real one.
    """

    def __init__(
        self, folder: Path, start: str = "", *, scenario: str = SCENARIO, real: bool = False
    ) -> None:
        emulator = Emulator(load_scenario(scenario, [f"start={start}"] if start else []), seed=SEED)
        self.cable = Cable(emulator)
        unit = _PicturedUnit(self.cable.open, port="/dev/ttyUSB0")
        unit.open()
        assert unit.emulation is not None  # we made it an emulator
        self.emulation = unit.emulation
        unit.real = real
        self.station = Station(unit, EmulatedClock(self.emulation), operator=OPERATOR)
        self.station.connect()
        true_utc_s, _ = self.emulation.time()
        name = f"{scenario}-{format_utc(true_utc_s, 0)[:10]}.jsonl"
        self.station.open_session(lambda header: Journal.create(folder / name, header))
        self.path = folder / name
        self.technician = AutomaticTechnician(
            self.station, self.emulation.spot, Schedule(points=12, every_min=50.0, checks=2)
        )

    def prepared(self) -> "Day":
        """Clock set, referenced, tracking."""
        self.station.set_unit_clock()
        self.station.ref_check()
        self.station.track()
        self.station.clock.wait(180.0)
        self.station.poll()
        return self

    def taken(self, points: int) -> "Day":
        """Points as a technician takes them, file initialised first."""
        if self.station.session.initialised is None:
            self.station.initialise(confirmed=True)
        for _ in range(points):
            self.technician.take_point()
            self.station.clock.wait(3000.0)
            self.station.poll()
        return self

    def offset_set(self) -> "Day":
        """On the Sun, the offset set, and watched for a minute and a half."""
        self.technician.sight.centre()
        self.station.set_sun_offset()
        self.technician.sight.watch()
        self.station.poll()
        return self

    @asynccontextmanager
    async def workstation(
        self, size: tuple[int, int] = SMALL, theme: str = DEFAULT_THEME
    ) -> AsyncIterator[Pilot[int]]:
        """The workstation at this station, its fit shown."""
        app = SolarcalApp(settings=Settings(theme=theme))
        async with app.run_test(size=size) as pilot:
            app.adopt(self.station)
            app._path = self.path
            app.push_screen(WorkstationScreen())
            session = app.state.session
            if session is not None and session.accepted:
                await until(pilot, lambda: app.fit is not None)
                await until(
                    pilot, lambda: app.state.session is not None and app.state.session.fit_recorded
                )
            await until(pilot, lambda: app.emulated_speed in (0.0, None))
            try:
                yield pilot
            finally:
                if app.worker is not None:
                    app.worker.close()


async def until(pilot: Pilot[int], true: Callable[[], object]) -> None:
    """Let the app work until that holds."""
    for _ in range(TURNS):
        if true():
            return
        await pilot.pause(TURN_S)
    raise TimeoutError(f"in vain; the screen shows:\n{text_of(pilot)}")


async def shows(pilot: Pilot[int], *words: str) -> None:
    await until(pilot, lambda: all(word in words_of(pilot) for word in words))


async def picture(pilot: Pilot[int], title: str) -> str:
    """The screen as SVG once nothing on it changes any more."""
    before, still = "", 0
    for _ in range(TURNS):
        await pilot.pause(TURN_S)
        now = text_of(pilot)
        still = still + 1 if now == before else 0
        if still == STILL_TURNS:
            break
        before = now
    app = pilot.app
    colours = app.theme_variables
    return screen_svg(
        [list(strip) for strip in app.screen._compositor.render_strips()],
        title=title,
        ink=colours["foreground"],
        paper=colours["background"],
    )


def text_of(pilot: Pilot[int]) -> str:
    """The screen's characters."""
    strips = pilot.app.screen._compositor.render_strips()
    return "\n".join("".join(segment.text for segment in strip) for strip in strips)


def words_of(pilot: Pilot[int]) -> str:
    """The same without frames and line ends, to look for sentences in."""
    text = text_of(pilot)
    for frame in "┃│╭╮╰╯─━┏┓┗┛":
        text = text.replace(frame, " ")
    return " ".join(text.split())
