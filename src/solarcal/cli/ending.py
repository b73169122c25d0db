"""SIGTERM and SIGHUP end a command as Ctrl-C does: what is open is closed, and nothing is lost."""

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType

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
