"""The sensor followed on the Moon by a unit that computes only the Sun."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from emulated_station import emulated_station

from solarcal.cli import run_command
from solarcal.emulator.emulation import Emulator
from solarcal.errors import ProcedureRefused
from solarcal.report.blocks import Table
from solarcal.report.tables import file_points_table, points_table
from solarcal.session.journal import Journal
from solarcal.session.parsing import read_points_only
from solarcal.session.view import read_session
from solarcal.station.clocks import EmulatedClock
from solarcal.station.fitting import solve
from solarcal.station.moon_following import MoonFollower
from solarcal.station.procedure import Station
from solarcal.station.sensor_following import FollowPlan
from solarcal.unit.tracker import Mode, Spot

FULL_MOON = "2026-06-30T05:00:00Z"


def moonlit(scenario: str = "tijeras-azel", *settings: str) -> tuple[Station, Emulator]:
    """Connected in a clear night, referenced and initialised for points on the Moon."""
    sunny, emulator = emulated_station(
        scenario, "truth.light=moon", *settings, start="2026-06-29T22:00:00Z"
    )
    sunny.clock.wait(7.0 * 3600.0)
    station = Station(
        sunny.tracker, EmulatedClock(emulation_of(sunny)), target="moon",
        weather=emulation_of(sunny).sky().weather,
    )  # fmt: skip
    station.connect()
    station.open_session(Journal.memory)
    station.ref_check()
    station.initialise(confirmed=True)
    return station, emulator


def emulation_of(station: Station):  # type: ignore[no-untyped-def]
    emulation = station.tracker.emulation
    assert emulation is not None
    return emulation


@pytest.mark.parametrize("scenario", ["tijeras-azel", "polar", "heliostat"])
def test_points_on_the_moon_show_the_mechanism_that_the_sun_would(scenario: str) -> None:
    """At each the axes stand, to a centring, where the true mechanism sees that direction."""
    station, emulator = moonlit(scenario)
    done = MoonFollower(station, emulation_of(station).spot).follow(
        FollowPlan(5, 40.0), commanded=True
    )
    assert done.stopped == ""
    assert len(done.points) == 5
    true = emulator.scenario.truth.mechanism()
    for point in done.points:
        assert (point.basis, point.offsets) == ("moon", None)
        assert point.answers.ref_check
        assert point.answers.sun_offset is None
        wanted = true.readings_deg(emulator.world.geometry, *point.ideal_deg)
        off1, off2 = np.array(point.reading_deg) - np.array(wanted, dtype=float)
        on_sky = math.hypot(off1 * math.sin(math.radians(point.ideal_deg[1])), off2)
        assert on_sky < 0.06
    solution = solve(station.session)
    assert solution is not None
    assert station.session.fits[-1].points == 5
    # Nothing takes its points for the Sun's: their instants and angles are not compared with it.
    assert not np.isfinite(station.session.table.utc_s).any()
    assert station.session.table.ideal == "apparent"


def test_the_unit_keeps_its_offsets_and_its_sun() -> None:
    station, _ = moonlit()
    before = station.tracker.stored()
    MoonFollower(station, emulation_of(station).spot).follow(FollowPlan(1), commanded=True)
    assert station.tracker.stored() == before
    status = station.poll()
    # The Sun is below the horizon, the axes are on the Moon.
    assert status.ideal2_deg > 90.0
    assert status.reading2_deg < 80.0


def test_it_starts_only_on_command_and_only_in_a_session_for_the_moon() -> None:
    station, _ = moonlit()
    look = emulation_of(station).spot
    with pytest.raises(ProcedureRefused, match="command"):
        MoonFollower(station, look).follow(FollowPlan(1), commanded=False)
    with pytest.raises(ProcedureRefused, match="points on the Moon"):
        station.begin_point()
    sunny, _ = emulated_station()
    sunny.initialise(confirmed=True)
    with pytest.raises(ProcedureRefused, match="points on the Sun"):
        MoonFollower(sunny, look).follow(FollowPlan(1), commanded=True)
    assert sunny.session.points == ()


def test_clouds_stop_the_unit_and_no_point_is_kept() -> None:
    station, _ = moonlit()
    done = MoonFollower(station, lambda: Spot(False, 0.0, 0.0)).follow(
        FollowPlan(2), commanded=True
    )
    assert "no Moon" in done.stopped
    assert station.poll().mode is Mode.STOP
    assert station.session.points == ()


def test_a_thin_moon_is_refused_before_anything_moves() -> None:
    station, _ = emulated_station("tijeras-azel", "truth.light=moon", start="2026-06-15T16:00:00Z")
    night = Station(station.tracker, station.clock, target="moon")
    night.connect()
    night.open_session(Journal.memory)
    night.ref_check()
    night.initialise(confirmed=True)
    before = night.poll()
    with pytest.raises(ProcedureRefused, match="too thin"):
        MoonFollower(night, emulation_of(night).spot).follow(FollowPlan(1), commanded=True)
    after = night.poll()
    assert (after.reading1_deg, after.reading2_deg) == (before.reading1_deg, before.reading2_deg)


def test_the_command_writes_a_session_that_fit_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "night.jsonl"
    words = ["two-mirror", "follow", "--target", "moon", "--scenario", "tijeras-azel", "--json"]
    words += ["--start", FULL_MOON, "--points", "4", "-o", str(path)]
    assert run_command(words) == 0
    assert json.loads(capsys.readouterr().out) == {
        "session": str(path), "points": 4, "stopped": None,
    }  # fmt: skip
    assert run_command(["fit", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["points"]["used"] == 4
    assert not [f for f in document["findings"] if f["certainty"] == "found"]
    session = read_session(path)
    assert session.header.target == "moon"
    _, both = read_points_only(path)
    assert both.ideal == session.table.ideal
    assert np.isnan(both.utc_s).all()
    assert list(zip(both.err1_deg, both.err2_deg, strict=True)) == [
        p.error_deg for p in session.accepted
    ]
    # Nothing compares the Moon's instants with the Sun; the tables show them all the same.
    stamps = [point.read_utc[11:16] for point in session.accepted]
    for blocks in (
        points_table(session),
        file_points_table(session.table),
        file_points_table(session.table.rows(range(len(stamps)))),
    ):
        table = next(block for block in blocks if isinstance(block, Table))
        assert [row[2][:5] for row in table.rows] == stamps


def test_the_light_of_an_emulator_in_process_is_the_one_followed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """--target sun at noon although the scenario says moon: the option decides."""
    path = tmp_path / "day.jsonl"
    words = ["two-mirror", "follow", "--scenario", "tijeras-azel", "--set", "truth.light=moon"]
    assert run_command([*words, "--start", "2026-06-03T16:00:00Z", "--points", "1",
                        "-o", str(path)]) == 0  # fmt: skip
    assert read_session(path).header.target == "sun"
    assert "1 point by" in capsys.readouterr().out
