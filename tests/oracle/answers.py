"""Answers of the program recorded before a change: what they are, and how two are compared.

``python tests/oracle/answers.py`` records the answers anew, in the same commit as the change that
moves them, and the message of that commit says which numbers move and why. With ``--sessions``
the sessions of the scenarios are made anew first: needed only when a scenario is added.

What is compared: every value of every key recorded. New keys and new items with a ``kind`` are
free. Of sentences and of the report the numbers are compared, not the words.
"""

import argparse
import contextlib
import io
import json
import lzma
import re
import sys
import tempfile
from pathlib import Path

from solarcal.cli import run_command
from solarcal.emulator.scenario import scenario_names

HERE = Path(__file__).parent
SESSIONS = HERE.parents[1] / "sessions"
SCENARIO_SESSIONS = HERE / "scenario_sessions.json.xz"
ANSWERS = HERE / "answers.json.xz"
SEED = "7"

COMMANDS = {
    "fit linear": ["fit", "--json", "--method", "linear"],
    "fit robust": ["fit", "--json", "--method", "robust"],
    "fit exact": ["fit", "--json", "--method", "exact"],
    "forecast": ["forecast", "--json"],
    "plan": ["plan", "--json"],
    "report": ["report"],
}

# Angles are in degrees, so this is 1e-9 deg; of numbers above 1 it is relative.
CLOSE = 1e-9
# Where an iterative solver was replaced by another: command -> (tolerance, why). As short as it
# can be.
LOOSER: dict[str, tuple[float, str]] = {}

# Names that were changed since the answers were recorded: old -> new. Emptied when the answers
# are recorded anew.
RENAMED_KEYS: dict[str, str] = {}
RENAMED_VALUES: dict[str, str] = {}

# Of a long list every so many-th item is recorded, and its length.
LONG = 60
EVERY = 40

NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w])")
LENGTH = "length of a long list"


def load(path: Path) -> dict:
    return json.loads(lzma.decompress(path.read_bytes()))


def store(path: Path, content: dict) -> None:
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False)
    path.write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))


def write_sessions(folder: Path) -> list[Path]:
    """The files answered about: those of ``sessions/`` and one of every scenario."""
    paths = sorted(SESSIONS.glob("*.jsonl"))
    for name, text in load(SCENARIO_SESSIONS).items():
        path = folder / f"scenario-{name}.jsonl"
        path.write_text(text, encoding="utf-8", newline="")
        paths.append(path)
    return paths


def answer(path: Path, command: str, folder: Path) -> object:
    """The JSON document of a command, or the text of the report."""
    arguments = [*COMMANDS[command], str(path)]
    if command != "report":
        return json.loads(_output_of(arguments))
    certificate = folder / f"{path.stem}.txt"
    _output_of([*arguments, "-o", str(certificate)])
    return certificate.read_text(encoding="utf-8")


def _output_of(arguments: list[str]) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as output:
        code = run_command(arguments)
    assert code == 0, f"solarcal {' '.join(arguments)} left with {code}"
    return output.getvalue()


def compact(value: object) -> object:
    """What is recorded of an answer: twelve digits, and a sample of long lists."""
    if isinstance(value, dict):
        return {key: compact(item) for key, item in value.items()}
    if isinstance(value, list):
        if len(value) > LONG:
            return {LENGTH: len(value), "sample": [compact(item) for item in value[::EVERY]]}
        return [compact(item) for item in value]
    return float(f"{value:.12g}") if isinstance(value, float) else value


def differences(recorded: object, now: object, command: str) -> list[str]:
    """Every place where an answer is another one, a line each."""
    close = LOOSER.get(command, (CLOSE, ""))[0]
    if command == "report":
        return _numbers_missing([str(recorded)], [str(now)])
    found = _Differences(close)
    found.compare(recorded, compact(now), "")
    return found.lines + _numbers_missing(_sentences(recorded), _sentences(now))


class _Differences:
    def __init__(self, close: float) -> None:
        self.close = close
        self.lines: list[str] = []

    def compare(self, old: object, new: object, where: str) -> None:
        if isinstance(old, dict) and isinstance(new, dict):
            for key, value in old.items():
                name = RENAMED_KEYS.get(key, key)
                if name in new:
                    self.compare(value, new[name], f"{where}.{name}")
                else:
                    self.lines.append(f"{where}.{name} is gone; it was {value!r}")
        elif isinstance(old, list) and isinstance(new, list):
            self._compare_lists(old, new, where)
        elif isinstance(old, str) and isinstance(new, str):
            if not _is_sentence(old) and RENAMED_VALUES.get(old, old) != new:
                self.lines.append(f"{where}: {old!r} is now {new!r}")
        elif _is_number(old) and _is_number(new):
            if abs(new - old) > self.close * max(1.0, abs(old)):
                self.lines.append(f"{where}: {old!r} is now {new!r}")
        elif old is not new:
            self.lines.append(f"{where}: {old!r} is now {new!r}")

    def _compare_lists(self, old: list, new: list, where: str) -> None:
        if all(isinstance(item, str) and _is_sentence(item) for item in old):
            return
        if all(isinstance(item, dict) and "kind" in item for item in old):
            self._compare_kinds(old, new, where)
        elif len(old) != len(new):
            self.lines.append(f"{where}: {len(old)} items are now {len(new)}")
        else:
            for number, (before, after) in enumerate(zip(old, new, strict=True)):
                self.compare(before, after, f"{where}[{number}]")

    def _compare_kinds(self, old: list[dict], new: list[dict], where: str) -> None:
        """Items in any order among new ones: each of the old ones must be there."""
        left = list(new)
        for item in old:
            best: _Differences | None = None
            for candidate in left:
                if candidate.get("kind") != RENAMED_VALUES.get(item["kind"], item["kind"]):
                    continue
                tried = _Differences(self.close)
                tried.compare(item, candidate, f"{where}[{candidate['kind']}]")
                if best is None or len(tried.lines) < len(best.lines):
                    best, chosen = tried, candidate
            if best is None:
                self.lines.append(f"{where}: {item['kind']} is gone")
            else:
                left.remove(chosen)
                self.lines += best.lines


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_sentence(text: str) -> bool:
    return " " in text


def _sentences(value: object) -> list[str]:
    if isinstance(value, dict):
        return [text for item in value.values() for text in _sentences(item)]
    if isinstance(value, list):
        return [text for item in value for text in _sentences(item)]
    return [value] if isinstance(value, str) and _is_sentence(value) else []


def _numbers_missing(recorded: list[str], now: list[str]) -> list[str]:
    """Numbers written in the old text and not in the new one; the last digit may differ by one."""
    missing = []
    new = _numbers_by_decimals(now)
    for decimals, numbers in _numbers_by_decimals(recorded).items():
        left = new.get(decimals, [])
        step = 1.0001 * 10.0**-decimals if decimals else 1e-9
        for number in numbers:
            match = next((other for other in left if abs(other - number) <= step), None)
            if match is None:
                missing.append(f"the text does not say {number:.{decimals}f} any more")
            else:
                left.remove(match)
    return missing


def _numbers_by_decimals(texts: list[str]) -> dict[int, list[float]]:
    found: dict[int, list[float]] = {}
    for token in NUMBER.findall("\n".join(texts)):
        decimals = len(token.partition(".")[2]) if "e" not in token else 0
        found.setdefault(decimals, []).append(float(token))
    return {decimals: sorted(numbers) for decimals, numbers in found.items()}


def _make_scenario_sessions(folder: Path) -> None:
    texts = {}
    for name in scenario_names():
        path = folder / f"{name}.jsonl"
        with contextlib.redirect_stderr(io.StringIO()):
            _output_of(["calibrate", "--scenario", name, "--seed", SEED, "-o", str(path), "--json"])
        texts[name] = path.read_text(encoding="utf-8")
    store(SCENARIO_SESSIONS, texts)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", action="store_true", help="make the sessions anew too")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if arguments.sessions:
            _make_scenario_sessions(folder)
        recorded = {
            path.name: {command: compact(answer(path, command, folder)) for command in COMMANDS}
            for path in write_sessions(folder)
        }
    store(ANSWERS, recorded)
    print(f"{len(recorded)} files, {ANSWERS.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
