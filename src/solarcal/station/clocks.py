"""The laptop's clock: the emulator's time where the unit is one; else, is it kept right?

The laptop's UTC is the technician's truth: 24 s of it are 0.1 deg of Sun. The system's own tools
answer whether the network or a receiver keeps it.
"""

import math
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from solarcal.errors import LinkError
from solarcal.stopping_rule import SYNCHRONISED_S, UNSYNCHRONISED_S
from solarcal.timescale import Clock, SystemClock
from solarcal.unit.tracker import Emulation

LONGEST_REAL_WAIT_S = 0.25
"""After this much real time a wait looks again: the technician may have changed the speed."""

ASK_AGAIN_S = 0.5
"""An emulator that was waited for in vain is not asked again at once: a lost line is recorded with
one such wait, not with one for each time that is needed."""


def clock_beside(emulation: Emulation | None) -> Clock:
    """The laptop's time beside a unit: the emulator's where the unit is one."""
    return SystemClock() if emulation is None else EmulatedClock(emulation)


class EmulatedClock:
    """A ``Clock`` that asks the emulator for the laptop's time and waits in its time.

    At speed 0 virtual time moves only by this clock's ``X ADVANCE``: a headless day runs as fast
    as it can be computed, and the same commands meet the same instants on every kind of line. At
    any other speed it flows on and ``wait`` really waits, so that a technician at the
    screen sees it flow.
    """

    def __init__(self, emulation: Emulation) -> None:
        self._emulation = emulation
        self._real = SystemClock()
        self._last_utc_s = 0.0
        self._silent_s = -math.inf

    def utc_s(self) -> float:
        # When the line is gone the session must still be told so: the last known time stands.
        asked_s = self._real.utc_s()
        if 0.0 <= asked_s - self._silent_s < ASK_AGAIN_S:
            return self._last_utc_s
        try:
            self._last_utc_s = self._emulation.time()[1]
        except LinkError:
            if self._real.utc_s() - asked_s > ASK_AGAIN_S:
                self._silent_s = self._real.utc_s()
        return self._last_utc_s

    def wait(self, seconds: float) -> None:
        """Return when that much virtual time has passed; LinkError where the emulator is gone."""
        # The wire carries milliseconds; anything finer would differ from line to line.
        left_s = round(seconds, 3)
        if left_s <= 0.0:
            return
        speed = self._emulation.speed()
        if speed == 0.0:
            self._emulation.advance(left_s)
            return
        until_utc_s = self._emulation.time()[1] + left_s
        while left_s > 0.0:
            if speed == 0.0:
                self._emulation.advance(left_s)
                return
            self._real.wait(min(left_s / speed, LONGEST_REAL_WAIT_S))
            left_s = round(until_utc_s - self._emulation.time()[1], 3)
            speed = self._emulation.speed()


TOOL_TIMEOUT_S = 3.0

Ask = Callable[[Sequence[str]], str | None]
"""A command's output, ``None`` where it is missing or fails."""


@dataclass(frozen=True, slots=True)
class LaptopClock:
    """``synchronised`` is ``None`` where this laptop has no time service."""

    synchronised: bool | None
    sentence: str


def laptop_clock(ask: Ask | None = None) -> LaptopClock:
    """Ask chrony, systemd and ntpd in turn."""
    ask = ask or _run
    for look in (_chrony, _systemd, _ntpd):
        answer = look(ask)
        if answer is not None:
            return answer
    return LaptopClock(
        None, "It is not known whether the laptop's clock is right; compare it with a time signal."
    )


def clock_sigma_s(ask: Ask | None = None) -> float:
    """How well this laptop's clock is known before it is compared with a time signal, seconds."""
    return SYNCHRONISED_S if laptop_clock(ask).synchronised else UNSYNCHRONISED_S


def _chrony(ask: Ask) -> LaptopClock | None:
    said = ask(("chronyc", "-n", "tracking"))
    if said is None:
        return None
    fields = dict(_fields(said, ":"))
    if fields.get("Leap status") not in ("Normal", "Insert second", "Delete second"):
        return LaptopClock(False, "chrony has NOT synchronised the laptop's clock.")
    off = fields.get("System time", "").partition(" ")[0]
    return LaptopClock(
        True, "The laptop's clock is synchronised by chrony" + (f", {off} s off." if off else ".")
    )


def _systemd(ask: Ask) -> LaptopClock | None:
    said = ask(("timedatectl", "show", "-p", "NTPSynchronized"))
    synchronised = dict(_fields(said or "", "=")).get("NTPSynchronized")
    if synchronised is None:
        return None
    if synchronised == "yes":
        return LaptopClock(True, "The laptop's clock is synchronised (timedatectl).")
    return LaptopClock(False, "The laptop's clock is NOT synchronised (timedatectl).")


def _ntpd(ask: Ask) -> LaptopClock | None:
    said = ask(("ntpq", "-pn"))
    if said is None:
        return None
    # ntpq marks the peer the clock follows with an asterisk.
    if any(line.startswith("*") for line in said.splitlines()):
        return LaptopClock(True, "The laptop's clock is synchronised by ntpd.")
    return LaptopClock(False, "ntpd follows no server: the laptop's clock is NOT synchronised.")


def _fields(text: str, separator: str) -> list[tuple[str, str]]:
    pairs = (line.partition(separator) for line in text.splitlines() if separator in line)
    return [(name.strip(), value.strip()) for name, _, value in pairs]


def _run(command: Sequence[str]) -> str | None:
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=TOOL_TIMEOUT_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None
