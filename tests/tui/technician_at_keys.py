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

STEPS = ((1.0, "8"), (0.5, "7"), (0.25, "6"), (0.1, "5"), (0.05, "4"), (0.02, "3"), (0.01, "2"))
SPOT = re.compile(r"spot (\d+\.\d+) (right|left), (\d+\.\d+) (up|down)")
CENTRED_DEG = 0.04
ARRIVED_DEG = (0.06, 0.04)
ARRIVES_S = 5.0
"""Real seconds; at the slowest pace a jog across the plate takes less."""
ANSWERS_S = 6.0
LOOKS = 25
AT_REST = re.compile(r"moving\s+at rest\s+at rest")


def row(terminal: Terminal, name: str) -> tuple[float, float] | None:
    """Both numbers of a row of the jog table, if they stand there."""
    found = re.search(rf"{name}\s+([-+]?\d+\.\d+)\s+([-+]?\d+\.\d+)", terminal.text())
    return (float(found.group(1)), float(found.group(2))) if found else None


def spot(terminal: Terminal) -> tuple[float, float] | None:
    """Right and up, degrees on the sky."""
    found = SPOT.search(terminal.words())
    if found is None:
        return None
    right = float(found.group(1)) * (1.0 if found.group(2) == "right" else -1.0)
    up = float(found.group(3)) * (1.0 if found.group(4) == "up" else -1.0)
    return right, up


def press_steps(terminal: Terminal, degrees: float, forward: bytes, back: bytes) -> float:
    """Jog about that far with the keys there are; how far it became."""
    arrow, sign = (forward, 1.0) if degrees > 0.0 else (back, -1.0)
    left, done = abs(degrees), 0.0
    for step, key in STEPS:
        count = int(left / step + 1e-6)
        if count:
            terminal.press(key, *[arrow] * count)
            left -= count * step
            done += sign * count * step
    return done


def centre(terminal: Terminal) -> None:
    """Jog until the spot fills the ring, both axes from behind."""
    for _ in range(LOOKS):
        terminal.until(lambda: spot(terminal) and row(terminal, "off ideal"))
        right, up = spot(terminal) or (0.0, 0.0)
        ideal, off = row(terminal, "ideal"), row(terminal, "off ideal")
        assert ideal is not None
        assert off is not None
        from_behind = "came from behind from behind" in terminal.words()
        if math.hypot(right, up) < CENTRED_DEG and from_behind:
            return
        if math.hypot(right, up) < CENTRED_DEG:
            terminal.press("b")
            terminal.shows("came from behind from behind")
            continue
        axis1 = press_steps(terminal, right / math.sin(math.radians(ideal[1])), RIGHT, LEFT)
        axis2 = press_steps(terminal, up, UP, DOWN)
        wanted = (off[0] + axis1, off[1] + axis2)

        def arrived(wanted: tuple[float, float] = wanted) -> bool:
            now = row(terminal, "off ideal")
            return now is not None and all(
                abs(n - w) < near for n, w, near in zip(now, wanted, ARRIVED_DEG, strict=True)
            )

        # A key that came too late took over where the axes stood: then look again from there.
        if not terminal.within(ARRIVES_S, arrived):
            terminal.until(lambda: AT_REST.search(terminal.text()))
    raise InVain(f"the spot cannot be centred:\n{terminal.text()}")


def hurry(terminal: Terminal, to: int = 60) -> None:
    """Let the emulator's time run fast, from the pace of life on."""
    terminal.press(*["+"] * (1, 2, 5, 10, 30, 60).index(to))
    terminal.shows(f"time x{to} [")


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
    for _ in range(4):
        terminal.until(lambda: spot(terminal))
        centre(terminal)
        terminal.press(ENTER)
        if terminal.within(ANSWERS_S, lambda: "SET and recorded" in terminal.words()):
            break
    terminal.shows("SET and recorded")
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
    terminal.shows("Store it?")
    terminal.press("y")
    terminal.shows("tored as record")
    terminal.shows_no("Store it?")


def wait_for_next(terminal: Terminal) -> None:
    """Skip to when the next point is due."""
    terminal.press("w")
    terminal.shows("set the Sun offset")
