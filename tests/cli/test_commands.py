"""The commands as a shell meets them: exit codes, one clear line, one JSON document.

Starting an interpreter costs more than most commands: a real process runs where the process is
what is looked at, everything else is the same call in this one.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from solarcal.cli import COMMANDS, run_command


def solarcal(*words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "solarcal", *words],
        capture_output=True,
        text=True,
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        timeout=120,
    )


@pytest.fixture
def said_by(capsys) -> Callable[..., str]:
    """``said_by("fit", FILE)``: what a command that ends well prints on stdout."""

    def said(*words: str | Path) -> str:
        assert run_command([str(word) for word in words]) == 0
        return capsys.readouterr().out

    return said


@pytest.fixture(scope="module")
def session(tmp_path_factory) -> tuple[Path, dict]:
    path = tmp_path_factory.mktemp("cli") / "s.jsonl"
    done = solarcal("calibrate", "--points", "8", "--seed", "4", "--json", "-o", str(path))
    assert done.returncode == 0, done.stderr
    return path, json.loads(done.stdout)


def test_calibrate_prints_the_fit_the_session_and_the_truth(session):
    path, document = session
    assert document["session"] == str(path)
    assert document["completed"] is True
    assert set(document["coefficients"]) == {"P1", "P2", "P3", "P4", "P5", "P6"}
    assert document["coefficients"]["P5"]["unit"] == "deg/deg"
    assert document["points"]["used"] == 8
    assert set(document["truth"]) == {
        "P1", "P2", "P3", "P4", "P5", "P6", "day_rms_before_deg", "day_rms_after_deg",
        "day_max_after_deg", "year_rms_before_deg", "year_rms_after_deg",
    }  # fmt: skip
    assert document["truth"]["day_rms_after_deg"] < document["truth"]["day_rms_before_deg"]


def test_fit_and_headless_replay_of_its_session_say_the_same(session):
    """In processes of their own, as the day was calibrated: nothing is left over from one."""
    path, live = session
    fitted = solarcal("fit", str(path), "--method", live["method"], "--json")
    replayed = solarcal("replay", str(path), "--headless", "--json")
    assert fitted.stdout == replayed.stdout
    again = json.loads(fitted.stdout)
    assert {key: live[key] for key in again} == again


def test_void_and_note_are_appended_and_change_the_fit(session, said_by, tmp_path):
    path = tmp_path / "copy.jsonl"
    path.write_bytes(session[0].read_bytes())
    before = path.read_bytes()
    points = [
        json.loads(line)["seq"]
        for line in before.decode().splitlines()
        if json.loads(line)["type"] == "point"
    ]
    said_by("void", path, str(points[0]), "--reason", "cloud")
    said_by("note", path, "wind from the west")
    assert path.read_bytes().startswith(before)
    document = json.loads(said_by("fit", path, "--json"))
    assert document["points"]["used"] == 7


def test_a_point_too_low_to_be_fitted_is_not_counted_as_used(said_by, tmp_path):
    points = tmp_path / "p.csv"
    said_by("export", "sessions/azel-good-day.jsonl", points)
    head, first = points.read_text("utf-8").split("T13:06:14", 1)
    points.write_text(f"{head}T11:40:00{first}", "utf-8")
    document = json.loads(said_by("fit", points, "--json"))
    assert any("below 5 deg of elevation" in note for note in document["notes"])
    assert (document["points"]["total"], document["points"]["used"]) == (12, 11)


def test_export_import_round_trip_gives_the_same_fit(session, said_by, tmp_path):
    path, _ = session
    said_by("export", path, tmp_path / "p.csv")
    said_by("import", tmp_path / "p.csv", tmp_path / "back.jsonl")
    # A points file carries neither limits nor weather, which only the other methods use.
    first, again = (
        json.loads(said_by("fit", file, "--method", "linear", "--json"))
        for file in (path, tmp_path / "back.jsonl")
    )
    for name, found in first["coefficients"].items():
        assert again["coefficients"][name]["value"] == pytest.approx(found["value"], abs=1e-9)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["fit", "nowhere.jsonl"], 2, "nowhere.jsonl is missing"),
        (["fit", "bad.csv"], 2, "bad.csv:4: column err2_deg: 'abc' is not a number"),
        (["fit", "broken.jsonl"], 2, "broken.jsonl:3"),
        (["fit", "short.dat"], 2, "short.dat:5"),
        (["fit", "points.xyz"], 2, "points are read from files ending in"),
        (["calibrate", "--scenario", "nosuch"], 2, "no scenario 'nosuch'"),
        (["calibrate", "--set", "truth.leen_deg=1"], 2, "did you mean truth.lean_deg"),
        (["calibrate", "--points", "2"], 2, "a fit needs at least three points"),
        (["calibrate", "--start", "yesterday"], 2, "not a date and time"),
        (["calibrate", "--port", "/dev/ttyNOPE"], 3, "does not exist"),
        (["sun", "--lat", "95", "--lon", "0", "--at", "2026-06-21"], 2, "--lat: 95 is not between"),
        (["calibrate", "--scenario", "screwjack", "--set",
          "unit.drive1=screwjack:1:2:90:10:100:-"], 2, "cannot close"),
    ],
)  # fmt: skip
def test_bad_input_gets_one_clear_line(session, tmp_path, monkeypatch, capsys, words, code, said):
    lines = session[0].read_text().splitlines()
    (tmp_path / "broken.jsonl").write_text("\n".join([*lines[:2], '{"type":', *lines[3:]]) + "\n")
    (tmp_path / "bad.csv").write_text(
        "# geometry=azel\n# lat_deg=35\nutc,ax1_deg,ax2_deg,err1_deg,err2_deg\n"
        "2026-06-21T15:00:00Z,10,20,0.1,abc\n"
    )
    (tmp_path / "short.dat").write_text("stars\n: ALTAZ\n-30 14 40.2\n10 40 10.1 40.1\n10 40 9\n")
    (tmp_path / "points.xyz").write_text("")
    monkeypatch.chdir(tmp_path)
    assert run_command(words) == code
    told = capsys.readouterr()
    assert told.out == ""
    last = told.err.strip().splitlines()[-1]
    assert last.startswith("solarcal: ")
    assert said in last
    assert "Traceback" not in told.err


def test_a_shell_gets_the_exit_code_and_the_line(tmp_path):
    done = solarcal("fit", "nowhere.jsonl", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("solarcal: nowhere.jsonl is missing")
    assert done.stderr.count("\n") == 1


def test_a_session_file_is_never_overwritten(session, capsys):
    path, _ = session
    before = path.read_bytes()
    assert run_command(["calibrate", "--points", "3", "-o", str(path)]) == 2
    assert str(path) in capsys.readouterr().err
    assert path.read_bytes() == before


def test_every_command_explains_itself_without_loading_anything_heavy():
    """All of them in one fresh interpreter; the first that loads something heavy is named."""
    code = (
        "import sys\n"
        "from solarcal.cli import COMMANDS, build_parser\n"
        "for command in COMMANDS:\n"
        "    text = build_parser(command).format_help()\n"
        "    heavy = {'numpy', 'scipy', 'textual', 'plotext', 'erfa', 'serial'} & {*sys.modules}\n"
        "    assert not heavy, (command, heavy)\n"
        "    print(command)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == list(COMMANDS)


def test_a_replay_at_a_speed_tells_every_record_in_its_order(session, said_by):
    path = session[0]
    told = said_by("replay", path, "--headless", "--speed", "1e6").splitlines()
    at_once = said_by("replay", path, "--headless").splitlines()
    records = path.read_text().count("\n") - 1
    # At once they stand below a heading and its rule.
    assert told[:records] == at_once[2 : 2 + records]
    assert told[-1] == at_once[-1]


@pytest.mark.parametrize(
    "words",
    [
        ("replay", "SESSION", "--speed", "0"),
        ("demo", "--headless", "--speed", "-1"),
        ("demo", "--headless", "--speed", "1e-320"),
        ("replay", "SESSION", "--speed", "1_000"),
        ("emulate", "--speed", "٣"),
    ],
)
def test_a_speed_that_cannot_be_is_refused(session, words, capsys):
    with pytest.raises(SystemExit) as left:
        run_command([str(session[0]) if word == "SESSION" else word for word in words])
    assert left.value.code == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "speed" in said
