"""SIGINT, SIGTERM and SIGHUP: the workstation restores the terminal and closes what it has open."""

import os
import select
import signal
import time
from pathlib import Path

import pytest
from pty_bench import PATIENCE_S, Terminal

from solarcal.session.journal import Journal

RESTORED = (b"\x1b[?1049l", b"\x1b[?1000l", b"\x1b[?25h")
"""The plain screen again, no mouse reports, a cursor."""


class Recording(Terminal):
    """Keeps every byte that was drawn."""

    drawn = b""

    def ended_by(self, number: signal.Signals) -> int:
        os.kill(self._process.pid, number)
        deadline = time.monotonic() + PATIENCE_S
        while select.select([self._master], [], [], max(0.0, deadline - time.monotonic()))[0]:
            try:
                data = os.read(self._master, 65536)
            except OSError:
                break
            if not data:
                break
            self.drawn += data
        return self._process.wait(10.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_terminal_is_as_it_was_and_the_session_is_free(tmp_path: Path, number) -> None:
    terminal = Recording(tmp_path, "--scenario", "tijeras-azel")
    try:
        terminal.shows("LINK OK")
        assert terminal.ended_by(number) == 128 + number
        for sequence in RESTORED:
            assert sequence in terminal.drawn
        assert b"Traceback" not in terminal.drawn
    finally:
        terminal.close()
    (path,) = (tmp_path / "sessions").glob("*.jsonl")
    journal = Journal.resume(path)
    journal.close()
    assert journal.warnings == ()
