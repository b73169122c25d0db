"""The start, workstation and replay screens as they look, at 80x24 and at 140x45."""

from types import SimpleNamespace

import pytest
from golden_screens import shows_golden
from procedure_bench import (
    LARGE,
    SMALL,
    bench,
    offset_set,
    plain_start,
    shows,
    take_points,
    until,
    workstation,
)

from solarcal.config import Choice, Settings
from solarcal.station.news import StatusRead
from solarcal.tui.app import SolarcalApp
from solarcal.tui.workstation.screen import WorkstationScreen
from solarcal.tui.workstation.view import WorkstationView

SIZES = [pytest.param(SMALL, id="80x24"), pytest.param(LARGE, id="140x45")]


def name_of(what, size):
    return f"{what}-{size[0]}x{size[1]}"


@pytest.fixture(scope="module")
def sessions(tmp_path_factory):
    """Session files with 0, 3 and 12 points, each written once for all tests here."""
    folder = tmp_path_factory.mktemp("sessions")
    stations = {}
    for points in (0, 3, 12):
        station, cable = bench(folder / f"calibration-{points}.jsonl", start="2026-06-03T13:30:00Z")
        if points:
            take_points(station, points, 40.0)
        stations[points] = (station, cable)
    return folder, stations


@pytest.mark.parametrize("size", SIZES)
async def test_start_offers_ports_emulated_trackers_and_sessions(size, monkeypatch):
    import serial.tools.list_ports

    plugged = SimpleNamespace(
        device="/dev/ttyUSB7", description="FT232R", manufacturer="FTDI", serial_number="A1",
        product=None, vid=0x0403, pid=0x6001,
    )  # fmt: skip
    monkeypatch.setattr(serial.tools.list_ports, "comports", lambda: [plugged])
    monkeypatch.setattr(
        "solarcal.tui.menu_entries.scenario_names", lambda: ["tijeras-azel", "tilted-tower"]
    )
    app = SolarcalApp(settings=Settings(last=Choice(scenario="tijeras-azel")))
    async with app.run_test(size=size) as pilot:
        await shows(pilot, "Last time", "/dev/ttyUSB7", "tilted-tower")
        await shows_golden(pilot, name_of("start", size))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("points", [0, 3, 12])
async def test_workstation(points, size, sessions):
    _, stations = sessions
    station, _ = stations[points]
    async with workstation(station, size) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await until(pilot, lambda: app.fit is not None)
        await until(pilot, lambda: station.session.fit_recorded and app.emulated_speed == 0.0)
        for name, key in (("now", "1"), ("points", "2"), ("fit", "3"), ("plot", "4")):
            if size == LARGE and name != "now":
                break
            await pilot.press(key)
            await shows_golden(pilot, name_of(f"workstation-{points}-{name}", size))


@pytest.mark.parametrize("size", SIZES)
async def test_replay_in_the_middle(size, sessions):
    folder, _ = sessions
    start = Choice(replay=str(folder / "calibration-12.jsonl"))
    app = plain_start(start=start)
    async with app.run_test(size=size) as pilot:
        await shows(pilot, "REPLAY")
        for _ in range(6):
            await pilot.press("pagedown")
        await pilot.press("4")
        view = app.screen.query_one(WorkstationView)
        await until(pilot, lambda: view.solution is not None and view.solution.n_points == 6)
        await shows_golden(pilot, name_of("replay", size))


@pytest.mark.parametrize("size", SIZES)
async def test_link_lost(size, tmp_path):
    station, cable = bench(tmp_path / "calibration.jsonl")
    offset_set(station)
    async with workstation(station, size) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await shows(pilot, "LINK OK", "clock paused")
        cable.pulled = True
        app.station_worker().submit(StatusRead, lambda s: s.poll())
        await shows(pilot, "LINK LOST", "reconnects automatically")
        await shows_golden(pilot, name_of("link-lost", size))
