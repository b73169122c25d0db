"""EasyComm II, as the firmware of many home-built rotators speaks it over a serial line.

``AZ EL`` asks where it stands, ``AZ123.4 EL45.6`` sends it, ``SA SE`` stops it. Only questions are
answered, replies carry neither number nor checksum, and firmware may report of its own accord. So
what is there before a question answers nothing and is thrown away; a position is believed if it is
written as one and can follow from the last; else it is asked for again.

References
----------
C. Jackson (G7UPN), EasyComm II, in Hamlib, rotators/easycomm/easycomm.txt.
"""

import re
import time

from solarcal.errors import LinkError, ProtocolError
from solarcal.mount.geometry import AxisLimits
from solarcal.unit.link import Link
from solarcal.unit.rotator import Direction, Rotator, RotatorIdentity

ANSWER_S = 1.0
"""Firmware answers within some milliseconds; a reply takes 20 ms at 9600 baud."""

BOOT_S = 3.0
"""Opening the port resets many an Arduino; its boot loader takes about two seconds."""

ASKED_AT_MOST = 4
"""Lost or damaged replies that are borne in a row."""

VERSION_S = 0.5
"""Firmware need not know ``VE``."""

JUMP_DEG = 2.0
"""A read-out farther than this from the last one is damage, unless it is read twice.

Damage to one digit that is smaller than this shows as an axis that moves, and moves back.
"""

MOST_DECIMALS = 4

AZIMUTH = AxisLimits(0.0, 360.0)
ELEVATION = AxisLimits(0.0, 180.0)
"""EasyComm does not report how far a rotator turns; the profile's limits narrow this down."""

_POSITION = re.compile(r"(AZ|EL)([-+]?[0-9]{1,3}(?:\.([0-9]{1,6}))?)")
_VERSION = re.compile(r"VE(\S{1,40})")


class EasyCommRotator(Rotator):
    """A ``Rotator`` on an EasyComm II line."""

    _decimals = 1
    _last: Direction | None = None

    # -- the line ------------------------------------------------------------------------------

    def open(self) -> RotatorIdentity:
        with self._turn:
            self.close()
            self._link = self._link_factory()
            self._decimals, self._last = 1, None
            self._last = self._asked_position(first=True)
            version = self._version()
            return RotatorIdentity(
                model="EasyComm II",
                version=version,
                azimuth=AZIMUTH,
                elevation=ELEVATION,
                read_out_deg=10.0**-self._decimals,
            )

    def close(self) -> None:
        with self._guard.sending():
            link, self._link = self._link, None
        if link is not None:
            link.close()

    # -- what a rotator does -------------------------------------------------------------------

    def position_deg(self) -> Direction:
        with self._turn:
            found = self._asked_position()
            if self._last is not None and _apart_deg(found, self._last) > JUMP_DEG:
                again = self._asked_position()
                if _apart_deg(again, found) > JUMP_DEG:
                    raise self._gave_up(
                        ProtocolError(
                            f"{self.where} reports {_words(self._last)}, then {_words(found)}, "
                            f"then {_words(again)}: no rotator turns so fast; check cable and "
                            "grounding"
                        )
                    )
                found = again
            self._last = found
            return found

    def go_to(self, azimuth_deg: float, elevation_deg: float, stops: int) -> None:
        places = self._decimals
        self._send(f"AZ{azimuth_deg:.{places}f} EL{elevation_deg:.{places}f}", stops=stops)

    def stop(self) -> None:
        """Both axes. EasyComm has no reply to it: the read-outs show whether it stopped."""
        self._send("SA SE", interrupts=True)

    def park(self) -> None:
        """Not part of EasyComm II; firmware that lacks it stays where it is."""
        self._send("SA SE", interrupts=True)
        self._send("PARK")

    # -- asking --------------------------------------------------------------------------------

    def _asked_position(self, *, first: bool = False) -> Direction:
        """Azimuth and elevation, asked again after silence and damage.

        Raises
        ------
        LinkError
            Silence each time; the line is given up.
        ProtocolError
            Something answers, but never with a position.
        """
        strays: list[bytes] = []
        for attempt in range(ASKED_AT_MOST):
            wait_s = BOOT_S if first and attempt == 0 else ANSWER_S
            found = self._one_position(wait_s, strays)
            if found is not None:
                return found
        if strays:
            raise self._gave_up(
                ProtocolError(
                    f"{self.where} answers {_shown(strays[-1])}, which is no EasyComm position; "
                    "check driver, port and baud rate"
                )
            )
        raise self._gave_up(
            LinkError(
                f"no answer from the rotator at {self.where} ({ASKED_AT_MOST} times, "
                f"{ANSWER_S:g} s each); check that it is on, the cable and the baud rate"
            )
        )

    def _one_position(self, wait_s: float, strays: list[bytes]) -> Direction | None:
        self._discard()
        self._send("AZ EL")
        found: dict[str, float] = {}
        deadline = time.monotonic() + wait_s
        while len(found) < 2:
            line = self._read(max(deadline - time.monotonic(), 0.0))
            if line is None:
                return None
            text = line.decode("ascii", errors="replace")
            for word in text.split():
                match = _POSITION.fullmatch(word)
                if match is not None and abs(float(match[2])) <= 720.0:
                    found[match[1]] = float(match[2])
                    # One is what the standard has; firmware that shows more also takes more.
                    shown = min(len(match[3] or ""), MOST_DECIMALS)
                    self._decimals = max(self._decimals, shown)
                elif not word.startswith(("AL", "VE")):
                    strays.append(line)
        return found["AZ"], found["EL"]

    def _version(self) -> str:
        self._discard()
        self._send("VE")
        deadline = time.monotonic() + VERSION_S
        while (line := self._read(max(deadline - time.monotonic(), 0.0))) is not None:
            match = _VERSION.match(line.decode("ascii", errors="replace").strip())
            if match is not None:
                return match[1]
        return ""

    def _read(self, timeout_s: float) -> bytes | None:
        line = self._open_link().read_line(timeout_s)
        if line is not None:
            self._received(line)
        return line

    def _discard(self) -> None:
        """What was sent before a question is no answer to it."""
        while self._read(0.0) is not None:
            pass

    def _send(self, line: str, *, stops: int | None = None, interrupts: bool = False) -> None:
        with self._guard.sending(stops, interrupts=interrupts):
            self._recent.append("> " + line)
            self._open_link().write(line.encode("ascii") + b"\n")

    def _open_link(self) -> Link:
        link = self._link
        if link is None:
            raise LinkError(f"the line to the rotator at {self.where} is not open; connect first")
        return link

    def _gave_up(self, error: LinkError | ProtocolError) -> LinkError | ProtocolError:
        """Close the line: a late reply must not pass for that to the next question."""
        self.close()
        return error


def _apart_deg(one: Direction, other: Direction) -> float:
    azimuth = (one[0] - other[0] + 180.0) % 360.0 - 180.0
    return max(abs(azimuth), abs(one[1] - other[1]))


def _words(direction: Direction) -> str:
    return f"AZ {direction[0]:g} EL {direction[1]:g}"


def _shown(line: bytes) -> str:
    return ascii(line[:60].decode("ascii", "replace"))
