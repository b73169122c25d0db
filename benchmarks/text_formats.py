"""``solarcal fit`` of 100,000 rows of every text format, whole process: seconds of processor.

The peer splits the same file into lines and cells and makes numbers of them, nothing else; its
process starts too.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.timing import table
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.timescale import format_utc
from solarcal.units import FloatArray

ROWS = 100_000
LIMIT_S = 3.0
RUNS = 3
PEER = (
    "import sys\n"
    "for line in open(sys.argv[1]):\n"
    "    for cell in line.replace(',', ' ').replace(':', ' ').split():\n"
    "        try: float(cell)\n"
    "        except ValueError: pass\n"
)


def _angles(rows: int, seed: int = 1) -> FloatArray:
    """Azimuth and elevation of the place and of the encoders, (4, rows), of a leaning tower."""
    rng = np.random.default_rng(seed)
    azimuth, elevation = rng.uniform(60.0, 300.0, rows), rng.uniform(12.0, 75.0, rows)
    mechanism = Mechanism(P1=0.3, P2=-0.3, P3=0.4, P4=0.2, P5=0.0005, P6=-0.0004)
    ax1, ax2 = mechanism.readings_deg(
        MountGeometry("azel", 35.0), 180.0 - azimuth, 90.0 - elevation
    )
    noise = rng.normal(0.0, 0.02, (2, rows)) / (np.cos(np.radians(elevation)), np.ones(rows))
    return np.stack((azimuth, elevation, 180.0 - ax1 - noise[0], 90.0 - ax2 - noise[1]))


def _sexagesimal(angle: float, between: str) -> str:
    tenths = round(abs(angle) * 36000.0)
    return between.join(
        (str(tenths // 36000), f"{tenths // 600 % 60:02d}", f"{tenths % 600 / 10.0:04.1f}")
    )


def _altaz(path: Path, head: str, between: str = "", end: str = "") -> None:
    def text(angle: float) -> str:
        return _sexagesimal(angle, between) if between else f"{angle:.6f}"

    rows = _angles(ROWS).T.tolist()
    lines = (" ".join(map(text, row)) for row in rows)
    path.write_text("\n".join([head, *lines, end]))


def _offsets(path: Path) -> None:
    azimuth, elevation, encoder1, encoder2 = _angles(ROWS)
    lines = ["# Latitude: 35.0", "# offset_az: observed azimuth - solar azimuth [deg]"]
    lines.append("\t".join(("timestamp", "azimuth", "elevation", "offset_az", "offset_el")))
    off1, off2 = encoder1 - azimuth, encoder2 - elevation
    columns = (azimuth.tolist(), elevation.tolist(), off1.tolist(), off2.tolist())
    for at, (a, e, da, de) in enumerate(zip(*columns, strict=True)):
        when = format_utc(1.78e9 + 60.0 * at, 0)[:-1]
        lines.append(f"{when}\t{a:.6f}\t{e:.6f}\t{da:.6f}\t{de:.6f}")
    path.write_text("\n".join([*lines, ""]))


def _points_csv(path: Path) -> None:
    azimuth, elevation, encoder1, encoder2 = _angles(ROWS)
    lines = ["# geometry=azel", "# lat_deg=35"]
    lines.append("utc,ax1_deg,ax2_deg,err1_deg,err2_deg,sigma_deg,status")
    errors = (azimuth - encoder1).tolist(), (elevation - encoder2).tolist()
    columns = ((180.0 - azimuth).tolist(), (90.0 - elevation).tolist(), *errors)
    for at, row in enumerate(zip(*columns, strict=True)):
        numbers = ",".join(f"{value:.6f}" for value in row)
        lines.append(f"{format_utc(1.78e9 + 60.0 * at)},{numbers},0.02,")
    path.write_text("\n".join([*lines, ""]))


def _files(folder: Path) -> dict[str, Path]:
    names = ("tpoint.dat", "spaced.dat", "colons.dat", "pmfit.dat", "offsets.tsv", "points.csv")
    tpoint, spaced, colons, pmfit, offsets, points = (folder / name for name in names)
    _altaz(tpoint, "tower\n: ALTAZ\n35.0", end="END")
    _altaz(spaced, "tower\n: ALTAZ\n35 00 00", " ", "END")
    _altaz(colons, "tower\n: ALTAZ\n35 00 00", ":", "END")
    _altaz(pmfit, "tower\nA\n35.0")
    _offsets(offsets)
    _points_csv(points)
    return {
        "TPOINT": tpoint,
        "TPOINT, d m s": spaced,
        "TPOINT, d:m:s": colons,
        "PMFIT": pmfit,
        "solaris-pointing": offsets,
        "points CSV": points,
    }


def _processor_s(*arguments: str) -> float:
    """User and system time of a process, which must succeed."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    return (after[2] - before[2]) + (after[3] - before[3])


def run() -> list[str]:
    found = []
    with tempfile.TemporaryDirectory(prefix="solarcal-bench-") as name:
        for kind, path in _files(Path(name)).items():
            seconds = [
                (
                    _processor_s("-m", "solarcal", "fit", str(path), "--json"),
                    _processor_s("-c", PEER, str(path)),
                )
                for _ in range(RUNS)
            ]
            ours, theirs = (min(of) for of in zip(*seconds, strict=True))
            found.append((kind, f"{ours:.2f}", f"{theirs:.2f}", f"{ours / theirs:.1f}"))
    return [
        f"seconds of processor, {ROWS} rows, least of {RUNS} runs; asked: {LIMIT_S:g}",
        *table(("format", "solarcal fit", "bare numbers", "ratio"), found),
    ]


if __name__ == "__main__":
    print("\n".join(run()))
