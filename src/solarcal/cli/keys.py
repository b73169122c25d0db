"""``solarcal keys``: what this terminal sends for a key, and which action it would be."""

import argparse
import os
import select
import sys
from collections.abc import Iterator

from solarcal.cli.process import print_json
from solarcal.config import load_keymap
from solarcal.errors import ConfigurationError

_KITTY_ON, _KITTY_OFF = "\x1b[>1u", "\x1b[<u"
"""As the workstation asks for it, so that the same bytes come."""

_QUIET_S = 0.05
"""Bytes of one key come together; after this silence a lone ESC is the key itself."""

_SCO_KEYS = {b"\x1b[" + bytes((code,)): f"F{n}" for n, code in enumerate(b"MNOPQRSTUVWX", 1)}
"""What PuTTY sends for F1 to F12 with its setting "SCO"; four of them are other keys elsewhere."""
_AMBIGUOUS = (b"\x1b[P", b"\x1b[Q", b"\x1b[R", b"\x1b[S")
_SCO_HINT = "SCO {key}: in PuTTY set Terminal > Keyboard > The Function keys and keypad to Xterm R6"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--headless", action="store_true", help="only print the table of keys")
    parser.add_argument("--json", action="store_true", help="the table as one JSON document")


def run(args: argparse.Namespace) -> int:
    """Print the table; in a terminal then listen."""
    from solarcal.tui.keys import bound_actions, checked_keymap

    actions = bound_actions(checked_keymap(load_keymap()))
    if args.json:
        print_json(
            {
                "actions": [
                    {"id": a.id, "label": a.label, "keys": list(a.keys), "tooltip": a.tooltip}
                    for a in actions
                ]
            }
        )
        return 0
    print(f"{'action':12} {'keys':22} what it does")
    for action in actions:
        print(f"{action.id:12} {action.shown:22} {action.tooltip}")
    if args.headless or not (sys.stdin.isatty() and sys.stdout.isatty()):
        return 0
    print("\nPress keys to see what the terminal sends; q twice ends.\n")
    _listen(actions)
    return 0


def _listen(actions: "tuple[object, ...]") -> None:
    before = ""
    print(f"{'bytes':30} {'key':16} action", flush=True)
    for data in _keystrokes():
        for key, line in read_keys(data, actions):
            print(line, end="\r\n", flush=True)
            if key == before == "q":
                return
            before = key


def read_keys(data: bytes, actions: "tuple[object, ...]") -> Iterator[tuple[str, str]]:
    """What the workstation makes of these bytes: key names, each with a line that says so."""
    from textual import events
    from textual._xterm_parser import XTermParser

    from solarcal.tui.keys import action_for, modified_f3

    readable = "".join(chr(b) if 32 < b < 127 else "ESC" if b == 27 else "·" for b in data)
    sent = f"{data.hex(' ')}  {readable}"
    if data in _SCO_KEYS and data not in _AMBIGUOUS:
        yield "", f"{sent:30} {'no key':16} {_SCO_HINT.format(key=_SCO_KEYS[data])}"
        return
    parser = XTermParser()
    told = [*parser.feed(data.decode("utf-8", errors="replace")), *parser.feed("")]
    nothing = True
    for event in told:
        if isinstance(event, events.Key):
            key = event.key
        elif isinstance(event, events.CursorPosition):
            key = modified_f3(event.y + 1, event.x + 1) or ""
        else:
            continue
        nothing = False
        action = action_for(key, actions)  # type: ignore[arg-type]
        meaning = f"{action.label} ({action.id})" if action is not None else "nothing"
        yield key, f"{sent:30} {key or 'no key':16} {meaning}"
    if nothing:
        yield "", f"{sent:30} {'no key':16} nothing"


def _keystrokes() -> Iterator[bytes]:
    """The bytes of each key, from the terminal in raw mode."""
    try:
        import termios
        import tty
    except ImportError:
        raise ConfigurationError(
            "this system's terminal cannot be read byte by byte; the table above is complete"
        ) from None
    descriptor = sys.stdin.fileno()
    kept = termios.tcgetattr(descriptor)
    try:
        tty.setraw(descriptor)
        sys.stdout.write(_KITTY_ON)
        sys.stdout.flush()
        while True:
            data = os.read(descriptor, 64)
            while select.select([descriptor], [], [], _QUIET_S)[0]:
                more = os.read(descriptor, 64)
                if not more:
                    break
                data += more
            if not data or data == b"\x03":
                return
            yield data
    finally:
        sys.stdout.write(_KITTY_OFF)
        sys.stdout.flush()
        termios.tcsetattr(descriptor, termios.TCSADRAIN, kept)
