"""What can go wrong with the line on request: a unit that is silent, or talks nonsense."""

import numpy as np


class Faults:
    """How replies leave the unit. ``kind``: ``""``, ``mute`` or ``garbage``."""

    def __init__(self, stream: np.random.Generator) -> None:
        self._stream = stream
        self.kind = ""

    def talk(self, kind: str) -> None:
        self.kind = kind

    def sent(self, reply: bytes) -> list[bytes]:
        """What really goes out in place of a reply."""
        if self.kind == "mute":
            return []
        if self.kind == "garbage":
            # Anything but a line end, which is added: noise as a wrong baud rate makes it.
            noise = self._stream.integers(0x80, 0x100, size=len(reply) - 2, dtype=np.uint8)
            return [noise.tobytes() + b"\r\n"]
        return [reply]
