"""What an emulated rotator speaks: Hamlib's ``rotctld``, or EasyComm II as rotator firmware does.

A line in, the lines of the reply out. What turns and reads out is ``emulator.rotator``.

References
----------
rotctld(1) of Hamlib 4.5, checked against its dummy rotator; Hamlib, rotators/easycomm/easycomm.txt.
"""

import re
from collections.abc import Callable, Sequence
from typing import ClassVar, Protocol

from solarcal.mount.geometry import AxisLimits

MODEL = 9001
"""No model of Hamlib's."""

OK, INVALID, NOT_IMPLEMENTED = 0, -1, -4
LONG = 20
"""No command has more words."""


class Machine(Protocol):
    """A rotator as its protocol sees it: directions in degrees, azimuth from North."""

    @property
    def azimuth(self) -> AxisLimits: ...

    @property
    def elevation(self) -> AxisLimits: ...

    def stands_deg(self) -> tuple[float, float]: ...

    def go_to(self, azimuth_deg: float, elevation_deg: float) -> bool:
        """Set out; False where that is beyond its range."""
        ...

    def stop(self) -> None: ...

    def park(self) -> None: ...


class RotatorProtocol(Protocol):
    """Answers one line at a time."""

    def answer(self, machine: Machine, line: bytes) -> list[str]: ...


class RotctldProtocol:
    """The commands a client of rotctld needs, in short (``p``) and long form (``\\get_pos``).

    A ``+`` in front asks for the extended form of the reply; ``;``, ``|`` and ``,`` do too, with
    that character between its parts.
    """

    SHORT: ClassVar[dict[str, str]] = {
        "p": "get_pos", "P": "set_pos", "S": "stop", "K": "park", "R": "reset", "M": "move",
        "_": "get_info", "1": "dump_caps",
    }  # fmt: skip
    ARGUMENTS: ClassVar[dict[str, int]] = {"set_pos": 2, "reset": 1, "move": 2}
    LABELS: ClassVar[dict[str, tuple[str, ...]]] = {
        "get_pos": ("Azimuth: ", "Elevation: "),
        "get_info": ("Info: ",),
        "dump_state": ("rotctld Protocol Ver: ", "Rotor Model: "),
    }
    """What the extended form puts before the parts of the short one."""

    def answer(self, machine: Machine, line: bytes) -> list[str]:
        text = line.decode("ascii", errors="replace").strip()
        separator = text[:1] if text[:1] and text[0] in "+;|," else ""
        text = text.removeprefix(separator)
        words = text.removeprefix("\\").split()[:LONG]
        if not words or words[0] in ("q", "Q"):
            return []
        name = words[0]
        arguments = words[1:]
        if not text.startswith("\\"):
            name, glued = self.SHORT.get(words[0][0], ""), words[0][1:]
            arguments = [*([glued] if glued else []), *arguments]
        moves = name == "set_pos"
        known = moves or name in _ROTCTLD
        if not known or len(arguments) != self.ARGUMENTS.get(name, 0):
            # The long form of what it does not know is passed over without a word, as there.
            return [] if text.startswith("\\") and not known else [f"RPRT {INVALID}"]
        body, result = _set_pos(machine, arguments) if moves else _ROTCTLD[name](machine)
        if not separator:
            return body if body and result == OK else [f"RPRT {result}"]
        labels = self.LABELS.get(name, ())
        if name == "dump_state":
            body = [*body[:2], *(_long_range(line) for line in body[2:])]
        labelled = [
            (labels[index] if index < len(labels) else "") + part for index, part in enumerate(body)
        ]
        parts = [f"{name}: {' '.join(arguments)}".rstrip(), *labelled, f"RPRT {result}"]
        return parts if separator == "+" else [separator.join(parts)]


Outcome = tuple[list[str], int]


def _set_pos(machine: Machine, arguments: Sequence[str]) -> Outcome:
    try:
        azimuth, elevation = (float(text) for text in arguments)
    except ValueError:
        return [], INVALID
    return [], OK if machine.go_to(azimuth, elevation) else INVALID


def _stop(machine: Machine) -> Outcome:
    machine.stop()
    return [], OK


def _park(machine: Machine) -> Outcome:
    machine.park()
    return [], OK


def _no_such(machine: Machine) -> Outcome:
    """It has absolute encoders and goes to positions only."""
    del machine
    return [], NOT_IMPLEMENTED


def _dump_state(machine: Machine) -> Outcome:
    azimuth, elevation = machine.azimuth, machine.elevation
    return [
        "1",
        str(MODEL),
        f"min_az={azimuth.low_deg:f}",
        f"max_az={azimuth.high_deg:f}",
        f"min_el={elevation.low_deg:f}",
        f"max_el={elevation.high_deg:f}",
        "south_zero=0",
        "rot_type=AzEl",
        "done",
    ], OK


def _dump_caps(machine: Machine) -> Outcome:
    del machine
    return [
        f"Caps dump for model:\t{MODEL}",
        "Model name:\t\tRotator",
        "Mfg name:\t\tEmulated",
        "Backend version:\t1.0",
        "Rot type:\t\tAz-El",
    ], OK


_ROTCTLD: dict[str, Callable[[Machine], Outcome]] = {
    "get_pos": lambda machine: ([f"{angle:.2f}" for angle in machine.stands_deg()], OK),
    "stop": _stop,
    "park": _park,
    "reset": _no_such,
    "move": _no_such,
    "get_info": lambda machine: (["Emulated Rotator"], OK),
    "dump_state": _dump_state,
    "dump_caps": _dump_caps,
}

_RANGES = {
    "min_az": "Minimum Azimuth",
    "max_az": "Maximum Azimuth",
    "min_el": "Minimum Elevation",
    "max_el": "Maximum Elevation",
    "south_zero": "South Zero",
}


def _long_range(line: str) -> str:
    """``min_az=0`` as the extended form writes it."""
    name, _, value = line.partition("=")
    return f"{_RANGES[name]}: {value}" if name in _RANGES else line


class EasyCommProtocol:
    """EasyComm II: commands of two letters, any number on a line; no reply to what only moves.

    ``decimals``: of the read-outs it reports. The standard says one; many firmwares have more.
    """

    _TARGET = re.compile(r"(AZ|EL)(-?[0-9]{1,3}(?:\.[0-9]+)?)")

    def __init__(self, decimals: int = 2) -> None:
        self._decimals = decimals

    def answer(self, machine: Machine, line: bytes) -> list[str]:
        replies: list[str] = []
        goals: dict[str, float] = {}
        for word in line.decode("ascii", errors="replace").split():
            target = self._TARGET.fullmatch(word)
            if target is not None:
                goals[target[1]] = float(target[2])
            elif word in ("AZ", "EL"):
                azimuth, elevation = machine.stands_deg()
                value = azimuth if word == "AZ" else elevation
                replies.append(f"{word}{value:.{self._decimals}f}")
            elif word in ("SA", "SE"):
                machine.stop()
            elif word == "PARK":
                machine.park()
            elif word == "VE":
                replies.append("VEemulated-1.0")
        if goals:
            azimuth, elevation = machine.stands_deg()
            # Firmware goes as far as it can and says nothing.
            machine.go_to(
                _on_its_turn_deg(machine.azimuth, goals.get("AZ", azimuth)),
                machine.elevation.clamped_deg(goals.get("EL", elevation)),
            )
        return [" ".join(replies)] if replies else []


def _on_its_turn_deg(reach: AxisLimits, azimuth_deg: float) -> float:
    """The azimuth as a rotator reads it whose range holds North: 350 deg is its -10."""
    turns = (azimuth_deg + 360.0 * turn for turn in (0, -1, 1))
    return next(
        (az for az in turns if reach.distance_deg(az) >= 0.0), reach.clamped_deg(azimuth_deg)
    )


ROTATOR_PROTOCOLS: dict[str, Callable[[], RotatorProtocol]] = {
    "rotctld": RotctldProtocol,
    "easycomm": EasyCommProtocol,
}
"""Driver -> what its emulated rotator speaks."""
