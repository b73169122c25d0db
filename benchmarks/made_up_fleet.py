"""A folder of session files as a fleet's technicians leave it; the same seed, the same bytes.

``python -m benchmarks.made_up_fleet DIR [SESSIONS]`` writes one. Every session is of a tracker of
its own with an exact mechanism, in one of forty plants, on one day of two years; a point in
fifty is a blunder, one tower in ten was measured with an inclinometer, one point in a hundred was
struck afterwards.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.judgement_trackers import daylight_s, measured, random_mechanism
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.mount.drive import RotaryDrive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.session.lines import encode_record
from solarcal.session.records import (
    Answers,
    ClockSet,
    Closed,
    FitRecord,
    Header,
    Initialised,
    PointRecord,
    Record,
    RefCheck,
    SunOffset,
    UnitRecord,
    Void,
)
from solarcal.site import Inclinometer, Site, Weather, standard_pressure_hpa
from solarcal.timescale import format_utc

SEED = 7
SESSIONS = 10_000
POINTS = 12
PLANTS = 40
IN_A_FOLDER = 500
BLUNDERS, STRUCK, MEASURED_LEANS = 0.02, 0.01, 0.1
BLUNDER_DEG = 0.5
_NOTHING = Coefficients()
_YES = Answers(ref_check=True, sun_offset=True, tracking=True)


@dataclass(frozen=True)
class _Plant:
    context: SkyContext
    zone_west_h: float


def write_fleet(folder: Path, sessions: int = SESSIONS, seed: int = SEED) -> None:
    """Write so many session files, some hundreds a folder."""
    plants = _plants(np.random.default_rng([seed, 1]))
    for number in range(sessions):
        rng = np.random.default_rng([seed, 2, number])
        # One plant after the other: its Sun is prepared once.
        plant = plants[number * len(plants) // sessions]
        content = b"".join(encode_record(r) for r in _session(number, plant, rng))
        path = folder / f"{number // IN_A_FOLDER:03d}" / f"unit-{number:05d}.jsonl"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def _plants(rng: np.random.Generator) -> list[_Plant]:
    plants = []
    for number in range(PLANTS):
        south = number % 5 == 4
        latitude = float(rng.uniform(24.0, 44.0)) * (-1.0 if south else 1.0)
        longitude, elevation = float(rng.uniform(-120.0, 120.0)), float(rng.uniform(0.0, 2000.0))
        name = "tiltroll-ew" if number % 4 == 1 else "azel"
        centre = 180.0 if south and name == "azel" else 0.0
        context = SkyContext(
            Site(latitude, longitude, elevation),
            MountGeometry(name, latitude, centre),
            ideal="solartrak",
            weather=Weather(standard_pressure_hpa(elevation), 20.0),
            year=f"{2025 + number % 2}-01-01",
        )
        plants.append(_Plant(context, -round(longitude / 15.0)))
    return plants


def _session(number: int, plant: _Plant, rng: np.random.Generator) -> Iterator[Record]:
    context = plant.context
    first, last = daylight_s(context, int(rng.integers(365)))
    times = np.round(np.linspace(first, last, POINTS), 3)
    mechanism = random_mechanism(rng)
    points = measured(context, mechanism, times, rng)
    blunders = BLUNDER_DEG * (rng.random(POINTS) < BLUNDERS) * rng.choice([-1.0, 1.0], POINTS)
    errors = points.err1_deg + blunders / np.sin(np.radians(points.ax2_deg))
    yield _header(number, plant, mechanism, first - 1800.0, rng)
    before = format_utc(first - 1800.0)
    yield ClockSet(seq=1, utc=before, before_s=float(rng.normal(0.0, 5.0)), after_s=0.0)
    yield RefCheck(seq=2, utc=before, number=1, complete=True, difference_counts=(0, 0))
    yield Initialised(seq=3, utc=before, distance_to_limits_deg=20.0)
    seq = 3
    for index in range(POINTS):
        for record in _point(points, errors, index, seq):
            seq = record.seq
            yield record
    end = format_utc(float(times[-1]) + 600.0)
    if rng.random() < STRUCK * POINTS:
        seq += 1
        struck = 5 + 3 * int(rng.integers(POINTS))
        yield Void(seq=seq, utc=end, voids=struck, reason="cloud")
    yield Closed(seq=seq + 1, utc=end, reason="end of the day")


def _header(
    number: int, plant: _Plant, mechanism: Mechanism, utc_s: float, rng: np.random.Generator
) -> Header:
    context = plant.context
    centre = context.geometry.ax1_centre_deg
    lean = None
    if rng.random() < MEASURED_LEANS and context.geometry.name == "azel":
        lean = Inclinometer(
            lean_north_deg=float(mechanism.P1), lean_east_deg=float(mechanism.P3), sigma_deg=0.05
        )
    unit = UnitRecord(
        model="SOLARTRAK",
        serial=f"{number:05d}",
        firmware="1.0",
        zone_west_h=plant.zone_west_h,
        drive1=RotaryDrive(1000.0),
        drive2=RotaryDrive(1000.0),
        limits=Limits(AxisLimits(centre - 179.0, centre + 179.0), AxisLimits(0.0, 180.0)),
        update_range_deg=0.1,
        reference1_deg=0.0,
        reference2_deg=90.0,
        tilt_decimals=4,
        scale_decimals=6,
        site=context.site,
    )
    return Header(
        utc=format_utc(utc_s),
        software="made up",
        unit=unit,
        site=context.site,
        geometry=context.geometry.name,
        ax1_centre_deg=centre,
        weather=context.weather or Weather(),
        inclinometer=lean,
    )


def _point(points: Points, err1_deg: np.ndarray, index: int, seq: int) -> Iterator[Record]:  # type: ignore[type-arg]
    assert points.utc_s is not None
    read = format_utc(float(points.utc_s[index]))
    after = format_utc(float(points.utc_s[index]) + 79.0)
    ideal = (round(float(points.ax1_deg[index]), 5), round(float(points.ax2_deg[index]), 5))
    error = (round(float(err1_deg[index]), 5), round(float(points.err2_deg[index]), 5))
    reading = (round(ideal[0] + error[0], 5), round(ideal[1] + error[1], 5))
    counts = (round(1000.0 * reading[0]), round(1000.0 * (reading[1] - 90.0)))
    offsets = Offsets(*error)
    yield SunOffset(
        seq=seq + 1,
        utc=read,
        ideal_deg=ideal,
        reading_deg=reading,
        counts=counts,
        offsets=offsets,
        coefficients=_NOTHING,
        approach=(1, 1),
    )
    yield PointRecord(
        seq=seq + 2,
        utc=after,
        status="accepted",
        answers=_YES,
        basis="sun_offset",
        read_utc=read,
        unit_minus_laptop_s=0.0,
        ideal_deg=ideal,
        precise_deg=ideal,
        reading_deg=reading,
        counts=counts,
        offsets=offsets,
        coefficients=_NOTHING,
        approach=(1, 1),
        distance_to_limits_deg=20.0,
        error_deg=error,
    )
    yield FitRecord(
        seq=seq + 3,
        utc=after,
        method="robust",
        points=index + 1,
        coefficients=_NOTHING,
        sigmas=_NOTHING,
        sky_rms_deg=0.03,
    )


if __name__ == "__main__":
    write_fleet(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else SESSIONS)
