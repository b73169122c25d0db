"""The workstation beside a bare Textual app, on the same pseudo-terminal in the same run.

First paint: start of the process until the first screen is there. Key latency: a key written until
the last byte of its answer, at 140x45 with 200 points in a live session. Idle cost: processor time
of the program while a status comes every second.
"""

import contextlib
import fcntl
import os
import pty
import select
import struct
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

COLUMNS, ROWS = 140, 45
PAINTS = 9
KEYS = 90
POINTS = 200
IDLE_S = 10.0
FIRST_SCREEN_BYTES = 2000
PAUSE_S = 0.004
"""Longer than between two pieces of one screen, shorter than between two screens."""

BARE_APP = """
from textual.app import App
from textual.widgets import Static

class Bare(App):
    BINDINGS = [("v", "turn", "")]
    number = 0

    def compose(self):
        yield Static("x" * 3000)

    def on_mount(self):
        self.set_interval(1.0, self.action_turn)

    def action_turn(self):
        self.number += 1
        self.query_one(Static).update(str(self.number) * 1500)

Bare().run()
"""


class Program:
    """A program on a pseudo-terminal."""

    def __init__(self, *command: str, home: Path) -> None:
        environment = os.environ | {
            "TERM": "xterm-256color",
            "SOLARCAL_CONFIG": str(home / "config"),
            "SOLARCAL_SESSIONS": str(home / "sessions"),
        }
        self.started_s = time.perf_counter()
        self.pid, self._terminal = pty.fork()
        if self.pid == 0:
            os.execvpe(command[0], command, environment)
        size = struct.pack("HHHH", ROWS, COLUMNS, 0, 0)
        fcntl.ioctl(self._terminal, termios.TIOCSWINSZ, size)

    def read(self, patience_s: float) -> bytes:
        if not select.select([self._terminal], [], [], patience_s)[0]:
            return b""
        try:
            return os.read(self._terminal, 65536)
        except OSError:
            return b""

    def first_paint_s(self) -> float:
        seen = 0
        while seen < FIRST_SCREEN_BYTES:
            data = self.read(20.0)
            if not data:
                raise RuntimeError("the program painted nothing")
            seen += len(data)
        return time.perf_counter() - self.started_s

    def until(self, words: bytes) -> None:
        seen = b""
        while words not in seen:
            data = self.read(30.0)
            if not data:
                raise RuntimeError(f"the program never showed {words!r}")
            seen += data

    def quiet(self, silence_s: float = 0.15) -> None:
        while self.read(silence_s):
            pass

    def answer_s(self, key: bytes) -> float:
        self.quiet()
        start = time.perf_counter()
        os.write(self._terminal, key)
        if not self.read(5.0):
            raise RuntimeError(f"no answer to {key!r}")
        answered = time.perf_counter()
        while self.read(PAUSE_S):
            answered = time.perf_counter()
        return answered - start

    def processor_s(self) -> float:
        """User and system time so far."""
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def idle_share(self) -> float:
        before, start = self.processor_s(), time.perf_counter()
        while time.perf_counter() - start < IDLE_S:
            self.read(0.2)
        return (self.processor_s() - before) / (time.perf_counter() - start)

    def end(self) -> None:
        os.kill(self.pid, 9)
        os.waitpid(self.pid, 0)
        os.close(self._terminal)


@contextlib.contextmanager
def running(*command: str, home: Path) -> Iterator[Program]:
    program = Program(*command, home=home)
    try:
        yield program
    finally:
        program.end()


@contextlib.contextmanager
def emulated_unit(home: Path) -> Iterator[str]:
    """A tracker in another process, living in real time."""
    link = home / "tracker"
    command = [sys.executable, "-m", "solarcal", "emulate", "--pty", str(link), "--speed", "1"]
    unit = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        assert unit.stdout is not None
        unit.stdout.readline()
        yield str(link)
    finally:
        unit.kill()
        unit.wait()


def long_session(path: Path, port: str) -> None:
    """A session of that unit with 200 accepted points along the Sun's path, still open."""
    import msgspec

    from solarcal.config import Choice, Settings, save_settings
    from solarcal.emulated_units import open_choice
    from solarcal.mount.formula import Coefficients, correction_deg
    from solarcal.profiles import Profile
    from solarcal.session.records import Answers, PointRecord
    from solarcal.timescale import format_utc, parse_utc

    line = open_choice(Choice(port=port), Profile(), output=path)
    journal = line.station._journal
    assert journal is not None
    hours = np.linspace(-5.0, 5.0, POINTS)
    ax1, ax2 = -15.0 * hours, 75.0 - 55.0 * np.cos(np.radians(13.0 * hours))
    truth = Coefficients(P1=0.3, P2=0.2, P3=-0.4, P4=0.1, P5=0.001, P6=-0.002)
    e1, e2 = correction_deg(truth, ax1, ax2)
    noise = 0.02 * np.random.default_rng(1).standard_normal((2, POINTS))
    noon_s = parse_utc(journal.header.utc) + 6.0 * 3600.0
    yes = Answers(ref_check=True, sun_offset=True, tracking=True)
    points = []
    for index in range(POINTS):
        error = (float(e1[index] + noise[0, index]), float(e2[index] + noise[1, index]))
        ideal = (float(ax1[index]), float(ax2[index]))
        utc = format_utc(noon_s + 3600.0 * float(hours[index]))
        points.append(
            PointRecord(
                seq=journal.next_seq + index, utc=utc, status="accepted", answers=yes,
                basis="gathering", read_utc=utc, ideal_deg=ideal, error_deg=error,
                reading_deg=(ideal[0] + error[0], ideal[1] + error[1]),
            )
        )  # fmt: skip
    journal.append_all(points)
    line.station.leave()
    line.resources.close()
    save_settings(msgspec.structs.replace(Settings(), lines={path.name: Choice(port=port)}))


def paints(home: Path) -> str:
    bare, ours = [], []
    (home / "bare.py").write_text(BARE_APP)
    for turn in range(PAINTS + 1):
        with running(sys.executable, str(home / "bare.py"), home=home) as program:
            first = program.first_paint_s()
        with running(sys.executable, "-m", "solarcal", "run", home=home) as program:
            second = program.first_paint_s()
        if turn:  # the first pair fills the disk cache
            bare.append(first)
            ours.append(second)
    ratio = float(np.median(ours) / np.median(bare))
    return (
        f"first paint: {1e3 * np.median(ours):4.0f} ms, bare Textual app "
        f"{1e3 * np.median(bare):4.0f} ms, ratio {ratio:.2f} (asked: below 1.8)"
    )


def latency_ms(program: Program, keys: bytes) -> tuple[float, float]:
    program.answer_s(keys[:1])
    times = [1e3 * program.answer_s(bytes([keys[i % len(keys)]])) for i in range(KEYS)]
    return float(np.median(times)), float(np.percentile(times, 95))


def run() -> list[str]:
    if not sys.platform.startswith("linux"):
        return ["the workstation's benchmark needs Linux: pseudo-terminals and /proc"]
    with tempfile.TemporaryDirectory(prefix="solarcal-bench-") as folder:
        home = Path(folder)
        os.environ["SOLARCAL_CONFIG"] = str(home / "config")
        os.environ["SOLARCAL_SESSIONS"] = str(home / "sessions")
        lines = [paints(home)]
        with running(sys.executable, str(home / "bare.py"), home=home) as bare:
            bare.first_paint_s()
            bare_median, bare_worst = latency_ms(bare, b"v")
            bare_idle = bare.idle_share()
        with emulated_unit(home) as port:
            session = home / "sessions" / "long.jsonl"
            session.parent.mkdir()
            long_session(session, port)
            command = [sys.executable, "-m", "solarcal", "run", "--continue", str(session)]
            with running(*command, home=home) as program:
                program.until(b"LINK OK")
                program.quiet(0.5)
                median, worst = latency_ms(program, b"v52")
                idle = program.idle_share()
    lines.append(
        f"a key to the screen, {COLUMNS}x{ROWS}, {POINTS} points: median {median:.1f} ms, 95th "
        f"percentile {worst:.1f} ms; bare app {bare_median:.1f} and {bare_worst:.1f} ms, ratio of "
        f"the percentiles {worst / bare_worst:.1f} (asked: 50 ms)"
    )
    lines.append(
        f"idle with a status every second: {100.0 * idle:.1f} % of a core; bare app that changes "
        f"its text every second {100.0 * bare_idle:.1f} % (asked: below 5 %)"
    )
    return lines
