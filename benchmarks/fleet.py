"""``solarcal fleet`` over 10 to 10,000 sessions of 12 points, whole processes.

The peer is the way of ``solarcal fit``, file after file in one process (its reader, its robust
fit; neither forecast nor diagnosis): the same answers, so the ratio is what reading only points and
fitting side by side are worth.
"""

import contextlib
import io
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from benchmarks.made_up_fleet import SESSIONS, write_fleet
from benchmarks.timing import table
from solarcal.station.analysing import load_points
from solarcal.station.fitting import solve_table

SIZES = (10, 100, 1_000, SESSIONS)
RUNS = 3
ONE_BY_ONE = 100
LIMIT_S = 10.0


def run() -> list[str]:
    rows = []
    with tempfile.TemporaryDirectory(prefix="solarcal-bench-") as name:
        for size in SIZES:
            folder = Path(name) / str(size)
            write_fleet(folder, size)
            seconds, alone = [], []
            for _ in range(RUNS):
                seconds.append(_fleet_s(folder))
                alone.append(_one_by_one_s(folder, min(size, ONE_BY_ONE)) / min(size, ONE_BY_ONE))
            rows.append(
                (
                    f"{size}",
                    f"{min(seconds):.2f} ({median(seconds):.2f})",
                    f"{1e3 * min(seconds) / size:.2f}",
                    f"{1e3 * min(alone):.2f} ({1e3 * median(alone):.2f})",
                    f"{size * min(alone) / min(seconds):.1f}",
                )
            )
    return [
        f"whole process, seconds: least (median); asked of {SESSIONS} sessions: {LIMIT_S:g}",
        *table(("sessions", "fleet", "ms each", "one by one, ms each", "ratio"), rows),
    ]


def _fleet_s(folder: Path) -> float:
    command = [sys.executable, "-m", "solarcal", "fleet", str(folder)]
    started = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=dict(os.environ))
    return time.perf_counter() - started


def _one_by_one_s(folder: Path, count: int) -> float:
    files = sorted(folder.rglob("*.jsonl"))
    chosen = files[:: max(1, len(files) // count)][:count]
    started = time.perf_counter()
    with contextlib.redirect_stderr(io.StringIO()):
        for path in chosen:
            points, session = load_points(path, {})
            solve_table(points, "robust", header=None if session is None else session.header)
    return time.perf_counter() - started


if __name__ == "__main__":
    print("\n".join(run()))
