"""Tries mutants in one copy of the tree: a process that has the libraries ready and forks for each.

Jobs come as lines of JSON on standard input, an answer goes back for each; `Worker` is the other
end.
"""

import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

MEMORY_BYTES = 6 * 2**30
TIMES_WALL = 3.0
"""Real seconds allowed for one of the processor's: the machine may have other work."""


class Worker:
    """The process that tries mutants in ``tree``."""

    def __init__(self, tree: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tools.mutants.worker"],
            cwd=tree,
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join((str(tree / "src"), str(tree))),
                "OPENBLAS_NUM_THREADS": "1",
            },
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def tries(self, path: str, text: str, tests: list[str], cpu_s: float) -> str:
        """Who killed it: a test, ``time`` or ``end of the process``; empty if nobody."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        job = {"path": path, "text": text, "tests": tests, "cpu_s": cpu_s}
        print(json.dumps(job), file=self._process.stdin, flush=True)
        killer: str = json.loads(self._process.stdout.readline())
        return killer

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def serve() -> None:
    """Read jobs until there are no more."""
    _prepare()
    # A compiled file is told from its source by whole seconds and size: each change has its own.
    written_s = int(time.time()) - 10_000_000
    for line in sys.stdin:
        job = json.loads(line)
        path = Path(job["path"])
        before = path.read_text(encoding="utf-8")
        try:
            written_s += 1
            path.write_text(job["text"], encoding="utf-8")
            os.utime(path, (written_s, written_s))
            killer = _tried(job["tests"], job["cpu_s"])
        finally:
            written_s += 1
            path.write_text(before, encoding="utf-8")
            os.utime(path, (written_s, written_s))
        print(json.dumps(killer), flush=True)


def _prepare() -> None:
    """Import what every test needs and no mutant changes."""
    for name in ("numpy", "scipy.linalg", "scipy.optimize", "erfa", "msgspec", "serial", "pytest",
                 "hypothesis", "_pytest.assertion.rewrite", "_pytest.python", "xdist"):  # fmt: skip
        with contextlib.suppress(ImportError):
            __import__(name)


def _tried(tests: list[str], cpu_s: float) -> str:
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        _run_tests(tests, cpu_s, writing)
    os.close(writing)
    deadline_s = time.monotonic() + TIMES_WALL * cpu_s
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > deadline_s:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return "time"
        time.sleep(0.02)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    with os.fdopen(reading) as pipe:
        failed = pipe.read()
    if os.WIFSIGNALED(status):
        return "time" if os.WTERMSIG(status) == signal.SIGXCPU else "end of the process"
    return failed if os.WEXITSTATUS(status) else ""


class _FirstFailure:
    """A pytest plugin that notes which test failed first."""

    def __init__(self) -> None:
        self.name = ""

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and not self.name:
            self.name = report.nodeid

    def pytest_collectreport(self, report: Any) -> None:
        if report.failed and not self.name:
            self.name = report.nodeid


def _run_tests(tests: list[str], cpu_s: float, pipe: int) -> None:
    """In the child: never returns."""
    code = 1
    try:
        os.setsid()
        nowhere = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(nowhere, descriptor)
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu_s), int(cpu_s) + 5))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        import pytest

        first = _FirstFailure()
        options = ["-q", "-x", "--tb=no", "-p", "no:cacheprovider"]
        code = int(pytest.main([*options, *tests], plugins=[first]))
        os.write(pipe, (first.name or f"pytest ended with {code}").encode())
    finally:
        os._exit(code)


if __name__ == "__main__":
    serve()
