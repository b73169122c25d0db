"""Replies of Hamlib's ``rotctld`` in its extended form, without any line to read them from.

A request is ``+\\name arguments``. The reply begins with ``name:`` (arguments may follow), has any
number of lines, and ends with ``RPRT n``: 0, or minus Hamlib's number of an error.
"""

import math
import re
from collections.abc import Iterable

from solarcal.errors import ConfigurationError, LinkError, ProtocolError, SolarcalError, UnitRefused
from solarcal.mount.geometry import AxisLimits
from solarcal.unit.rotator import Direction, RotatorIdentity

MOST_LINES = 250
"""``dump_caps`` has some eighty."""

_END = re.compile(rb"RPRT (-?[0-9]{1,4})")

ERRORS = {
    1: "a parameter it does not take, or a direction beyond the rotator's range",
    2: "rotctld is configured wrongly (model, device or speed of the rotator)",
    3: "rotctld ran out of memory",
    4: "this rotator cannot do that (function not implemented)",
    5: "the rotator does not answer rotctld in time",
    6: "rotctld cannot read or write the rotator's line",
    7: "an internal error of Hamlib",
    8: "the rotator answers rotctld with what Hamlib does not understand",
    9: "the rotator rejects the command",
    10: "a command or argument was cut off",
    11: "this rotator cannot do that (function not available)",
    13: "trouble on the bus between rotctld and the rotator",
    14: "a collision on the bus between rotctld and the rotator",
    17: "an argument out of the rotator's domain",
}
"""Hamlib's error numbers, as far as a rotator can cause them."""

BEHIND_ROTCTLD = frozenset((5, 6, 8, 13, 14))
"""Those that mean the line from rotctld to the rotator: to a technician, a lost link."""


def request(name: str, *arguments: float) -> bytes:
    """The line of a request. Directions go out with six decimals."""
    return " ".join((f"+\\{name}", *(f"{a:.6f}" for a in arguments))).encode("ascii") + b"\n"


class ReplyReader:
    """Takes the lines of one reply until it is complete.

    Attributes
    ----------
    lines : what stands between the first and the last line.
    error : Hamlib's number, 0 for none; ``None`` while the reply is not complete.
    """

    def __init__(self, name: str, where: str) -> None:
        self.name = name
        self.lines: list[str] = []
        self.error: int | None = None
        self._where = where
        self._begun = False

    def feed(self, line: bytes) -> bool:
        """Whether the reply is complete with this line.

        Raises
        ------
        ProtocolError
            It cannot be a line of this reply.
        """
        if not self._begun:
            # A reply to something else, or not rotctld at all.
            if not line.startswith(self.name.encode("ascii") + b":"):
                raise self._garbage(line)
            self._begun = True
            return False
        end = _END.fullmatch(line)
        if end is not None:
            self.error = abs(int(end[1]))
            return True
        if len(self.lines) >= MOST_LINES:
            raise self._garbage(line)
        self.lines.append(line.decode("ascii", errors="replace"))
        return False

    def _garbage(self, line: bytes) -> ProtocolError:
        shown = ascii(line[:60].decode("ascii", errors="replace"))
        return ProtocolError(
            f"{self._where}, reply to {self.name}: {shown} is not what rotctld answers; check that "
            "it is Hamlib's rotctld there, and no other program"
        )

    def outcome(self) -> SolarcalError | None:
        """The error this reply tells of, ``None`` for none."""
        if not self.error:
            return None
        words = ERRORS.get(self.error, "an unknown error code")
        if self.error in BEHIND_ROTCTLD:
            return LinkError(
                f"{self._where}, {self.name}: {words} (RPRT -{self.error}); check the rotator's "
                "power, its cable, and how rotctld was started"
            )
        return UnitRefused(-self.error, words, self.name)


def labelled(lines: Iterable[str]) -> dict[str, str]:
    """The ``label: value`` lines of a reply; of a label that comes twice the first."""
    found: dict[str, str] = {}
    for line in lines:
        label, colon, value = line.partition(":")
        if colon:
            found.setdefault(label.strip(), value.strip())
    return found


def position(lines: Iterable[str], where: str) -> Direction:
    """Azimuth and elevation of a reply to ``get_pos``.

    Raises
    ------
    ProtocolError
        One is missing, no number, or no direction.
    """
    told = labelled(lines)
    return (
        _number(told, "Azimuth", 720.0, f"{where}, reply to get_pos"),
        _number(told, "Elevation", 270.0, f"{where}, reply to get_pos"),
    )


def identity(state: Iterable[str], caps: Iterable[str], where: str) -> RotatorIdentity:
    """Who answers, of replies to ``dump_state`` and ``dump_caps``.

    The range is that of the state, which knows how rotctld was configured.

    Raises
    ------
    ConfigurationError
        It turns about one axis only.
    ProtocolError
        Something is missing, or cannot be.
    """
    told, known = labelled(state), labelled(caps)
    reply = f"{where}, reply to dump_state"
    kind = known.get("Rot type", "")
    if kind in ("Azimuth", "Elevation"):
        raise ConfigurationError(
            f"the rotator at {where} turns in {kind.lower()} only; azimuth and elevation are needed"
        )
    names = (known.get("Mfg name", ""), known.get("Model name", ""))
    model = " ".join(name for name in names if name)
    return RotatorIdentity(
        model=model or f"Hamlib model {told.get('Rotor Model', 'unknown')}",
        version=known.get("Backend version", ""),
        azimuth=_range(told, "Azimuth", reply),
        elevation=_range(told, "Elevation", reply),
    )


def _range(told: dict[str, str], what: str, reply: str) -> AxisLimits:
    low = _number(told, f"Minimum {what}", 720.0, reply)
    high = _number(told, f"Maximum {what}", 720.0, reply)
    try:
        return AxisLimits(low, high)
    except ConfigurationError as error:
        raise ProtocolError(f"{reply}: {what.lower()} {error}") from None


def _number(told: dict[str, str], label: str, most: float, reply: str) -> float:
    if label not in told:
        raise ProtocolError(f"{reply}: {label} is missing")
    try:
        value = float(told[label])
    except ValueError:
        value = math.nan
    if not abs(value) <= most:
        raise ProtocolError(f"{reply}: {label} {told[label][:30]!r} is no angle")
    return value
