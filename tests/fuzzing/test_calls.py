"""A few of the bad calls of which `make fuzz` makes 825."""

import json
import os
from pathlib import Path

import pytest

from fuzzing.calls import LONGEST_S, BadFiles, Outcome, bad_calls, measured, sweep
from solarcal.cli import COMMANDS

GOOD = Path("sessions/azel-good-day.jsonl").resolve()


SEED = 7
SHORT = 5
ONE_AFTER_ANOTHER = """
import contextlib, io, json, pathlib, sys, traceback
from solarcal.cli import run_command
told = []
for words in json.loads(sys.argv[1]):
    with contextlib.redirect_stderr(io.StringIO()) as error:
        try:
            code = run_command(words)
        except SystemExit as end:
            code = end.code
        except BaseException:
            code = 1
            traceback.print_exc()
    told.append((code, error.getvalue()))
pathlib.Path("told.json").write_text(json.dumps(told))
"""


def called(calls, home):
    """The outcome of each call, all made in one process, in the memory of one.

    A pipe that is waited for and a gigabyte that is read would be seen in it.
    """
    words = ("-c", ONE_AFTER_ANOTHER, json.dumps(calls))
    whole = measured(("all",), home, words, LONGEST_S * len(calls))
    assert (whole.code, whole.fault) == (0, ""), whole.error
    told = json.loads((home / "told.json").read_text())
    return [
        Outcome(tuple(words), code, 0.0, 0.0, error)
        for words, (code, error) in zip(calls, told, strict=True)
    ]


def faults(outcomes):
    return [(one.words, one.fault, one.error) for one in outcomes if one.fault]


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="this system does not count a child's memory")
def test_a_bad_call_ends_soon_in_words_and_in_little_memory(tmp_path):
    folder = tmp_path / "bad"
    folder.mkdir()
    assert faults(sweep(SHORT, SEED, folder, GOOD)) == []


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="this system does not count a child's memory")
def test_no_command_answers_a_bad_call_otherwise(tmp_path):
    """One of each command, without a process for each of them."""
    folder, home = tmp_path / "bad", tmp_path / "home"
    folder.mkdir()
    home.mkdir()
    calls = list(bad_calls(BadFiles(folder, GOOD), len(COMMANDS), SEED))
    assert {words[0] for words in calls} == set(COMMANDS)
    assert faults(called(calls, home)) == []


NO_SENSIBLE_FILE = [
    *(("fit", name) for name in ("pipe.jsonl", "huge.jsonl", "huge.csv", "folder.jsonl")),
    ("note", "huge.jsonl", "a remark"),
    *(
        (*words, name)
        for words in (("run", "--site"), ("calibrate", "--scenario"), ("scenarios",))
        for name in ("pipe.toml", "huge.toml")
    ),
]


@pytest.fixture(scope="module")
def refused(tmp_path_factory):
    """What each of these calls says."""
    home = tmp_path_factory.mktemp("home")
    folder = tmp_path_factory.mktemp("bad")
    names = BadFiles(folder, GOOD).names
    calls = [
        tuple(str(folder / word) if "." in word else word for word in words)
        for words in NO_SENSIBLE_FILE
    ]
    assert {word for words in calls for word in words if "." in word} <= set(names)
    return folder, dict(zip(NO_SENSIBLE_FILE, called(calls, home), strict=True))


@pytest.mark.parametrize("words", NO_SENSIBLE_FILE, ids=" ".join)
def test_what_is_not_a_file_of_sensible_size_is_refused_before_it_is_read(refused, words):
    folder, told = refused
    outcome = told[words]
    error = outcome.error
    assert (outcome.code, outcome.fault) == (2, "")
    if words[0] == "fit":
        assert error.startswith(f"solarcal: {folder / words[1]} cannot be read: it is ")
    elif words[0] == "note":
        assert "it is larger than 32 MB" in error
    elif words[0] == "run":
        # Without a terminal it says no more.
        assert "cannot be read: it is " in error or "needs a terminal" in error
    else:
        assert "cannot be read: it is " in error


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
