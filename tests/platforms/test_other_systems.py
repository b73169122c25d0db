"""Systems without pseudo-terminals, terminal settings or POSIX locks, as Windows is.

Absence is simulated: the module is made impossible to import before the program starts.
"""

import errno
import importlib
import json
import os
import subprocess
import sys
import types
from pathlib import Path

import pytest

import solarcal.session.disk
from solarcal.errors import SessionFileError

POSIX_ONLY = ("pty", "tty", "termios")


def run_without(
    modules: tuple[str, ...], *words: str, cwd: Path
) -> subprocess.CompletedProcess[str]:
    """``solarcal words`` in a process that cannot import ``modules``."""
    program = (
        f"import sys; sys.modules.update(dict.fromkeys({modules!r}));"
        f"sys.argv = ['solarcal', *{list(words)!r}];"
        "from solarcal.__main__ import main; sys.exit(main())"
    )
    return subprocess.run(
        [sys.executable, "-c", program],
        cwd=cwd,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        timeout=120,
        check=False,
    )


def test_a_whole_calibration_needs_no_posix_module(tmp_path):
    done = run_without(
        POSIX_ONLY, "calibrate", "--scenario", "tijeras-azel", "--json",
        "-o", "day.jsonl", cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["truth"]["day_rms_after_deg"] < 0.05
    fitted = run_without(POSIX_ONLY, "fit", "day.jsonl", "--json", cwd=tmp_path)
    assert json.loads(fitted.stdout)["points"]["used"] == 12


def test_demo_falls_back_to_tcp_without_pseudo_terminals(tmp_path):
    # Not tty and termios: pyserial and plotext need them here; on Windows they have others.
    # Without a terminal it goes on without the workstation.
    done = run_without(("pty",), "demo", "--points", "6", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "on TCP" in done.stdout + done.stderr
    assert "true error on the sky" in done.stdout


def test_a_pseudo_terminal_that_cannot_be_is_refused_in_one_line(tmp_path):
    done = run_without(POSIX_ONLY, "emulate", "--pty", "line", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        "solarcal: this system has no pseudo-terminals; use --tcp 127.0.0.1:PORT instead\n"
    )


def test_the_table_of_keys_needs_no_terminal(tmp_path):
    done = run_without(POSIX_ONLY, "keys", cwd=tmp_path)
    assert done.returncode == 0
    assert "F12 s ^S" in done.stdout


@pytest.fixture
def windows_disk(monkeypatch: pytest.MonkeyPatch):
    """The disk module as Windows loads it, with the locks of one other program in ``held``."""
    held: set[tuple[int, int]] = set()
    msvcrt = types.ModuleType("msvcrt")
    msvcrt.LK_NBLCK = 2  # type: ignore[attr-defined]

    def locking(descriptor: int, mode: int, number: int) -> None:
        place = (os.fstat(descriptor).st_ino, os.lseek(descriptor, 0, os.SEEK_CUR))
        if place in held:
            raise OSError(errno.EACCES, "Permission denied")
        held.add(place)

    msvcrt.locking = locking  # type: ignore[attr-defined]
    with monkeypatch.context() as windows:
        windows.setitem(sys.modules, "msvcrt", msvcrt)
        windows.setitem(sys.modules, "fcntl", None)
        windows.setattr(sys, "platform", "win32")
        importlib.reload(solarcal.session.disk)
    # Its functions were chosen on loading; sys.platform is this system's own again.
    yield solarcal.session.disk
    importlib.reload(solarcal.session.disk)


def test_windows_locks_far_beyond_the_session_and_names_the_conflict(windows_disk, tmp_path):
    disk, path = windows_disk.Disk(), tmp_path / "s.jsonl"
    first = disk.create(path)
    disk.write(first, b"a record\n")
    disk.lock(first, path)
    second = disk.open(path)
    with pytest.raises(SessionFileError, match="is being written by another program"):
        disk.lock(second, path)
    # What is locked is no byte of the session, so that it stays readable meanwhile.
    assert os.lseek(first, 0, os.SEEK_CUR) > 1 << 30
    assert disk.read(second) == b"a record\n"
    disk.close(first)
    disk.close(second)
