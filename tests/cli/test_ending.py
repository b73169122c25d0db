"""A command that is terminated, or whose terminal is gone, closes what it has open."""

import os
import signal
import subprocess
import sys

import pytest

from solarcal.session.journal import Journal
from solarcal.session.view import read_session


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_headless_calibration_that_is_ended_leaves_a_whole_session(tmp_path, name):
    path = tmp_path / "day.jsonl"
    command = [sys.executable, "-m", "solarcal", "calibrate", "--scenario", "tijeras-azel"]
    environment = os.environ | {"SOLARCAL_SESSIONS": str(tmp_path), "HOME": str(tmp_path)}
    process = subprocess.Popen(
        [*command, "--points", "200", "--every", "5", "-o", str(path)],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    assert process.stderr is not None
    # Its first sentence: the session is open by then.
    first = process.stderr.readline()
    assert first.startswith("unit clock set"), first
    process.send_signal(getattr(signal, name))
    _, said = process.communicate(timeout=60)
    assert process.returncode == 128 + getattr(signal, name)
    assert f"solarcal: ended by {name}" in said
    assert "Traceback" not in said
    session = read_session(path)
    (warning,) = session.warnings
    assert warning.endswith("was not closed: the session goes on, or its end is missing")
    # Nobody holds it: it can be gone on with.
    Journal.resume(path).close()


def test_one_that_ignores_hang_ups_goes_on_ignoring_them(tmp_path):
    program = (
        "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN);"
        "from solarcal.cli.process import end_by_signals; end_by_signals();"
        "assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN;"
        "assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


@pytest.mark.parametrize("hung_up", [True, False])
def test_the_exit_code_of_a_hang_up_is_not_that_of_what_could_not_be_written(hung_up):
    """What was left in a stream is written again at the interpreter's end, in vain: 120."""
    code = 128 + signal.SIGHUP if hung_up else 0
    program = (
        "import sys; from solarcal.cli.process import let_go_of_terminal; "
        f"print('left'); sys.exit(let_go_of_terminal({code}))"
    )
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    reading, writing = os.pipe()
    os.close(reading)
    try:
        ended = subprocess.run(
            [sys.executable, "-c", program],
            stdout=writing,
            stderr=subprocess.DEVNULL,
            env=buffered,
        )
    finally:
        os.close(writing)
    assert ended.returncode == (code if hung_up else 120)
