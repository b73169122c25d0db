"""The commands that want a terminal, with one and without; and how little ``--help`` costs."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from pty_bench import Terminal

SCREENS = ("run", "demo", "replay", "keys", "doctor")


def solarcal(*arguments, home, **options):
    environment = os.environ | {
        "SOLARCAL_CONFIG": str(home / "config"),
        "SOLARCAL_SESSIONS": str(home / "sessions"),
    }
    return subprocess.run(
        [sys.executable, "-m", "solarcal", *arguments],
        capture_output=True, text=True, stdin=subprocess.DEVNULL, env=environment, timeout=60,
        **options,
    )  # fmt: skip


@pytest.mark.parametrize("arguments", [(), ("run",), ("run", "--scenario", "tijeras-azel")])
def test_the_workstation_without_a_terminal_says_what_to_use_instead(arguments, tmp_path):
    done = solarcal(*arguments, home=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert "needs a terminal" in done.stderr
    assert "demo --headless" in done.stderr
    assert len(done.stderr.strip().split("\n")) == 1


def test_keys_without_a_terminal_is_the_table_and_ends(tmp_path):
    done = solarcal("keys", home=tmp_path)
    assert done.returncode == 0
    assert "Alt+F3" in done.stdout


def test_replay_without_a_terminal_is_told_in_text(tmp_path):
    saved = Path("sessions/azel-good-day.jsonl").resolve()
    done = solarcal("replay", str(saved), home=tmp_path)
    assert done.returncode == 0
    assert "What happened" in done.stdout


@pytest.mark.parametrize("command", SCREENS)
def test_help_does_not_load_the_screens(command, tmp_path):
    code = (
        "import sys\n"
        "from solarcal.cli import run_command\n"
        "try:\n"
        f"    run_command([{command!r}, '--help'])\n"
        "except SystemExit:\n"
        "    pass\n"
        "heavy = {'textual', 'numpy', 'scipy', 'plotext', 'serial'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "usage: solarcal" in done.stdout


def test_the_first_screen_is_there_before_numpy(tmp_path):
    code = (
        "import sys, solarcal.tui.app\n"
        "heavy = {'numpy', 'scipy', 'plotext', 'erfa', 'serial'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_program_ends_with_its_terminal_even_if_no_hang_up_is_sent(tmp_path):
    terminal = Terminal(tmp_path, "--scenario", "tijeras-azel")
    try:
        terminal.shows("LINK OK")
        assert terminal.take_away() == 128 + signal.SIGHUP
    finally:
        terminal.close()
    # The session is whole and free to go on with.
    from solarcal.session.journal import Journal

    (path,) = (tmp_path / "sessions").glob("*.jsonl")
    with Journal.resume(path) as journal:
        assert journal.warnings == ()
