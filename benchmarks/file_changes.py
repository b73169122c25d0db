"""How far one ``solarcal fit`` walks through the source: calls, changes of file, files touched.

Counted below ``cli`` and ``report``, for a session of twelve points, once everything is imported
and nothing is remembered from an earlier fit. A call is that of a named function; a change, one
whose caller is in another file. What is called most across files is listed: a reader has to follow
it there.
"""

import contextlib
import functools
import gc
import inspect
import io
import sys
from collections import Counter
from pathlib import Path
from types import FrameType

import solarcal
from benchmarks.timing import table
from solarcal.cli import run_command

SESSION = Path(__file__).parents[1] / "sessions" / "azel-good-day.jsonl"
SOURCE = Path(solarcal.__file__).parent
ABOVE = ("cli", "report", "__main__.py")
MOST_CHANGES, MOST_FILES = 300, 26
LISTED = 12


class _Walk:
    """Counts what ``sys.setprofile`` reports."""

    def __init__(self) -> None:
        self.calls: Counter[str] = Counter()
        self.changes: Counter[tuple[str, str]] = Counter()

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        file = _room(code.co_filename)
        if event != "call" or not file or code.co_name.startswith("<"):
            return
        if code.co_flags & inspect.CO_GENERATOR and frame.f_lasti > 2:
            # A generator goes on: nobody called it anew.
            return
        self.calls[file] += 1
        caller = frame.f_back
        while caller is not None and not caller.f_code.co_filename.startswith(str(SOURCE)):
            caller = caller.f_back
        came_from = "" if caller is None else caller.f_code.co_filename
        if came_from != code.co_filename:
            name = f"{file}: {code.co_name}"
            self.changes[_room(came_from) or "above", name] += 1


@functools.cache
def _room(filename: str) -> str:
    """The file's place below the package; empty for what is not counted."""
    path = Path(filename)
    if not path.is_relative_to(SOURCE):
        return ""
    place = path.relative_to(SOURCE)
    return "" if place.parts[0] in ABOVE else place.as_posix()


def _fit() -> None:
    with contextlib.redirect_stdout(io.StringIO()):
        run_command(["fit", str(SESSION)])


def _forget() -> None:
    """Empty every cache of the program."""
    for found in gc.get_objects():
        if isinstance(found, functools._lru_cache_wrapper) and str(found.__module__).startswith(
            "solarcal."
        ):
            found.cache_clear()


def run() -> list[str]:
    _fit()
    _forget()
    walk = _Walk()
    sys.setprofile(walk)
    try:
        _fit()
    finally:
        sys.setprofile(None)
    calls, changes = sum(walk.calls.values()), sum(walk.changes.values())
    most = walk.changes.most_common(LISTED)
    return [
        f"one `solarcal fit {SESSION.name}`, below cli and report: {calls} calls",
        f"{changes} changes of file (goal: at most {MOST_CHANGES}), {len(walk.calls)} files "
        f"(goal: at most {MOST_FILES}); most of them:",
        *table(("from", "to", "changes"), [(a, b, str(n)) for (a, b), n in most]),
    ]
