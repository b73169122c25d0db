"""A profile beside an emulated unit on a line: all of it counts but the place, which is said."""

import json

import pytest

from solarcal.cli import run_command
from solarcal.config import Choice
from solarcal.emulated_units import open_choice
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_tcp
from solarcal.profiles import load_site_file
from solarcal.session.view import read_session

PROFILE = """
operator = "Ann"
pointing_device = "tube"
tolerance_deg = 0.2
done_probability = 0.9
unmodelled = { sag_deg = 0.07, air = 0.5 }
last_coefficients = [0.3, -0.36, 0.5, 0.2, 0.0008, -0.0006]

[site]
latitude_deg = 35.05
longitude_deg = -106.48

[inclinometer]
lean_north_deg = 0.28
lean_east_deg = 0.53
sigma_deg = 0.02
"""
AWAY = (
    "the profile's site is not used: the unit's latitude is 35.2500, ours 35.0500: 0.200 deg away"
)


@pytest.fixture
def site_file(tmp_path):
    path = tmp_path / "tower.toml"
    path.write_text(PROFILE)
    return path


@pytest.fixture(params=[35.25, 35.052])
def unit(request):
    """Its port, and what must be said of its latitude."""
    settings = [f"site.latitude_deg={request.param}", "start=2026-06-03T14:00:00Z"]
    with serve_tcp(Emulator(load_scenario("tijeras-azel", settings), seed=3)) as port:
        yield port, request.param, [AWAY] if request.param == 35.25 else []


def of_the_profile(header, latitude_deg):
    assert (header.operator, header.pointing_device) == ("Ann", "tube")
    assert (header.tolerance_deg, header.done_probability) == (0.2, 0.9)
    assert header.unmodelled.sag_deg == 0.07
    assert header.inclinometer.lean_east_deg == 0.53
    assert header.last_coefficients.P1 == 0.3
    assert header.site.latitude_deg == latitude_deg


def test_calibrate_goes_by_the_profile(site_file, unit, tmp_path, capsys):
    port, latitude_deg, said = unit
    day = tmp_path / "day.jsonl"
    words = ["calibrate", "--port", port, "--site", str(site_file), "-o", str(day), "--json"]
    assert run_command([*words, "--points", "3", "--every", "10", "--force", "a trial"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["completed"]
    assert [line for line in err.splitlines() if "site is not used" in line] == said
    of_the_profile(read_session(day).header, latitude_deg)


def test_what_is_given_with_the_command_overrides_it(site_file, unit, tmp_path, capsys):
    day = tmp_path / "day.jsonl"
    words = ["calibrate", "--port", unit[0], "--site", str(site_file), "-o", str(day)]
    words += ["--points", "3", "--every", "10", "--force", "a trial", "--tolerance", "0.3"]
    words += ["--unmodelled", "air=0.25", "--last-coefficients", "0.1 0 0 0 0 0"]
    assert run_command(words) == 0
    header = read_session(day).header
    assert (header.tolerance_deg, header.done_probability) == (0.3, 0.9)
    assert (header.unmodelled.air, header.unmodelled.sag_deg) == (0.25, 0.07)
    assert header.last_coefficients.as_tuple() == (0.1, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_the_workstation_goes_by_the_profile(site_file, unit, tmp_path):
    port, latitude_deg, said = unit
    line = open_choice(Choice(port=port), load_site_file(site_file), output=tmp_path / "s.jsonl")
    try:
        of_the_profile(line.station.session.header, latitude_deg)
        assert [one for one in line.noticed if "site is not used" in one] == said
    finally:
        line.close()
