"""Every request of the wire protocol, described once: its arguments, its reply, what it does.

Both ends write and read fields by this table, ``docs/protocol.md`` has its tables from it
(``python -m tools.protocol_page``), and a test goes through every entry. A field's name says what
it holds; ``values.KINDS`` says how that is written and what it can be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from solarcal.errors import ProtocolError
from solarcal.unit.values import KINDS, SCALE_DECIMALS, TILT_DECIMALS


@dataclass(frozen=True, slots=True)
class Verb:
    """One request. Words that are no field stand as they are.

    Attributes
    ----------
    request, reply : words and names of fields, as they go over the line.
    does : for the page.
    unlock : it needs the unlock.
    """

    request: str
    reply: str
    does: str
    unlock: bool = False

    @property
    def arguments(self) -> str:
        """Names of the fields behind the words of the request."""
        return " ".join(word for word in self.request.split() if word in KINDS)


_STATUS = (
    "mode local_time ideal1 ideal2 reading1 reading2 counts1 counts2 target1 target2 O1 O2"
    " motion approach phase flags unlocked"
)
_SITE = "latitude longitude elevation_m zone geometry ax1_centre"
_COEF = "P1 P2 P3 P4 P5 P6 O1 O2"

VERBS: tuple[Verb, ...] = (
    Verb(
        "OPEN nonce",
        "nonce",
        "starts a conversation. `nonce`: 8 hex digits, new each time. Cancels a jog and locks",
    ),
    Verb(
        "ID",
        "model serial firmware protocol extensions",
        "`extensions`: letters, or `-` for none; `X` announces the emulator requests",
    ),
    Verb("CLOCK", "local_time zone", "reads the clock"),
    Verb("CLOCK SET local_time", "local_time zone", "sets it", unlock=True),
    Verb("SITE", _SITE, "`geometry`: `azel`, `polar`, `tiltroll-ew`, `tiltroll-ns`"),
    Verb("SITE SET latitude longitude elevation_m zone", _SITE, "sets it", unlock=True),
    Verb("STATUS", _STATUS, "everything of one instant; the fields are explained below"),
    Verb("PARAM name", "value", "reads a parameter"),
    Verb("PARAM name value", "value", "writes it", unlock=True),
    Verb(
        "UNLOCK",
        "unlocked",
        "unlocks writes and motion for that number of seconds (60); every unlocked request "
        "restarts the time",
    ),
    Verb("LOCK", "", "ends the unlock at once"),
    Verb(
        "MODE mode",
        "mode",
        "`TRACK`: track the Sun; `MANUAL`: hold position and wait for jogs",
        unlock=True,
    ),
    Verb("STOP", "STOP", "every motion ends now; the unit stays in mode `STOP` until `MODE`"),
    Verb("STOW", "STOW", "drives to the stow position"),
    Verb(
        "JOG target1 target2",
        "target1 target2",
        "drives to ABSOLUTE readings. The target expires 5 s after it was last sent: "
        "the axes then stop where they are. Leaves `TRACK` for `JOG`; on arrival and on "
        "expiry the mode becomes `MANUAL`. Refused beyond limits",
        unlock=True,
    ),
    Verb(
        "OFFSET SET",
        _STATUS,
        "sets O so that `reading = ideal + E + O` is true now, and returns the status of "
        "that instant (new O included). Refused while an axis moves",
        unlock=True,
    ),
    Verb(
        "REF START",
        "number",
        "starts a reference check: drives to the reference switches, stores the counts "
        "found there, sets the count registers to zero; O and P do not change. The mode is "
        "`REF` during the check and `MANUAL` afterwards",
        unlock=True,
    ),
    Verb(
        "REF",
        "number state difference1 difference2",
        "the last check: `state` is `NONE`, `RUNNING`, `DONE` or `BROKEN` (stopped before the "
        "end); differences: counts found on the register at the switch, 0 expected",
    ),
    Verb("COEF", _COEF, "in force (temporary memory)"),
    Verb("COEF STORED", _COEF, "permanent memory"),
    Verb(
        f"COEF SET {_COEF}",
        _COEF,
        "sets all eight or none; the reply has the stored values",
        unlock=True,
    ),
    Verb("STORE", "1", "temporary to permanent memory", unlock=True),
    Verb(
        "X TIME",
        "true_utc laptop_utc speed",
        "ISO 8601 with `Z`, milliseconds; speed 0: time moves only by `X ADVANCE`",
    ),
    Verb(
        "X SPEED speed",
        "speed",
        "sets the number of virtual seconds per real second, 0 to a million, up to three "
        "decimals; 0 as above",
    ),
    Verb(
        "X ADVANCE seconds",
        "true_utc laptop_utc",
        "advances virtual time by this, as fast as possible. 0 to 86400, up to six decimals",
    ),
    Verb(
        "X SPOT",
        "visible error1 error2",
        "spot as seen by the technician: `1` or `0`, and the motion of each axis that centres "
        "the Sun (heliostat: that brings the beam onto the middle of the target board), degrees, "
        "as estimated by eye",
    ),
    Verb(
        "X SKY",
        "sun pressure temperature",
        "values of the emulated world: its Sun model (`precise`), station pressure in hPa "
        "(0: no air, no refraction), temperature in degrees Celsius",
    ),
    Verb(
        "X TRUTH",
        "P1 P2 P3 P4 P5 P6 day_rms day_max year_rms",
        "the true coefficients, and the true pointing error with the P and O in force",
    ),
    Verb(
        "X FAULT name",
        "name",
        "from now on: `mute` (no replies), `garbage` (noise instead of replies), "
        "`none`, `freeze1`, `freeze2` (axis read-out does not change), `reboot` (loses "
        "reference and temporary memory), `miss1:counts`, `miss2:counts`",
    ),
)


def verb(words: str) -> Verb:
    """The description of a request, by its words: ``COEF SET``."""
    return _BY_WORDS[words]


def expect(fields: Sequence[str], names: str) -> tuple[str, ...]:
    """The fields, of which there must be as many as ``names`` (separated by spaces) has."""
    wanted = names.split()
    if len(fields) != len(wanted):
        raise ProtocolError(
            f"{len(fields)} fields where {len(wanted)} belong ({', '.join(wanted) or 'none'})"
        )
    return tuple(fields)


def read(names: str, texts: Sequence[str]) -> list[Any]:
    """The values of fields, in the order of their names.

    Raises
    ------
    ProtocolError
        As many texts as there are names there must be, each of its kind; names the field.
    """
    found = zip(names.split(), expect(texts, names), strict=True)
    return [KINDS[name].read(text, name) for name, text in found]


def write(
    names: str, values: Sequence[Any], decimals: tuple[int, int] = (TILT_DECIMALS, SCALE_DECIMALS)
) -> list[str]:
    """The texts of fields from their values, in the order of their names."""
    fields = zip(names.split(), values, strict=True)
    return [KINDS[name].write(value, decimals) for name, value in fields]


_BY_WORDS = {
    " ".join(word for word in verb.request.split() if word not in KINDS): verb
    for verb in reversed(VERBS)
}
