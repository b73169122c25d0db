"""A month in the workstation, without a screen: does anything grow, drift, or go missing?

An emulated tracker is calibrated anew every day, each day in a file of its own, while the unit is
read every few minutes of the day and night and the screens are looked at. Virtual time moves only
by the station's clock, so that a month takes minutes.
"""

import asyncio
import gc
import os
import queue
import resource
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from textual._styles_cache import StylesCache

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.session.journal import Journal
from solarcal.session.records import Header
from solarcal.session.view import read_session
from solarcal.station.clocks import EmulatedClock
from solarcal.station.news import Done
from solarcal.station.procedure import Station
from solarcal.station.recording import CreateJournal
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.tui.app import SolarcalApp
from solarcal.tui.workstation.screen import WorkstationScreen
from solarcal.unit.drivers.solartrak import SolarTrakUnit

READING_S = 300.0
POINTS_A_DAY = 8
POINT_S = 3600.0
"""Data points begin on the hour after the morning's preparation."""

LOOKED_AT = ("v", "f1", "escape", "p", "escape", "f10", "escape", "v")
WARM_UP_DAYS = 5
MOST_GROWTH_KB_A_DAY = 100.0
"""Above what bounded caches of words and styles still take; one status kept of every reading would
be some 300."""


@dataclass(slots=True)
class Month:
    """What was measured, a value a day."""

    readings: int = 0
    readings_due: int = 0
    shown: int = 0
    points: int = 0
    worst_reading_lag_s: float = 0.0
    worst_point_lag_s: float = 0.0
    traced_kb: list[float] = field(default_factory=list)
    cached_kb: list[float] = field(default_factory=list)
    resident_mb: list[float] = field(default_factory=list)
    objects: list[int] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def growth_kb_a_day(self) -> float:
        """Slope of the traced memory after the warm-up; 0 while there is none yet."""
        after = np.array(self.traced_kb[WARM_UP_DAYS:])
        return float(np.polyfit(np.arange(len(after)), after, 1)[0]) if len(after) > 2 else 0.0

    def complaints(self, days: int) -> list[str]:
        """What is not as it must be; empty when all is well."""
        found = []
        if self.readings != self.readings_due:
            found.append(f"{self.readings_due - self.readings} readings are missing")
        if self.shown != self.readings:
            found.append(f"{self.readings - self.shown} readings did not reach the screen")
        if self.points != days * POINTS_A_DAY:
            found.append(f"{self.points} points instead of {days * POINTS_A_DAY}")
        if self.worst_reading_lag_s > 0.01 or self.worst_point_lag_s > 0.01:
            found.append("the schedule drifts")
        if self.growth_kb_a_day > MOST_GROWTH_KB_A_DAY:
            found.append(f"memory grows by {self.growth_kb_a_day:.0f} kB a day")
        return found

    def words(self) -> str:
        traced, resident = self.traced_kb, self.resident_mb
        return (
            f"{len(traced)} days in {self.seconds / 60.0:.1f} min: {self.readings} of "
            f"{self.readings_due} readings, {self.shown} on the screen, {self.points} points; "
            f"worst lag of a reading {self.worst_reading_lag_s:.3f} s, of a point "
            f"{self.worst_point_lag_s:.3f} s; memory in use day 1 {traced[0] / 1e3:.1f} MB, "
            f"last day {traced[-1] / 1e3:.1f} MB, after the warm-up "
            f"{self.growth_kb_a_day:+.1f} kB a day (beside them up to "
            f"{max(self.cached_kb) / 1e3:.1f} MB a day in Textual's bounded cache); resident "
            f"{resident[0]:.0f} to "
            f"{resident[-1]:.0f} MB (most {_peak_mb():.0f}); objects {self.objects[0]} to "
            f"{self.objects[-1]}"
        )


class Lived(Done[None], name="a step of the month"): ...


class _Worker:
    """Steps through the app's own worker, waited for."""

    def __init__(self, app: SolarcalApp, month: Month) -> None:
        self.app, self.month = app, month

    async def do(self, step: Callable[[Station], object]) -> None:
        assert self.app.worker is not None
        done: queue.Queue[BaseException | None] = queue.Queue()

        def watched(station: Station) -> None:
            try:
                step(station)
            except BaseException as error:
                done.put(error)
                raise
            done.put(None)

        self.app.worker.submit(Lived, watched)
        while done.empty():
            await asyncio.sleep(0.002)
        error = done.get()
        if error is not None:
            raise error


async def live_a_month(folder: Path, days: int, say: Callable[[str], object] = print) -> Month:
    """Run it; the files of the days are left in ``folder``."""
    month, started = Month(), time.perf_counter()
    emulator = Emulator(load_scenario("tijeras-azel"), seed=1)
    unit = SolarTrakUnit(lambda: InProcessLink(emulator), port="the emulator")
    unit.open()
    emulation = unit.emulation
    assert emulation is not None
    station = Station(unit, EmulatedClock(emulation), operator="soak")
    station.connect()
    numbers = iter(range(1, days + 1))

    def create(header: Header) -> Journal:
        return Journal.create(folder / f"day-{next(numbers):02d}.jsonl", header)

    station.open_session(create)
    technician = AutomaticTechnician(station, emulation.spot, Schedule(points=POINTS_A_DAY))
    morning_s = station.clock.utc_s()
    app = SolarcalApp()
    async with app.run_test(size=(120, 40)) as pilot:
        app.adopt(station)
        await app.push_screen(WorkstationScreen())
        await pilot.pause()
        worker = _Worker(app, month)
        tracemalloc.start()
        try:
            for day in range(days):
                morning = morning_s + day * SECONDS_PER_DAY
                await _live_a_day(worker, technician, create if day else None, morning)
                await pilot.press(*LOOKED_AT)
                await pilot.pause()
                month.cached_kb.append(_empty_drawing_cache())
                month.traced_kb.append(tracemalloc.get_traced_memory()[0] / 1024.0)
                month.resident_mb.append(_resident_mb())
                month.objects.append(len(gc.get_objects()))
                say(
                    f"  day {day + 1}: {month.readings} readings, {month.traced_kb[-1]:.0f} kB, "
                    f"{month.objects[-1]} objects"
                )
        finally:
            tracemalloc.stop()
            if app.worker is not None:
                app.worker.close()
    station.close()
    month.points = sum(
        point.status == "accepted"
        for path in sorted(folder.glob("day-*.jsonl"))
        for point in read_session(path).points
    )
    month.seconds = time.perf_counter() - started
    return month


async def _live_a_day(
    worker: _Worker,
    technician: AutomaticTechnician,
    start_next: CreateJournal | None,
    morning_s: float,
) -> None:
    """From one morning to the next: prepare, points on the hour, readings throughout."""
    month = worker.month

    def prepare(station: Station) -> None:
        station.clock.wait(morning_s - station.clock.utc_s())
        station.set_unit_clock()
        technician._check_reference()
        station.initialise(confirmed=True, start_next=start_next)

    await worker.do(prepare)
    last_point_s = morning_s + POINTS_A_DAY * POINT_S
    slot_s = morning_s
    while (slot_s := slot_s + READING_S) < morning_s + SECONDS_PER_DAY:
        now_s = worker.app.worker.station.clock.utc_s()  # type: ignore[union-attr]
        on_the_hour = (slot_s - morning_s) % POINT_S == 0.0 and slot_s <= last_point_s
        if slot_s < now_s and not on_the_hour:
            continue  # a point was being taken
        month.readings_due += 1

        def reading(station: Station, slot_s: float = slot_s) -> None:
            station.clock.wait(slot_s - station.clock.utc_s())
            station.poll()
            at_s = station.state.live.laptop_utc_s
            assert at_s is not None
            month.readings += 1
            month.worst_reading_lag_s = max(month.worst_reading_lag_s, abs(at_s - slot_s))

        await worker.do(reading)
        await _until_shown(worker, slot_s)
        if on_the_hour:

            def point(station: Station, slot_s: float = slot_s) -> None:
                lag_s = abs(station.clock.utc_s() - slot_s)
                month.worst_point_lag_s = max(month.worst_point_lag_s, lag_s)
                technician.take_point()

            await worker.do(point)


async def _until_shown(worker: _Worker, slot_s: float) -> None:
    """Until the app has been told of this reading (it may skip what a newer one replaced)."""
    for _ in range(5000):
        told_s = worker.app.state.live.laptop_utc_s
        if told_s is not None and told_s >= slot_s - 0.01:
            worker.month.shown += 1
            return
        await asyncio.sleep(0.002)


def _empty_drawing_cache() -> float:
    """Throw away what Textual keeps of widgets that are gone; how many kB that was.

    It remembers up to 1,024 of them with all they have drawn, some 30 MB, and no more: a bounded
    amount that would take a month to fill and hide what is not bounded.
    """
    gc.collect()
    before = tracemalloc.get_traced_memory()[0]
    StylesCache.get_inner_outer.cache_clear()
    gc.collect()
    return (before - tracemalloc.get_traced_memory()[0]) / 1024.0


def _resident_mb() -> float:
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        return _peak_mb()
    return pages * os.sysconf("SC_PAGESIZE") / 2**20


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
