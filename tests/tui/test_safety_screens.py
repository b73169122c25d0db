"""Looking at every screen commands nothing; what units and files say is never markup."""

from pathlib import Path

from procedure_bench import (
    SMALL,
    Cable,
    bench,
    on_loop,
    shows,
    until,
    workstation,
)
from textual.widgets import Input

from solarcal.session.disk import Disk
from solarcal.session.journal import Journal
from solarcal.session.records import Header
from solarcal.station.news import NoteWritten
from solarcal.station.state import LinkState
from solarcal.tui.app import SolarcalApp
from solarcal.tui.keys import ACTIONS
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.frames import decode_request
from solarcal.unit.link import Link

READS = ("OPEN", "ID", "STATUS", "SITE", "REF", "COEF", "COEF STORED", "CLOCK")
ASKS_EMULATOR = ("X TIME", "X SPOT", "X SKY", "X TRUTH")
PARAMETER = 2
"""Words of a request that reads a parameter; one more writes it."""


def reads_only(said: str) -> bool:
    words = said.split(" ")
    if words[0] == "PARAM":
        return len(words) == PARAMETER
    return said in READS or words[0] == "OPEN" or said in ASKS_EMULATOR


class OverheardCable(Cable):
    """A line that keeps what was said on it."""

    def __init__(self, cable: Cable, said: list[str]) -> None:
        super().__init__(cable.emulator)
        self._said = said

    def open(self) -> Link:
        link, said = super().open(), self._said
        write = link.write

        def overheard(data: bytes) -> None:
            said.append(decode_request(data).text)
            write(data)

        link.write = overheard  # type: ignore[method-assign]
        return link


@on_loop
async def test_opening_and_leaving_every_screen_commands_the_unit_nothing() -> None:
    station, cable = bench()
    station.initialise(confirmed=True)
    said: list[str] = []
    station.tracker = SolarTrakUnit(OverheardCable(cable, said).open, port="test")
    station.connect()
    before = station.session.records
    async with workstation(station, begun=True) as (app, pilot):
        for action in ACTIONS:
            # These are commands in so many words: to stop, to leave, to let emulated time pass.
            if action.id in ("stop", "quit", "faster", "slower", "skip"):
                continue
            at = len(app.screen_stack)
            await pilot.press(action.keys[0])
            await pilot.pause()
            if action.id not in ("next_plot", "theme", "alerts"):
                await until(pilot, lambda at=at: len(app.screen_stack) > at)
            station.poll()
            while len(app.screen_stack) > at:
                depth = len(app.screen_stack)
                await pilot.press("escape")
                await until(pilot, lambda depth=depth: len(app.screen_stack) < depth)
    assert len(said) > 10
    assert [one for one in said if not reads_only(one)] == []
    # The point screen opens an attempt; leaving it discards nothing that was stored.
    assert station.session.records[: len(before)] == before
    assert not reads_only("MODE TRACK")
    assert not reads_only("PARAM update_range 0.2")


@on_loop
async def test_what_a_unit_and_a_technician_are_called_is_never_markup(tmp_path: Path) -> None:
    """``[/x]`` would end a style that was never begun: an exception in the middle of a screen."""
    station, _ = bench(tmp_path / "s.jsonl", "unit.serial=[/x][red]A")
    station.initialise(confirmed=True)
    station.note("[/b] [link=file:///etc/passwd]here[/link] [bold]")
    async with workstation(station) as (app, pilot):
        for key, words in (("f2", "[/x][red]A"), ("x", "[/b] [link=file:///etc/passwd]here")):
            at = len(app.screen_stack)
            await pilot.press(key)
            await shows(pilot, words)
            await pilot.press("escape")
            await until(pilot, lambda at=at: len(app.screen_stack) == at)
    app = SolarcalApp()
    async with app.run_test(size=SMALL, notifications=True) as pilot:
        app.notify("the unit refused [/x]: [red]")
        await shows(pilot, "refused [/x]: [red]")


class FullDisk(Disk):
    full = False

    def write(self, descriptor: int, content: bytes) -> int:
        if self.full:
            raise OSError(28, "No space left on device")
        return super().write(descriptor, content)


@on_loop
async def test_a_full_disk_is_said_and_the_workstation_goes_on_when_there_is_room(
    tmp_path: Path,
) -> None:
    station, cable = bench()
    disk = FullDisk()

    def create(header: Header) -> Journal:
        return Journal.create(tmp_path / "s.jsonl", header, disk=disk)

    station.open_session(create)
    async with workstation(station, SMALL) as (app, pilot):
        disk.full = True
        await pilot.press("n")
        await until(pilot, lambda: isinstance(app.focused, Input))
        await pilot.press(*"windy", "enter")
        await shows(pilot, "No space left on device")
        assert station.session.records == ()
        disk.full = False
        await pilot.press("enter")
        await until(pilot, lambda: len(station.session.records) == 1)
        # The line is lost while nothing can be recorded: said, and reconnected all the same.
        disk.full = True
        cable.pulled = True
        await until(pilot, lambda: station.state.live.link is LinkState.LOST)
        cable.pulled = False
        disk.full = False
        assert app.worker is not None
        app.worker.reconnect_now()
        await until(pilot, lambda: station.state.live.link is LinkState.CONNECTED)
        app.worker.submit(NoteWritten, lambda station: station.note("back"))
        await until(pilot, lambda: len(station.session.records) >= 2)
