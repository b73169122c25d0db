"""``solarcal fleet``: the worst first, what cannot be read named."""

import json
import shutil
from pathlib import Path

import pytest

from solarcal.cli import run_command
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.station.fleet import fit_fleet

SESSIONS = Path(__file__).parents[2] / "sessions"
FILES = sorted(SESSIONS.glob("*.jsonl"))


def test_unreadable_files_are_named_and_nothing_stops(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(FILES[1], tmp_path / "good.jsonl")
    (tmp_path / "empty.jsonl").write_bytes(b"")
    (tmp_path / "noise.jsonl").write_bytes(bytes(range(256)))
    assert run_command(["fleet", str(tmp_path), "--json"]) == 0
    told = capsys.readouterr()
    document = json.loads(told.out)
    assert document["files"] == 3
    assert document["fitted"] == 1
    assert {Path(bad["file"]).name for bad in document["unreadable"]} == {
        "empty.jsonl",
        "noise.jsonl",
    }
    assert "fitting 3 of 3" in told.err


def test_every_file_is_one_line_whatever_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(FILES[1], tmp_path / "go\nod\x1b[2J.jsonl")
    (tmp_path / "em\npty.jsonl").write_bytes(b"")
    assert run_command(["fleet", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("1 session fitted by robust")
    assert r"go od\x1b[2J.jsonl" in "\n".join(lines)
    at = lines.index("1 file could not be read or fitted:")
    assert len(lines) == at + 2
    assert lines[at + 1].count("em pty.jsonl") == 1


@pytest.mark.parametrize(
    ("worst_by", "key"),
    [("rms", "sky_rms_deg"), ("lean", "lean_deg"), ("sigma", "lean_sigma_deg")],
)
def test_the_worst_stand_first(worst_by: str, key: str, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["fleet", str(SESSIONS), "--worst-by", worst_by, "--top", "3", "--json"]
    assert run_command(argv) == 0
    sessions = json.loads(capsys.readouterr().out)["sessions"]
    everything = [getattr(member, key) for member in fit_fleet(FILES).members]
    assert [session[key] for session in sessions] == pytest.approx(
        sorted(everything, reverse=True)[:3]
    )
    assert tuple(sessions[0]["mechanism"]) == COEFFICIENT_NAMES


def test_a_folder_without_sessions_is_said_in_a_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command(["fleet", str(tmp_path)]) == 2
    assert "no session file" in capsys.readouterr().err
