"""`solarcal fit` of several files: two days of one unit are one fit, two units are refused."""

import copy
import json
import re
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from solarcal.cli import run_command
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_tcp
from solarcal.mount.formula import Coefficients
from solarcal.session.view import read_session
from solarcal.station.analysing import analyse_files, read_files
from solarcal.station.curves import table_plot_data


def calibrate(folder: Path, name: str, *options: str) -> Path:
    path = folder / f"{name}.jsonl"
    argv = ["calibrate", "--points", "5", "--every", "90", "-o", str(path), *options]
    assert run_command(argv) == 0
    return path


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("merged")
    return {
        "june": calibrate(folder, "june", "--start", "2026-06-03", "--seed", "1"),
        "september": calibrate(folder, "september", "--start", "2026-09-20", "--seed", "2"),
        "other": calibrate(
            folder, "other", "--start", "2026-06-03", "--set", "unit.serial=another-unit"
        ),
    }


def fit(capsys: pytest.CaptureFixture[str], *files: Path, options: tuple[str, ...] = ()) -> Any:
    capsys.readouterr()
    assert run_command(["fit", *map(str, files), *options, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_two_days_of_one_unit_are_one_fit(
    files: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    june, september = fit(capsys, files["june"]), fit(capsys, files["september"])
    both = fit(capsys, files["june"], files["september"])
    assert both["files"] == ["june.jsonl", "september.jsonl"]
    assert both["points"]["total"] == june["points"]["total"] + september["points"]["total"]
    assert both["points"]["used"] == 10
    assert both["geometry"] == "azel"
    # The Sun of two seasons pins what one leaves open.
    for name, found in both["coefficients"].items():
        for alone in (june, september):
            assert found["sigma"] < alone["coefficients"][name]["sigma"]


def test_a_session_broken_off_before_its_first_point_changes_nothing(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = tmp_path / "begun.jsonl"
    begun.write_bytes(files["june"].read_bytes().splitlines(keepends=True)[0])
    alone, both = fit(capsys, files["june"]), fit(capsys, begun, files["june"])
    assert both["files"] == ["begun.jsonl", "june.jsonl"]
    assert both["coefficients"] == alone["coefficients"]
    assert run_command(["fit", str(begun)]) == 2
    assert "no points to fit" in capsys.readouterr().err


def test_the_order_of_the_files_does_not_matter(
    files: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    manual = ("--method", "linear")
    there = fit(capsys, files["june"], files["september"], options=manual)
    back = fit(capsys, files["september"], files["june"], options=manual)
    for name, found in there["coefficients"].items():
        assert back["coefficients"][name]["value"] == pytest.approx(found["value"], abs=1e-9)
    assert (
        there["condition_number"] < fit(capsys, files["june"], options=manual)["condition_number"]
    )


def test_the_text_tells_the_points_of_both_days(
    files: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run_command(["fit", str(files["june"]), str(files["september"])]) == 0
    said = capsys.readouterr().out
    assert "10 points" in said or "10 of 10" in said


def refusal(capsys: pytest.CaptureFixture[str], *files: Path) -> str:
    capsys.readouterr()
    assert run_command(["fit", *map(str, files), "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


def test_files_of_two_units_are_refused(
    files: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    said = refusal(capsys, files["june"], files["other"])
    assert "another-unit" in said
    assert str(files["other"]) in said


def test_a_file_given_twice_is_refused(
    files: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert "given twice" in refusal(capsys, files["june"], files["june"])


@pytest.fixture(scope="module")
def moved(files: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Axis 1's zero is half a degree elsewhere in August."""
    folder = tmp_path_factory.mktemp("moved")
    path = folder / "august.jsonl"
    options = ["--start", "2026-08-03", "--seed", "3", "--set", "truth.P2=0.15", "--force", "moved"]
    argv = ["calibrate", "--points", "6", "--every", "80", "-o", str(path), *options]
    assert run_command(argv) == 0
    return path


def test_what_is_left_of_a_point_is_counted_after_its_own_sessions_shift(
    files: dict[str, Path], moved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run_command(["fit", str(files["june"]), str(moved)]) == 0
    text = capsys.readouterr().out
    assert "the zeros of axis 1 and 2 changed by" in " ".join(text.split())
    rows = [line.split() for line in text.splitlines() if line.endswith(" accepted")]
    assert len(rows) == 11
    left = [float(row[-2]) for row in rows]
    # As the line of the summary says; and as small as the noise, on both sides of the move.
    (told,) = re.findall(r"as beside each point: rms [0-9.]+ deg, largest ([0-9.]+)", text)
    assert max(left) == pytest.approx(float(told), abs=0.003)
    assert max(left) < 0.08
    both = analyse_files(read_files([files["june"], moved], {}))
    shown = table_plot_data(both.table, both.solution)
    assert np.abs(shown.points.residual2_deg).max() < 0.08
    sine = np.sin(np.radians(shown.points.ax2_deg))
    assert np.abs(shown.points.residual1_deg * sine).max() < 0.08
    # The model's dots of each day pass its points.
    points, dots = shown.points, shown.model
    for at, day in enumerate(points.day):
        hours = np.where(np.array(dots.day) == day, dots.solar_time_h, np.inf)
        near = int(np.argmin(np.abs(hours - points.solar_time_h[at])))
        across = dots.err1_deg[near] - points.err1_deg[at]
        assert abs(across * np.sin(np.radians(points.ax2_deg[at]))) < 0.1


def test_points_of_several_files_are_named_with_theirs(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lost = tmp_path / "lost.jsonl"
    options = ["--start", "2026-07-20", "--seed", "2", "--force", "short", "-o", str(lost)]
    words = ["calibrate", "--scenario", "missed-counts", "--points", "8", "--every", "60"]
    assert run_command([*words, *options]) == 0
    alone, both = fit(capsys, lost), fit(capsys, files["june"], lost)
    (one,) = [f for f in alone["findings"] if f["kind"] == "missed_counts"]
    (other,) = [f for f in both["findings"] if f["kind"] == "missed_counts"]
    assert one["sentence"].startswith("reference check 3 found")
    assert other["sentence"].startswith(f"{lost}: reference check 3 found")
    assert other["points"] == one["points"] or set(one["points"]) <= set(other["points"])
    named = analyse_files(read_files([files["june"], lost], {})).solution.labels
    assert str(named[0]) == f"5 of {files['june']}"
    assert str(named[-1]).endswith(f" of {lost}")
    assert copy.deepcopy(named) == named
    # What every session says alike is said once, and without names.
    clocks = [f["sentence"] for f in both["findings"] if "laptop's own clock" in f["sentence"]]
    assert len(clocks) == 1
    assert clocks[0].startswith("a constant error of the laptop's own clock")


def test_the_fit_of_two_days_is_written_and_recorded_in_the_newer(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In whatever order they are named."""
    june, september = (tmp_path / f"{name}.jsonl" for name in ("june", "september"))
    for path in (june, september):
        path.write_bytes(files[path.stem].read_bytes())
    was = june.read_bytes()
    fitted = fit(capsys, september, june)["coefficients"]
    with serve_tcp(Emulator(load_scenario("tijeras-azel", []), seed=3), "127.0.0.1", 0) as port:
        line = ["--port", port, "--json"]
        assert run_command(["upload", str(september), str(june), *line]) == 0
        told = json.loads(capsys.readouterr().out)
    assert (told["file"], told["files"]) == ("september.jsonl", ["september.jsonl", "june.jsonl"])
    assert told["verified"] is True
    unit = read_session(september).header.unit
    written = Coefficients(**{name: found["value"] for name, found in fitted.items()})
    assert told["new_coefficients"] == msgspec.to_builtins(
        written.rounded(unit.tilt_decimals, unit.scale_decimals)
    )
    assert june.read_bytes() == was
    records = read_session(september).records
    assert records[-1].seq == told["seq"]
    assert "the fit of september.jsonl, june.jsonl together" in str(records[-3])


def test_the_files_of_two_units_are_not_written_into_one(
    files: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    before = [files[name].read_bytes() for name in ("september", "other")]
    words = ["upload", str(files["september"]), str(files["other"]), "--port", "/dev/nowhere"]
    assert run_command(words) == 2
    assert "another-unit" in capsys.readouterr().err
    assert [files[name].read_bytes() for name in ("september", "other")] == before
    words[2] = "points.csv"
    assert run_command(words) == 2
    assert "points.csv: uploads are recorded in the session file" in capsys.readouterr().err
