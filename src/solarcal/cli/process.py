"""The process of a command: what it prints and its streams can print, the signals that end it.

SIGTERM and SIGHUP end a command as Ctrl-C (SIGINT) does: what is open is closed, and nothing is
lost. A terminal that is gone ends it too: where the program is no child of its terminal the system
sends no hang-up when that is closed. It would then read an end of file for ever, as fast as it can,
and hold the unit's line and the session file. Everything recorded is on the disk already; the start
screen offers to go on.
"""

import argparse
import codecs
import contextlib
import io
import json
import os
import select
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TextIO

from solarcal.errors import ConfigurationError, one_line

if TYPE_CHECKING:
    from solarcal.instruments.form import Answer


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


def demand_streams() -> None:
    """Open streams that the program was started without (``>&-``).

    Nothing typed, words into nowhere, and a result that fails where it is written. Otherwise the
    next file opened becomes the standard output, and words for stderr go to stdout.
    """
    missing: list[object] = [sys.stdin, sys.stdout, sys.stderr]
    if missing[0] is None:
        sys.stdin = os.fdopen(os.open(os.devnull, os.O_RDONLY))
    if missing[1] is None:
        sys.stdout = os.fdopen(os.open(os.devnull, os.O_RDONLY), "w", encoding="utf-8")
    if missing[2] is None:
        sys.stderr = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8")


def let_go(*streams: TextIO) -> None:
    """Write nothing more to streams that fail.

    What a failed write leaves in a stream is written again when the interpreter ends. It fails
    again, and the program would end with the interpreter's own code for that (120).
    """
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        # A stream that is no file has nothing to let go of.
        with contextlib.suppress(OSError, ValueError, AttributeError):
            os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


AGAIN_S = 1.0
"""A signal asks again after so long as nothing comes of it. What it raises can be lost: raised in
a function that a library in C calls, it may be taken for an answer."""

DEFERRED_S = 0.05
"""A signal within an import asks again after so long, for a library in C that is interrupted while
it starts may crash. Within a ``__del__`` too: what is raised there is printed, and lost."""

GRACE_S = 5.0
"""A terminal that is gone may block whoever draws on it; the program ends all the same."""


class Ended(KeyboardInterrupt):
    """A signal asked the program to end; raised where it happened to be."""

    def __init__(self, number: int) -> None:
        super().__init__(f"ended by {signal.Signals(number).name}")
        self.exit_code = 128 + number


def _ending() -> tuple[signal.Signals, ...]:
    """Windows knows no hang-up."""
    names = ("SIGINT", "SIGTERM", "SIGHUP")
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


def end_by_signals() -> None:
    """Raise ``Ended`` in the main thread when the program is terminated or its terminal is gone,
    KeyboardInterrupt when it is interrupted.

    A signal that is ignored stays so (``nohup``).
    """
    for number in _ending():
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _raise_ended)


def _raise_ended(number: int, frame: FrameType | None) -> None:
    deferred = _within_import_or_del(frame)
    if number == signal.SIGINT and not deferred:
        # Who sent it sees whether it ends, and sends another one.
        raise KeyboardInterrupt
    wait_s = DEFERRED_S if deferred else AGAIN_S
    again = threading.Timer(wait_s, _ask_again, args=(number,))
    again.daemon = True
    again.start()
    if deferred:
        return
    # Closing must not be broken off by a second one.
    if not any(isinstance(error, KeyboardInterrupt) for error in _chain(sys.exc_info()[1])):
        raise Ended(number)


def _ask_again(number: int) -> None:
    """In the main thread: a signal raised in another one does not wake it from a wait."""
    main = threading.main_thread().ident
    if main is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main, number)
    else:
        signal.raise_signal(number)


def _within_import_or_del(frame: FrameType | None) -> bool:
    while frame is not None:
        code = frame.f_code
        if code.co_filename.startswith("<frozen importlib") or code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


@contextlib.contextmanager
def interrupts_prevail() -> Iterator[None]:
    """What fails because an interrupt broke it off is that interrupt.

    An interrupt that comes between two steps of a lock leaves it in a state that its end refuses.
    What is raised ``from`` something says itself what there is to say.
    """
    try:
        yield
    except Exception as error:
        for cause in _chain(error):
            if isinstance(cause, KeyboardInterrupt):
                raise cause from None
            if cause.__suppress_context__:
                break
        raise
    finally:
        interrupts_obeyed()


def interrupts_obeyed() -> None:
    """The program is about to end: the signal that asked for it need not ask again."""
    for number in _ending():
        if number != signal.SIGINT and signal.getsignal(number) is _raise_ended:
            signal.signal(number, signal.SIG_IGN)


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """An exception and those in whose handling it was raised."""
    while error is not None:
        yield error
        error = error.__context__


def let_go_of_terminal(code: int) -> int:
    """The exit code; after a hang-up nothing more is written to the terminal, which is gone."""
    if code == 128 + getattr(signal, "SIGHUP", 0):
        let_go(sys.stdout, sys.stderr)
    return code


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


TALLEST_CHART = 30
"""Rows of a drawing that takes a whole screen."""


def add_json_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def plain(value: Any) -> Any:
    """Numpy scalars and arrays as Python numbers, not-a-number as null, recursively.

    A byte of a file's name that is no UTF-8 is written out, as every sentence does it.
    """
    import numpy as np

    if isinstance(value, str):
        return value.encode(errors="backslashreplace").decode()
    if isinstance(value, dict):
        return {plain(str(key)): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def add_replace_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--replace", action="store_true", help="overwrite an existing file")


def refuse_to_replace(args: argparse.Namespace, target: str | Path | None) -> None:
    """Before anything is computed: a file that exists is overwritten only with ``--replace``."""
    if target is not None and Path(target).exists() and not args.replace:
        raise ConfigurationError(f"{target} exists already; give another name, or --replace")


def print_json(document: Any) -> None:
    """Exactly one JSON document on stdout."""
    json.dump(plain(document), sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")


def print_answer(answer: "Answer", as_json: bool) -> int:
    """The answer of a field calculator as a document or as text with its drawings; 0."""
    if as_json:
        print_json(answer.document)
        return 0
    from solarcal.report.scales import Sheet

    width, colour = terminal_size()
    screen = min(max(shutil.get_terminal_size((80, 24)).lines - 2, 20), TALLEST_CHART)
    for block in answer.blocks:
        if isinstance(block, str):
            print(block)
        else:
            print(block.draw(Sheet(width, block.height or screen, colour)))
    return 0


def say(sentence: str) -> None:
    """Progress for a person; stderr, so that stdout stays the result.

    A log that is full takes no words; the work goes on.
    """
    try:
        print(sentence, file=sys.stderr, flush=True)
    except BrokenPipeError:
        raise
    except OSError:
        let_go(sys.stderr)


def warn(warnings: Iterable[str]) -> None:
    """Each warning as a line of its own."""
    for warning in warnings:
        say(f"warning: {one_line(warning)}")


def terminal_size() -> tuple[int, bool]:
    """Columns for a drawing, and whether it may have colours."""
    columns = min(100, max(40, shutil.get_terminal_size((80, 24)).columns))
    return columns, sys.stdout.isatty()
