"""``solarcal run --continue``: the line it goes on with, and what it says where there is none."""

from pathlib import Path

import pytest

from solarcal.cli import run, run_command
from solarcal.config import Choice

DAY = Path(__file__).parents[2] / "sessions" / "southern-day.jsonl"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Choice]:
    """The choices that the workstation was opened with."""
    choices: list[Choice] = []
    monkeypatch.setattr(run, "has_terminal", lambda: True)
    monkeypatch.setattr(run, "run_workstation", lambda choice, **_: choices.append(choice) or 0)
    return choices


@pytest.fixture
def broken_off(tmp_path: Path) -> Path:
    """A session without its ``closed`` record, outside the sessions folder."""
    path = tmp_path / "day.jsonl"
    path.write_text("".join(DAY.read_text("utf-8").splitlines(True)[:-1]), encoding="utf-8")
    return path


def test_a_session_that_is_missing_is_said_to_be(tmp_path: Path, opened, capsys) -> None:
    assert run_command(["run", "--continue", str(tmp_path / "none.jsonl")]) == 2
    assert "is missing: no such file" in capsys.readouterr().err
    assert not opened


def test_a_session_of_an_unknown_line_goes_on_where_port_says(opened, broken_off, capsys) -> None:
    words = ["run", "--continue", str(broken_off)]
    assert run_command(words) == 2
    assert f"say --port: solarcal run --continue {broken_off} --port URL" in capsys.readouterr().err
    line = ["--port", "/dev/ttyUSB1", "--baudrate", "19200", "--driver", "rotctld"]
    assert run_command([*words, *line]) == 0
    (choice,) = opened
    assert (choice.session, choice.port) == (str(broken_off), "/dev/ttyUSB1")
    assert (choice.baudrate, choice.driver) == (19200, "rotctld")


@pytest.mark.parametrize("line", [[], ["--port", "/dev/ttyUSB1"]])
def test_a_finished_session_is_said_to_be_finished(opened, capsys, line) -> None:
    assert run_command(["run", "--continue", str(DAY), *line]) == 2
    assert f"{DAY} is finished; begin a new session" in capsys.readouterr().err
    assert not opened


@pytest.mark.parametrize("other", [["--scenario", "polar"], ["--offline"]])
def test_a_session_goes_on_with_a_unit_of_its_own(opened, broken_off, capsys, other) -> None:
    assert run_command(["run", "--continue", str(broken_off), *other]) == 2
    assert f"{other[0]} and --continue do not go together" in capsys.readouterr().err
