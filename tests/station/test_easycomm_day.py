"""A rotator that speaks EasyComm II on a serial line, no Hamlib between: calibrated and tracked."""

import json

import numpy as np
import pytest

from solarcal.cli import run_command
from solarcal.emulator.rotator import EmulatedRotator, RotatorWorld
from solarcal.emulator.rotator_protocols import EasyCommProtocol
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_pty
from solarcal.profiles import MountDescription
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.headless import calibrate
from solarcal.station.software_controller.coefficient_store import MemoryStore
from solarcal.station.software_controller.motion import ThreadPace
from solarcal.station.software_controller.rotator_tracker import RotatorTracker
from solarcal.station.technician import Schedule
from solarcal.unit.drivers.easycomm import EasyCommRotator
from solarcal.unit.link import SerialLink

SITE_FILE = """
driver = "easycomm"

[site]
latitude_deg = 35.05
longitude_deg = -106.48
elevation_m = 1830.0

[mount]
unit_name = "roof"
"""


def test_a_day_over_a_pseudo_terminal_finds_the_lean():
    scenario = load_scenario("tijeras-azel", ["truth.backlash1_deg=0", "truth.backlash2_deg=0"])
    rotator = EmulatedRotator(scenario, seed=3)
    rotator.protocol = EasyCommProtocol(decimals=2)
    world, store = RotatorWorld(rotator), MemoryStore()
    with serve_pty(rotator) as port:
        tracker = RotatorTracker(
            EasyCommRotator(lambda: SerialLink(port), port),
            "roof",
            MountDescription(reference1_deg=118.0),
            scenario.site.place(),
            EmulatedClock(world),
            lambda model, serial: store,
            emulation=world,
            pace=ThreadPace(world.speed),
        )
        world.stand_in = tracker
        done = calibrate(tracker, Journal.memory, Schedule(points=8, every_min=60.0, checks=1))
        tracker.close()
    header = done.session.header
    assert (header.unit.model, header.unit.serial) == ("EasyComm II", "roof")
    assert (header.unit.firmware, header.unit.has_switches) == ("emulated-1.0", False)
    assert done.completed
    # The axes read in hundredths here; a tenth of the error that was there is left, or less.
    before, after = done.truth_before, done.truth_after
    assert after.day_rms_deg < 0.1 * before.day_rms_deg
    found = done.solution.coefficients()
    assert np.hypot(found.P1 - after.coefficients.P1, found.P3 - after.coefficients.P3) < 0.1


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_UNITS", str(tmp_path / "units"))
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "sessions"))
    (tmp_path / "site.toml").write_text(SITE_FILE)
    return tmp_path


def test_calibrate_track_upload_and_rollback_take_it_by_its_name(folder, capsys):
    day = folder / "day.jsonl"
    emulated = ["--scenario", "tijeras-azel", "--driver", "easycomm"]
    assert (
        run_command(
            [
                "calibrate",
                *emulated,
                "--points",
                "3",
                "--force",
                "a short day",
                "--json",
                "-o",
                str(day),
            ]
        )
        == 0
    )
    assert json.loads(capsys.readouterr().out)["completed"]

    # The emulated day's coefficients; half an hour of the same world, followed with them.
    fitted = folder / "fit.json"
    assert run_command(["fit", str(day), "--json"]) == 0
    fitted.write_text(capsys.readouterr().out)
    track = ["track", *emulated, "--coefficients", str(fitted), "--start", "2026-06-03T16:00:00Z"]
    assert run_command([*track, "--until", "16:10", "--every", "60", "--json"]) == 0
    tracked = json.loads(capsys.readouterr().out)
    assert tracked["off_max_deg"] < 0.15

    rotator = EmulatedRotator(load_scenario("tijeras-azel", []))
    rotator.protocol = EasyCommProtocol()
    with serve_pty(rotator, folder / "rotator") as port:
        line = ["--port", port, "--site", str(folder / "site.toml")]
        # The emulated unit of the session was another one: it says so.
        assert run_command(["upload", str(day), *line]) == 1
        assert "EasyComm II" in capsys.readouterr().err


def test_a_site_is_needed_and_asked_for(folder, capsys):
    rotator = EmulatedRotator(load_scenario("tijeras-azel", []))
    rotator.protocol = EasyCommProtocol()
    with serve_pty(rotator) as port:
        assert run_command(["track", "--driver", "easycomm", "--port", port]) == 2
    assert "driver easycomm needs the site" in capsys.readouterr().err
