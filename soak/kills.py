"""Journal writers killed at random moments: nothing acknowledged is lost, every file is whole."""

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from soak.journal_writer import text_of
from solarcal.errors import SessionFileError
from solarcal.session.records import Note
from solarcal.session.view import read_session

MOST_RECORDS = 200
"""A file longer than this is left alone and another begun."""


@dataclass(frozen=True, slots=True)
class Killed:
    """What was seen. ``torn``: lines found unfinished; ``unborn``: killed before the header."""

    kills: int
    files: int
    acknowledged: int
    torn: int
    unborn: int
    seconds: float

    def words(self) -> str:
        return (
            f"{self.kills} kills over {self.files} files in {self.seconds:.1f} s: "
            f"{self.acknowledged} records acknowledged, none lost; {self.torn} torn lines, "
            f"{self.unborn} files without a header yet"
        )


class LostRecord(AssertionError):
    """An acknowledged record is not in the file, or not as it was written."""


def kill_writers(folder: Path, kills: int, seed: int) -> Killed:
    """Kill ``kills`` writers; after each, read the file; the next one resumes it.

    Raises
    ------
    LostRecord
        Something acknowledged is gone.
    SessionFileError
        A file cannot be read.
    """
    moments = random.Random(seed)
    started = time.perf_counter()
    files, known, acknowledged, torn, unborn = 1, 0, 0, 0, 0
    torn_here, born = 0, False
    path = folder / "1.jsonl"
    writer = subprocess.Popen(
        [sys.executable, str(Path(__file__).with_name("journal_writer.py"))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        for _ in range(kills):
            # At its beginning, in the first records, or after some; and anywhere within one.
            after = moments.choice((-1, 0, 1, moments.randint(2, 12)))
            last = _kill_one(writer, path, after, moments.random() * 0.004)
            seqs, tears = read_back(path, begun=last >= 0 or born, promised=max(known, last))
            acknowledged += max(last - known, 0)
            known = seqs[-1] if seqs else 0
            torn, torn_here = torn + tears - torn_here, tears
            unborn += seqs is None
            born = seqs is not None
            if seqs is None or known > MOST_RECORDS:
                files, known, torn_here, born = files + 1, 0, 0, False
                path = folder / f"{files}.jsonl"
    finally:
        assert writer.stdin is not None
        writer.stdin.close()
        writer.wait(timeout=30)
    return Killed(kills, files, acknowledged, torn, unborn, time.perf_counter() - started)


def _kill_one(writer: "subprocess.Popen[str]", path: Path, after: int, later_s: float) -> int:
    """Let a writer work until it has acknowledged ``after`` times (-1: not even begun), then kill
    it within ``later_s``; the last record it acknowledged (-1: it had not begun)."""
    assert writer.stdin is not None
    assert writer.stdout is not None
    writer.stdin.write(f"{path}\n")
    writer.stdin.flush()
    child = int(writer.stdout.readline().removeprefix("child "))
    last = -1
    for _ in range(after + 1):
        last = int(writer.stdout.readline())
    moment = time.perf_counter() + later_s
    while time.perf_counter() < moment:
        pass
    os.kill(child, signal.SIGKILL)
    while (said := writer.stdout.readline()) != "dead\n":
        last = int(said)
    return last


def read_back(path: Path, begun: bool, promised: int) -> tuple[list[int] | None, int]:
    """Numbers of the records in the file (``None``: not even a header) and its torn lines."""
    try:
        session = read_session(path)
    except SessionFileError:
        if begun:
            raise
        return None, 0
    seqs = [record.seq for record in session.records]
    for record in session.records:
        if not isinstance(record, Note) or record.text != text_of(record.seq):
            raise LostRecord(f"{path}: record {record.seq} is not what was written")
    if seqs != list(range(1, len(seqs) + 1)) or len(seqs) < promised:
        raise LostRecord(f"{path}: {promised} records were acknowledged, {len(seqs)} are there")
    return seqs, sum("torn" in warning for warning in session.warnings)
