"""The pictures of the documentation, one function each, in the order of a day."""

from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

from textual.pilot import Pilot

from solarcal.config import Choice, Settings
from solarcal.station.news import StatusRead
from solarcal.tui.app import SolarcalApp
from solarcal.tui.base import MenuEntriesFound
from solarcal.tui.menu_entries import Entry, MenuEntries, menu_entries
from solarcal.tui.start_screen import StartScreen
from solarcal.tui.widgets.plot import PLOTS
from solarcal.tui.workstation.view import WorkstationView
from tools.pictures.film import Frame, film
from tools.pictures.stage import LARGE, SMALL, Day, picture, shows, until

Scene = Callable[[Path], Coroutine[Any, Any, str]]
SCENES: dict[str, Scene] = {}
MORNING, LATE_MORNING = "2026-06-03T13:30:00Z", "2026-06-03T15:00:00Z"
QUESTIONS = ("1. Did you", "2. Did you", "3. Do you")


def scene(make: Scene) -> Scene:
    """The function's name is the file's."""
    SCENES[make.__name__.replace("_", "-")] = make
    return make


class _PicturedStart(StartScreen):
    """MenuEntries made up here: what is plugged into this computer is nobody's business."""

    def _look_up(self) -> None:
        port: Entry = ("/dev/ttyUSB0     USB serial adapter (FTDI)", Choice(port="/dev/ttyUSB0"))
        scenarios = menu_entries(Settings()).scenarios
        self.post_message(MenuEntriesFound(MenuEntries([], [port], scenarios, [])))


@scene
async def start(folder: Path) -> str:
    del folder
    app = SolarcalApp()
    async with app.run_test(size=SMALL) as pilot:
        app.push_screen(_PicturedStart())
        await shows(pilot, "/dev/ttyUSB0", "Emulated trackers")
        return await picture(pilot, "The start screen: ports, emulated trackers, saved sessions")


@scene
async def connected(folder: Path) -> str:
    day = Day(folder)
    day.station.poll()
    async with day.workstation() as pilot:
        await shows(pilot, "Set the unit's clock", "NO REF CHECK")
        return await picture(pilot, "Just connected: the first thing to do is the clock")


@scene
async def clock(folder: Path) -> str:
    async with Day(folder, scenario="wrong-clock").workstation() as pilot:
        await pilot.press("f10")
        await shows(pilot, "Unit - laptop")
        return await picture(pilot, "Both clocks compared")


@scene
async def reference_check(folder: Path) -> str:
    day = Day(folder)
    day.station.set_unit_clock()
    async with day.workstation() as pilot:
        await pilot.press("f5")
        await shows(pilot, "Start: drive to the switches")
        await pilot.press("enter")
        await shows(pilot, "Track again", "Check no. 1 complete")
        return await picture(pilot, "A reference check, complete")


@scene
async def sun_offset(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().workstation() as pilot:
        await pilot.press("f6")
        await shows(pilot, "mode TRACK", "(deg, sky)")
        return await picture(pilot, "Set Sun Offset on an emulated tracker: its sunspot is drawn")


@scene
async def sun_offset_real(folder: Path) -> str:
    async with Day(folder, MORNING, real=True).prepared().workstation() as pilot:
        await pilot.press("f6")
        await shows(pilot, "mode TRACK", "came")
        return await picture(pilot, "Set Sun Offset on a real tracker: the sunspot calculator")


@scene
async def initialise(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().offset_set().workstation() as pilot:
        await pilot.press("f3")
        await shows(pilot, "Are you sure?")
        return await picture(pilot, "Initialise the data file")


@scene
async def questions(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(4).offset_set().workstation() as pilot:
        await pilot.press("f7")
        for words in QUESTIONS[:2]:
            await shows(pilot, words)
            await pilot.press("y")
        await shows(pilot, QUESTIONS[2], "The spot is")
        return await picture(pilot, "The third question, with what the program saw beside it")


@scene
async def result(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(4).offset_set().workstation() as pilot:
        await pilot.press("f7")
        for words in QUESTIONS:
            await shows(pilot, words)
            await pilot.press("y")
        await shows(pilot, "Store it?", "in sigmas")
        return await picture(pilot, "The result of a gathering: store it or not?")


@scene
async def error_plot(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(5).workstation() as pilot:
        await pilot.press("4")
        await shows(pilot, "apparent solar time")
        return await picture(pilot, "The error plot after five points")


@scene
async def plan(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(4).workstation() as pilot:
        await pilot.press("f4")
        await shows(pilot, "the rest of the day", "local stop, UTC")
        await pilot.press("down", "down", "down", "space")
        await shows(pilot, "cloud")
        return await picture(pilot, "The plan of the day, one half hour struck out for cloud")


@scene
async def workstation(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(12).workstation(LARGE) as pilot:
        await shows(pilot, "Year 95 %")
        return await picture(pilot, "The workstation after twelve points")


@scene
async def sunlight(folder: Path) -> str:
    day = Day(folder, MORNING).prepared().taken(12)
    async with day.workstation(SMALL, theme="sunlight") as pilot:
        return await picture(pilot, "The theme for bright sunlight")


@scene
async def forecast(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(7).workstation(SMALL) as pilot:
        await pilot.press("4")
        for _ in range(PLOTS.index("forecast")):
            await pilot.press("v")
        await shows(pilot, "mean solar hour")
        return await picture(pilot, "The expected error of the whole year")


@scene
async def link_lost(folder: Path) -> str:
    day = Day(folder, MORNING).prepared().taken(3)
    async with day.workstation() as pilot:
        day.cable.pulled = True
        app = pilot.app
        assert isinstance(app, SolarcalApp)
        app.station_worker().submit(StatusRead, lambda station: station.poll())
        await shows(pilot, "LINK LOST", "reconnects automatically")
        return await picture(pilot, "The cable was pulled")


@scene
async def upload(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(12).workstation() as pilot:
        await pilot.press("f8")
        await shows(pilot, "Upload?")
        return await picture(pilot, "Upload: in force, new, and what rounding costs")


@scene
async def uploaded(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(12).workstation() as pilot:
        await pilot.press("f8")
        await shows(pilot, "Upload?")
        await pilot.press("y")
        await shows(pilot, "read back EQUAL")
        return await picture(pilot, "Uploaded and read back")


@scene
async def proven(folder: Path) -> str:
    day = Day(folder, MORNING).prepared().taken(11)
    day.technician.upload()
    day.technician.take_checks()
    async with day.workstation() as pilot:
        await pilot.press("5")
        await shows(pilot, "SIGNED OFF")
        return await picture(pilot, "Two check points prove the upload")


@scene
async def report(folder: Path) -> str:
    day = Day(folder, MORNING).prepared().taken(11)
    day.technician.upload()
    day.technician.take_checks()
    async with day.workstation() as pilot:
        await pilot.press("e")
        await shows(pilot, "Write it?", "Status")
        return await picture(pilot, "The certificate of this session")


@scene
async def recompute(folder: Path) -> str:
    async with Day(folder, MORNING).prepared().taken(7).workstation() as pilot:
        await pilot.press("f9")
        await shows(pilot, "OPEN", "P5")
        return await picture(pilot, "Recompute: a saved session opened beside the running one")


@scene
async def replay(folder: Path) -> str:
    path = Day(folder, MORNING).prepared().taken(8).path
    app = SolarcalApp(start=Choice(replay=str(path)))
    async with app.run_test(size=SMALL) as pilot:
        await shows(pilot, "REPLAY")
        for _ in range(6):
            await pilot.press("pagedown")
        view = app.screen.query_one(WorkstationView)
        await until(pilot, lambda: view.solution is not None and view.solution.n_points == 6)
        await pilot.press("4")
        return await picture(pilot, "Replay: the session as it stood after its sixth point")


@scene
async def before_and_after(folder: Path) -> str:
    day = Day(folder, MORNING).prepared().taken(11)
    day.technician.upload()
    day.technician.take_checks()
    async with day.workstation() as pilot:
        await pilot.press("e")
        await shows(pilot, "Before and after")
        await pilot.press("v")
        await shows(pilot, "SIGNED OFF", "AFTER, as uploaded")
        await pilot.press("v")
        return await picture(pilot, "The year before and after the calibration")


@scene
async def demo(folder: Path) -> str:
    """A calibration on the emulated tracker by its keys; the points between by the technician."""
    frames: list[Frame] = []
    day = Day(folder, MORNING)

    async def show(pilot: Pilot[int], caption: str, *words: str, seconds: float = 3.0) -> None:
        await shows(pilot, *words)
        frames.append(Frame(await picture(pilot, caption), caption, seconds))

    day.station.poll()
    async with day.workstation() as pilot:
        await show(pilot, "solarcal demo: what to do next stands on top", "Set the unit's clock")
        await pilot.press("f10", "enter")
        await show(pilot, "F10, Enter: the unit's clock is set", "Set and recorded")
        await pilot.press("escape", "f5", "enter")
        await show(pilot, "F5, Enter: reference check", "Check no. 1 complete")
    day.prepared()
    async with day.workstation() as pilot:
        await pilot.press("f6")
        await show(pilot, "F6: arrow keys jog the spot to the centre", "mode TRACK", "(deg, sky)")
    day.offset_set()
    async with day.workstation() as pilot:
        await pilot.press("f3")
        await show(pilot, "F3: the calibration begins in this file", "Are you sure?")
        await pilot.press("y")
        await shows(pilot, "The calibration begins")
        await pilot.press("f7")
        await show(pilot, "F7: the first of three questions, with its evidence", QUESTIONS[0])
        for words in QUESTIONS:
            await shows(pilot, words)
            await pilot.press("y")
        await show(pilot, "y y y: the point is gathered; store it?", "Store it?")
        await pilot.press("y")
        await show(pilot, "y: stored; the next point is planned", "1 point", "Point 2")
    day.station.clock.wait(3000.0)
    day.taken(5)
    async with day.workstation() as pilot:
        await pilot.press("4")
        await show(pilot, "4: errors and model after six points", "apparent solar time")
    day.taken(6)
    async with day.workstation() as pilot:
        await show(pilot, "Twelve points: the verdict", "Year 95 %")
        await pilot.press("f8")
        await show(pilot, "F8: in force, new, and what it changes", "Upload?")
        await pilot.press("y")
        app = pilot.app
        assert isinstance(app, SolarcalApp)
        if app.judgement is not None and app.judgement.verdict.state != "done":
            await show(pilot, "y: more points would be better; asked once more", "once more")
            await pilot.press("y")
        await show(pilot, "y: written, stored, read back", "read back EQUAL")
    day.technician.take_checks()
    async with day.workstation() as pilot:
        await pilot.press("e")
        await shows(pilot, "Before and after")
        await pilot.press("v")
        await show(pilot, "Two check points: the year before and after", "AFTER", "Nov")
        await pilot.press("v")
        await show(pilot, "v: the errors before and after", "model", seconds=4.0)
        colours = pilot.app.theme_variables
    return film(
        frames,
        title="A calibration with solarcal demo",
        ink=colours["foreground"],
        paper=colours["background"],
    )


@scene
async def calculators(folder: Path) -> str:
    del folder
    app = SolarcalApp()
    async with app.run_test(size=SMALL) as pilot:
        await pilot.press("f11")
        await shows(pilot, "Sunspot device")
        return await picture(pilot, "The field calculators")
