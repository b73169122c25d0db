"""The real program in a terminal, by the manual's chords, on an emulator in another process."""

import json
from pathlib import Path

import pytest
from pty_bench import (
    CTRL_F9,
    ENTER,
    ESC,
    F6,
    F8,
    F10,
    RIGHT,
    UP,
    EmulatorProcess,
    Terminal,
    in_real_time,
    solarcal_json,
)
from technician_at_keys import (
    check_reference,
    hurry,
    initialise,
    leave_sun_offset,
    pace,
    set_clock,
    set_sun_offset,
    take_point,
    wait_for_next,
)

from solarcal.mount.formula import Coefficients
from solarcal.session.records import CheckRecord, PointRecord, UploadRecord
from solarcal.session.view import read_session
from solarcal.station.connect import open_tracker

START = "2026-06-03T15:30:00Z"
POINTS = 4
LARGE = (140, 45)
KEYS_TO_THE_FIRST, KEYS_A_POINT = 40, 12


@pytest.mark.slow
@in_real_time
def test_a_whole_calibration_by_the_manuals_keys_goes_on_after_a_power_cut(tmp_path: Path) -> None:
    """Begun in a large terminal, killed in the middle of the second point, gone on with in one of
    80x24: no accepted point is missing, and what stood in the file stays."""
    link, path = tmp_path / "tracker", tmp_path / "sessions" / "day.jsonl"
    emulator = EmulatorProcess(link, tmp_path, start=START, speed=1.0)
    emulator.start()
    terminal = Terminal(tmp_path, "--port", str(link), "-o", str(path), size=LARGE)
    try:
        terminal.shows("LINK OK", "day.jsonl")
        set_clock(terminal)
        hurry(terminal)
        check_reference(terminal)
        set_sun_offset(terminal)
        leave_sun_offset(terminal)
        initialise(terminal)
        take_point(terminal)
        terminal.shows("1 point")
        assert terminal.pressed <= KEYS_TO_THE_FIRST
        print("keys to the first point:", terminal.pressed)

        wait_for_next(terminal)
        set_sun_offset(terminal)
        terminal.press(".")
        terminal.shows("1. Did you do a reference check?")
        terminal.kill()
        terminal.close()
        lines = path.read_text().splitlines()
        assert all(json.loads(line) for line in lines)

        terminal = gone_on_with(tmp_path, "1 point")
        take_point(terminal)
        terminal.shows("2 points")
        hurry(terminal, since=pace(terminal))
        # One point fits hardly anything: from two on the fit brings the axes near the Sun.
        before = terminal.pressed
        for number in range(3, POINTS + 1):
            wait_for_next(terminal)
            set_sun_offset(terminal)
            take_point(terminal)
            terminal.shows(f"{number} point")
        keys = terminal.pressed - before
        assert keys <= KEYS_A_POINT * (POINTS - 2)
        print("keys for two more:", keys)
        assert path.read_text().splitlines()[: len(lines)] == lines

        terminal.press(F8)
        terminal.shows("in sigmas", f"{POINTS} points")
        terminal.press("y")
        terminal.shows_one_of("Type the reason", "Against it", "read back EQUAL")
        if "Type the reason" in terminal.words():
            # Four points may be no better than none beyond their uncertainty: not without a reason.
            terminal.press(*"trial", ENTER)
            terminal.shows_one_of("Against it", "read back EQUAL")
        # Four points are not done: asked a second time, in other words.
        if "Against it" in terminal.words():
            terminal.press("y")
        terminal.shows("read back EQUAL")
        terminal.press("t")
        terminal.shows_no("Upload coefficients")

        set_sun_offset(terminal)
        take_point(terminal, "c")
        look_around(terminal)

        terminal.press(CTRL_F9)
        terminal.shows("RECOMPUTE", "day.jsonl")
        terminal.press(" ", ENTER)
        terminal.shows("OPEN", "P1", "P6")
        terminal.press(ESC)
        terminal.shows("LINK OK")
        assert terminal.quit() == 0

        session = read_session(path)
        assert all("was not closed" in warning for warning in session.warnings)
        records = session.records
        accepted = [r for r in records if isinstance(r, PointRecord) and r.status == "accepted"]
        assert len(accepted) == POINTS
        assert all(point.basis == "sun_offset" for point in accepted)
        uploads = [r for r in records if isinstance(r, UploadRecord)]
        assert [upload.verified for upload in uploads] == [True]
        checks = [r for r in records if isinstance(r, CheckRecord)]
        assert [check.status for check in checks] == ["accepted"]
        assert checks[0].sky_error_deg is not None
        assert checks[0].sky_error_deg < 0.15

        # What `fit` makes of the file is what was uploaded, to the decimals the unit keeps.
        fitted = solarcal_json(tmp_path, "fit", str(path))
        values = Coefficients(*(fitted["coefficients"][f"P{i}"]["value"] for i in range(1, 7)))
        unit = session.header.unit
        uploaded = uploads[0].new_coefficients
        assert values.rounded(unit.tilt_decimals, unit.scale_decimals) == uploaded

        tracker = open_tracker(str(link))
        stored = tracker.stored()
        tracker.close()
        assert stored.coefficients == stored.permanent_coefficients == uploaded
    finally:
        terminal.close()
        emulator.kill()


def gone_on_with(home: Path, *recorded: str) -> Terminal:
    """Begun again without arguments, the open session chosen, and what is in it still there."""
    terminal = Terminal(home)
    terminal.shows("day.jsonl")
    terminal.press(ENTER)
    terminal.shows("LINK OK", "day.jsonl", *recorded)
    return terminal


def look_around(terminal: Terminal) -> None:
    """Before and after, and what is recorded, opened and left by their keys."""
    terminal.press("e")
    terminal.shows("The certificate of this session", "Before and after")
    terminal.press("v")
    terminal.shows("BEFORE, as found", "AFTER, as uploaded", "day of the year across")
    terminal.press("v")
    terminal.shows("BEFORE, as found", "apparent solar time, h")
    terminal.press(ESC)
    terminal.shows("LINK OK")

    open_what_is_recorded(terminal, POINTS)


def open_what_is_recorded(terminal: Terminal, points: int) -> None:
    """A point and its neighbour, the plot, the clocks and the large digits; left again."""
    terminal.press("2", UP, ENTER)
    terminal.shows(f"Point {points - 1} of {points}", "Leverage", "Without it")
    terminal.press(RIGHT)
    terminal.shows(f"Point {points} of {points}")
    terminal.press("x")
    terminal.shows("Why is this point struck out?", "F12 or ^S stops.")
    terminal.press(ESC)
    terminal.shows_no("Reason:")
    terminal.press(ESC)
    terminal.shows("LINK OK")

    terminal.press("4", "z", "+")
    terminal.shows("PgUp PgDn points")
    terminal.press("0", "z")
    terminal.shows_no("PgUp PgDn points")

    terminal.press(F10, "m")
    terminal.shows("Unit - laptop", "Signal - laptop")
    terminal.press(ESC)
    terminal.shows_no("Clocks")

    terminal.press(F6)
    terminal.shows("Set Sun Offset", "Arrow keys jog")
    terminal.press("B")
    terminal.shows("still to move", "axis 1, deg")
    terminal.press("B")
    terminal.shows("off ideal")
    terminal.press(ESC)
    terminal.shows_no("Set Sun Offset")
