"""A few of the bad calls of which `make fuzz` makes 825."""

import os
from pathlib import Path

import pytest

from fuzzing.calls import BadFiles, Outcome, bad_calls, call, sweep

GOOD = Path("sessions/azel-good-day.jsonl").resolve()
SHORT = 20


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="this system does not count a child's memory")
def test_a_bad_call_ends_soon_in_words_and_in_little_memory(tmp_path):
    folder = tmp_path / "bad"
    folder.mkdir()
    faults = [
        (outcome.words, outcome.fault, outcome.error)
        for outcome in sweep(SHORT, 7, folder, GOOD)
        if outcome.fault
    ]
    assert faults == []


@pytest.mark.parametrize("name", ["pipe.jsonl", "huge.jsonl", "huge.csv", "folder.jsonl"])
def test_what_is_not_a_file_of_sensible_size_is_refused_before_it_is_read(tmp_path, name):
    folder = tmp_path / "bad"
    folder.mkdir()
    files = BadFiles(folder, GOOD)
    path = str(folder / name)
    assert path in files.names
    outcome = call(("fit", path), tmp_path)
    assert (outcome.code, outcome.fault) == (2, "")
    assert outcome.error.startswith(f"solarcal: {path} cannot be read: it is ")


def test_a_session_too_large_to_read_is_not_appended_to_either(tmp_path):
    folder = tmp_path / "bad"
    folder.mkdir()
    BadFiles(folder, GOOD)
    outcome = call(("note", str(folder / "huge.jsonl"), "a remark"), tmp_path)
    assert (outcome.code, outcome.fault) == (2, "")
    assert "it is larger than 32 MB" in outcome.error


@pytest.mark.parametrize("name", ["pipe.toml", "huge.toml"])
@pytest.mark.parametrize("words", [("run", "--site"), ("calibrate", "--scenario"), ("scenarios",)])
def test_a_profile_or_scenario_that_is_not_a_sensible_file_is_refused(tmp_path, name, words):
    folder = tmp_path / "bad"
    folder.mkdir()
    BadFiles(folder, GOOD)
    outcome = call((*words, str(folder / name)), tmp_path)
    assert outcome.code == 2
    assert "cannot be read: it is " in outcome.error or "needs a terminal" in outcome.error


def test_a_seed_names_its_calls_and_every_command_is_among_them(tmp_path):
    folder = tmp_path / "bad"
    folder.mkdir()
    files = BadFiles(folder, GOOD)
    calls = list(bad_calls(files, 60, 7))
    assert calls == list(bad_calls(files, 60, 7))
    assert calls != list(bad_calls(files, 60, 8))
    assert len({words[0] for words in calls}) > 25


@pytest.mark.parametrize(
    ("code", "megabytes", "error", "fault"),
    [
        (None, 50.0, "", "still running"),
        (1, 50.0, "Traceback (most recent call last):\n", "traceback"),
        (2, 50.0, "", "no word"),
        (2, 50.0, "line\n" * 20, "20 lines"),
        (0, 400.0, "", "400 MB"),
        (-11, 50.0, "", "exit code -11"),
        (2, 50.0, "solarcal: one line\n", ""),
    ],
)
def test_the_measure_sees_what_may_not_be(code, megabytes, error, fault):
    found = Outcome(("fit",), code, 1.0, megabytes, error).fault
    assert fault in found
    assert bool(fault) == bool(found)
