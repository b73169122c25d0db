"""A faulty line in this process: a link without a wire, hang-ups when a test wants them."""

from collections import deque

from solarcal.emulator.line_faults import FaultyLine, HungUp
from solarcal.errors import LinkError
from solarcal.unit.frames import LineBuffer


class OrderedLine(FaultyLine):
    """A ``FaultyLine`` with a station's end; it also breaks where a test says."""

    _hang_up_in: int | None = None
    _delivered = False

    def connect(self) -> "DirectLink":
        """A connection over this line; any number, one after the other."""
        return DirectLink(self)

    def hang_up(self, after_frames: int = 0, *, delivered: bool = False) -> None:
        """Break the connection at the frame that follows ``after_frames`` more.

        ``delivered``: the unit still gets that frame and acts on it; its reply is lost.
        """
        self._hang_up_in, self._delivered = after_frames, delivered

    def breaks_at(self, data: bytes) -> bool:
        """Whether the connection breaks with this frame; delivers the frame where that was said."""
        if self._hang_up_in is None:
            return False
        self._hang_up_in -= 1
        if self._hang_up_in >= 0:
            return False
        self._hang_up_in = None
        self.damages += 1
        if self._delivered:
            # Buffers on the way may keep a reply for whoever connects next.
            for reply in self.emulator.handle_input(data):
                self._held += reply
        return True


class DirectLink:
    """A ``Link`` over such a line: silence is known at once."""

    def __init__(self, line: OrderedLine) -> None:
        self._line = line
        self._buffer = LineBuffer()
        self._lines: deque[bytes] = deque()
        self._lost = ""

    def write(self, data: bytes) -> None:
        if self._lost:
            raise LinkError(self._lost)
        if self._line.breaks_at(data):
            self._end("the line to the emulator was lost")
            raise LinkError(self._lost)
        try:
            pieces = self._line.handle_input(data)
        except HungUp:
            self._end("the line to the emulator was lost")
            raise LinkError(self._lost) from None
        for piece in pieces:
            self._lines.extend(self._buffer.feed(piece))

    def read_line(self, timeout_s: float) -> bytes | None:
        if self._lines:
            return self._lines.popleft()
        if self._lost:
            raise LinkError(self._lost)
        return None

    def close(self) -> None:
        self._end("the line to the emulator is closed")

    def _end(self, reason: str) -> None:
        if not self._lost:
            self._lost = reason
            self._line.link_lost()
