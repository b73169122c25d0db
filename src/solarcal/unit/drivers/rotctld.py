"""Hamlib's ``rotctld`` over TCP: one connection, requests in turn, STOP past all of them.

rotctld answers in the order it was asked, and its replies carry no number. So what is ambiguous
is never guessed: after silence, or a line that belongs to no reply, the connection is
given up, and only a new one (``open``) is used again.
"""

import re
import threading
import time
from collections import deque
from collections.abc import Callable

from solarcal.errors import ConfigurationError, LinkError, ProtocolError, UnitRefused
from solarcal.unit.drivers import rotctld_replies as replies
from solarcal.unit.link import Link
from solarcal.unit.rotator import Direction, Rotator, RotatorIdentity

DEFAULT_PORT = 4533

ANSWER_S = 5.0
"""rotctld asks a rotator on a slow serial line up to three times before it gives up."""

LINES_KEPT = 400
"""``dump_caps`` arrives at once; more than a line's usual share of unread ones."""

CANNOT = (-4, -11)
"""Hamlib's numbers for what a rotator has no command for."""

_ADDRESS = re.compile(r"(?:socket://)?(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(?::([0-9]{1,5}))?/?")


def rotctld_address(text: str) -> str:
    """``host:port`` of ``host``, ``host:port``, ``[IPV6]:port`` or ``socket://host:port``.

    Anything else is a ConfigurationError.
    """
    found = _ADDRESS.fullmatch(text.strip())
    port = int(found[2] or DEFAULT_PORT) if found is not None else 0
    if found is None or not 0 < port < 65536:
        raise ConfigurationError(
            f"{text!r} is no address of Hamlib's rotctld: give host or host:{DEFAULT_PORT}; for a "
            "rotator on this computer start rotctld -m MODEL -r DEVICE first and give localhost"
        )
    return f"{found[1]}:{port}"


class _Waiting:
    """A request under way."""

    __slots__ = ("done", "reply")

    def __init__(self, reply: replies.ReplyReader) -> None:
        self.reply = reply
        self.done = False


class RotctldRotator(Rotator):
    """A ``Rotator`` behind rotctld."""

    def __init__(self, link_factory: Callable[[], Link], where: str) -> None:
        super().__init__(link_factory, where)
        self._broken = f"the line to {where} is not open; connect first"
        self._state = threading.Condition()
        self._waiting: deque[_Waiting] = deque()
        self._someone_reads = False

    # -- the line ------------------------------------------------------------------------------

    def open(self) -> RotatorIdentity:
        with self._turn:
            self.close()
            link = self._link_factory()
            with self._state:
                self._link, self._broken = link, ""
                self._waiting.clear()
            state = self._ask("dump_state")
            caps = self._ask("dump_caps")
            found = replies.identity(state, caps, self.where)
            # A rotctld whose rotator is switched off answers all the rest.
            self.position_deg()
            return found

    def close(self) -> None:
        self._give_up(f"the line to {self.where} is closed")

    # -- what it is asked and told -------------------------------------------------------------

    def position_deg(self) -> Direction:
        return replies.position(self._ask("get_pos"), self.where)

    def go_to(self, azimuth_deg: float, elevation_deg: float, stops: int) -> None:
        self._ask("set_pos", azimuth_deg, elevation_deg, stops=stops)

    def stop(self) -> None:
        try:
            self._interrupt("stop")
        except UnitRefused as refusal:
            if refusal.code not in CANNOT:
                raise
            self._ask("set_pos", *self.position_deg())

    def park(self) -> None:
        self._interrupt("park")

    # -- the conversation ----------------------------------------------------------------------

    def _ask(self, name: str, *arguments: float, stops: int | None = None) -> list[str]:
        with self._turn:
            return self._converse(name, arguments, stops, False)

    def _interrupt(self, name: str) -> None:
        self._converse(name, (), None, True)

    def _converse(
        self, name: str, arguments: tuple[float, ...], stops: int | None, interrupts: bool
    ) -> list[str]:
        waiting = _Waiting(replies.ReplyReader(name, self.where))
        self._send(waiting, replies.request(name, *arguments), stops, interrupts)
        self._await(waiting)
        trouble = waiting.reply.outcome()
        if trouble is not None:
            raise trouble
        return waiting.reply.lines

    def _send(self, waiting: _Waiting, line: bytes, stops: int | None, interrupts: bool) -> None:
        # The queue is within, too: replies come in the order of the writes.
        with self._guard.sending(stops, interrupts=interrupts):
            link = self._open_link()
            try:
                with self._state:
                    nobody_waits = not self._waiting and not self._someone_reads
                    self._waiting.append(waiting)
                # What is there already answers nothing: replies carry no number to tell them by.
                # A STOP goes out all the same.
                stray = link.read_line(0.0) if nobody_waits and not interrupts else None
                if stray is not None:
                    self._received(stray)
                    raise ProtocolError(f"{self.where} sent {_text(stray)!a} without a request")
                self._recent.append("> " + line.decode("ascii").rstrip())
                link.write(line)
            except LinkError as error:
                self._give_up(str(error))
                raise
            except KeyboardInterrupt:
                # Whether it went out is not known, nor which reply would be whose.
                self._give_up(f"a request to {self.where} was interrupted; connect again")
                raise

    def _open_link(self) -> Link:
        with self._state:
            if self._link is None:
                raise LinkError(self._broken)
            return self._link

    def _await(self, waiting: _Waiting) -> None:
        """Whoever waits while no thread reads, reads for all."""
        deadline = time.monotonic() + ANSWER_S
        with self._state:
            while not waiting.done:
                link = self._open_link()
                if self._someone_reads:
                    self._state.wait(max(deadline - time.monotonic(), 0.0))
                    if time.monotonic() >= deadline and not waiting.done:
                        raise LinkError(self._give_up(self._silence(waiting)))
                    continue
                self._someone_reads = True
                try:
                    self._state.release()
                    line = link.read_line(max(deadline - time.monotonic(), 0.0))
                except LinkError as error:
                    self._give_up(str(error))
                    raise
                finally:
                    try:
                        self._state.acquire()
                    finally:
                        # An interrupt here must not leave a line that nobody reads.
                        self._someone_reads = False
                    self._state.notify_all()
                if line is None:
                    raise LinkError(self._give_up(self._silence(waiting)))
                self._hand_over(line)

    def _hand_over(self, line: bytes) -> None:
        """A line belongs to the oldest request that has no whole reply yet."""
        try:
            self._received(line)
            if not self._waiting:
                raise ProtocolError(f"{self.where} sent {line[:60]!a} without a request")
            oldest = self._waiting[0]
            oldest.done = oldest.reply.feed(line)
        except (LinkError, ProtocolError) as error:
            self._give_up(str(error))
            raise
        if oldest.done:
            self._waiting.popleft()

    def _silence(self, waiting: _Waiting) -> str:
        return (
            f"no answer from rotctld at {self.where} to {waiting.reply.name} within "
            f"{ANSWER_S:g} s; check that it runs, and that the rotator is on"
        )

    def _give_up(self, reason: str) -> str:
        """Discard everything that still comes on this connection; returns the reason."""
        with self._state:
            link, self._link = self._link, None
            if link is not None or not self._broken:
                self._broken = reason
            self._waiting.clear()
            self._state.notify_all()
        if link is not None:
            link.close()
        return reason


def _text(line: bytes) -> str:
    return line[:60].decode("ascii", "backslashreplace")
