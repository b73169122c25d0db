"""``solarcal track``: the Sun followed for a while with coefficients of a file, then a stop."""

import json

import msgspec
import pytest
from rotator_bench import RotatorBench

from solarcal.cli import run_command
from solarcal.errors import FitError, InputFileError, LinkError, UnitRefused
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.journal import Journal
from solarcal.station.procedure import Station
from solarcal.station.software_controller.coefficient_store import MemoryStore
from solarcal.station.sun_tracking import SunTracking, TrackingRun, read_coefficients
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import Mode

P = Coefficients(0.28, -0.35, 0.53, 0.22, 0.0008, -0.0006)
DOCUMENT = {
    "geometry": "azel",
    "method": "robust",
    "coefficients": {name: {"value": value} for name, value in msgspec.to_builtins(P).items()},
}


@pytest.fixture
def fit_file(tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(DOCUMENT))
    return path


def tracking(bench, say=lambda line: None):
    run = TrackingRun("roof", P, "a test", bench.clock.utc_s())
    return SunTracking(bench.tracker, bench.clock, run, say)


def test_it_tracks_until_the_time_given_and_stops_the_rotator():
    bench = RotatorBench()
    bench.open().use_for_now(P)
    said = []
    begun = bench.clock.utc_s()
    done = tracking(bench, said.append).until(begun + 900.0, 60.0).document()
    assert (done["ended_by"], done["looks"], done["lines_lost"]) == ("until", 14, 0)
    assert done["off_max_deg"] < 0.09
    assert bench.tracker.status().mode is Mode.STOP
    assert bench.cable.motions()[-1] == "+\\stop"
    assert bench.clock.utc_s() - begun == pytest.approx(900.0, abs=0.1)
    assert "on the way" in said[0]
    # It points at the Sun: what is left is half an update step and the error of P itself.
    bench.tracker.set_mode(Mode.TRACK)
    bench.clock.wait(60.0)
    spot = bench.world.spot()
    assert spot.visible
    assert max(abs(spot.error1_deg), abs(spot.error2_deg)) < 0.2


def test_it_ends_with_the_sun_and_waits_where_the_limits_end_before():
    bench = RotatorBench(start="2026-06-04T01:30:00Z")
    bench.open()
    said = []
    done = tracking(bench, said.append).until(None, 300.0).document()
    assert done["ended_by"] == "sunset"
    assert done["looks_at_limit"] > 0
    assert "the Sun is beyond the limits" in said[-1]
    assert bench.tracker.status().mode is Mode.STOP


def test_ctrl_c_stops_the_rotator():
    bench = RotatorBench()
    bench.open()

    def interrupted(line):
        raise KeyboardInterrupt

    done = tracking(bench, interrupted).until(None, 10.0).document()
    assert done["ended_by"] == "interrupted"
    assert bench.cable.motions()[-1] == "+\\stop"


@pytest.mark.parametrize("request_no", range(8))
def test_ctrl_c_within_a_request_stops_the_rotator_too(request_no):
    bench = RotatorBench()
    bench.open()
    handled, sent = bench.rotator.handle_input, []

    def interrupted(data):
        sent.append(data)
        if len(sent) == request_no + 1:
            raise KeyboardInterrupt
        return handled(data)

    bench.rotator.handle_input = interrupted
    done = tracking(bench).until(None, 10.0).document()
    assert done["ended_by"] == "interrupted"
    assert sent[-1] == b"+\\get_pos\n" or sent[-1] == b"+\\stop\n"
    assert bench.cable.motions()[-1] == "+\\stop"
    assert bench.tracker.status().mode is Mode.STOP


def test_an_interrupt_that_broke_a_lock_stops_the_rotator_too():
    bench = RotatorBench()
    bench.open()

    def broken(line):
        raise RuntimeError("cannot release un-acquired lock")

    with pytest.raises(RuntimeError):
        tracking(bench, broken).until(None, 10.0)
    assert bench.cable.motions()[-1] == "+\\stop"


def test_a_stop_by_somebody_else_counts():
    bench = RotatorBench()
    bench.open()
    looks = []

    def stopped_elsewhere(line):
        looks.append(line)
        if len(looks) == 3:
            bench.tracker.stow()

    done = tracking(bench, stopped_elsewhere).until(None, 10.0).document()
    assert done["ended_by"] == "mode STOW"


def test_a_line_that_comes_back_is_tracked_on():
    bench = RotatorBench()
    bench.open().use_for_now(P)
    said = []

    def cut(line):
        said.append(line)
        bench.cable.pulled = len(said) == 3

    begun = bench.clock.utc_s()
    done = tracking(bench, cut).until(begun + 600.0, 30.0).document()
    assert done["lines_lost"] == 1
    assert done["ended_by"] == "until"
    assert "the line is open again; tracking goes on" in said
    # The coefficients of this run are still those: not what is kept for the rotator.
    assert bench.tracker.in_force() == (P, Offsets())


def test_a_line_lost_between_two_looks_is_the_reason_and_not_the_mode_it_left(monkeypatch):
    """The step after the Sun that failed was of the unit's own accord; the next look says why."""
    bench = RotatorBench()
    bench.open()
    looks, said = [], []

    def failing(line):
        said.append(line)
        looks.append(line)
        if len(looks) == 3:
            bench.cable.pulled = True
            bench.clock.wait(60.0)
            bench.cable.pulled = False

    begun = bench.clock.utc_s()
    done = tracking(bench, failing).until(begun + 600.0, 30.0).document()
    assert (done["ended_by"], done["lines_lost"]) == ("until", 1)
    assert "the line to the emulated rotator was lost" in said


def test_what_ended_a_run_is_told_though_no_stop_goes_out_either():
    bench = RotatorBench()
    bench.open()
    said = []

    def cut(line):
        said.append(line)
        bench.cable.pulled = True

    with pytest.raises(LinkError, match="no answer from"):
        tracking(bench, cut).until(None, 30.0)
    assert said[-1].startswith("it could not be stopped: ")


def test_an_end_that_cannot_stop_the_unit_says_both():
    bench = RotatorBench()
    bench.open()

    def cut_and_interrupted(line):
        bench.cable.pulled = True
        raise KeyboardInterrupt

    with pytest.raises(LinkError, match="interrupted; the unit could NOT be stopped: the line to"):
        tracking(bench, cut_and_interrupted).until(None, 30.0)


def test_a_line_that_stays_away_is_given_up_after_two_minutes():
    bench = RotatorBench()
    bench.open()

    def cut(line):
        bench.cable.pulled = True

    begun = bench.clock.utc_s()
    with pytest.raises(LinkError):
        tracking(bench, cut).until(None, 10.0)
    assert bench.clock.utc_s() - begun == pytest.approx(130.0, abs=5.0)


def test_no_tracking_at_night():
    bench = RotatorBench(start="2026-06-03T08:00:00Z")
    bench.open()
    with pytest.raises(UnitRefused, match="below the horizon"):
        tracking(bench).until(None, 10.0)


def test_coefficients_of_a_run_are_not_kept():
    store = MemoryStore()
    bench = RotatorBench(store=store)
    bench.open().use_for_now(P)
    assert bench.tracker.in_force() == (P, Offsets())
    assert store.load().coefficients == Coefficients()
    # A Set Sun Offset of such a run neither.
    bench.tracker.set_sun_offset()
    assert store.load().offsets == Offsets()


# -- files of coefficients ---------------------------------------------------------------------


def test_coefficients_of_a_fit_document(fit_file):
    found = read_coefficients(fit_file)
    assert (found.coefficients, found.geometry) == (P, "azel")
    assert found.source == f"robust fit in {fit_file}"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("P1 = 3", "is neither a session"),
        ('{"geometry": "azel"}', "is neither a session"),
        ("\ufeff[]", "is neither a session"),
        (
            json.dumps({**DOCUMENT, "coefficients": {"P1": {"value": 0.1}}}),
            "P2, P3, P4, P5, P6 missing",
        ),
    ],
)
def test_what_holds_no_coefficients_is_said(tmp_path, content, words):
    path = tmp_path / "fit.json"
    path.write_text(content)
    with pytest.raises(InputFileError, match=words):
        read_coefficients(path)


def test_a_session_without_points_gives_none(tmp_path):
    bench = RotatorBench()
    station = Station(bench.tracker, bench.clock)
    station.connect()
    station.open_session(lambda header: Journal.create(tmp_path / "day.jsonl", header))
    station.close()
    with pytest.raises(FitError):
        read_coefficients(tmp_path / "day.jsonl")


# -- the command -------------------------------------------------------------------------------


def test_the_command_says_what_it_did(fit_file, capsys):
    words = ["track", "--scenario", "tijeras-azel", "--coefficients", str(fit_file), "--json"]
    words += ["--start", "2026-06-05T15:00:00Z", "--until", "15:10", "--every", "60"]
    assert run_command(words) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert told["coefficients"] == msgspec.to_builtins(P)
    assert told["ended_by"] == "until"
    assert told["off_max_deg"] < 0.1
    assert parse_utc(told["ended_utc"]) - parse_utc(told["started_utc"]) == 600.0
    assert "tracking with P1..P6 +0.2800 -0.3500 +0.5300 +0.2200 +0.000800 -0.000600" in err


@pytest.mark.parametrize(
    ("held", "source", "with_offsets"),
    [
        ([], "(nothing is uploaded: all zero)", []),
        (["unit.coefficients=[0.1, 0, 0, 0, 0, 0]"], "(what was uploaded last)", []),
        (
            ["unit.offsets=[0.25, -0.5]"],
            "(nothing is uploaded: all zero)",
            ["and with the reference offsets O +0.2500 -0.5000 deg"],
        ),
    ],
)
def test_without_a_file_the_command_says_what_the_unit_holds(held, source, with_offsets, capsys):
    words = ["track", "--scenario", "tijeras-azel", "--start", "2026-06-05T15:00:00Z", "--json"]
    words += [f"--set={one}" for one in held]
    assert run_command([*words, "--until", "15:02", "--every", "60"]) == 0
    out, err = capsys.readouterr()
    assert err.splitlines()[0].endswith(source)
    assert [line for line in err.splitlines() if "reference offsets" in line] == with_offsets
    offsets = json.loads(out)["offsets"]
    assert offsets == ({"O1": 0.25, "O2": -0.5} if with_offsets else {"O1": 0.0, "O2": 0.0})


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--port", "localhost:1", "--driver", "rotctld"], 2, "needs the site"),
        (["--driver", "rotctld"], 2, "driver rotctld needs a port"),
        ([], 2, "which rotator?"),
        (["--scenario", "tijeras-azel", "--driver", "solartrak"], 2, "has its own tracking"),
        (["--scenario", "polar"], 2, "choose an azel scenario"),
        (["--scenario", "tijeras-azel", "--until", "noon"], 2, "HH:MM"),
        (["--scenario", "tijeras-azel", "--start", "2026-06-05T08:00:00Z"], 1, "horizon"),
        (["--scenario", "tijeras-azel", "--coefficients", "no.json"], 2, "is missing"),
    ],
)
def test_what_the_command_refuses_is_one_line(words, code, said, capsys):
    assert run_command(["track", *words]) == code
    err = capsys.readouterr().err
    assert said in err.splitlines()[-1]
    assert "Traceback" not in err


def test_an_interval_out_of_range_is_a_wrong_call(capsys):
    with pytest.raises(SystemExit) as ended:
        run_command(["track", "--scenario", "tijeras-azel", "--every", "0"])
    assert ended.value.code == 2
    assert "argument --every: 0 is not between 1 and 3600" in capsys.readouterr().err


def test_coefficients_of_another_mount_are_refused(tmp_path, capsys):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps({**DOCUMENT, "geometry": "polar"}))
    assert run_command(["track", "--scenario", "tijeras-azel", "--coefficients", str(path)]) == 2
    assert "is of a polar mount, this is azel" in capsys.readouterr().err
