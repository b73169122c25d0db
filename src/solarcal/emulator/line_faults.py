"""A line that goes wrong on purpose, between a station and an emulated unit.

It stands where the emulator stands, behind a server (``serve_pty``, ``serve_tcp``). What goes wrong
follows from the seed and from the bytes that passed, never from the time of day.
"""

from dataclasses import dataclass, fields

import numpy as np

from solarcal.emulator.emulation import Emulator
from solarcal.errors import ConfigurationError

MOST_BABBLE_BYTES = 2000
"""Length of the longest burst of noise put before a reply: eight times the longest frame."""


@dataclass(frozen=True, slots=True)
class LineFaults:
    """How often what goes wrong, as probabilities, in both directions unless said otherwise.

    Attributes
    ----------
    flipped, dropped, doubled : of each byte.
    halved : of each piece of the stream: only its beginning arrives.
    silent : of each piece of the stream: nothing of it arrives.
    delayed : of each reply: its end (or all of it) arrives only when the station has given up
        waiting and speaks again, as a stale reply.
    babbled : of each reply: noise without a line end comes before it.
    rebooted : of each piece the station sends: the unit loses its power for a moment before it.
    hung_up : of each piece the station sends: the connection ends with it, at either side of the
        unit's answer. Only where a line can hang up: in process and on TCP.
    """

    flipped: float = 0.0
    dropped: float = 0.0
    doubled: float = 0.0
    halved: float = 0.0
    silent: float = 0.0
    delayed: float = 0.0
    babbled: float = 0.0
    rebooted: float = 0.0
    hung_up: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            if not 0.0 <= getattr(self, field.name) <= 1.0:
                raise ConfigurationError(f"line fault {field.name} is a probability, 0 to 1")
        if self.flipped + self.dropped + self.doubled > 1.0:
            raise ConfigurationError("flipped, dropped and doubled are more than all bytes")


def line_faults(text: str) -> LineFaults:
    """Faults as one writes them: ``flipped=0.01,silent=0.002``.

    Raises
    ------
    ConfigurationError
        Not ``NAME=PROBABILITY`` pairs, or a fault of another name.
    """
    known = [field.name for field in fields(LineFaults)]
    found: dict[str, float] = {}
    for pair in text.split(","):
        name, _, value = (part.strip() for part in pair.partition("="))
        if name not in known:
            raise ConfigurationError(
                f"--faults {text}: no line fault {name!r}; there is: {', '.join(known)}"
            )
        try:
            found[name] = float(value)
        except ValueError:
            raise ConfigurationError(
                f"--faults {text}: {name} needs a probability, like {name}=0.01"
            ) from None
    return LineFaults(**found)


class HungUp(Exception):
    """The connection ends here; a server closes it and waits for the next."""


class FaultyLine:
    """The line to ``emulator``, with faults. It outlives the connections made over it."""

    def __init__(
        self, emulator: Emulator, faults: LineFaults | None = None, *, seed: int = 0
    ) -> None:
        self.emulator = emulator
        self.faults = faults or LineFaults()
        self.damages = 0
        """How often something has gone wrong so far."""
        self.frames = 0
        """How many pieces of the stream the station has sent so far."""
        self._random = np.random.default_rng(seed)
        self._held = bytearray()

    def handle_input(self, data: bytes) -> list[bytes]:
        """What comes back over the line for a piece of the stream; ``HungUp`` ends it."""
        self.frames += 1
        if self._happens(self.faults.rebooted):
            self.emulator.reboot()
        if self._happens(self.faults.hung_up):
            if self._random.random() < 0.5:
                # Buffers on the way may keep a reply for whoever connects next.
                self._held += b"".join(self.emulator.handle_input(data))
            raise HungUp
        late, self._held = bytes(self._held), bytearray()
        replies = self.emulator.handle_input(self._damaged(data))
        arriving = [late] if late else []
        arriving += [self._returned(reply) for reply in replies]
        return [piece for piece in arriving if piece]

    def catch_up(self) -> None:
        self.emulator.catch_up()

    def link_lost(self) -> None:
        """The station is gone. What the line still holds of old replies, it keeps."""
        self.emulator.link_lost()

    # -- what goes wrong ---------------------------------------------------------------------

    def _happens(self, probability: float) -> bool:
        # Nothing is drawn for what cannot happen: adding a kind of fault leaves the others alone.
        if probability <= 0.0 or self._random.random() >= probability:
            return False
        self.damages += 1
        return True

    def _damaged(self, data: bytes) -> bytes:
        """A piece of the stream as it arrives at the other end."""
        faults = self.faults
        if self._happens(faults.silent):
            return b""
        if self._happens(faults.halved):
            data = data[: int(self._random.integers(len(data) + 1))]
        if not faults.flipped + faults.dropped + faults.doubled:
            return data
        flip_to = faults.flipped
        drop_to = flip_to + faults.dropped
        double_to = drop_to + faults.doubled
        arriving = bytearray()
        for byte, roll in zip(data, self._random.random(len(data)), strict=True):
            if roll >= double_to:
                arriving.append(byte)
                continue
            self.damages += 1
            if roll < flip_to:
                arriving.append(byte ^ int(self._random.integers(1, 0x100)))
            elif roll >= drop_to:
                arriving += bytes((byte, byte))
        return bytes(arriving)

    def _returned(self, reply: bytes) -> bytes:
        """A reply as it arrives at the station; a late part of it is held back."""
        reply = self._damaged(reply)
        if self._happens(self.faults.delayed):
            cut = int(self._random.integers(len(reply) + 1))
            self._held += reply[cut:]
            reply = reply[:cut]
        if self._happens(self.faults.babbled):
            reply = self._babble() + reply
        return reply

    def _babble(self) -> bytes:
        length = int(self._random.integers(1, MOST_BABBLE_BYTES + 1))
        noise: bytes = self._random.integers(0, 0x100, length, dtype=np.uint8).tobytes()
        return noise.replace(b"\n", b"?")
