"""A whole headless calibration day over a pseudo-terminal, beside the same day in process.

Where the time goes is measured by wrapping the three places that can cost: waiting for the line,
fitting, and the journal's synced appends.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.timing import table
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink, serve_pty
from solarcal.session.journal import Journal
from solarcal.station import gathering, headless, technician
from solarcal.station.connect import open_tracker
from solarcal.station.headless import calibrate
from solarcal.station.technician import Schedule
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.link import SerialLink
from solarcal.unit.tracker import Tracker

REPEATS = 5
PARTS = ("waiting", "fitting", "journal")


class Stopwatch:
    """Seconds spent inside wrapped functions."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def around(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*args: Any, **kwargs: Any) -> Any:
            start = time.perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                self.seconds += time.perf_counter() - start

        return timed


@contextmanager
def _on_a_pty(emulator: Emulator) -> Iterator[Tracker]:
    with serve_pty(emulator) as name:
        tracker = open_tracker(name)
        try:
            yield tracker
        finally:
            tracker.close()


@contextmanager
def _in_process(emulator: Emulator) -> Iterator[Tracker]:
    tracker = SolarTrakUnit(lambda: InProcessLink(emulator))
    try:
        yield tracker
    finally:
        tracker.close()


def _one_day(line: Callable[[Emulator], Any]) -> dict[str, float]:
    watches = {name: Stopwatch() for name in PARTS}
    emulator = Emulator(load_scenario("tijeras-azel", []), seed=1)
    with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
        enter = stack.enter_context
        for link in (SerialLink, InProcessLink):
            wait = watches["waiting"].around(link.read_line)
            enter(mock.patch.object(link, "read_line", wait))
        for module in (technician, gathering, headless):
            solve = watches["fitting"].around(module.solve)
            enter(mock.patch.object(module, "solve", solve))
        append = watches["journal"].around(Journal.append)
        enter(mock.patch.object(Journal, "append", append))
        tracker = enter(line(emulator))
        start = time.perf_counter()
        calibrate(
            tracker,
            lambda header: Journal.create(Path(folder) / "day.jsonl", header),
            Schedule(points=12),
        )
        total = time.perf_counter() - start
    return {"total": total, **{name: watch.seconds for name, watch in watches.items()}}


def run() -> list[str]:
    lines = (("pty", _on_a_pty), ("in process", _in_process))
    _one_day(_in_process)
    turns = [{name: _one_day(line) for name, line in lines} for _ in range(REPEATS)]
    rows = []
    least: dict[str, float] = {}
    for name, _ in lines:
        days = sorted((turn[name] for turn in turns), key=lambda day: day["total"])
        best, middle = days[0], days[len(days) // 2]
        least[name] = best["total"]
        shares = (f"{100.0 * best[part] / best['total']:.0f} %" for part in PARTS)
        rows.append((name, f"{best['total']:.2f} ({middle['total']:.2f})", *shares))
    return [
        "a whole day of 12 points, seconds: least (median), and where the least one's went",
        *table(("line", "day", *PARTS), rows),
        f"over a pty {least['pty'] / least['in process']:.2f} times the day in process; waiting is "
        "the emulator computing its world, plus the line",
    ]
