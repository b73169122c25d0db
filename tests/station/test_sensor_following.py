"""Follow the sensor: points take themselves, only when asked for, and stop at any doubt."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from emulated_station import emulated_station

from solarcal.cli import run_command
from solarcal.errors import ProcedureRefused
from solarcal.session.records import Note
from solarcal.station.procedure import Station
from solarcal.station.sensor_following import FollowPlan, SensorFollower
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import Mode, Spot, Status


def ready(scenario: str = "tijeras-azel", *settings: str) -> tuple[Station, Callable[[], Spot]]:
    """Initialised and tracking, and the emulator's spot as the sensor."""
    station, _ = emulated_station(scenario, *settings)
    station.initialise(confirmed=True)
    emulation = station.tracker.emulation
    assert emulation is not None
    return station, emulation.spot


def on_the_sun() -> tuple[Station, Callable[[], Spot]]:
    """The same with the spot centred once by the technician."""
    station, look = ready()
    assert AutomaticTechnician(station, look, Schedule()).sight.centre()
    station.set_sun_offset()
    station.track()
    station.clock.wait(60.0)
    return station, look


@pytest.mark.parametrize("scenario", ["tijeras-azel", "backlash"])
def test_points_take_themselves(scenario: str) -> None:
    """Each is the technician's kind of point, and as good: its error is the mechanism's."""
    station, look = ready(scenario)
    looks_s: list[float] = []

    def sensor() -> Spot:
        looks_s.append(station.clock.utc_s())
        return look()

    done = SensorFollower(station, sensor).follow(FollowPlan(5, 40.0), commanded=True)
    assert done.stopped == ""
    # The mean of several looks is better than one where each sees the light anew.
    assert np.diff(looks_s).min() > 0.4
    assert len(done.points) == 5
    accepted = station.session.accepted
    assert [p.seq for p in accepted] == [p.seq for p in done.points]
    began_s = [parse_utc(p.utc) for p in accepted]
    # From one to the next; each takes a minute or two of its own.
    assert np.diff(began_s) == pytest.approx(2400.0, abs=30.0)
    assert all(p.basis == "sun_offset" for p in accepted)
    assert all(p.answers.ref_check and p.answers.sun_offset and p.answers.tracking
               for p in accepted)  # fmt: skip
    assert station.poll().mode is Mode.TRACK
    fit = station.session.fits[-1]
    assert fit.points == 5
    assert fit.sky_rms_deg < 0.03


def test_it_starts_only_on_explicit_command() -> None:
    station, look = ready()
    before = station.poll()
    with pytest.raises(ProcedureRefused, match="command"):
        SensorFollower(station, look).follow(FollowPlan(1), commanded=False)
    assert station.poll().offsets == before.offsets
    assert station.session.points == ()


def test_what_a_point_needs_is_asked_for_first() -> None:
    station, _ = emulated_station()
    with pytest.raises(ProcedureRefused, match="initialise"):
        SensorFollower(station, lambda: Spot(False, 0.0, 0.0)).follow(FollowPlan(1), commanded=True)
    station, look = ready()
    station.stop()
    station.clock.wait(3.0)
    with pytest.raises(ProcedureRefused, match="mode STOP"):
        SensorFollower(station, look).follow(FollowPlan(1), commanded=True)


@pytest.mark.parametrize("flipped", [0, 1])
def test_a_sensor_wired_the_wrong_way_round_is_noticed_and_the_unit_stopped(flipped: int) -> None:
    """The axis moved by less than a degree or two meanwhile."""
    station, look = on_the_sun()
    start = station.poll()

    def wrong() -> Spot:
        spot = look()
        signs = [1.0, 1.0]
        signs[flipped] = -1.0
        return Spot(spot.visible, spot.error1_deg * signs[0], spot.error2_deg * signs[1])

    station.jog(start.reading1_deg + 0.1, start.reading2_deg + 0.1)
    station.clock.wait(3.0)
    station.track()
    done = SensorFollower(station, wrong).follow(FollowPlan(2), commanded=True)
    after = station.poll()
    assert done.points == ()
    assert "sign" in done.stopped
    assert after.mode is Mode.STOP
    assert station.session.points == ()
    moved = (after.reading1_deg - after.ideal1_deg) - (start.reading1_deg - start.ideal1_deg)
    assert abs(moved) * math.sin(math.radians(after.ideal2_deg)) < 2.5
    notes = [r.text for r in station.session.records if isinstance(r, Note)]
    assert done.stopped in notes[-1]


def test_without_sun_on_the_sensor_it_stops() -> None:
    station, look = on_the_sun()
    looks = 0

    def clouding() -> Spot:
        nonlocal looks
        looks += 1
        return look() if looks < 3 else Spot(False, 0.0, 0.0)

    done = SensorFollower(station, clouding).follow(FollowPlan(2), commanded=True)
    assert "no Sun" in done.stopped
    assert station.poll().mode is Mode.STOP
    assert station.session.accepted == ()


def test_axes_that_never_reach_their_targets_are_given_up_after_twenty_minutes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    station, look = on_the_sun()
    honest = station.poll

    def stuck() -> Status:
        status = honest()
        return msgspec.structs.replace(status, target1_deg=status.reading1_deg + 5.0)

    monkeypatch.setattr(station, "poll", stuck)
    began_s = station.clock.utc_s()
    done = SensorFollower(station, look).follow(FollowPlan(2), commanded=True)
    assert "did not reach their targets in 20 minutes" in done.stopped
    assert station.clock.utc_s() - began_s == pytest.approx(1200.0, abs=60.0)
    assert station.session.accepted == ()


def test_a_stop_by_somebody_else_ends_it_without_a_point() -> None:
    station, look = on_the_sun()
    looks = 0

    def watched() -> Spot:
        nonlocal looks
        looks += 1
        if looks == 2:
            station.stop()
        return look()

    done = SensorFollower(station, watched).follow(FollowPlan(2), commanded=True)
    assert "mode STOP" in done.stopped
    assert station.poll().mode is Mode.STOP
    assert station.session.accepted == ()


def test_a_sensor_that_wants_too_much_is_not_followed() -> None:
    """A constant 0.5 deg to one side: after 2 deg on the sky it is taken for a mistake."""
    station, _ = on_the_sun()
    start = station.poll()
    done = SensorFollower(station, lambda: Spot(True, 0.0, 0.5)).follow(
        FollowPlan(1), commanded=True
    )
    assert "more than 2" in done.stopped
    assert abs(station.poll().reading2_deg - start.reading2_deg) < 3.0


def test_a_plan_beyond_reason_is_refused() -> None:
    with pytest.raises(ProcedureRefused, match="points"):
        FollowPlan(0)
    with pytest.raises(ProcedureRefused, match="minutes"):
        FollowPlan(3, 1.0)


def test_the_command_writes_an_ordinary_session(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "followed.jsonl"
    words = ["--scenario", "tijeras-azel", "--points", "3", "-o", str(path), "--json"]
    assert run_command(["two-mirror", "follow", *words]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == {"session": str(path), "points": 3, "stopped": None}
    assert run_command(["fit", str(path), "--method", "linear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["points"]["used"] == 3


@pytest.mark.parametrize(
    ("plan", "refused"),
    [
        ({"points": 0}, "0 points: give 1 to 200"),
        ({"points": 1}, ""),
        ({"points": 200}, ""),
        ({"points": 201}, "201 points: give 1 to 200"),
        ({"every_min": 4.9}, "a point every 4.9 minutes: give 5 to 240 minutes"),
        ({"every_min": 5.0}, ""),
        ({"every_min": 240.0}, ""),
        ({"every_min": 240.1}, "a point every 240.1 minutes: give 5 to 240 minutes"),
    ],
)
def test_a_plan_that_cannot_be_followed_is_refused(plan: dict[str, float], refused: str) -> None:
    if refused:
        with pytest.raises(ProcedureRefused, match=refused):
            FollowPlan(**plan)
    else:
        # A dozen points half an hour apart, as by hand.
        assert msgspec.to_builtins(FollowPlan(**plan)) == {"points": 12, "every_min": 30.0} | plan
