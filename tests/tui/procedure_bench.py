"""The workstation on an emulated unit in this process, and ways to wait for it and to read it."""

import asyncio
import functools
import itertools
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import textual.app
from textual.events import MouseDown, MouseUp
from textual.geometry import Offset, Region
from textual.pilot import Pilot
from textual.screen import Screen

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.procedure import Station
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.tui.app import SolarcalApp
from solarcal.tui.dialogs.dialog import Dialog
from solarcal.tui.widgets.footer import KeyButton, Keys
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.link import Link

START = "2026-06-03T16:00:00Z"
SMALL, LARGE = (80, 24), (140, 45)
PATIENCE = 1000
"""Looks at the screen, some hundredths of a second apart, before a test gives up waiting."""

RESTLESS = 25
"""Looks after which the words are compared where the painting does not end."""


class Cable:
    """A line that can be pulled: then every write and read fails, and opening too."""

    def __init__(self, emulator: Emulator) -> None:
        self.emulator = emulator
        self.pulled = False

    def open(self) -> Link:
        from solarcal.errors import LinkError

        if self.pulled:
            raise LinkError("port test is not there")
        return _PullableLink(self)


class _PullableLink(InProcessLink):
    def __init__(self, cable: Cable) -> None:
        super().__init__(cable.emulator)
        self._cable = cable

    def write(self, data: bytes) -> None:
        from solarcal.errors import LinkError

        if self._cable.pulled:
            raise LinkError("the line to test was lost; check the cable and the unit's power")
        super().write(data)


def bench(path: Path | None = None, *settings: str, start: str = START) -> tuple[Station, Cable]:
    """A station whose unit is referenced and tracks; time moves only by its clock."""
    station, cable = unreferenced_bench(path, *settings, start=start)
    station.set_unit_clock()
    station.ref_check()
    station.track()
    station.clock.wait(120.0)
    station.poll()
    return station, cable


def unreferenced_bench(
    path: Path | None = None, *settings: str, start: str = START
) -> tuple[Station, Cable]:
    """The same, just switched on: before clock and reference check."""
    emulator = Emulator(load_scenario("tijeras-azel", [f"start={start}", *settings]), seed=7)
    cable = Cable(emulator)
    unit = SolarTrakUnit(cable.open, port="test")
    unit.open()
    emulation = unit.emulation
    assert emulation is not None
    station = Station(unit, EmulatedClock(emulation), operator="test")
    station.connect()
    station.open_session(
        Journal.memory if path is None else lambda header: Journal.create(path, header)
    )
    return station, cable


def take_points(station: Station, points: int, every_min: float = 45.0) -> None:
    """By the automatic technician, so that a test can begin in the middle of a day."""
    emulation = station.tracker.emulation
    assert emulation is not None
    technician = AutomaticTechnician(
        station, emulation.spot, Schedule(points=points, every_min=every_min)
    )
    if station.session.initialised is None:
        station.initialise(confirmed=True)
    technician.take_points()
    # A reference check ends the day; let the axes come back from it.
    station.clock.wait(180.0)
    station.poll()


def upload_and_check(station: Station, checks: int) -> None:
    """Uploaded by the automatic technician, and so many check points taken."""
    emulation = station.tracker.emulation
    assert emulation is not None
    technician = AutomaticTechnician(
        station, emulation.spot, Schedule(checks=checks, check_every_min=30.0)
    )
    technician.upload()
    technician.take_checks()


def offset_set(station: Station) -> None:
    """Set Sun Offset where the axes stand, and a watched minute and a half."""
    station.set_sun_offset()
    station.track()
    station.clock.wait(90.0)
    station.poll()


def plain_start(**options: Any) -> SolarcalApp:
    """The app without its start screen, which costs each test a screen and has tests of its own."""
    app = SolarcalApp(**options)
    app.get_default_screen = Screen  # type: ignore[method-assign]
    return app


@asynccontextmanager
async def workstation(
    station: Station, size: tuple[int, int] = SMALL, *, begun: bool = False
) -> AsyncIterator[tuple[SolarcalApp, Pilot[int]]]:
    """The app with this station adopted, ``begun`` on its start screen; closed again."""
    app = SolarcalApp() if begun else plain_start()
    async with app.run_test(size=size) as pilot:
        app.adopt(station)
        await pilot.pause()
        try:
            yield app, pilot
            # A key that still waits would find no screen: run_test closes them before the app.
            await textual.app.wait_for_idle()
        finally:
            if app.worker is not None:
                app.worker.close()


def on_loop(test: Callable[..., Coroutine[Any, Any, None]]) -> Callable[..., None]:
    """A test written as a coroutine, for a plain test runner."""

    @functools.wraps(test)
    def run(*args: object, **kwargs: object) -> None:
        asyncio.run(test(*args, **kwargs))

    return run


async def until(pilot: Pilot[int], true: Callable[[], object]) -> None:
    """Let the app work until that holds."""
    for _ in range(PATIENCE):
        if true():
            return
        # Looking at the screen costs more than it takes to change: not more often than needed.
        await pilot.pause(0.03)
    raise AssertionError(f"in vain; the screen shows:\n{screen_text(pilot.app)}")


async def shows(pilot: Pilot[int], *words: str) -> None:
    app, painted = pilot.app, -1

    def shown() -> bool:
        """Looked at again only when something was painted since."""
        nonlocal painted
        if painted == paints(app):
            return False
        painted = paints(app)
        shown_words = screen_words(app)
        return all(word in shown_words for word in words)

    try:
        await until(pilot, shown)
    except AssertionError:
        # What is drawn without being painted is of no use to anybody, but tells what is wrong.
        raise AssertionError(f"{words} in vain; the screen shows:\n{screen_text(app)}") from None


async def settled_text(pilot: Pilot[int], turns: int = 10) -> str:
    """The screen's text once nothing is painted any more: layout follows words by a turn.

    A dialog that a unit's answers paint again and again is at rest when its text stays.
    """
    app = pilot.app
    before, text, same = paints(app), "", 0
    for look in range(PATIENCE):
        await pilot.pause(0.02)
        now = paints(app)
        same += 1
        if now != before:
            shown = screen_text(app) if look >= RESTLESS else ""
            if not shown or shown != text:
                same = 0
            before, text = now, shown
        if same == turns:
            return screen_text(app)
    raise AssertionError(f"never at rest:\n{screen_text(app)}")


async def mouse_click(pilot: Pilot[int], place: Offset) -> None:
    """A click as the terminal sends it: the app finds out what is under it, and what it follows.

    Two of them are a double click within ``CLICK_CHAIN_TIME_THRESHOLD``.
    """
    for kind in (MouseDown, MouseUp):
        pilot.app.post_message(kind(None, *place, 0, 0, 1, False, False, False, *place))
        await pilot.pause()


async def keys_beside_each_other(pilot: Pilot[int], dialog: Dialog, offered: list[str]) -> None:
    """These and the way out and STOP, each whole, its key named in full."""
    dialog.offer(*offered)
    await pilot.pause()
    await pilot.pause()
    shown = [key for key in dialog.query(KeyButton) if key.display]
    assert len(shown) == len(offered) + 2
    for key in shown:
        assert key.region.width >= len(str(key.border_title)) + 6, key.border_title
    places = sorted((key.region for key in shown), key=lambda place: place.x)
    inside = dialog.query_one("#dialog").content_region
    assert places[0].x >= inside.x
    assert places[-1].right <= inside.right
    for left, right in itertools.pairwise(places):
        assert left.right <= right.x, type(dialog)


def target(app: SolarcalApp, label: str) -> Region:
    """Where on the screen a target of the footer or beside the tabs stands."""
    return next(
        place.translate(keys.region.offset)
        for keys in app.screen.query(Keys)
        for entry, place in keys.places()
        if entry.label == label
    )


def paints(app: object) -> int:
    """How often the app has painted its screen, all of it or a part; counted by conftest."""
    return getattr(app, "paints", 0)


def screen_text(app: object) -> str:
    """What the terminal would show, line by line, without colours."""
    screen = app.screen  # type: ignore[attr-defined]
    width, height = screen.size
    lines = [
        "".join(segment.text for segment in strip).rstrip()
        for strip in screen._compositor.render_strips()
    ]
    del width
    return "\n".join(lines[:height])


def screen_words(app: object) -> str:
    """The same with frames and line breaks taken out, to look for sentences in."""
    text = screen_text(app)
    for frame in "┃│╭╮╰╯─━┏┓┗┛":
        text = text.replace(frame, " ")
    return " ".join(text.split())
