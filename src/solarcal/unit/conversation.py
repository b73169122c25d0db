"""Requests and replies over one link: repeats, timeouts, and replies matched by sequence number.

Requests of several threads are serialised; ``STOP`` and ``STOW`` are not: they go out at once, past
a request that is still waiting for its reply.
"""

import math
import threading
import time
from collections import deque
from collections.abc import Callable

import msgspec

from solarcal.decimals import counted
from solarcal.errors import LinkError, ProtocolError, UnitRefused
from solarcal.unit.frames import (
    SEQUENCE_NUMBERS,
    Code,
    MalformedFrame,
    Reply,
    Request,
    decode_reply,
    encode_request,
)
from solarcal.unit.link import Link
from solarcal.unit.stop_guard import StopGuard

FRAMES_REMEMBERED = 100

TURNED_AWAY = b"# busy"
"""How a server that has a station already greets a second one."""


def refuse_if_turned_away(line: bytes, where: str) -> None:
    """LinkError where a server says that it has a station already."""
    if line.startswith(TURNED_AWAY):
        raise LinkError(f"{where} is in use by another station; close that one first")


class Timing(msgspec.Struct, frozen=True):
    """How long to wait and how often to repeat (``docs/protocol.md``, Timing).

    ``answer_s`` is twice what a unit may take. ``advance_s`` is for ``X ADVANCE``, which computes:
    so long in all, with a repeat every ``answer_s``. Damage comes with a reply at once and may be
    repeated often; silence costs a timeout each time.
    """

    answer_s: float = 1.0
    advance_s: float = 60.0
    repeats_after_silence: int = 3
    repeats_after_damage: int = 60


class _Waiting:
    """A request under way."""

    __slots__ = ("accepts", "damaged", "fault", "reply", "request")

    def __init__(self, request: Request, accepts: Callable[[Reply], bool] | None) -> None:
        self.request = request
        self.accepts = accepts
        self.reply: Reply | None = None
        self.damaged = False
        self.fault = ""


class Conversation:
    """One conversation over ``link`` with whatever answers at ``port`` (its name in messages)."""

    def __init__(self, link: Link, port: str, timing: Timing, last_seq: int = 0) -> None:
        self.port = port
        self.turn = threading.RLock()
        """Held by a thread whose requests must not be interleaved with those of others."""
        self.last_seq = last_seq
        self._link = link
        self._timing = timing
        self._state = threading.Condition()
        self._waiting: dict[int, _Waiting] = {}
        self._someone_reads = False
        self._understood = False
        self._echoes = False
        self._guard = StopGuard()
        self.recent: deque[str] = deque(maxlen=FRAMES_REMEMBERED)
        """The last frames as they went over the line, their own ``>`` and ``<`` in front."""

    def ask(self, verb: str, *arguments: str, answer_s: float | None = None) -> tuple[str, ...]:
        """Send a request, wait, and return the reply's fields.

        Raises
        ------
        UnitRefused
            The unit answered NO.
        LinkError
            No answer, or the line is gone.
        ProtocolError
            Answers came, but damaged every time.
        """
        with self.turn:
            return self._ask(verb, arguments, answer_s=answer_s)

    def command(self, verb: str, *arguments: str, moves: bool = False) -> tuple[str, ...]:
        """Ask what needs the unlock: when the unit says it is locked, unlock and ask anew.

        With ``moves``, raises ``ProcedureRefused`` when STOP or STOW went out before the unit took
        the request: one that was waiting, or was lost on the way, must not set the axes moving
        after a STOP.
        """
        stops = self._guard.stops if moves else None
        with self.turn:
            try:
                return self._ask(verb, arguments, stops=stops)
            except UnitRefused as refusal:
                if refusal.code != Code.LOCKED:
                    raise
            self._ask("UNLOCK", ())
            return self._ask(verb, arguments, stops=stops)

    def interrupt(self, verb: str) -> tuple[str, ...]:
        """Ask ``STOP`` or ``STOW``: at once, whatever else is waiting."""
        return self._ask(verb, (), interrupts=True)

    def open(self, nonce: str) -> None:
        """Begin: the reply must carry this nonce. One with another is left over from before."""
        with self.turn:
            self._ask(
                "OPEN", (nonce,), accepts=lambda reply: reply.refused or reply.fields == (nonce,)
            )

    def close(self) -> None:
        self._link.close()

    def _ask(
        self,
        verb: str,
        arguments: tuple[str, ...],
        *,
        answer_s: float | None = None,
        accepts: Callable[[Reply], bool] | None = None,
        stops: int | None = None,
        interrupts: bool = False,
    ) -> tuple[str, ...]:
        answer_s = self._timing.answer_s if answer_s is None else answer_s
        with self._state:
            self.last_seq = (self.last_seq + 1) % SEQUENCE_NUMBERS
            waiting = _Waiting(Request(self.last_seq, verb, arguments), accepts)
            self._waiting[waiting.request.seq] = waiting
        try:
            self._converse(waiting, answer_s, stops, interrupts)
        finally:
            with self._state:
                del self._waiting[waiting.request.seq]
        reply = waiting.reply
        assert reply is not None
        if reply.code is not None:
            raise UnitRefused(reply.code, reply.text, waiting.request.text)
        return reply.fields

    def _converse(
        self, waiting: _Waiting, answer_s: float, stops: int | None, interrupts: bool
    ) -> None:
        """Send, and repeat the same frame until a reply settles it."""
        frame = encode_request(waiting.request)
        # A long action is asked for again meanwhile: what is done already is answered from memory,
        # and a reply that was lost costs one short wait, not a long one.
        silences_borne = max(
            self._timing.repeats_after_silence, math.ceil(answer_s / self._timing.answer_s) - 1
        )
        answer_s = min(answer_s, self._timing.answer_s)
        damages = silences = 0
        self._send(frame, waiting.request, stops, interrupts)
        while True:
            self._await(waiting, answer_s)
            if waiting.reply is not None:
                return
            if waiting.fault:
                raise ProtocolError(waiting.fault)
            if waiting.damaged:
                damages += 1
                waiting.damaged = False
            else:
                silences += 1
            if damages > self._timing.repeats_after_damage:
                raise ProtocolError(self._damage_text(waiting.request, damages))
            if silences > silences_borne:
                if damages and not self._understood:
                    raise ProtocolError(self._damage_text(waiting.request, damages))
                if self._echoes and not self._understood:
                    raise LinkError(
                        f"{self.port} only repeats what is sent to it; check the wiring (a loop "
                        "plug, transmit and receive exchanged) and that the unit is on"
                    )
                raise LinkError(
                    f"no answer from {self.port} to {waiting.request.verb} "
                    f"({counted(silences, 'time')}, {answer_s:g} s each); check that the unit is "
                    "on, the cable and the port"
                )
            self._send(frame, waiting.request, stops, False)

    def _send(self, frame: bytes, request: Request, stops: int | None, interrupts: bool) -> None:
        given_up = f"{request.text} was given up: the unit was stopped or stowed"
        with self._guard.sending(stops, interrupts=interrupts, given_up=given_up):
            self.recent.append(_readable(frame))
            try:
                self._link.write(frame)
            except LinkError:
                self._hear_last_words()
                raise

    def _hear_last_words(self) -> None:
        """A server that turned us away has said so before it hung up."""
        while True:
            try:
                line = self._link.read_line(0.0)
            except LinkError:
                return
            if line is None:
                return
            if not self._understood:
                refuse_if_turned_away(line, self.port)

    def _await(self, waiting: _Waiting, answer_s: float) -> None:
        """Return when the request is settled, was damaged, or ``answer_s`` have passed.

        Whoever waits while no thread reads, reads for all: no thread of its own stands between the
        link and the one who asked.
        """
        deadline = time.monotonic() + answer_s
        with self._state:
            while waiting.reply is None and not waiting.fault:
                left_s = deadline - time.monotonic()
                if left_s <= 0.0:
                    return
                if self._someone_reads:
                    if waiting.damaged:
                        return
                    self._state.wait(left_s)
                    continue
                self._someone_reads = True
                line = None
                try:
                    self._state.release()
                    # Noise often breaks one reply into several lines: read what is there before
                    # repeating, or each piece would cost a repeat of its own.
                    line = self._link.read_line(0.0 if waiting.damaged else left_s)
                finally:
                    try:
                        self._state.acquire()
                    finally:
                        # An interrupt here must not leave a line that nobody reads.
                        self._someone_reads = False
                    self._state.notify_all()
                if line is None:
                    return
                self._hand_over(line)

    def _hand_over(self, line: bytes) -> None:
        """Give a reply to the request it answers; mark all as damaged when none can tell."""
        self.recent.append(_readable(line))
        if not self._understood:
            refuse_if_turned_away(line, self.port)
        if line.startswith(b">"):
            # Our own frame, from an adapter that hears what it sends, or from a plug that loops.
            self._echoes = True
            return
        try:
            reply = decode_reply(line)
        except MalformedFrame as error:
            self._fault(f"{self.port} breaks the protocol: {error}, with a right checksum")
            return
        except ProtocolError:
            reply = None
        if reply is None or reply.code == Code.DAMAGED:
            self._understood = self._understood or reply is not None
            for each in self._waiting.values():
                each.damaged = True
            return
        self._understood = True
        waiting = self._waiting.get(reply.seq) if reply.seq is not None else None
        if waiting is None or (waiting.accepts is not None and not waiting.accepts(reply)):
            return
        waiting.reply = reply

    def _fault(self, text: str) -> None:
        """Undamaged nonsense answers no request: repeating it would not help."""
        self._understood = True
        for each in self._waiting.values():
            each.fault = text

    def _damage_text(self, request: Request, damages: int) -> str:
        if self._understood:
            return (
                f"the line to {self.port} is too noisy: {counted(damages, 'frame')} of "
                f"{request.verb} arrived damaged; check cable, connectors and grounding"
            )
        return (
            f"{self.port} answers, but not in the SolarTrak protocol; "
            "check that it is the right port and driver, and the unit's baud rate"
        )


def _readable(frame: bytes) -> str:
    text = frame.decode("ascii", "backslashreplace").rstrip("\r\n")
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else "?" for c in text)
