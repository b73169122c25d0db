"""A technician at the terminal: reads the screen, presses keys, knows nothing else."""

import math
import re

from pty_bench import (
    ALT_F3,
    ALT_F5,
    DOWN,
    ENTER,
    ESC,
    F6,
    F10,
    LEFT,
    RIGHT,
    UP,
    EmulatorProcess,
    InVain,
    Terminal,
)

SPOT = re.compile(r"spot (\d+\.\d+) (right|left), (\d+\.\d+) (up|down)")
PACE = re.compile(r"time x(\d+) \[")
CENTRED_DEG = 0.06
MOVED = 0.4
"""Of what was off: more than the Sun goes between two looks."""
MOVES_S = 4.0
"""Real seconds an arrow takes to be seen, at the slowest pace."""
ANSWERS_S = 6.0
LOOKS = 25
AT_REST = re.compile(r"moving\s+at rest\s+at rest")


def spot(terminal: Terminal) -> tuple[float, float] | None:
    """Right and up, degrees on the sky."""
    found = SPOT.search(terminal.words())
    if found is None:
        return None
    right = float(found.group(1)) * (1.0 if found.group(2) == "right" else -1.0)
    up = float(found.group(3)) * (1.0 if found.group(4) == "up" else -1.0)
    return right, up


def centre(terminal: Terminal) -> None:
    """Jog until the spot fills the ring, both axes from behind; the step of an arrow adapts."""
    for _ in range(LOOKS):
        # An arrow is pressed when what the last one did is seen.
        terminal.until(lambda: spot(terminal) and AT_REST.search(terminal.text()))
        right, up = spot(terminal) or (0.0, 0.0)
        if math.hypot(right, up) >= CENTRED_DEG:
            across = abs(right) >= abs(up)
            key = (RIGHT if right > 0.0 else LEFT) if across else (UP if up > 0.0 else DOWN)
            terminal.press(key)
            seen = (right, up)
            terminal.within(MOVES_S, lambda seen=seen: moved(seen, spot(terminal)))
        elif "came from behind from behind" in terminal.words():
            return
        else:
            terminal.press("b")
            terminal.shows("came from behind from behind")
    raise InVain(f"the spot cannot be centred:\n{terminal.text()}")


def moved(before: tuple[float, float], now: tuple[float, float] | None) -> bool:
    return now is not None and math.dist(before, now) > MOVED * max(map(abs, before))


def hurry(terminal: Terminal, to: int = 60, since: int = 1) -> None:
    """Let the emulator's time run fast, from the pace of life on or another."""
    paces = (1, 2, 5, 10, 30, 60)
    with terminal.uncounted():
        terminal.press(*["+"] * (paces.index(to) - paces.index(since)))
    terminal.shows(f"time x{to} [")


def pace(terminal: Terminal) -> int:
    """How fast the emulator's time runs, as the screen says."""
    terminal.until(lambda: PACE.search(terminal.words()))
    found = PACE.search(terminal.words())
    assert found is not None
    return int(found.group(1))


def press_until(terminal: Terminal, key: bytes, *words: str) -> None:
    """Press, and again where nothing came of it, as anybody would.

    A notice may cover the heading of a dialog that is still open and takes no such key; a jog that
    expired on a busy machine is no place to set an offset at.
    """
    for _ in range(3):
        terminal.press(key)
        if terminal.within(ANSWERS_S, lambda: all(word in terminal.words() for word in words)):
            return
    terminal.shows(*words)


def set_clock(terminal: Terminal) -> None:
    press_until(terminal, F10, "Set the unit's")
    terminal.press(ENTER)
    terminal.shows("Set and recorded")
    terminal.press(ESC)
    terminal.shows_no("Clocks")


def check_reference(terminal: Terminal) -> None:
    press_until(terminal, ALT_F5, "Start: drive to the switches")
    terminal.press(ENTER)
    terminal.shows("Track again")
    terminal.press("t")
    terminal.shows_no("Reference check no")
    terminal.shows("TRACK")


def set_sun_offset(terminal: Terminal) -> None:
    press_until(terminal, F6, "Set Sun Offset", "Arrow keys jog")
    # Seconds of life are long for a test: five times as fast still lets a jog be followed.
    hurry(terminal, EmulatorProcess.pace)
    if "To fit" in terminal.words():
        terminal.press("p")
        terminal.shows("Both axes came from behind")
    for _ in range(4):
        terminal.until(lambda: spot(terminal))
        centre(terminal)
        terminal.press(ENTER)
        if terminal.within(ANSWERS_S, lambda: "SET and recorded" in terminal.words()):
            break
    terminal.shows("SET and recorded")


def leave_sun_offset(terminal: Terminal) -> None:
    terminal.press(ESC)
    terminal.shows_no("SET and recorded")


def initialise(terminal: Terminal) -> None:
    press_until(terminal, ALT_F3, "Are you sure?")
    terminal.press("y")
    terminal.shows_no("Are you sure?")


def take_point(terminal: Terminal, kind: str = "") -> None:
    """The three questions, yes to each, and store."""
    terminal.press(".")
    if kind:
        terminal.shows("a check point, or one more data point?")
        terminal.press(kind)
    terminal.shows("1. Did you do a reference check?")
    hurry(terminal, EmulatorProcess.pace)
    terminal.press("y")
    terminal.shows("2. Did you do a 'Set Sun Offset'?")
    terminal.press("y")
    terminal.shows("3. Do you like the way it is tracking?")
    terminal.press("y")
    # The heading of its table is never broken, as the question "Store it?" may be.
    heading = "left, axis 1" if kind == "c" else "in sigmas"
    terminal.shows(heading)
    terminal.press("y")
    terminal.shows("tored as record")
    terminal.shows_no(heading)


def wait_for_next(terminal: Terminal) -> None:
    """Skip to when the next point is due."""
    with terminal.uncounted():
        terminal.press("w")
    terminal.shows("set the Sun offset")
