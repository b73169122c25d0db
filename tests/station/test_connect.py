"""One way from the words of a command line to a tracker; what is missing is said in one line."""

from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from solarcal.cli import run_command
from solarcal.config import Choice
from solarcal.emulated_units import emulated_unit
from solarcal.errors import ConfigurationError
from solarcal.profiles import MountDescription, Profile, load_site_file
from solarcal.session.journal import Journal
from solarcal.session.view import read_session
from solarcal.site import Site
from solarcal.station import opening
from solarcal.station.connect import Connection, open_tracker
from solarcal.station.described_unit import unit_parameters

SITE_FILE = """
driver = "solartrak"
port = "/dev/nowhere"
operator = "Ann"

[site]
latitude_deg = 35.05
longitude_deg = -106.48

[mount]
geometry = "polar"
drive1 = "rotary:1000"
limits1_deg = [-90.0, 90.0]
"""


def test_a_port_that_was_not_given_is_asked_for():
    with pytest.raises(ConfigurationError, match="needs a port: give --port"):
        open_tracker("")


def test_a_site_that_nobody_told_is_asked_for():
    way = Connection("x", "some-rotator", profile=Profile())
    with pytest.raises(ConfigurationError, match=r"some-rotator needs the site.*--site FILE"):
        way.demand_site()
    there = Site(1.0, 2.0)
    assert Connection("x", profile=Profile(site=there)).demand_site() == there
    assert way.mount() == MountDescription()


def test_a_site_file_holds_site_unit_and_mount(tmp_path):
    path = tmp_path / "roof.toml"
    path.write_text(SITE_FILE)
    profile = load_site_file(path)
    assert (profile.name, profile.operator, profile.port) == ("roof", "Ann", "/dev/nowhere")
    assert profile.mount == MountDescription(
        geometry="polar", drive1="rotary:1000", limits1_deg=(-90.0, 90.0)
    )


def test_the_site_file_of_the_manual_is_one(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "drivers.md").read_text(encoding="utf-8")
    path = tmp_path / "roof.toml"
    path.write_text(page.partition("```toml\n")[2].partition("```")[0])
    profile = load_site_file(path)
    assert (profile.driver, profile.port) == ("rotctld", "localhost:4533")
    parameters = unit_parameters(profile.mount, profile.site)
    # Every default that the page names is the program's.
    assert parameters == unit_parameters(
        MountDescription(limits1_deg=(-120.0, 120.0), limits2_deg=(5.0, 85.0)), profile.site
    )


def test_commands_take_port_and_driver_from_the_site_file(tmp_path, capsys):
    path = tmp_path / "roof.toml"
    path.write_text(SITE_FILE)
    assert run_command(["calibrate", "--site", str(path)]) == 3
    assert "port /dev/nowhere does not exist" in capsys.readouterr().err


def test_what_is_misspelt_in_the_mount_is_not_passed_over(tmp_path, capsys):
    path = tmp_path / "roof.toml"
    path.write_text(SITE_FILE.replace("drive1", "drive_1"))
    assert run_command(["calibrate", "--site", str(path)]) == 2
    said = capsys.readouterr().err
    assert "roof.toml" in said
    assert "drive_1" in said
    assert said.count("\n") == 1


def test_a_site_file_that_is_not_there_and_a_driver_that_is_none(tmp_path, capsys):
    assert run_command(["rollback", "--port", "x", "--site", str(tmp_path / "no.toml")]) == 2
    assert "no.toml is missing" in capsys.readouterr().err
    assert run_command(["rollback", "--port", "x", "--driver", "belt"]) == 2
    assert "no driver 'belt'; there is: solartrak" in capsys.readouterr().err


def test_a_profile_that_was_never_saved_is_not_taken_for_an_empty_one(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("SOLARCAL_CONFIG", str(tmp_path))
    assert run_command(["rollback", "--port", "x", "--profile", "roof"]) == 2
    assert "no profile 'roof'; none has been saved yet" in capsys.readouterr().err


@pytest.mark.parametrize("asked", [True, False])
def test_sessions_to_go_on_with_are_offered_where_they_are_asked_for(tmp_path, monkeypatch, asked):
    saved = SimpleNamespace(words=lambda: "yesterday's", path=tmp_path / "yesterday.jsonl")
    monkeypatch.setattr(opening, "unfinished_sessions", lambda *of: [saved])
    monkeypatch.setattr(opening, "_journal_creator", lambda *of: Journal.memory)
    tracker = emulated_unit("tijeras-azel").tracker
    tracker.open()
    choice = Choice(offers_unfinished=asked)
    if asked:
        with pytest.raises(opening.UnfinishedSessions) as offered:
            opening.open_line(tracker, choice, Profile())
        ((words, taken_up),) = offered.value.entries
        assert words == "yesterday's"
        assert taken_up.session == str(saved.path)
        assert not taken_up.offers_unfinished
    else:
        opening.open_line(tracker, choice, Profile()).close()


@pytest.mark.parametrize(
    ("scenario", "serial", "name"),
    [("polar", "0001", "polar"), ("", "SN 17", "SN-17"), ("", "", "unit")],
)
def test_a_session_is_named_after_the_scenario_or_the_unit(
    tmp_path, monkeypatch, scenario, serial, name
):
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path))
    header = read_session(Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl").header
    unit = msgspec.structs.replace(header.unit, serial=serial)
    create = opening._journal_creator(Choice(scenario=scenario), None)
    with create(msgspec.structs.replace(header, unit=unit)) as journal:
        assert journal.path.name == f"{name}-{header.utc[:10]}.jsonl"
