"""Bad calls of the program: every command with an option or a file that cannot be.

Each call is a process of its own. It must end within ten seconds with an exit code of the
contract, use no more than 300 MB, and answer in words: no traceback, no page of them.
"""

import argparse
import functools
import os
import random
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from solarcal.cli import COMMANDS, build_parser

CALLS = 825
LONGEST_S = 10.0
LARGEST_MB = 300.0
MOST_LINES = 6

_SKIPPED = {"--help", "--debug"}
_TEXTS = (
    "", " ", "-", "--", "nan", "inf", "-inf", "1_000", "٣٥", "１２", "1e309", "1e-320", "-1", "0",
    "1e300", "99999999999999999999", "0x10", "1,5", "1.2.3", "+-1", "12:60", "25:00", "2026-13-45",
    "9999-12-31T23:59:59Z", "0000-00-00", "soon", "now now", "P1,P1", "P9", "../../etc/passwd",
    "socket://127.0.0.1:1", "socket://", "rfc2217://x:99999", "a=b", "truth.lean_deg=1e9", "=",
    "truth.x=[[[[", "éü", "\x1b[2J", "A" * 5000, "%s%n", "'; rm", "[", "{}",
)  # fmt: skip

_BASES = {
    # What would run for long, serve for ever, or need a person, is refused or short in its base.
    "run": ("--port", "socket://127.0.0.1:1"),
    "demo": ("--headless", "--points", "3", "--method", "linear"),
    "calibrate": ("--scenario", "tijeras-azel", "--points", "3"),
    "emulate": ("--tcp", "127.0.0.1:99999"),
    "serve": ("--port", "99999"),
    "track": ("--port", "socket://127.0.0.1:1"),
    "keys": ("--headless",),
    "replay": ("FILE", "--headless"),
    "upload": ("FILE", "--port", "socket://127.0.0.1:1"),
    "rollback": ("--port", "socket://127.0.0.1:1"),
    "void": ("FILE", "3", "--reason", "why"),
    "note": ("FILE", "a remark"),
    "import": ("FILE", "OUT"),
    "export": ("FILE", "OUT"),
    "report": ("FILE", "-o", "OUT"),
    "fleet": ("FOLDER",),
    "sun": ("--lat", "35", "--lon", "-106"),
    "day": ("--lat", "35", "--lon", "-106"),
    "year": ("--lat", "35", "--lon", "-106"),
    "heliostat": ("--sun", "180", "40", "--target", "180", "80"),
    "screwjack": ("--R1", "30", "--R2", "20", "--at", "0", "36"),
    "sunspot": ("--height", "500", "--hole", "4", "--spot", "13", "--edge", "5"),
    "two-mirror": ("fov",),
    "completion": ("bash",),
    "fit": ("FILE",),
    "forecast": ("FILE",),
    "plan": ("FILE",),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a call ended."""

    words: tuple[str, ...]
    code: int | None
    seconds: float
    megabytes: float
    error: str

    @property
    def fault(self) -> str:
        """What may not be; empty where nothing is."""
        if self.code is None:
            return f"still running after {LONGEST_S:g} s"
        if self.code not in (0, 1, 2, 3):
            return f"exit code {self.code}"
        if "Traceback" in self.error:
            return "a traceback"
        if self.code and not self.error.strip():
            return "no word about it"
        if self.code >= 2 and self.error.count("\n") > MOST_LINES:
            return f"{self.error.count(chr(10))} lines about it"
        if self.megabytes > LARGEST_MB:
            return f"{self.megabytes:.0f} MB"
        return ""


class BadFiles:
    """A folder of files that cannot be read, or not as what they are called."""

    def __init__(self, folder: Path, good: Path) -> None:
        self.folder = folder
        content = good.read_bytes()
        lines = content.splitlines(keepends=True)
        for name, bad in {
            "empty.jsonl": b"",
            "empty.csv": b"",
            "binary.jsonl": bytes(range(256)) * 50,
            "binary.csv": bytes(range(256)) * 50,
            "torn.jsonl": content[: len(content) // 2],
            "headless.jsonl": b"".join(lines[1:]),
            "twice.jsonl": content + content,
            "deep.jsonl": b"[" * 200_000,
            "deep.json": b'{"a":' * 100_000,
            "text.toml": b"name = [1,",
            "keys.toml": b"speed = 1e999\n",
            "long.csv": b"1," * 500_000,
            "nul.dat": b"\0" * 10_000,
            "words.dat": b"no TPOINT file\n",
            "wide.json": b"[]",
        }.items():
            (folder / name).write_bytes(bad)
        for name in ("huge.jsonl", "huge.csv", "huge.toml"):
            with open(folder / name, "wb") as file:
                # Sparse: it holds a gigabyte and takes no room.
                file.truncate(1_000_000_000)
        (folder / "folder.jsonl").mkdir()
        self.names = [str(folder / name.name) for name in sorted(folder.iterdir())]
        self.names += [str(folder / "missing.jsonl"), str(folder), "/dev/zero", "/dev/null"]
        for name in ("pipe.jsonl", "pipe.toml"):
            if hasattr(os, "mkfifo"):
                os.mkfifo(folder / name)
                self.names.append(str(folder / name))
        self.good = folder / "good.jsonl"
        self.good.write_bytes(content)
        self.out = folder / "out.csv"

    def base(self, command: str) -> list[str]:
        """A call of the command that is right, or refused at once."""
        stand_in = {"FILE": str(self.good), "OUT": str(self.out), "FOLDER": str(self.folder)}
        return [stand_in.get(word, word) for word in _BASES.get(command, ())]


def bad_calls(files: BadFiles, count: int, seed: int) -> Iterator[tuple[str, ...]]:
    """Calls, always the same for a seed: a right one with something bad in it."""
    chance = random.Random(seed)
    commands = sorted(COMMANDS)
    for number in range(count):
        command = commands[number % len(commands)]
        words = files.base(command)
        options = [action for action in _actions(command) if action.option_strings]
        for _ in range(chance.randint(1, 2)):
            bad = chance.choice(files.names if chance.random() < 0.4 else _TEXTS)
            places = [at for at, word in enumerate(words) if not word.startswith("--")]
            if options and (not places or chance.random() < 0.6):
                action = chance.choice(options)
                takes = 0 if action.nargs == 0 else action.nargs
                many = takes if isinstance(takes, int) else 1
                words += [chance.choice(action.option_strings), *[bad] * many]
            elif places:
                words[chance.choice(places)] = bad
            else:
                words.append(bad)
        yield (command, *words)


@functools.cache
def _actions(command: str) -> list[argparse.Action]:
    parser = build_parser(command)
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            asked: argparse.ArgumentParser = action.choices[command]
            # --debug asks for the traceback.
            return [one for one in asked._actions if not _SKIPPED & set(one.option_strings)]
    return []


def call(words: tuple[str, ...], home: Path) -> Outcome:
    """Run the program with these words, in a home of its own."""
    return measured(words, home, ("-m", "solarcal", *words))


def measured(
    words: tuple[str, ...], home: Path, arguments: Sequence[str], longest_s: float = LONGEST_S
) -> Outcome:
    """Run Python with these arguments as `call` does."""
    environment = os.environ | {
        "SOLARCAL_SESSIONS": str(home / "sessions"), "SOLARCAL_CONFIG": str(home / "config"),
        "COLUMNS": "80",
    }  # fmt: skip
    started = time.perf_counter()
    with open(home / "error.txt", "w+b") as error:
        running = subprocess.Popen(
            [sys.executable, *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=error,
            cwd=home, env=environment,
        )  # fmt: skip
        killer = threading.Timer(longest_s, running.kill)
        killer.start()
        _, status, usage = os.wait4(running.pid, 0)
        killer.cancel()
        code = os.waitstatus_to_exitcode(status)
        running.returncode = code
        error.seek(0)
        text = error.read(100_000).decode("utf-8", "replace")
    seconds = time.perf_counter() - started
    # A process begins with the largest size of the one that started it; below that it is unknown.
    here = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    largest = usage.ru_maxrss if usage.ru_maxrss > 1.01 * here else 0
    megabytes = largest / (1e3 if sys.platform != "darwin" else 1e6)
    overdue = code < 0 and seconds >= longest_s
    return Outcome(words, None if overdue else code, seconds, megabytes, text)


def sweep(count: int, seed: int, folder: Path, good: Path) -> Iterator[Outcome]:
    """Every call of a seed, one after the other."""
    files = BadFiles(folder, good)
    home = folder.parent / f"{folder.name}-home"
    home.mkdir()
    for words in bad_calls(files, count, seed):
        yield call(words, home)
