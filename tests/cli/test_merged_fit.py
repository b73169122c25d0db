"""`solarcal fit` of several files: two days of one unit are one fit, two units are refused."""

import json
from pathlib import Path
from typing import Any

import pytest

from solarcal.cli import run_command


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
