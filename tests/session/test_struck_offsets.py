"""A point taken on a Set Sun Offset that is struck out is not used, and the program reports it."""

import shutil
from pathlib import Path

import msgspec
import pytest

from solarcal.cli import run_command
from solarcal.session.parsing import NeedsWholeReader, read_points_only
from solarcal.session.records import CheckRecord, Record, Void
from solarcal.session.view import SessionView, read_session, view_session
from solarcal.station.point_judgement import point_evidence

DAY = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"


@pytest.fixture(scope="module")
def day() -> SessionView:
    return read_session(DAY)


def with_records(day: SessionView, *voids: int) -> SessionView:
    records: list[Record] = list(day.records)
    for seq in voids:
        last = records[-1]
        records.append(Void(seq=last.seq + 1, utc=last.utc, voids=seq, reason="wrong place"))
    return view_session(day.header, tuple(records))


def test_its_point_is_not_used_until_it_is_restored(day: SessionView) -> None:
    offset = day.sun_offsets[1]
    (point,) = [p for p in day.accepted if p.read_utc == offset.instant]
    struck = with_records(day, offset.seq)
    assert [p.seq for p in day.accepted if p not in struck.accepted] == [point.seq]
    (shown,) = [p for p in struck.points if p.seq == point.seq]
    assert shown.status == "rejected"
    assert shown.reason == f"its Set Sun Offset, record {offset.seq}, is struck out"
    assert point.seq not in struck.table.accepted().labels
    evidence = point_evidence(struck, point)
    assert evidence.sun_offset == offset
    assert evidence.void is not None
    restored = with_records(struck, evidence.void.seq)
    assert restored.accepted == day.accepted


def test_a_point_that_took_no_error_from_it_stays(day: SessionView) -> None:
    offset = day.sun_offsets[1]
    gathered = [
        msgspec.structs.replace(p, basis="gathering") if p in day.accepted else p
        for p in day.records
    ]
    session = with_records(view_session(day.header, tuple(gathered)), offset.seq)
    assert len(session.accepted) == len(day.accepted)


def test_a_check_point_goes_with_it(day: SessionView) -> None:
    check = next(r for r in day.records if isinstance(r, CheckRecord) and r.status == "accepted")
    offset = next(o for o in day.sun_offsets if o.instant == check.read_utc)
    struck = with_records(day, offset.seq)
    assert [c.status for c in struck.checks if c.seq == check.seq] == ["rejected"]
    assert check not in struck.checks_after(struck.uploads[-1])


def test_the_command_and_every_reader_name_the_point(day, tmp_path: Path, capsys) -> None:
    path = tmp_path / "day.jsonl"
    shutil.copy(DAY, path)
    offset = day.sun_offsets[1]
    (point,) = [p for p in day.accepted if p.read_utc == offset.instant]
    assert run_command(["void", str(path), str(offset.seq), "--reason", "wrong place"]) == 0
    sentence = f"point {point.seq} is not used: its Set Sun Offset, record {offset.seq}, is struck"
    assert sentence in capsys.readouterr().err
    assert sentence in " ".join(read_session(path).warnings)
    with pytest.raises(NeedsWholeReader):
        read_points_only(path)
