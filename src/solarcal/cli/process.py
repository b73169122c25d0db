"""The process of a command: what its streams can print, and the signals that end it.

SIGTERM and SIGHUP end a command as Ctrl-C does: what is open is closed, and nothing is lost. A
terminal that is gone ends it too: where the program is no child of its terminal the system sends no
hang-up when that is closed. It would then read an end of file for ever, as fast as it can, and hold
the unit's line and the session file. Everything recorded is on the disk already; the start screen
offers to go on.
"""

import codecs
import io
import os
import select
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import TextIO

_NEAREST = str.maketrans("─╌│●○◆◇◈·░▒▓█°±–—", "--|*oxvX..:%#d+--")
_FRAME = range(0x2500, 0x2580)


def _nearest(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    missing = error.object[error.start : error.end].translate(_NEAREST)
    return "".join(_ascii(character) for character in missing), error.end


def _ascii(character: str) -> str:
    if character.isascii():
        return character
    # Corners and crossings of a frame.
    return "+" if ord(character) in _FRAME else "?"


def never_fail(stream: TextIO | None) -> None:
    """Let ``stream`` write "*" where its encoding has no dot, instead of ending in a traceback."""
    if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
        codecs.register_error("nearest", _nearest)
        stream.reconfigure(errors="nearest")


GRACE_S = 5.0
"""A terminal that is gone may block whoever draws on it; the program ends all the same."""


class Ended(KeyboardInterrupt):
    """A signal asked the program to end; raised where it happened to be."""

    def __init__(self, number: int) -> None:
        super().__init__(f"ended by {signal.Signals(number).name}")
        self.exit_code = 128 + number


def _ending() -> tuple[signal.Signals, ...]:
    """Windows knows no hang-up."""
    return tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))


def end_by_signals() -> None:
    """Raise ``Ended`` in the main thread when the program is terminated or its terminal is gone.

    A signal that is ignored stays so (``nohup``).
    """

    def end(number: int, frame: FrameType | None) -> None:
        del frame
        # Once: closing must not be broken off by a second one.
        for ending in _ending():
            signal.signal(ending, signal.SIG_IGN)
        raise Ended(number)

    for number in _ending():
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, end)


def leave_by_signals(leave: Callable[[int], object]) -> None:
    """Have ``leave`` called with the exit code, on a thread of its own.

    For a program whose main thread runs an event loop, which no exception may break: it leaves the
    loop, restores the terminal and closes what is open.
    """

    def end(number: int, frame: FrameType | None) -> None:
        del frame
        code = 128 + number
        threading.Thread(target=leave, args=(code,), name="leaving", daemon=True).start()
        last = threading.Timer(GRACE_S, os._exit, args=(code,))
        last.daemon = True
        last.start()

    for number in _ending():
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, end)


def end_with_terminal(descriptor: int) -> None:
    """Raise SIGHUP in this process when the terminal at ``descriptor`` is gone.

    Does nothing where the system has no ``poll`` or no hang-ups.
    """
    if not hasattr(select, "poll") or not hasattr(signal, "SIGHUP"):
        return
    watch = threading.Thread(
        target=_wait_for_hang_up, args=(descriptor,), name="terminal watch", daemon=True
    )
    watch.start()


def _wait_for_hang_up(descriptor: int) -> None:
    poll = select.poll()
    # No event is asked for: a hang-up and an error are told all the same, a key is not.
    poll.register(descriptor, 0)
    if poll.poll():
        os.kill(os.getpid(), signal.SIGHUP)
