"""What a key means: the user's keymap over the table of actions, and the lost Alt+F3.

Terminals send ``ESC[1;3R`` for Alt+F3, which Textual takes for a cursor-position report
(Textualize/textual#6242). A program that fills the screen never asks where the cursor is: a report
of row 1 can only be a modified F3, its column one more than the modifier bits.
"""

import difflib
from collections.abc import Mapping
from dataclasses import replace

from solarcal.errors import ConfigurationError
from solarcal.tui.bindings import ACTIONS, BY_ID, Action

SHIFT, ALT, CTRL = 1, 2, 4
_LOCKS = 64 | 128
_NAMES = {"full_stop": ".", "question_mark": "?", "plus": "+", "minus": "-", "decimal": "keypad ."}

STOP_KEYS = frozenset({"f12", "ctrl+s"})
"""Bound to STOP on every screen, whatever the keymap says."""


def modified_f3(row: int, column: int) -> str | None:
    """The key a cursor-position report really is, ``None`` if it may be a report.

    ``row`` and ``column`` count from one, as on the wire.
    """
    bits = (column - 1) & ~_LOCKS
    if row != 1 or not 1 < column <= 256 or not bits or bits & ~(SHIFT | ALT | CTRL):
        return None
    names = [name for bit, name in ((ALT, "alt"), (CTRL, "ctrl"), (SHIFT, "shift")) if bits & bit]
    return "+".join([*names, "f3"])


def shown_key(key: str) -> str:
    """A Textual key name as people write it."""
    if key in _NAMES:
        return _NAMES[key]
    parts = key.split("+")
    names = [part.upper() if len(part) > 1 and part[1:].isdigit() else part for part in parts]
    if names[0] == "ctrl" and len(names) == 2 and len(names[1]) == 1:
        return f"^{names[1].upper()}"
    return "+".join(
        name.capitalize() if name in ("alt", "ctrl", "shift") else name for name in names
    )


def checked_keymap(keymap: Mapping[str, str]) -> dict[str, str]:
    """The user's keymap, every mistake in it named.

    Raises
    ------
    ConfigurationError
        An unknown action, no key at all, a key given twice, or one that belongs to STOP.
    """
    given: dict[str, str] = {}
    for action_id, keys in keymap.items():
        if action_id not in BY_ID:
            near = difflib.get_close_matches(action_id, BY_ID, 1)
            hint = f"; did you mean {near[0]}?" if near else f"; there is: {', '.join(BY_ID)}"
            raise ConfigurationError(f"keymap.toml: no action {action_id!r}{hint}")
        names = [key.strip() for key in keys.split(",") if key.strip()]
        if not names:
            raise ConfigurationError(f"keymap.toml: {action_id} has no key")
        for key in names:
            if key == "escape":
                raise ConfigurationError("keymap.toml: escape only ever leaves a dialog")
            if key in STOP_KEYS and action_id != "stop":
                raise ConfigurationError(f"keymap.toml: {shown_key(key)} always is STOP")
            if key in given:
                raise ConfigurationError(
                    f"keymap.toml: {shown_key(key)} is given to {given[key]} and to {action_id}"
                )
            given[key] = action_id
    return {
        action_id: ",".join(key.strip() for key in keys.split(",") if key.strip())
        for action_id, keys in keymap.items()
    }


def bound_actions(keymap: Mapping[str, str]) -> tuple[Action, ...]:
    """The actions with the keys they have now: the keymap takes keys away from others."""
    taken = {key for keys in keymap.values() for key in keys.split(",")}
    actions = []
    for action in ACTIONS:
        if action.id in keymap:
            keys = tuple(keymap[action.id].split(","))
            if action.stop:
                keys += tuple(key for key in ("f12", "ctrl+s") if key not in keys)
        else:
            keys = tuple(key for key in action.keys if key not in taken)
        if keys == action.keys:
            actions.append(action)
        else:
            actions.append(replace(action, keys=keys, shown=" ".join(map(shown_key, keys))))
    return tuple(actions)


def action_for(key: str, actions: tuple[Action, ...] = ACTIONS) -> Action | None:
    """Which action a key is."""
    return next((action for action in actions if key in action.keys), None)
