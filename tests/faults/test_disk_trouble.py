"""Disk full, read-only, a file opened twice, a clock that steps back, a very long session."""

import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from faulty_bench import PersistentTechnician, faulty_line

from soak.journal_writer import HEADER, note
from solarcal.cli import run_command
from solarcal.errors import LinkError, SessionFileError
from solarcal.session.disk import Disk
from solarcal.session.journal import Journal
from solarcal.session.records import Closed, LinkLost, Note, PointRecord
from solarcal.session.view import read_session
from solarcal.station.state import Activity, LinkState
from solarcal.timescale import parse_utc


class FillingDisk(Disk):
    """Room for ``room`` bytes more: the line that does not fit is written in part."""

    def __init__(self) -> None:
        self.room: int | None = None

    def write(self, descriptor: int, content: bytes) -> int:
        if self.room is None:
            return super().write(descriptor, content)
        if not self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        taken = super().write(descriptor, content[: self.room])
        self.room -= taken
        return taken


@pytest.fixture
def bench(tmp_path):
    """A technician at the first point, the session on a disk that may fill up."""
    disk = FillingDisk()
    create = Journal.create
    technician = PersistentTechnician(
        faulty_line(), tmp_path / "s.jsonl", lambda step: None, lambda p, h: create(p, h, disk=disk)
    )
    technician.step("clock", technician.station.set_unit_clock)
    technician.step("reference check", technician.reference_check)
    technician.step("initialise", lambda: technician.station.initialise(confirmed=True))
    return technician, disk


def short(seq: int) -> Note:
    return Note(seq=seq, utc=HEADER.utc, text=f"remark {seq}")


def append_until_it_fails(journal: Journal) -> None:
    while True:
        journal.append(short(journal.next_seq))


def refused_for_want_of_room(action: Callable[[], object], path: Path) -> None:
    with pytest.raises(SessionFileError, match="No space left on device") as refusal:
        action()
    assert str(path) in str(refusal.value)
    assert "is not saved" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_point_that_finds_no_room_waits_with_its_answers_until_there_is(bench):
    technician, disk = bench
    station = technician.station
    technician.sight.centre()
    station.set_sun_offset()
    technician.sight.watch()
    technician.questions(False)
    candidate = station.gather_point()
    before = read_session(technician.path).records
    for room in (0, 1, 40, 300):
        disk.room = room
        refused_for_want_of_room(lambda: station.store(True), technician.path)
        assert station.state.activity is Activity.RESULT
        assert station.session.accepted == ()
        # Half a line is no record, and the file stays readable.
        assert read_session(technician.path).records == before
    disk.room = None
    stored = station.store(True)
    assert isinstance(stored, PointRecord)
    assert stored.error_deg == candidate.error_deg
    assert station.state.activity is Activity.IDLE
    assert read_session(technician.path).records == (*before, stored)


def test_what_the_unit_did_without_room_to_record_it_can_be_done_again(bench):
    technician, disk = bench
    station = technician.station
    technician.sight.centre()
    for step in (station.set_sun_offset, station.ref_check, lambda: station.note("windy")):
        disk.room = 10
        refused_for_want_of_room(step, technician.path)
        assert station.state.activity is Activity.IDLE
        disk.room = None
        recorded = step()
        assert read_session(technician.path).records[-1] == recorded


def test_a_line_lost_on_a_full_disk_leaves_nothing_half_done(bench):
    technician, disk = bench
    station = technician.station
    technician.sight.centre()
    station.set_sun_offset()
    station.begin_point()
    disk.room = 0
    technician.line.hang_up()
    with pytest.raises(LinkError) as lost:
        station.poll()
    refused_for_want_of_room(lambda: station.link_lost(lost.value), technician.path)
    assert station.state.live.link is LinkState.LOST
    assert station.state.attempt is None
    assert station.state.activity is Activity.IDLE
    disk.room = None
    station.reconnect()
    technician.back_to_tracking()
    technician.point(check=False)
    assert len(station.session.accepted) == 1
    assert not any(isinstance(r, LinkLost) for r in read_session(technician.path).records)


def test_a_session_closed_on_a_full_disk_is_let_go_of_and_can_be_gone_on_with(bench):
    technician, disk = bench
    disk.room = 0
    refused_for_want_of_room(technician.station.close, technician.path)
    assert technician.station.state.live.link is LinkState.CLOSED
    with Journal.resume(technician.path) as journal:
        assert not any(isinstance(record, Closed) for record in journal.records)


def test_initialising_again_on_a_full_disk_keeps_the_old_file_in_force(bench, tmp_path):
    technician, _ = bench
    station = technician.station
    second = FillingDisk()
    names = iter(("second.jsonl", "third.jsonl"))

    def start_next(header):
        journal = Journal.create(tmp_path / next(names), header, disk=second)
        second.room = 100
        return journal

    with pytest.raises(SessionFileError, match="No space left"):
        station.initialise(confirmed=True, start_next=start_next)
    assert station.session_path == technician.path
    station.note("still here")
    assert read_session(technician.path).records[-1].text == "still here"  # type: ignore[union-attr]

    def roomy(header):
        second.room = None
        return Journal.create(tmp_path / next(names), header, disk=second)

    station.initialise(confirmed=True, start_next=roomy)
    assert station.session_path == tmp_path / "third.jsonl"
    assert station.session.ref_checks


def test_a_real_file_system_without_room(tmp_path):
    """A tmpfs of 64 kB: the same words from the operating system, the same file afterwards."""
    small = tmp_path / "small"
    small.mkdir()
    mount = shutil.which("mount")
    mounted = (
        mount
        and not subprocess.run(
            [mount, "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(small)], capture_output=True
        ).returncode
    )
    if not mounted:
        pytest.skip("a file system of a given size can only be mounted by the administrator")
    try:
        path = small / "s.jsonl"
        (small / "ballast").write_bytes(b"x" * 20_000)
        with Journal.create(path, HEADER) as journal:
            with pytest.raises(SessionFileError, match="No space left on device"):
                append_until_it_fails(journal)
            acknowledged = len(journal.records)
            assert len(read_session(path).records) == acknowledged > 3
            (small / "ballast").unlink()
            journal.append(short(journal.next_seq))
        assert len(read_session(path).records) == acknowledged + 1
    finally:
        subprocess.run(["umount", str(small)], check=True)


def test_a_sessions_folder_that_cannot_be_made_is_one_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "a-file").write_text("")
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "a-file" / "sessions"))
    assert run_command(["calibrate", "--points", "3"]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith("solarcal: the sessions folder")
    assert "SOLARCAL_SESSIONS" in said


def test_a_session_file_that_is_removed_or_moved_away_is_written_again(tmp_path):
    path, moved = tmp_path / "day.jsonl", tmp_path / "moved.jsonl"
    disk = FillingDisk()
    with Journal.create(path, HEADER, disk=disk) as journal:
        journal.append(short(1))
        path.unlink()
        journal.append(short(2))
        path.rename(moved)
        disk.room = 100
        with pytest.raises(SessionFileError, match="record 3 is not saved"):
            journal.append(short(3))
        assert not path.exists()
        disk.room = None
        journal.append(short(3))
        with pytest.raises(SessionFileError, match="is being written by"):
            Journal.resume(path)
    assert [record.seq for record in read_session(path).records] == [1, 2, 3]
    assert [record.seq for record in read_session(moved).records] == [1, 2]


def test_nothing_is_recorded_into_a_file_that_has_lost_its_name_or_its_end(tmp_path):
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER) as journal:
        journal.append(short(1))
        saved = path.read_bytes()
        # An editor writes a file of its own and puts it there.
        edited = tmp_path / "edited"
        edited.write_bytes(saved)
        edited.replace(path)
        with pytest.raises(SessionFileError, match="another file has taken the place"):
            journal.append(short(2))
        path.rename(edited)
        journal.append(short(2))
        assert [record.seq for record in read_session(path).records] == [1, 2]
        os.truncate(path, len(saved) - 10)
        with pytest.raises(SessionFileError, match="was cut short by another program"):
            journal.append(short(3))


def test_two_programs_never_write_one_session(tmp_path, capsys):
    path = tmp_path / "s.jsonl"
    with Journal.create(path, HEADER) as journal:
        journal.append(note(1))
        other = subprocess.run(
            [sys.executable, "-m", "solarcal", "note", str(path), "me too"],
            capture_output=True,
            text=True,
        )
        assert other.returncode == 2
        assert "is being written by another program" in other.stderr
        assert "Traceback" not in other.stderr
        journal.append(note(2))
    assert len(read_session(path).records) == 2
    assert run_command(["note", str(path), "now"]) == 0


def test_a_laptop_clock_that_steps_back_is_kept_as_it_was_told(bench):
    technician, _ = bench
    station = technician.station
    technician.point(check=False)
    honest = station.clock

    class SteppedBack:
        """Ten minutes earlier than a moment ago."""

        def utc_s(self) -> float:
            return honest.utc_s() - 600.0

        def wait(self, seconds: float) -> None:
            honest.wait(seconds)

    station.clock = SteppedBack()
    station.note("the clock was set back")
    first, last = (parse_utc(station.session.records[i].utc) for i in (-2, -1))
    assert last < first
    station.close()
    session = read_session(technician.path)
    assert [r.seq for r in session.records] == list(range(1, len(session.records) + 1))
    assert session.warnings == ()
    # The order of the file is its sequence, whatever the clock said.
    with Journal.resume(technician.path) as journal:
        assert journal.records[-1].seq == session.records[-1].seq


def test_a_session_of_twenty_thousand_records_is_read_resumed_and_appended_to(tmp_path):
    path = tmp_path / "long.jsonl"
    with Journal.create(path, HEADER) as journal:
        for _ in range(20):
            first = journal.next_seq
            journal.append_all([short(first + i) for i in range(1000)])
    with Journal.resume(path) as journal:
        assert len(journal.records) == 20_000
        journal.append(short(20_001))
    assert read_session(path).records[-1] == short(20_001)
