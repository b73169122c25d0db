"""``solarcal void``, ``note``, ``import`` and ``export``."""

import json
from pathlib import Path

import pytest
from session_samples import HEADER, assert_same_points, note, point, table

from solarcal.cli import run_command
from solarcal.session.interchange import read_table, write_table
from solarcal.session.journal import Journal
from solarcal.session.view import read_session


@pytest.fixture
def day(tmp_path: Path) -> Path:
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER) as journal:
        for record in (point(1), point(2), point(3, "rejected"), note(4)):
            journal.append(record)
    return path


def refused(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    """Run a command that must be refused with exit code 2 and one line; that line."""
    assert run_command([str(word) for word in words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


def test_a_void_strikes_a_point_and_another_restores_it(
    day: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = day.read_bytes()
    assert run_command(["void", str(day), "2", "--reason", "bird on the plate", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["seq"], document["voids"]) == (5, 2)
    assert day.read_bytes().startswith(before)
    assert [p.seq for p in read_session(day).points] == [1, 3]
    assert run_command(["void", str(day), "5", "--reason", "no bird after all"]) == 0
    assert "record 5 is void" in capsys.readouterr().out
    assert [p.seq for p in read_session(day).points] == [1, 2, 3]


def test_voids_that_make_no_sense_change_nothing(
    day: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = day.read_bytes()
    assert "the header" in refused(capsys, "void", day, 0, "--reason", "x")
    assert "no record 77" in refused(capsys, "void", day, 77, "--reason", "x")
    assert "--reason is empty" in refused(capsys, "void", day, 1, "--reason", " ")
    assert "cannot be opened" in refused(capsys, "void", day / "no", 1, "--reason", "x")
    assert day.read_bytes() == before


def test_a_note_is_appended(day: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command(["note", str(day), "Süd­wind", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["seq"] == 5
    assert read_session(day).records[-1].text == "Süd­wind"  # type: ignore[union-attr]
    assert "the note is empty" in refused(capsys, "note", day, "")
    assert "cannot be written" in refused(capsys, "note", day, "\udcff")


def test_a_session_somebody_is_writing_is_left_alone(
    day: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Journal.resume(day):
        assert "is being written by" in refused(capsys, "note", day, "hello")
        assert "is being written by" in refused(capsys, "void", day, 1, "--reason", "x")


def test_export_and_import_bring_the_points_back(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    csv, back = tmp_path / "out.csv", tmp_path / "back.jsonl"
    assert run_command(["export", str(day), str(csv), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["points"] == {
        "total": 3, "accepted": 2, "aborted": 0, "rejected": 1,
    }  # fmt: skip
    assert run_command(["import", str(csv), str(back), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["session"], document["unknown"]) == (str(back), [])
    assert_same_points(read_table(back), read_table(day))


def test_tpoint_both_ways(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, session, second = (tmp_path / name for name in ("a.dat", "b.jsonl", "c.dat"))
    write_table(table(longitude_deg=None), first)
    assert run_command(["import", str(first), str(session)]) == 0
    captured = capsys.readouterr()
    assert captured.out == f"3 points (3 accepted) in {session}\n"
    assert "the longitude is not known" in captured.err
    assert run_command(["export", str(session), str(second)]) == 0
    assert second.read_bytes() == first.read_bytes()


def test_options_complete_an_import(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "a.csv"
    source.write_text("utc,ax1_deg,ax2_deg,err1_deg,err2_deg\n,10,40,0.1,0.2\n")
    words = ["--geometry", "polar", "--lat", "-20", "--lon", "55", "--elevation", "5"]
    target = tmp_path / "b.jsonl"
    assert "--geometry" in refused(capsys, "import", source, target)
    assert run_command(["import", str(source), str(target), *words, "--unit", "B"]) == 0
    header = read_session(target).header
    assert (header.geometry, header.site.latitude_deg, header.unit.serial) == ("polar", -20.0, "B")


def test_an_import_tells_of_times_that_do_not_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_table(table(), tmp_path / "a.csv")
    assert run_command(["import", str(tmp_path / "a.csv"), str(tmp_path / "b.jsonl")]) == 0
    assert "check utc, site and geometry" in capsys.readouterr().err


def test_bad_files_and_endings_are_one_line(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = tmp_path / "short.dat"
    short.write_text("caption\n: ALTAZ\n-30 14 40.2\n120.0 30.0 119.9\nEND\n")
    assert "short.dat:4: 3 numbers" in refused(capsys, "import", short, tmp_path / "x.jsonl")
    assert not (tmp_path / "x.jsonl").exists()
    assert "ends in .jsonl" in refused(capsys, "import", short, tmp_path / "x.txt")
    assert "exists already" in refused(capsys, "import", day, day)
    assert "written as .csv or .dat" in refused(capsys, "export", day, tmp_path / "x.xls")
    sheet = tmp_path / "x.xls"
    assert "is missing" in refused(capsys, "export", sheet, tmp_path / "x.csv")
    sheet.write_text("what is this")
    assert "points are read from" in refused(capsys, "export", sheet, tmp_path / "x.csv")
    polar = tmp_path / "polar.csv"
    write_table(table(geometry="polar"), polar)
    assert "azel only" in refused(capsys, "export", polar, tmp_path / "x.dat")
