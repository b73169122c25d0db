"""`solarcal scenarios` and the refusals of `solarcal emulate`."""

import json
import os
import signal
import threading

import pytest

from solarcal.cli import run_command
from solarcal.emulator.scenario import scenario_names


def test_scenarios_are_listed_one_a_line(capsys):
    assert run_command(["scenarios"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == scenario_names()
    assert "(default)" in lines[0]


def test_scenarios_as_one_json_document(capsys):
    assert run_command(["scenarios", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["default"] == "tijeras-azel"
    assert [entry["name"] for entry in document["scenarios"]] == scenario_names()
    first = document["scenarios"][0]
    assert first["start_utc"] == "2026-06-03T13:01:00Z"
    assert first["settings"]["truth.lean_deg"] == 0.6


def test_one_scenario_with_its_keys(capsys):
    assert run_command(["scenarios", "missed-counts"]) == 0
    out = capsys.readouterr().out
    assert 'truth.missed_counts            [{ at = "+4h", axis = 1, counts = 300 }]' in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--scenario", "nope"], "no scenario 'nope'"),
        (["--set", "truth.leen_deg=1"], "did you mean truth.lean_deg?"),
        (["--tcp", "nowhere"], "HOST:PORT"),
        (["--seed", "-1"], "seed"),
        (["--speed", "-1"], "speed"),
        (["--start", "dawn"], "dawn"),
        (["--noise-deg", "-1"], "noise"),
        (["--faults", "eaten=0.1"], "no line fault 'eaten'"),
        (["--faults", "hung_up=0.1"], "give --tcp with hung_up"),
    ],
)
def test_bad_options_are_one_line_and_exit_2(capsys, arguments, words):
    try:
        code = run_command(["emulate", *arguments])
    except SystemExit as refused:
        # What argparse itself refuses.
        code = refused.code
    assert code == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="no signals to threads here")
def test_a_signal_that_another_thread_takes_ends_it_too(capsys):
    """So it is after Ctrl-Z and `kill`: the waiting thread is still stopped when it comes."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    left = threading.Event()
    in_time = []

    def terminate() -> None:
        while signal.getsignal(signal.SIGTERM) is before[signal.SIGTERM]:
            left.wait(0.01)
        # Time to reach the wait; the signal ends the command at any moment, only later it is hard.
        left.wait(0.5)
        signal.pthread_kill(threading.get_ident(), signal.SIGTERM)
        in_time.append(left.wait(10.0))
        if not in_time[0]:
            os.kill(os.getpid(), signal.SIGTERM)

    helper = threading.Thread(target=terminate)
    helper.start()
    try:
        assert run_command(["emulate", "--tcp", ":0"]) == 0
    finally:
        left.set()
        helper.join()
        for number, handler in before.items():
            signal.signal(number, handler)
    assert in_time == [True]
    assert capsys.readouterr().out.startswith("connect to socket://127.0.0.1:")


def test_watching_a_rotator_names_the_light_that_shines():
    """What `--watch` prints: where the light is on the sunspot device from where it reads."""
    from solarcal.cli.emulate import _seen
    from solarcal.emulator.rotator import EmulatedRotator
    from solarcal.emulator.scenario import load_scenario
    from solarcal.sun.moon import moon_position
    from solarcal.timescale import parse_utc

    scenario = load_scenario("tijeras-azel", ["truth.light=moon"])
    night_s = parse_utc("2026-06-30T06:00")
    moon = moon_position(night_s, scenario.site.place())
    rotator = EmulatedRotator(
        scenario, start_utc_s=night_s, seed=0, noise_deg=None, speed=0.0,
    )  # fmt: skip
    assert "no Moon on the sunspot device" in _seen(rotator)
    assert rotator.go_to(float(moon.azimuth_deg), float(moon.elevation_deg))
    rotator.advance(600.0)
    # The Moon has gone on by some two degrees meanwhile.
    assert "deg; Moon at az " in _seen(rotator)
