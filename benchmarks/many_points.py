"""Fit, forecast, plan and verdict of very many points: CPU time and memory of a process of its own.

Goals: 20,000 points below 300 MB; a million below 2 GB and a minute.
"""

import resource
import subprocess
import sys
import time

import numpy as np

from benchmarks.judgement_trackers import context_of, daylight_s, measured
from benchmarks.timing import table
from solarcal.model.analysis import analyse
from solarcal.mount.mechanism import Mechanism

GOALS = {20_000: (60.0, 300.0), 1_000_000: (60.0, 2000.0)}
JUNE = 171
SPACING_S = 2.5


def run() -> list[str]:
    rows = []
    for n, (most_s, most_mb) in GOALS.items():
        told = subprocess.run(
            [sys.executable, "-m", "benchmarks.many_points", f"{n}"],
            check=True, capture_output=True, text=True,
        ).stdout.split()  # fmt: skip
        cpu_s, peak_mb = float(told[0]), float(told[1])
        met = "met" if cpu_s <= most_s and peak_mb <= most_mb else "NOT MET"
        rows.append((f"{n}", f"{cpu_s:.1f}", f"{peak_mb:.0f}", met))
    return table(("points", "CPU s", "peak MB", "goal"), rows)


def _one(n: int) -> str:
    context = context_of("azel")
    first_s, last_s = daylight_s(context, JUNE)
    # Points of one instant would be one measurement: so many days that each is of its own.
    days = 1 + int(n * SPACING_S / (last_s - first_s))
    day, at = np.divmod(np.arange(n), -(-n // days))
    times = first_s + SPACING_S * at + 86400.0 * day
    tracker = Mechanism(P1=0.7, P2=-0.5, P3=0.3, P4=1.2, P5=0.001, P6=-0.0005)
    points = measured(context, tracker, times, np.random.default_rng(1))
    begun_s = time.process_time()
    analyse(points, context, at_utc_s=last_s)
    cpu_s = time.process_time() - begun_s
    return f"{cpu_s} {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0}"


if __name__ == "__main__":
    print(_one(int(sys.argv[1])))
