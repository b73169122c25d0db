"""The unit dies in each step of the procedure and comes back: the program stays usable."""

from pathlib import Path

import pytest
from pty_bench import (
    ALT_F5,
    ENTER,
    ESC,
    F2,
    F6,
    F8,
    F10,
    LEFT,
    EmulatorProcess,
    Terminal,
    in_real_time,
)
from technician_at_keys import check_reference, hurry, initialise

from solarcal.session.records import LinkLost, LinkRestored, Note, PointRecord
from solarcal.session.view import read_session

START = "2026-06-03T15:30:00Z"


def dies_and_comes_back(terminal: Terminal, emulator: EmulatorProcess) -> None:
    """The dialog says so at once, and again when the line is back."""
    emulator.kill()
    terminal.shows("LINK LOST")
    emulator.start()
    terminal.shows("link is back")
    terminal.press(ESC)
    # An escape with a key at its heels would be Alt and that key.
    terminal.shows_no("link is back")


@pytest.mark.slow
@in_real_time
def test_the_unit_is_killed_in_every_step_and_started_again(tmp_path: Path) -> None:
    link, path = tmp_path / "tracker", tmp_path / "sessions" / "day.jsonl"
    emulator = EmulatorProcess(link, tmp_path, start=START, speed=1.0)
    emulator.start()
    terminal = Terminal(tmp_path, "--port", str(link), "-o", str(path))
    try:
        terminal.shows("LINK OK")
        initialise(terminal)

        terminal.press("n")
        terminal.shows("Remark")
        terminal.press("gusts")
        terminal.shows("gusts")
        emulator.kill()
        terminal.shows("LINK LOST", "gusts")
        emulator.start()
        # What was typed is still there and can be used.
        terminal.shows("link is back", "gusts")
        terminal.press(ENTER)
        terminal.shows_no("Remark")

        terminal.press(F10)
        terminal.shows("Set the unit's")
        dies_and_comes_back(terminal, emulator)

        terminal.press(ALT_F5)
        terminal.shows("Start: drive to the switches")
        terminal.press(ENTER)
        terminal.shows("Reference check running")
        dies_and_comes_back(terminal, emulator)

        terminal.press(".")
        terminal.shows("1. Did you do a reference check?")
        dies_and_comes_back(terminal, emulator)

        hurry(terminal)
        check_reference(terminal)
        terminal.press(F6)
        terminal.shows("Nothing moves before one")
        terminal.press("8", LEFT, LEFT)
        terminal.shows("mode JOG")
        dies_and_comes_back(terminal, emulator)

        # The dialog gave the speed back; the new unit has to find its switches again.
        terminal.shows("time x60 [")
        check_reference(terminal)
        terminal.press(".")
        for words in ("1. Did", "2. Did", "3. Do"):
            terminal.shows(words)
            terminal.press("y")
        terminal.shows("GATHERING")
        dies_and_comes_back(terminal, emulator)

        terminal.press(F8)
        terminal.shows("Upload coefficients", "0 accepted points")
        emulator.kill()
        terminal.shows("LINK LOST")
        emulator.start()
        # What the unit holds is read anew.
        terminal.shows("LINK OK", "0 accepted points")
        terminal.press(ESC)
        terminal.shows_no("Upload coefficients")

        terminal.press(F2)
        terminal.shows("CONNECTED", "lost 7 times, restored 7 times")
        terminal.press(ESC)
        terminal.shows_no("CONNECTED")
        assert terminal.quit() == 0
    finally:
        terminal.close()
        emulator.kill()
    session = read_session(path)
    assert all("was not closed" in warning for warning in session.warnings)
    kinds = [type(record) for record in session.records]
    assert kinds.count(LinkLost) == kinds.count(LinkRestored)
    # Where it was lost again at once, the record of its return says how often.
    again = sum(r.losses for r in session.records if isinstance(r, LinkRestored))
    assert kinds.count(LinkLost) + again == 7
    assert [r.text for r in session.records if isinstance(r, Note)] == ["gusts"]
    attempts = [r for r in session.records if isinstance(r, PointRecord)]
    assert [a.status for a in attempts] == ["aborted", "aborted"]
    assert all(a.reason.startswith("link lost") for a in attempts)
    assert [record.seq for record in session.records] == list(range(1, len(kinds) + 1))
