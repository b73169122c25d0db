"""Commands that reach a rotator over a line: what is uploaded is kept by the station, and found."""

import json

import msgspec
import pytest

from solarcal.cli import run_command
from solarcal.config import Choice, read_toml
from solarcal.emulated_units import open_choice
from solarcal.emulator.rotator import EmulatedRotator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_tcp
from solarcal.errors import ConfigurationError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.profiles import Profile, load_site_file
from solarcal.session.view import read_session, view_session
from solarcal.station.software_controller.coefficient_store import StoredCorrection

SITE_FILE = """
driver = "rotctld"

[site]
latitude_deg = 35.05
longitude_deg = -106.48
elevation_m = 1830.0

[mount]
unit_name = "0001"
reference1_deg = 118.0
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_UNITS", str(tmp_path / "units"))
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "sessions"))
    (tmp_path / "site.toml").write_text(SITE_FILE)
    return tmp_path


@pytest.fixture
def port():
    with serve_tcp(EmulatedRotator(load_scenario("tijeras-azel", []))) as url:
        yield url


def kept(folder):
    return read_toml(folder / "units" / "Emulated-Rotator-0001.toml", StoredCorrection)


def test_a_day_is_calibrated_uploaded_and_rolled_back(folder, port, capsys):
    day = folder / "day.jsonl"
    calibrate = ["calibrate", "--scenario", "tijeras-azel", "--driver", "rotctld", "--json"]
    assert run_command([*calibrate, "--points", "3", "--force", "a short day", "-o", str(day)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["completed"]
    # Three points of a morning: better than nothing, and no more is asked here.
    assert told["truth"]["day_rms_after_deg"] < told["truth"]["day_rms_before_deg"]
    # What an emulated rotator in this process was given is nobody's but its own.
    assert not (folder / "units").exists()

    line = ["--port", port, "--site", str(folder / "site.toml")]
    assert run_command(["upload", str(day), *line]) == 1
    # Three points leave a year no better than as it is: it wants a reason.
    assert "no improvement beyond its uncertainty" in capsys.readouterr().err
    assert run_command(["upload", str(day), *line, "--force", "a trial"]) == 0
    uploads = view_session(*_of(day)).uploads
    assert kept(folder).coefficients == uploads[-1].new_coefficients
    assert kept(folder).offsets == Offsets()
    assert uploads[-1].old_coefficients == Coefficients()

    assert run_command(["rollback", str(day), *line]) == 0
    assert kept(folder).coefficients == Coefficients()

    # The session tells site and mount where no profile does.
    line = ["--port", port, "--driver", "rotctld"]
    assert run_command(["upload", str(day), *line, "--force", "a trial"]) == 0
    assert kept(folder).coefficients == uploads[-1].new_coefficients
    assert run_command(["rollback", str(day), *line]) == 0
    assert kept(folder).coefficients == Coefficients()


def test_a_mount_described_otherwise_is_not_the_sessions(folder, port, capsys):
    day = folder / "day.jsonl"
    calibrate = ["calibrate", "--scenario", "tijeras-azel", "--driver", "rotctld"]
    assert run_command([*calibrate, "--points", "3", "--force", "a short day", "-o", str(day)]) == 0
    (folder / "site.toml").write_text(SITE_FILE.replace("-106.48", "-105.0"))
    capsys.readouterr()
    line = ["--port", port, "--site", str(folder / "site.toml")]
    assert run_command(["upload", str(day), *line]) == 1
    assert "has been given another longitude" in capsys.readouterr().err


def test_a_real_rotator_is_not_calibrated_without_an_eye(folder, port, capsys):
    line = ["--port", port, "--site", str(folder / "site.toml")]
    assert run_command(["calibrate", *line]) == 2
    assert "cannot see its sunspot" in capsys.readouterr().err


def test_a_session_goes_on_at_the_site_of_its_header(folder, port):
    """The mount too, whatever the remembered profile does not tell."""
    profile = load_site_file(folder / "site.toml")
    limits = {"limits1_deg": (-100.0, 100.0), "limits2_deg": (5.0, 80.0)}
    mount = msgspec.structs.replace(profile.mount, drive2="rotary:-250.5", **limits)
    day = folder / "day.jsonl"
    choice = Choice(port=port, driver="rotctld")
    begun = msgspec.structs.replace(profile, mount=mount)
    line = open_choice(choice, begun, output=day)
    line.station.leave()
    line.resources.close()
    line = open_choice(msgspec.structs.replace(choice, session=str(day)), Profile())
    station = line.station
    unit = station.session.header.unit
    parameters = station.tracker.parameters()
    assert station.unit_site.site == unit.site == profile.site
    assert (parameters.limits, parameters.drive2) == (unit.limits, unit.drive2)
    assert parameters.limits.axis1.high_deg == 100.0
    line.resources.close()


def test_an_emulated_rotator_runs_at_the_speed_asked_for(folder):
    choice = Choice(scenario="tijeras-azel", driver="easycomm", speed=30.0)
    line = open_choice(choice, Profile())
    assert line.station.tracker.emulation.speed() == 30.0
    line.close()


def test_a_trace_of_a_rotator_in_the_process_is_refused(folder):
    choice = Choice(scenario="tijeras-azel", driver="easycomm")
    with pytest.raises(ConfigurationError, match="--trace records a line"):
        open_choice(choice, Profile(), trace="line.txt")


def _of(path):
    session = read_session(path)
    return session.header, tuple(session.records)
