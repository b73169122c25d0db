"""``solarcal doctor``: each check finds what it is there for."""

import json
from types import SimpleNamespace

import pytest

from solarcal.cli import readiness, run_command
from solarcal.config import config_dir
from solarcal.station.clocks import LaptopClock


@pytest.fixture
def sound(monkeypatch):
    """A laptop on which nothing is wrong but what a test spoils."""
    import serial.tools.list_ports

    monkeypatch.setattr(serial.tools.list_ports, "comports", list)
    monkeypatch.setattr(
        "solarcal.station.clocks.laptop_clock", lambda: LaptopClock(True, "kept by chrony")
    )


def document(capsys):
    code = run_command(["doctor", "--json"])
    told = json.loads(capsys.readouterr().out)
    return code, told, {check["name"]: check for check in told["checks"]}


def test_a_sound_laptop_is_ready(sound, capsys):
    code, told, checks = document(capsys)
    assert (code, told["ready"]) == (0, True)
    assert checks["clock"]["verdict"] == "ok"
    assert checks["disk"]["verdict"] == "ok"
    assert checks["ports"]["verdict"] == "warning"


def test_a_free_running_clock_fails(sound, capsys, monkeypatch):
    monkeypatch.setattr(
        "solarcal.station.clocks.laptop_clock", lambda: LaptopClock(False, "NOT kept")
    )
    code, told, checks = document(capsys)
    assert (code, told["ready"]) == (1, False)
    assert "24 s of error are 0.1 deg" in checks["clock"]["remedy"]


def test_a_damaged_profile_fails_and_is_named(sound, capsys):
    folder = config_dir() / "profiles"
    folder.mkdir(parents=True)
    (folder / "north.toml").write_text("tolerance_deg = 'much'\n")
    code, _, checks = document(capsys)
    assert code == 1
    assert "north.toml" in checks["config"]["found"]
    assert "tolerance_deg" in checks["config"]["found"]


def test_a_keymap_with_a_mistake_fails(sound, capsys):
    config_dir().mkdir(parents=True)
    (config_dir() / "keymap.toml").write_text('note = "f12"\n')
    code, _, checks = document(capsys)
    assert code == 1
    assert "is always STOP" in checks["keys"]["found"]


def test_a_sessions_folder_that_is_a_file_fails(sound, capsys, monkeypatch, tmp_path):
    (tmp_path / "occupied").write_text("")
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "occupied"))
    code, _, checks = document(capsys)
    assert code == 1
    assert "cannot be written" in checks["disk"]["found"]


def test_a_full_disk_fails(sound, capsys, monkeypatch):
    monkeypatch.setattr(readiness.shutil, "disk_usage", lambda folder: SimpleNamespace(free=2**20))
    code, _, checks = document(capsys)
    assert code == 1
    assert "1 MB free" in checks["disk"]["found"]


def test_a_port_without_access_fails_with_the_cure(sound, capsys, monkeypatch):
    shut = {"port": "/dev/ttyUSB7", "looks_like": "USB serial adapter", "likely": True}
    monkeypatch.setattr(
        readiness, "describe", lambda port: shut | {"readable": False, "writable": False}
    )
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [object()])
    code, _, checks = document(capsys)
    assert code == 1
    assert "dialout" in checks["ports"]["remedy"]


@pytest.mark.parametrize(("columns", "verdict"), [(80, "ok"), (79, "failed")])
def test_the_terminal_must_have_80_columns(columns, verdict, monkeypatch):
    monkeypatch.setattr(readiness.sys, "stdout", SimpleNamespace(isatty=lambda: True))
    monkeypatch.setattr(
        readiness.shutil, "get_terminal_size", lambda: SimpleNamespace(columns=columns, lines=24)
    )
    monkeypatch.setenv("TERM", "xterm-256color")
    assert readiness.terminal().verdict == verdict


def test_the_linux_console_is_told_about_alt_f_keys(monkeypatch):
    monkeypatch.setenv("TERM", "linux")
    assert "plain F-keys" in readiness.keys().remedy


def test_the_text_form_says_what_to_do(sound, capsys):
    assert run_command(["doctor"]) == 0
    printed = capsys.readouterr().out
    assert printed.rstrip().endswith("ready")
    assert "-> plug the adapter in" in printed
