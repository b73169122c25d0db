"""The real program on a pseudo-terminal, read by pyte; the unit in a process of its own."""

import fcntl
import functools
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyte

PATIENCE_S = 30.0
PACES = (5, 5, 2, 1)
"""How many seconds of an emulator pass in a real one while keys are pressed, try after try."""
KITTY = re.compile(rb"\x1b\[[<=>?][0-9;]*u")
"""Keyboard protocol requests, which pyte takes for something else."""

NO_FRAMES = dict.fromkeys(map(ord, "┃│╭╮╰╯─━┏┓┗┛▌▐"), " ")

ALT_F3, ALT_F5, ALT_F7, CTRL_F9 = b"\x1b[1;3R", b"\x1b[15;3~", b"\x1b[18;3~", b"\x1b[20;5~"
F2, F6, F8, F10, F12 = b"\x1bOQ", b"\x1b[17~", b"\x1b[19~", b"\x1b[21~", b"\x1b[24~"
ENTER, ESC, CTRL_Q, CTRL_S = b"\r", b"\x1b", b"\x11", b"\x13"
UP, DOWN, RIGHT, LEFT = b"\x1b[A", b"\x1b[B", b"\x1b[C", b"\x1b[D"


class InVain(AssertionError):
    """The screen never showed what was waited for."""


def in_real_time(test: Callable[[Path], None]) -> Callable[[Path], None]:
    """A few tries, each in a folder of its own, the later ones slower.

    Program, emulator and the keys are three processes in real time: on a machine that is busy
    elsewhere a key can come too late to keep the moving Sun on the plate. Only a screen waited for
    in vain is tried again; a wrong number never is.
    """

    @functools.wraps(test)
    def tried(tmp_path: Path) -> None:
        for number, pace in enumerate(PACES, start=1):
            folder = tmp_path / str(number)
            folder.mkdir()
            EmulatorProcess.pace = pace
            try:
                return test(folder)
            except InVain as vain:
                print(f"try {number}: {vain}")
                if number == len(PACES):
                    raise
        raise AssertionError("no try was made")

    return tried


def environment(home: Path) -> dict[str, str]:
    """Nothing of the user who runs the tests."""
    env = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLORTERM")}
    env |= {
        "TERM": "xterm-256color",
        "HOME": str(home),
        "XDG_CONFIG_HOME": str(home / "config"),
        "XDG_DATA_HOME": str(home / "data"),
        "SOLARCAL_SESSIONS": str(home / "sessions"),
    }
    (home / "sessions").mkdir(parents=True, exist_ok=True)
    return env


class EmulatorProcess:
    """``solarcal emulate`` on a pseudo-terminal of its own."""

    pace = PACES[0]
    """How fast its time may run while keys are pressed."""

    def __init__(self, link: Path, home: Path, *settings: str, start: str, speed: float) -> None:
        self.link = link
        self._command = [sys.executable, "-m", "solarcal", "emulate", "--pty", str(link)]
        self._command += [
            "--start",
            start,
            "--seed",
            "7",
            "--noise-deg",
            "0.005",
            "--speed",
            f"{speed:g}",
        ]
        self._command += [part for setting in settings for part in ("--set", setting)]
        self._env = environment(home)
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._process = subprocess.Popen(
            self._command, env=self._env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        assert self._process.stdout is not None
        # Its first line says that it can be connected to.
        assert self._process.stdout.readline()

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            assert self._process.stdout is not None
            self._process.stdout.close()
            self._process = None


class Terminal:
    """``solarcal run`` in a terminal of that size."""

    def __init__(self, home: Path, *arguments: str, size: tuple[int, int] = (80, 24)) -> None:
        columns, rows = size
        self.screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self.screen)
        self._text: str | None = None
        self._words: str | None = None
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self._process = subprocess.Popen(
            [sys.executable, "-m", "solarcal", "run", *arguments],
            env=environment(home),
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
        )
        os.close(slave)
        self._master = master
        self.pressed = 0
        """Keys so far; a hurried emulator's not counted."""

    # -- eyes ----------------------------------------------------------------------------------

    def read(self, timeout_s: float = 0.05) -> bool:
        """Take in what the program has drawn; whether there was anything."""
        readable, _, _ = select.select([self._master], [], [], timeout_s)
        if not readable:
            return False
        try:
            data = os.read(self._master, 65536)
        except OSError:
            # The program has ended and its terminal with it.
            return False
        self._stream.feed(KITTY.sub(b"", data))
        self._text = self._words = None
        return True

    def text(self) -> str:
        # Put together cell by cell, which costs more than drawing: once for each drawing. The cell
        # beside a wide character holds nothing.
        if self._text is None:
            buffer, columns = self.screen.buffer, range(self.screen.columns)
            rows = ([buffer[y][x].data for x in columns] for y in range(self.screen.lines))
            self._text = "\n".join("".join(row).rstrip() for row in rows)
        return self._text

    def words(self) -> str:
        if self._words is None:
            self._words = " ".join(self.text().translate(NO_FRAMES).split())
        return self._words

    def until(self, true: Callable[[], object], what: str = "") -> None:
        if not self.within(PATIENCE_S, true):
            raise InVain(f"waited for {what or true} in vain; the screen shows:\n{self.text()}")

    def within(self, seconds: float, true: Callable[[], object]) -> bool:
        """Whether that came to hold in so many seconds."""
        deadline = time.monotonic() + seconds
        while not true():
            if time.monotonic() > deadline:
                return False
            self.read()
        return True

    def shows(self, *words: str) -> None:
        self.until(lambda: all(word in self.words() for word in words), f"{words}")

    def shows_one_of(self, *words: str) -> None:
        self.until(lambda: any(word in self.words() for word in words), f"one of {words}")

    def shows_no(self, *words: str) -> None:
        """Gone for good: a screen half drawn anew lacks words that it will have again."""

        def gone() -> bool:
            if any(word in self.words() for word in words):
                return False
            # The whole of a drawing comes at once; after it the program draws nothing for a while.
            return not self.read(0.1) and all(word not in self.words() for word in words)

        self.until(gone, f"the end of {words}")

    # -- hands ---------------------------------------------------------------------------------

    def press(self, *keys: bytes | str) -> None:
        strokes: list[bytes] = []
        for key in keys:
            strokes += [c.encode() for c in key] if isinstance(key, str) else [key]
        self.pressed += len(strokes)
        for stroke in strokes:
            os.write(self._master, stroke)
            # One key a read, as from a hand: an escape must not melt into the next key.
            self.read(0.02)

    @contextmanager
    def uncounted(self) -> Iterator[None]:
        """Keys that only hurry an emulator are no work of the technician's."""
        before = self.pressed
        yield
        self.pressed = before

    # -- life ----------------------------------------------------------------------------------

    def kill(self) -> None:
        """As a power cut would."""
        os.kill(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def quit(self) -> int:
        """By its own key."""
        self.press(CTRL_Q)
        deadline = time.monotonic() + PATIENCE_S
        while self._process.poll() is None:
            if time.monotonic() > deadline:
                raise AssertionError(f"does not quit; the screen shows:\n{self.text()}")
            self.read()
        return self._process.returncode

    def take_away(self) -> int:
        """The terminal is gone and nobody tells the program; how it ended."""
        os.close(self._master)
        self._master = -1
        return self._process.wait(PATIENCE_S)

    def close(self) -> None:
        if self._process.poll() is None:
            self.kill()
        if self._master >= 0:
            os.close(self._master)


def solarcal_json(home: Path, *arguments: str) -> dict[str, Any]:
    """What a command prints with ``--json``."""
    done = subprocess.run(
        [sys.executable, "-m", "solarcal", *arguments, "--json"],
        env=environment(home),
        capture_output=True,
        text=True,
        check=True,
    )
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer
