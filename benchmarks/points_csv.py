"""Reading points CSV: solarcal's reader beside Python's ``csv`` with ``float`` and nothing else.

The peer splits rows and makes numbers of them; ours checks every field, its range and its date,
and names file, line and column of the first that is wrong.
"""

import csv
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.timing import table, timed
from solarcal.session.interchange import read_table
from solarcal.timescale import format_utc

SIZES = (100, 1_000, 10_000, 100_000)
LIMIT_S = 3.0
HEAD = (
    "# geometry=azel\n# lat_deg=35\n# lon_deg=-106\n# ideal=apparent\n"
    "utc,ax1_deg,ax2_deg,err1_deg,err2_deg,sigma_deg,status\n"
)


def write_points(path: Path, rows: int, seed: int = 1) -> None:
    rng = np.random.default_rng(seed)
    ax1, ax2 = rng.uniform(-120.0, 120.0, rows), rng.uniform(10.0, 80.0, rows)
    err1, err2 = rng.normal(0.0, 0.5, (2, rows))
    with path.open("w") as file:
        file.write(HEAD)
        for i in range(rows):
            when = format_utc(1.78e9 + 60.0 * i)
            file.write(f"{when},{ax1[i]:.5f},{ax2[i]:.5f},{err1[i]:.5f},{err2[i]:.5f},0.03,\n")


def _bare(path: Path) -> Callable[[], object]:
    def read() -> object:
        with path.open(newline="") as file:
            rows = csv.reader(line for line in file if not line.startswith("#"))
            next(rows)
            return np.array([[float(field) for field in row[1:6]] for row in rows])

    return read


def run() -> list[str]:
    found = []
    with tempfile.TemporaryDirectory(prefix="solarcal-bench-") as folder:
        for size in SIZES:
            path = Path(folder) / f"{size}.csv"
            write_points(path, size)
            ours, theirs = timed(
                lambda path=path: read_table(path),  # type: ignore[misc]
                _bare(path),
                runs=5,
            )
            found.append(
                (
                    f"{size}",
                    ours.ms(),
                    theirs.ms(),
                    f"{theirs.least_s / ours.least_s:.2f}",
                    ours.per(size, 1e-6),
                )
            )
    return [
        f"ms: least (median); asked of {SIZES[-1]} rows: {1e3 * LIMIT_S:g}",
        *table(("rows", "solarcal", "bare csv", "ratio", "us a row"), found),
    ]


if __name__ == "__main__":
    print("\n".join(run()))
