"""What all commands do alike: one line for a usage error, full disks, poor terminals, --debug."""

import io
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from solarcal.cli import run_command
from solarcal.session.view import read_session
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fit"], "solarcal fit: the following arguments are required: FILE"),
        (["fit", "a.jsonl", "--tolerance", "nan"], "'nan' is not an angle above 0"),
        (["fleet", ".", "--top", "-1"], "argument --top: -1 is not 0 or more"),
        (["two-mirror", "trace"], "solarcal two-mirror trace: the following arguments"),
        (["fit", "a.jsonl", "--method", "exact", "--nope"], "solarcal fit: unrecognized"),
        (["fti", "a.jsonl"], "invalid choice: 'fti'"),
        (["calibrate", "--port", ""], "argument --port: is empty"),
        (["calibrate", "-o", "-"], "argument -o/--output: -: a session file ends in .jsonl"),
        (["calibrate", "-o", "day.csv"], "day.csv: a session file ends in .jsonl"),
        (["run", "-o", "day"], "day: a session file ends in .jsonl"),
        (["demo", "-o", "day.txt"], "day.txt: a session file ends in .jsonl"),
        (["run", "--port", " "], "argument --port: is empty"),
        (["upload", "a.jsonl", "--port", "p", "--baudrate", "0"], "'0' is no rate from 300"),
        (["upload", "a.jsonl", "--port", "p", "--baudrate", "-5"], "'-5' is no rate from 300"),
    ],
)
def test_a_usage_error_is_one_line_that_names_the_help(capsys, words, said):
    with pytest.raises(SystemExit) as left:
        run_command(words)
    out, err = capsys.readouterr()
    assert left.value.code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert said in err
    assert "--help` lists the options" in err


@pytest.mark.parametrize(
    "words", [["--debug", "fit", "no.jsonl"], ["fit", "no.jsonl", "--debug"]], ids=["first", "last"]
)
def test_debug_shows_the_traceback_and_keeps_the_exit_code(capsys, words):
    assert run_command(words) == 2
    err = capsys.readouterr().err
    assert err.startswith("Traceback")
    assert err.endswith("solarcal: no.jsonl is missing: no such file\n")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
def test_a_full_disk_is_one_line(capsys, monkeypatch):
    with open("/dev/full", "w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert run_command(["sun", "--lat", "35", "--lon", "0"]) == 2
    assert capsys.readouterr().err == (
        "solarcal: the output cannot be written: No space left on device\n"
    )


def _through_a_shell(words, redirections="", buffered=True, typed=""):
    environment = {**os.environ, "PYTHONUNBUFFERED": "" if buffered else "1"}
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", f'"{sys.executable}" -m solarcal {words} {redirections}'],
        env=environment,
        input=typed,
        capture_output=True,
        text=True,
    )


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
@pytest.mark.parametrize("buffered", [True, False])
@pytest.mark.parametrize("words", ["--help", "fit --help", "--version", "scenarios --json"])
def test_an_output_that_cannot_be_written_is_no_success(words, buffered):
    for redirection, reason in ((">/dev/full", "No space left on"), (">&-", "Bad file descriptor")):
        ended = _through_a_shell(words, redirection, buffered)
        assert ended.returncode == 2
        assert ended.stderr.startswith(f"solarcal: the output cannot be written: {reason}")
        assert ended.stderr.count("\n") == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
@pytest.mark.parametrize("words", ["--help", "scenarios"])
def test_a_reader_that_leaves_is_no_failure(words):
    ended = _through_a_shell(words, "| true")
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("fit sessions/azel-good-day.jsonl --require done", 0),
        ("fit sessions/azel-good-day.jsonl --tolerance 0.001", 0),
        ("fit sessions/azel-good-day.jsonl --tolerance 0.001 --require done", 1),
        ("fit sessions/azel-good-day.jsonl --tolerance 0.001 --require done --json", 1),
        ("calibrate --scenario tijeras-azel --points 3 2>&1", 1),
    ],
)
def test_the_exit_code_is_what_was_found_though_no_reader_is_left(words, code, tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    try:
        ended = subprocess.run(
            ["bash", "-c", f'exec "{sys.executable}" -m solarcal {words}'],
            env={**os.environ, "XDG_DATA_HOME": str(tmp_path)},
            stdout=writing,
            stderr=subprocess.DEVNULL,
        )
    finally:
        os.close(writing)
    assert ended.returncode == code


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
@pytest.mark.parametrize("redirection", ["2>/dev/full", "2>&-", "2>&- <&-"])
def test_a_stderr_that_fails_changes_no_exit_code_and_no_result(redirection):
    assert _through_a_shell("fit no.csv", redirection).returncode == 2
    assert _through_a_shell("run", redirection).returncode == 2
    at_night = "--lat 35 --lon 0 --at 2026-06-03T00:00Z --model noaa --json"
    ended = _through_a_shell(f"sun {at_night}", redirection)
    assert (ended.returncode, ended.stderr) == (0, "")
    json.loads(ended.stdout)


def test_a_dash_is_standard_input_in_every_format_of_points(tmp_path, capsys):
    session = Path("sessions/azel-good-day.jsonl")
    points = tmp_path / "day.csv"
    assert run_command(["export", str(session), str(points)]) == 0
    for file in (session, points):
        capsys.readouterr()
        assert run_command(["fit", str(file), "--json"]) == 0
        expected = json.loads(capsys.readouterr().out)
        ended = _through_a_shell("fit - --json", typed=file.read_text("utf-8"))
        assert json.loads(ended.stdout) == {**expected, "files": ["-"]}


def test_an_archive_names_what_came_from_standard_input(tmp_path):
    session = Path("sessions/azel-good-day.jsonl").read_text("utf-8")
    ended = _through_a_shell(f'report - -o "{tmp_path / "day.html"}" --zip', typed=session)
    assert ended.returncode == 0, ended.stderr
    with zipfile.ZipFile(tmp_path / "day.zip") as archive:
        assert archive.read("standard-input").decode("utf-8") == session


@pytest.mark.parametrize("typed", ["", "hello\n"])
def test_standard_input_without_points_is_bad_input(typed):
    ended = _through_a_shell("forecast -", typed=typed)
    assert ended.returncode == 2
    assert ended.stderr.startswith("solarcal: standard input is in no format that points are read")
    assert ended.stderr.count("\n") == 1


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_drawings_reach_a_terminal_that_is_not_utf8(monkeypatch, encoding):
    words = ["day", "--lat", "35", "--lon", "0", "--at", "2026-06-21", "--chart"]
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
    assert run_command(words) == 0
    text = raw.getvalue().decode(encoding)
    assert "+---" in text
    assert "*" in text
    assert "?" not in text


def test_terms_may_be_written_with_spaces_and_not_left_empty(capsys):
    session = "sessions/azel-good-day.jsonl"
    assert run_command(["fit", session, "--terms", "P2, P4", "--json"]) == 0
    capsys.readouterr()
    assert run_command(["fit", session, "--terms", ""]) == 2
    assert "there is no error term ''" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("calibrate --trace line.txt", "--trace is for a unit on a line: give --port"),
        ("calibrate --baudrate 1200", "--baudrate is for a unit on a line: give --port"),
        ("calibrate --port loop:// --set truth.P1=0.3", "--set is for an emulated tracker"),
        ("calibrate --port loop:// --start 2026-06-03", "--start is for an emulated tracker"),
        ("calibrate --port loop:// --seed 0", "--seed is for an emulated tracker"),
        ("calibrate --scenario polar --site s.toml", "--site is for a unit on a line: leave"),
        ("calibrate --scenario polar --profile roof", "--profile is for a unit on a line: leave"),
        ("calibrate --scenario polar --trace t.txt", "--trace is for a unit on a line: leave"),
        ("calibrate --input b.book --seed 3", "--seed is for an emulated tracker"),
        ("calibrate --input b.book --points 3", "--points is for a unit on a line; the book"),
        ("calibrate --input b.book --trace t", "--trace is for a unit on a line"),
        ("track --port loop:// --driver rotctld --seed 1", "--seed is for an emulated tracker"),
        ("track --port loop:// --noise-deg 0.1", "--noise-deg is for an emulated tracker"),
        ("track --scenario tijeras-azel --site s.toml", "--site is for a unit on a line: leave"),
        ("track --scenario tijeras-azel --input b.book", "--input is for a unit without a line"),
        ("run --input b.book", "--input is for calibrate, upload and rollback"),
        ("run --scenario polar --baudrate 1200", "--baudrate is for a unit on a line"),
        ("run --scenario polar --driver typed", "there is no emulated unit for driver typed"),
        ("run --scenario polar --driver rotctld --trace t", "--trace is for a unit on a line"),
        ("run --continue a.jsonl -o b.jsonl", "--output is for a new session"),
        ("run --continue a.jsonl --driver rotctld", "--driver is for a new session"),
        ("run --offline --trace t.txt", "--trace is for a unit; --offline opens none"),
    ],
)
def test_an_option_that_the_unit_has_no_use_for_is_not_passed_over(capsys, words, said):
    assert run_command(words.split()) == 2
    assert capsys.readouterr().err.startswith(f"solarcal: {said}")


@pytest.mark.parametrize("option", ["--points 3", "--method exact", "--force why"])
def test_the_demonstration_on_a_screen_takes_no_option_of_the_one_without(
    capsys, monkeypatch, option
):
    monkeypatch.setattr("solarcal.cli.run.has_terminal", lambda: True)
    assert run_command(["demo", *option.split()]) == 2
    said = f"solarcal: {option.split()[0]} is for a demonstration without a screen: give --headless"
    assert capsys.readouterr().err.startswith(said)


def test_a_rotator_is_emulated_on_the_screen_of_run_too(monkeypatch):
    opened = []
    monkeypatch.setattr("solarcal.cli.run.has_terminal", lambda: True)
    monkeypatch.setattr(
        "solarcal.cli.run.run_workstation", lambda choice, **how: opened.append(choice) or 0
    )
    assert run_command(["run", "--scenario", "tijeras-azel", "--driver", "rotctld"]) == 0
    assert opened[0].driver == "rotctld"


def test_a_start_on_a_date_is_that_morning_at_the_site(capsys, tmp_path):
    session = tmp_path / "winter.jsonl"
    words = ["calibrate", "--start", "2026-12-21", "--points", "3", "-o", str(session)]
    assert run_command(words) == 0
    header = read_session(session).header
    # 12 deg up, some minutes after the 10 deg of the next test.
    assert header.utc.startswith("2026-12-21T15:2")
    sun = sun_position("solartrak", np.array([parse_utc(header.utc)]), header.site)
    assert 12.0 <= float(sun.elevation_deg[0]) < 12.2
    assert "waiting for the morning" not in capsys.readouterr().err


def test_a_calibration_begun_at_night_waits_for_the_morning(capsys, tmp_path):
    session = tmp_path / "winter.jsonl"
    words = ["calibrate", "--start", "2026-12-21T08:00Z", "--points", "3", "-o", str(session)]
    assert run_command(words) == 0
    assert "the Sun is down; waiting for the morning\n" in capsys.readouterr().err
    first = next(line for line in session.read_text().splitlines() if '"type":"point"' in line)
    # 10 deg up at about 15:15 UTC in New Mexico.
    assert '"utc":"2026-12-21T15:' in first


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["--start", "1950-01-01"],
            "start 1950-01-01: no Sun for 1950-01-01T07:00:00Z: the models hold from 1960",
        ),
        (["--noise-deg", "1e300"], "truth.noise_deg: 1e+300 is more than 10"),
    ],
)
def test_an_emulator_that_cannot_be_is_bad_input(capsys, words, said):
    assert run_command(["calibrate", *words]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_a_sessions_folder_that_cannot_be_made_is_one_line(capsys, tmp_path, monkeypatch):
    in_the_way = tmp_path / "sessions"
    in_the_way.touch()
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(in_the_way / "mine"))
    assert run_command(["calibrate", "--points", "3"]) == 2
    err = capsys.readouterr().err
    assert f"the sessions folder {in_the_way / 'mine'} cannot be made: Not a directory" in err
    assert err.count("\n") == 1


def test_a_remark_stays_one_line_and_cannot_steer_the_terminal(capsys, tmp_path):
    session = tmp_path / "s.jsonl"
    session.write_bytes(Path("sessions/azel-good-day.jsonl").read_bytes())
    assert run_command(["note", str(session), "one\ntwo \x1b[31mred"]) == 0
    capsys.readouterr()
    assert run_command(["replay", str(session), "--headless"]) == 0
    out = capsys.readouterr().out
    assert "note: one two \\x1b[31mred\n" in out
    assert "\x1b" not in out


GOOD_DAY = "sessions/azel-good-day.jsonl"


def test_export_writes_over_nothing_unless_told_and_says_what_tpoint_cannot(capsys, tmp_path):
    target = tmp_path / "points.dat"
    assert run_command(["export", GOOD_DAY, str(target)]) == 0
    assert "TPOINT cannot record that the angles are solartrak" in capsys.readouterr().err
    kept = target.read_bytes()
    target.write_text("mine\n")
    assert run_command(["export", GOOD_DAY, str(target)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert target.read_text() == "mine\n"
    assert run_command(["export", GOOD_DAY, str(target), "--replace"]) == 0
    assert target.read_bytes() == kept


def test_a_session_with_an_editors_byte_order_mark_is_read(capsys, tmp_path):
    session = tmp_path / "s.jsonl"
    session.write_bytes(b"\xef\xbb\xbf" + Path(GOOD_DAY).read_bytes())
    assert run_command(["note", str(session), "after the mark"]) == 0
    capsys.readouterr()
    assert run_command(["fit", str(session), "--json"]) == 0
    assert '"used": 12' in capsys.readouterr().out


def test_a_calibration_has_an_end(capsys):
    assert run_command(["calibrate", "--points", "100000"]) == 2
    assert "more than 500" in capsys.readouterr().err


def test_a_name_that_is_no_utf_8_is_written_out_in_every_document(tmp_path, capsys):
    session = tmp_path / "bad\udcff.jsonl"
    session.write_bytes(Path(GOOD_DAY).read_bytes())
    for words in (["fit", str(session)], ["fleet", str(tmp_path)]):
        assert run_command([*words, "--json"]) == 0
        text = capsys.readouterr().out
        assert r"bad\\udcff.jsonl" in text
        json.dumps(json.loads(text), ensure_ascii=False).encode("utf-8")


def test_a_key_that_resembles_nothing_is_pointed_to_the_list(capsys):
    assert run_command(["calibrate", "--set", "zzqqxx=1"]) == 2
    assert "`solarcal scenarios NAME` shows them all" in capsys.readouterr().err


def test_now_is_an_instant_for_the_sun_too(capsys):
    assert run_command(["sun", "--lat", "35", "--lon", "-106", "--at", "now", "--json"]) == 0
    assert '"utc"' in capsys.readouterr().out


def test_a_file_name_longer_than_the_system_allows_is_one_line(capsys):
    assert run_command(["export", "sessions/azel-good-day.jsonl", "A" * 5000 + ".csv"]) == 2
    err = capsys.readouterr().err
    assert "has 5004 characters" in err
    assert err.count("\n") == 1
