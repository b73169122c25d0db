"""Is this laptop's clock kept right by the network or a receiver? Asked of the system's own tools.

The laptop's UTC is the technician's truth: 24 s of it are 0.1 deg of Sun.
"""

import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from solarcal.stopping_rule import SYNCHRONISED_S, UNSYNCHRONISED_S

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
        None,
        "It is not known whether the laptop's clock is right; compare it with a time signal.",
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
