"""A command that is terminated, or whose terminal is gone, closes what it has open."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from solarcal import cli
from solarcal.cli.process import Ended
from solarcal.errors import LinkError
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


LOST = """
import os, signal, time
from solarcal.cli import process
process.AGAIN_S = 0.05
process.end_by_signals()
for _ in range(2):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(120.0)
    except BaseException:
        pass
try:
    time.sleep(120.0)
finally:
    time.sleep(0.3)
    print("closed")
"""


def test_a_signal_whose_exception_is_lost_asks_again_and_does_not_break_off_the_closing():
    """A library in C can take an exception for an answer; then the program would go on for ever."""
    done = subprocess.run(
        [sys.executable, "-c", LOST], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.stdout == "closed\n"
    assert done.stderr.strip().endswith("Ended: ended by SIGTERM")


WITHIN_AN_IMPORT = """
import signal, sys, time
from solarcal.cli.process import end_by_signals
signal.signal(signal.SIGINT, signal.SIG_DFL)
end_by_signals()
try:
    import begun
    time.sleep(120.0)
except KeyboardInterrupt:
    print("loaded" if "begun" in sys.modules else "broken off")
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_breaks_off_no_import(tmp_path, name):
    """A library in C whose start is interrupted may crash."""
    (tmp_path / "begun.py").write_text(
        f"import os, signal, time\nos.kill(os.getpid(), signal.{name})\ntime.sleep(0.2)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", WITHIN_AN_IMPORT],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("loaded\n", "")


WITHIN_A_DEL = """
import os, signal, time
from solarcal.cli.process import end_by_signals
signal.signal(signal.SIGINT, signal.SIG_DFL)
end_by_signals()
class Deleted:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.1)
try:
    Deleted()
    time.sleep(120.0)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_an_interrupt_within_a_del_is_not_lost():
    done = subprocess.run(
        [sys.executable, "-c", WITHIN_A_DEL],
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("interrupted\n", "")


def interrupted_in_a_lock(args):
    """As a condition's wait is, between giving its lock away and taking it again."""
    lock = threading.Lock()
    with lock:
        lock.release()
        raise Ended(signal.SIGTERM)


def refused_while_closing(args):
    try:
        raise KeyboardInterrupt
    finally:
        raise LinkError("the unit does not answer")


def not_stopped(args):
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt:
        raise LinkError("interrupted; the unit could NOT be stopped") from None


@pytest.mark.parametrize(
    ("run", "code", "said"),
    [
        (interrupted_in_a_lock, 143, "ended by SIGTERM"),
        (refused_while_closing, 130, "interrupted"),
        (not_stopped, LinkError.exit_code, "interrupted; the unit could NOT be stopped"),
    ],
)
def test_what_an_interrupt_breaks_on_its_way_is_that_interrupt(
    run, code, said, monkeypatch, capsys
):
    monkeypatch.setattr(cli, "command_functions", lambda name: (lambda parser: None, run))
    assert cli.run_command(["ports"]) == code
    assert capsys.readouterr().err == f"solarcal: {said}\n"


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


INTERRUPTED_WHILE_STARTING = """
import os, signal, sys
from solarcal.__main__ import main
class Interrupt:
    def find_spec(self, name, *_):
        if name == "solarcal.cli":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupt())
sys.argv = ["solarcal", "scenarios"]
main()
"""
INTERRUPTED_AT_THE_END = """
import atexit, os, signal, sys
from solarcal.__main__ import main
atexit.register(os.kill, os.getpid(), signal.SIGINT)
sys.argv = ["solarcal", "scenarios"]
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("program", "code"), [(INTERRUPTED_WHILE_STARTING, -signal.SIGINT), (INTERRUPTED_AT_THE_END, 0)]
)
def test_an_interrupt_before_or_after_the_command_is_no_traceback(program, code):
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (code, "")
