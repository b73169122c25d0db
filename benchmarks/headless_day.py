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

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink, serve_pty
from solarcal.session.journal import Journal
from solarcal.station import gathering, headless, technician
from solarcal.station.front_door import open_tracker
from solarcal.station.headless import calibrate
from solarcal.station.technician import Schedule
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.link import SerialLink
from solarcal.unit.tracker import Tracker

REPEATS = 3


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
    watches = {name: Stopwatch() for name in ("waiting", "fitting", "journal")}
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
    _one_day(_in_process)
    days = {
        name: min((_one_day(line) for _ in range(REPEATS)), key=lambda day: day["total"])
        for name, line in (("pty", _on_a_pty), ("in process", _in_process))
    }
    lines = [f"{'line':12} {'total s':>8} {'waiting':>8} {'fitting':>8} {'journal':>8}"]
    for name, day in days.items():
        shares = " ".join(
            f"{100.0 * day[part] / day['total']:7.1f}%"
            for part in ("waiting", "fitting", "journal")
        )
        lines.append(f"{name:12} {day['total']:8.2f} {shares}")
    ratio = days["pty"]["total"] / days["in process"]["total"]
    lines.append(
        f"a 12-point day over a pty takes {ratio:.2f}x the day in process; waiting on the pty is "
        "the emulator computing its world, plus the line"
    )
    return lines
