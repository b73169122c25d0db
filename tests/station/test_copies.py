"""A point that several files hold is one point, whichever files they are."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from solarcal.session.interchange import read_table, session_from_table, write_table
from solarcal.session.journal import Journal
from solarcal.session.points import merge_tables
from solarcal.session.records import Void
from solarcal.session.view import read_session
from solarcal.station.analysing import UnitFiles, analyse_files, read_files

SAVED = Path(__file__).parents[2] / "sessions"
DAY = SAVED / "azel-good-day.jsonl"
COUNT = len(read_session(DAY).accepted)


def files(*paths: Path) -> UnitFiles:
    return read_files(paths, {})


def one_point_each(read: UnitFiles) -> bool:
    return read.table.count("accepted") == COUNT and [w for w in read.warnings if "once" in w] != []


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    path = tmp_path / "copy.jsonl"
    path.write_bytes(DAY.read_bytes())
    return path


@pytest.fixture
def csv(tmp_path: Path) -> Path:
    path = tmp_path / "day.csv"
    write_table(read_session(DAY).table, path)
    return path


def test_a_copy_or_a_link_of_a_session_adds_nothing(copy: Path, tmp_path: Path) -> None:
    link = tmp_path / "link.jsonl"
    link.symlink_to(DAY)
    for other in (copy, link):
        read = files(DAY, other)
        assert one_point_each(read)
        (said,) = [w for w in read.warnings if "once" in w]
        assert str(other) in said
        assert str(DAY) in said
        assert len(read.sessions) == 1
    alone, both = analyse_files(files(DAY)), analyse_files(files(DAY, copy))
    assert both.solution.as_json() == alone.solution.as_json()
    assert both.findings == alone.findings


def test_a_session_holds_its_points_before_an_export_of_it(csv: Path, tmp_path: Path) -> None:
    again = tmp_path / "imported.jsonl"
    session_from_table(read_table(csv), again, utc_s=0.0)
    for other in (csv, again):
        for given in ((DAY, other), (other, DAY)):
            read = files(*given)
            assert one_point_each(read)
            assert read.table.sources == (str(DAY),) * len(read.table)
            assert [s.header.unit.imported for s in read.sessions] == [False]


def test_points_files_of_the_same_points(csv: Path, tmp_path: Path) -> None:
    rounded = tmp_path / "rounded.csv"
    table = read_table(csv)
    columns = {n: getattr(table, n).round(3) for n in ("ax1_deg", "ax2_deg", "err1_deg")}
    write_table(replace(table, utc_s=table.utc_s.round(), **columns), rounded)
    assert one_point_each(files(csv, rounded))
    undated = tmp_path / "undated.csv"
    plain = replace(table, ideal="apparent", utc_s=np.full(len(table), np.nan))
    write_table(plain, undated)
    twice = tmp_path / "twice.csv"
    write_table(plain, twice)
    assert one_point_each(files(undated, twice))


def test_other_times_or_other_read_outs_are_other_points(csv: Path, tmp_path: Path) -> None:
    table, other = read_table(csv), tmp_path / "other.csv"
    write_table(replace(table, ideal="apparent"), csv)
    undated = np.full(len(table), np.nan)
    for changes in (
        {"utc_s": table.utc_s + 600.0},
        {"utc_s": undated, "err2_deg": table.err2_deg + 0.002},
        {"utc_s": undated, "ax1_deg": table.ax1_deg + 0.002},
    ):
        write_table(replace(table, ideal="apparent", **changes), other)
        read = files(csv, other)
        assert read.table.count("accepted") == 2 * COUNT
        assert read.warnings == ()


@pytest.mark.parametrize("reading_deg", [0.002, 0.1])
def test_two_readings_of_one_instant_are_one_point(csv, tmp_path, reading_deg: float) -> None:
    table, other = read_table(csv), tmp_path / "other.csv"
    ax1, err2 = table.ax1_deg.round(2), table.err2_deg + reading_deg
    write_table(replace(table, ax1_deg=ax1, err2_deg=err2), other)
    read = files(csv, other)
    assert one_point_each(read)
    said = [finding.sentence for finding in read.contradictions]
    assert len(said) == (reading_deg > 0.01)
    for text in said:
        assert "differ by 0.100 deg on the sky" in text
        assert f"of {csv} and " in text
        assert f"of {other}" in text
    alone, both = analyse_files(files(csv)), analyse_files(read)
    assert both.solution.values.tolist() == alone.solution.values.tolist()
    assert {*read.contradictions} <= {*both.findings}


def test_two_readings_of_one_instant_in_one_file_are_a_finding(csv: Path) -> None:
    table = read_table(csv)
    shifted = replace(table, err2_deg=table.err2_deg + 0.1)
    write_table(merge_tables((table, replace(shifted, sources=("b",) * COUNT))), csv)
    judged = analyse_files(files(csv))
    assert judged.solution.n_points == COUNT
    (said,) = [f.sentence for f in judged.findings if f.kind == "contradiction"]
    assert "differ by 0.100 deg on the sky" in said
    assert said in judged.analysis.verdict.reasons


def test_of_a_session_and_its_earlier_state_the_session_counts(tmp_path: Path) -> None:
    early, later = tmp_path / "early.jsonl", tmp_path / "later.jsonl"
    lines = DAY.read_bytes().splitlines(keepends=True)
    open_end = lines[:-1] if b'"closed"' in lines[-1] else lines
    early.write_bytes(b"".join(open_end))
    later.write_bytes(early.read_bytes())
    struck = read_session(early).accepted[2]
    with Journal.resume(later) as journal:
        utc = journal.records[-1].utc
        journal.append(Void(seq=journal.next_seq, utc=utc, voids=struck.seq, reason="a bird"))
    for given in ((early, later), (later, early)):
        read = files(*given)
        assert read.table.count("accepted") == COUNT - 1
        assert struck.seq not in read.table.accepted().labels
        (said,) = [w for w in read.warnings if "earlier state" in w]
        assert said == f"{early} is an earlier state of {later}: it is not used"


def test_what_a_session_struck_out_does_not_come_back_by_its_export(csv, copy: Path) -> None:
    struck = read_session(copy).accepted[2]
    with Journal.resume(copy) as journal:
        void = Void(
            seq=journal.next_seq, utc=struck.utc, voids=struck.seq, reason="a bird on the plate"
        )
        journal.append(void)
    read = files(csv, copy)
    assert read.table.count("accepted") == COUNT - 1
    (said,) = [w for w in read.warnings if "struck out" in w]
    assert said.startswith("point ")
    assert said.endswith(f"of {csv} is not used: not accepted, or struck out, in {copy}")
    assert {*read.table.sources} == {str(copy)}


def test_a_point_stored_again_on_the_offset_of_a_struck_one_counts(csv, copy: Path) -> None:
    struck = read_session(copy).accepted[2]
    with Journal.resume(copy) as journal:
        void = Void(seq=journal.next_seq, utc=struck.utc, voids=struck.seq, reason="by mistake")
        journal.append(void)
        journal.append(msgspec.structs.replace(struck, seq=journal.next_seq))
    assert files(csv, copy).table.count("accepted") == COUNT
    assert files(copy, csv).table.count("accepted") == COUNT


def test_a_file_that_holds_more_keeps_what_both_hold(csv: Path, tmp_path: Path) -> None:
    part = tmp_path / "part.csv"
    table = read_table(csv)
    write_table(table.rows(range(4)), part)
    (of_both,) = {*files(part, csv).table.sources}
    assert of_both == str(csv)


def test_identical_rows_of_one_file_count_once_beside_another_file(csv, tmp_path: Path) -> None:
    table, other = read_table(csv), tmp_path / "second.csv"
    write_table(replace(table, utc_s=table.utc_s + 7.0 * 86400.0, ideal="apparent"), other)
    plain = replace(table, ideal="apparent")
    write_table(plain.rows([*range(len(table)), 0, 0]), csv)
    solution = analyse_files(files(csv, other)).solution
    assert len(solution.points) == 2 * COUNT
    assert len(solution.points.copies) == 2


@pytest.mark.parametrize("method", ["robust", "linear"])
def test_files_that_alternate_in_time_and_differ_do_not_fit_by_any_method(csv, tmp_path, method):
    table, other = replace(read_table(csv), ideal="apparent"), tmp_path / "other.csv"
    moved = replace(table, err2_deg=table.err2_deg + 0.4)
    write_table(table.rows(range(0, COUNT, 2)), csv)
    write_table(moved.rows(range(1, COUNT, 2)), other)
    judged = analyse_files(files(csv, other), method=method)
    (said,) = [f for f in judged.findings if f.kind == "contradiction"]
    assert said.sentence in judged.analysis.verdict.reasons
    assert judged.analysis.verdict.state == "does_not_fit"
