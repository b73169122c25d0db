"""Build wheel and source archive, install the wheel alone, calibrate with it.

``python -m tools.dist_check [PYTHON ...]``: for each interpreter named (default: this one).
"""

import json
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
IN_THE_WHEEL = (
    "solarcal/py.typed",
    "solarcal/tui/solarcal.tcss",
    "solarcal/emulator/scenarios/tijeras-azel.toml",
    "licenses/LICENSE",
    "share/man/man1/solarcal.1",
)
IN_THE_SOURCE = ("LICENSE", "README.md", "pyproject.toml", "docs/README.md", "tests/conftest.py")


def build(folder: Path) -> tuple[Path, Path]:
    """Build both archives into ``folder``; return wheel and source archive."""
    _run(sys.executable, "-m", "hatchling", "build", "-d", str(folder))
    (wheel,) = folder.glob("*.whl")
    (source,) = folder.glob("*.tar.gz")
    return wheel, source


def missing(wheel: Path, source: Path) -> list[str]:
    """Return the files that the archives should hold and do not."""
    with zipfile.ZipFile(wheel) as packed, tarfile.open(source) as archive:
        in_wheel, in_source = packed.namelist(), archive.getnames()
    return [
        f"{path.name}: {wanted}"
        for path, names, expected in (
            (wheel, in_wheel, IN_THE_WHEEL),
            (source, in_source, IN_THE_SOURCE),
        )
        for wanted in expected
        if not any(name.endswith(wanted) for name in names)
    ]


def calibrates(wheel: Path, python: str, folder: Path) -> float:
    """Install the wheel alone in a new environment, calibrate; return the true rms afterwards."""
    _run(python, "-m", "venv", str(folder / "venv"))
    bin_folder = folder / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
    pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _run(str(bin_folder / "python"), *pip, str(wheel))
    answer = _run(
        str(bin_folder / "solarcal"), "calibrate", "--scenario", "tijeras-azel", "--json",
        "-o", str(folder / "day.jsonl"), cwd=folder,
    )  # fmt: skip
    _run(str(bin_folder / "solarcal"), "demo", "--headless", cwd=folder)
    return float(json.loads(answer)["truth"]["day_rms_after_deg"])


def _run(*command: str, cwd: Path = ROOT) -> str:
    done = subprocess.run(
        command, cwd=cwd, check=False, capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def main(pythons: list[str]) -> int:
    with tempfile.TemporaryDirectory() as name:
        wheel, source = build(Path(name))
        print(f"{wheel.name}: {wheel.stat().st_size // 1024} kB; {source.name}")
        if lost := missing(wheel, source):
            print("\n".join(f"missing in {line}" for line in lost))
            return 1
        for python in pythons or [sys.executable]:
            with tempfile.TemporaryDirectory() as place:
                rms = calibrates(wheel, python, Path(place))
                print(f"{python}: calibrated, true rms of the day afterwards {rms:.4f} deg")
                if rms > 0.05:
                    return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
