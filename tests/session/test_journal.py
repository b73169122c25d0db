"""The journal: what is acknowledged is kept, whatever happens next."""

import errno
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from session_samples import HEADER, note, point

from solarcal.errors import SessionFileError
from solarcal.session.disk import Disk
from solarcal.session.journal import Journal
from solarcal.session.view import read_session

WRITER = """
import sys
sys.path.insert(0, sys.argv[2])
from session_samples import HEADER, note
from solarcal.session.journal import Journal
with Journal.create(sys.argv[1], HEADER) as journal:
    print(0, flush=True)
    while True:
        journal.append(note(journal.next_seq, "x" * (journal.next_seq % 700)))
        print(journal.next_seq - 1, flush=True)
"""

HOLDER = """
import sys
sys.path.insert(0, sys.argv[2])
from solarcal.session.journal import Journal
with Journal.resume(sys.argv[1]) as journal:
    print("open", flush=True)
    sys.stdin.readline()
"""


def start(script: str, path: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", script, str(path), str(Path(__file__).parent)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


class RecordingDisk(Disk):
    """Real files, with a diary of the calls and, on demand, failures."""

    def __init__(self) -> None:
        self.diary: list[str] = []
        self.fail_write_after: int | None = None
        self.fail_sync = False
        self.fail_folder = False

    def write(self, descriptor: int, content: bytes) -> int:
        self.diary.append("write")
        if self.fail_write_after is not None:
            super().write(descriptor, content[: self.fail_write_after])
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(descriptor, content)

    def sync(self, descriptor: int) -> None:
        self.diary.append("sync")
        if self.fail_sync:
            raise OSError(errno.EIO, "Input/output error")
        super().sync(descriptor)

    def sync_folder(self, folder: Path) -> None:
        self.diary.append("sync folder")
        if self.fail_folder:
            raise OSError(errno.EIO, "Input/output error")
        super().sync_folder(folder)


def test_records_come_back_as_they_were_written(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER) as journal:
        journal.append(note(1))
        journal.append(point(2))
        assert journal.next_seq == 3
    session = read_session(path)
    assert session.header == HEADER
    assert session.records == (note(1), point(2))
    (warning,) = session.warnings
    assert warning == f"{path} was not closed: the session goes on, or its end is missing"


def test_resume_goes_on_where_the_file_ends(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER) as journal:
        journal.append(note(1))
    before = path.read_bytes()
    with Journal.resume(path) as journal:
        assert path.read_bytes() == before
        assert journal.header == HEADER
        assert journal.records == [note(1)]
        journal.append(point(journal.next_seq))
    assert path.read_bytes().startswith(before)
    assert read_session(path).records == (note(1), point(2))


def test_every_record_is_synced_before_append_returns(tmp_path: Path) -> None:
    disk = RecordingDisk()
    with Journal.create(tmp_path / "day.jsonl", HEADER, disk=disk) as journal:
        assert disk.diary == ["write", "sync", "sync folder"]
        disk.diary.clear()
        journal.append(note(1))
        assert disk.diary == ["write", "sync"]


def test_an_unsynced_record_is_not_acknowledged(tmp_path: Path) -> None:
    disk = RecordingDisk()
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER, disk=disk) as journal:
        disk.fail_sync = True
        for _ in range(2):
            with pytest.raises(SessionFileError, match="record 1 is not saved"):
                journal.append(note(1, "never acknowledged"))
        assert journal.records == []
        disk.fail_sync = False
        journal.append(note(1, "the second attempt"))
        journal.append(note(2))
    session = read_session(path)
    assert session.records == (note(1, "the second attempt"), note(2))


def test_a_short_write_is_completed(tmp_path: Path) -> None:
    class SlowDisk(Disk):
        def write(self, descriptor: int, content: bytes) -> int:
            return super().write(descriptor, content[:7])

    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER, disk=SlowDisk()) as journal:
        journal.append(note(1))
    assert read_session(path).records == (note(1),)


@pytest.mark.parametrize("taken", [0, 1, 30])
def test_a_full_disk_is_one_clear_line_and_the_session_can_go_on(
    tmp_path: Path, taken: int
) -> None:
    disk = RecordingDisk()
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER, disk=disk) as journal:
        journal.append(note(1))
        disk.fail_write_after = taken
        with pytest.raises(SessionFileError) as refusal:
            journal.append(note(2, "lost"))
        assert str(refusal.value) == (
            f"{path} cannot be written: No space left on device; record 2 is not saved"
        )
        assert read_session(path).records == (note(1),)
        disk.fail_write_after = None
        journal.append(note(2, "kept"))
    assert read_session(path).records == (note(1), note(2, "kept"))


def test_a_real_write_error_in_mid_line(tmp_path: Path) -> None:
    """A file size limit makes the operating system itself cut the line."""
    path = tmp_path / "day.jsonl"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with Journal.create(path, HEADER) as journal:
        room = path.stat().st_size + 40
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, hard))
        try:
            with pytest.raises(SessionFileError, match="record 1 is not saved"):
                journal.append(note(1, "lost"))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert path.stat().st_size == room
        journal.append(note(1, "kept"))
    assert read_session(path).records == (note(1, "kept"),)


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    class ReadOnlyDisk(Disk):
        def create(self, path: Path) -> int:
            raise PermissionError(errno.EACCES, "Permission denied")

    with pytest.raises(SessionFileError, match=r"day\.jsonl cannot be created: Permission denied"):
        Journal.create(tmp_path / "day.jsonl", HEADER, disk=ReadOnlyDisk())
    with pytest.raises(SessionFileError, match="cannot be created: No such file or directory"):
        Journal.create(tmp_path / "nowhere" / "day.jsonl", HEADER)


@pytest.mark.parametrize("failure", ["fail_sync", "fail_folder"])
def test_a_file_that_could_not_be_begun_leaves_nothing_behind(tmp_path: Path, failure: str) -> None:
    disk = RecordingDisk()
    setattr(disk, failure, True)
    with pytest.raises(SessionFileError, match="cannot be created"):
        Journal.create(tmp_path / "day.jsonl", HEADER, disk=disk)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("call", ["write", "sync"])
def test_a_record_that_is_being_written_when_interrupted_is_written_whole(
    tmp_path: Path, call: str
) -> None:
    class Interrupted(Disk):
        calls = 0

        def write(self, descriptor: int, content: bytes) -> int:
            taken = super().write(descriptor, content[:40])
            self.interrupt("write")
            return taken

        def sync(self, descriptor: int) -> None:
            super().sync(descriptor)
            self.interrupt("sync")

        def interrupt(self, name: str) -> None:
            self.calls += name == call
            if self.calls == 3:
                self.calls += 1
                raise KeyboardInterrupt

    path = tmp_path / "day.jsonl"
    Journal.create(path, HEADER).close()
    with Journal.resume(path, disk=Interrupted()) as journal:
        with pytest.raises(KeyboardInterrupt):
            list(map(journal.append, map(note, range(1, 5))))
        last = journal.records[-1].seq
        journal.append(note(last + 1))
    session = read_session(path)
    assert session.records == tuple(note(number) for number in range(1, last + 2))
    assert not [words for words in session.warnings if "torn" in words]


@pytest.mark.parametrize("call", ["lock", "write", "sync", "sync_folder"])
def test_a_file_whose_beginning_is_interrupted_leaves_nothing_behind(
    tmp_path: Path, call: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = Disk()
    real, calls = getattr(disk, call), []

    def interrupted(*arguments: object) -> object:
        calls.append(arguments)
        done = real(*arguments)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return done

    monkeypatch.setattr(disk, call, interrupted)
    with pytest.raises(KeyboardInterrupt):
        Journal.create(tmp_path / "day.jsonl", HEADER, disk=disk)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    path.write_text("mine")
    with pytest.raises(SessionFileError, match="exists already"):
        Journal.create(path, HEADER)
    assert path.read_text() == "mine"


def test_a_missing_file_cannot_be_resumed(tmp_path: Path) -> None:
    with pytest.raises(SessionFileError, match="cannot be opened for writing: No such file"):
        Journal.resume(tmp_path / "none.jsonl")


def test_records_out_of_order_are_the_callers_mistake(tmp_path: Path) -> None:
    with Journal.create(tmp_path / "day.jsonl", HEADER) as journal:
        with pytest.raises(ValueError, match="record 2 where 1 comes next"):
            journal.append(note(2))
        with pytest.raises(ValueError):
            journal.append(HEADER)


def test_a_record_that_would_not_read_back_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER) as journal:
        for bad in (
            point(1, ideal_deg=(float("nan"), 50.0)),
            point(1, error_deg=None),
            note(1, "\udcff"),
        ):
            with pytest.raises(SessionFileError, match="cannot be written"):
                journal.append(bad)
        journal.append(note(1))
    assert read_session(path).records == (note(1),)


def test_a_batch_is_one_sync_and_all_or_nothing(tmp_path: Path) -> None:
    disk = RecordingDisk()
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER, disk=disk) as journal:
        disk.diary.clear()
        journal.append_all([note(1), note(2)])
        assert disk.diary == ["write", "sync"]
        disk.fail_write_after = 150
        with pytest.raises(SessionFileError):
            journal.append_all([note(3), note(4)])
        disk.fail_write_after = None
        journal.append(note(3, "after"))
    assert read_session(path).records == (note(1), note(2), note(3, "after"))


def test_nothing_is_appended_after_closing(tmp_path: Path) -> None:
    journal = Journal.create(tmp_path / "day.jsonl", HEADER)
    journal.close()
    journal.close()
    with pytest.raises(SessionFileError, match="is closed"):
        journal.append(note(1))


def test_a_journal_in_memory_keeps_the_same_rules() -> None:
    journal = Journal.memory(HEADER)
    journal.append(note(1))
    assert journal.records == [note(1)]
    assert journal.path is None
    with pytest.raises(SessionFileError):
        journal.append(point(2, ideal_deg=(float("inf"), 0.0)))
    with pytest.raises(ValueError):
        journal.append(note(7))


def test_a_second_journal_in_the_same_program_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    with Journal.create(path, HEADER) as journal:
        with pytest.raises(SessionFileError, match="is being written by another program"):
            Journal.resume(path)
        read_session(path)  # reading neither needs nor loses the lock
        with pytest.raises(SessionFileError, match="is being written by"):
            Journal.resume(path)
        journal.append(note(1))
    Journal.resume(path).close()


def test_a_second_process_is_refused_until_the_first_one_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    Journal.create(path, HEADER).close()
    holder = start(HOLDER, path)
    assert holder.stdout is not None
    try:
        assert holder.stdout.readline() == "open\n"
        with pytest.raises(SessionFileError) as refusal:
            Journal.resume(path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)
        if sys.platform == "linux":
            assert f"(process {holder.pid})" in str(refusal.value)
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.communicate()
    with Journal.resume(path) as journal:
        journal.append(note(1))


@pytest.mark.parametrize("acknowledged", [0, 1, 7, 60])
def test_a_killed_writer_loses_nothing_it_acknowledged(tmp_path: Path, acknowledged: int) -> None:
    path = tmp_path / "day.jsonl"
    writer = start(WRITER, path)
    assert writer.stdout is not None
    try:
        last = 0
        for line in writer.stdout:
            last = int(line)
            if last == acknowledged:
                break
    finally:
        os.kill(writer.pid, signal.SIGKILL)
        rest, _ = writer.communicate()
    last = max([last, *(int(n) for n in rest.split("\n")[:-1])])
    assert last >= acknowledged
    session = read_session(path)
    assert [r.seq for r in session.records][:last] == list(range(1, last + 1))
    with Journal.resume(path) as journal:
        journal.append(note(journal.next_seq, "after the kill"))
    assert read_session(path).records[-1].text == "after the kill"  # type: ignore[union-attr]


@pytest.mark.skipif(sys.platform == "win32", reason="folders are not synced there")
@pytest.mark.parametrize("code", [errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EIO])
def test_only_a_file_system_that_cannot_sync_a_folder_is_forgiven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    def refused(descriptor: int) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "fsync", refused)
    if code == errno.EIO:
        with pytest.raises(OSError, match=os.strerror(code)):
            Disk().sync_folder(tmp_path)
    else:
        Disk().sync_folder(tmp_path)
