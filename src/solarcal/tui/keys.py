"""Every action of the workstation, once: its keys, its name, its words.

An action has the manual's chord where the manual has one, a plain F-key, a letter, a palette entry
and a clickable footer. Terminals and desktops swallow different chords: no action depends on one.
Nothing destructive is ever bound to ``escape``.
"""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, replace

from textual.binding import Binding

from solarcal.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class Action:
    """One thing the technician can ask for.

    ``keys`` are Textual key names, the one to show first; ``shown`` is how help writes them.
    ``stop`` actions work everywhere, at once.
    """

    id: str
    label: str
    keys: tuple[str, ...]
    shown: str
    tooltip: str
    stop: bool = False

    def binding(self) -> Binding:
        """The Textual binding; its id lets the user's keymap change it."""
        return Binding(
            ",".join(self.keys),
            f"perform('{self.id}')",
            self.label,
            show=False,
            tooltip=self.tooltip,
            id=self.id,
            key_display=self.shown.split()[0],
        )


@dataclass(frozen=True, slots=True)
class DialogKey:
    """One command of a dialog. ``action`` is the screen's; the first key is shown."""

    action: str
    label: str
    keys: str
    shown: str
    button: bool = True

    def binding(self) -> Binding:
        return Binding(self.keys, self.action, self.label, show=False)


ACTIONS: tuple[Action, ...] = (
    Action("help", "Help", ("f1", "question_mark"), "F1 ?", "The procedure and the keys"),
    Action("link", "Link", ("f2", "l", "L"), "F2 l", "The line to the unit: connect, reconnect"),
    Action(
        "initialise", "Initialise", ("f3", "i", "alt+f3"), "F3 i Alt+F3",
        "Begin the calibration in this data file (after a question; once per calibration)",
    ),
    Action("plan", "Plan", ("f4", "p"), "F4 p", "When to take the next points"),
    Action(
        "ref_check", "Ref check", ("f5", "r", "alt+f5"), "F5 r Alt+F5",
        "Drive to the reference switches and check the counts",
    ),
    Action("sun_offset", "Sun offset", ("f6", "o"), "F6 o", "Jog onto the Sun and set the offset"),
    Action(
        "take_point", "Take point", ("f7", "full_stop", "alt+f7", "decimal"), "F7 . Alt+F7",
        "Take a data point: three questions, a few seconds of gathering, store or not",
    ),
    Action("upload", "Upload", ("f8", "u"), "F8 u", "Load coefficients into the unit, verified"),
    Action(
        "recompute", "Recompute", ("f9", "c", "ctrl+f9"), "F9 c Ctrl+F9",
        "Compute and show another saved file (a there: by its path), without changing this session",
    ),
    Action("clock", "Clock", ("f10", "k"), "F10 k", "Laptop and unit clocks; set the unit's"),
    Action(
        "next_plot", "Next plot", ("v",), "v",
        "Errors, residuals, sky map, history of P1..P6, forecast of the year",
    ),
    Action("report", "Report", ("e",), "e", "Certificate and zip archive"),
    Action("void", "Void", ("x",), "x", "Strike a record, or restore it"),
    Action("note", "Note", ("n",), "n", "Write a remark into the session"),
    Action(
        "calculators", "Calculators", ("f11", "g"), "F11 g",
        "Field calculators: Sun, day, heliostat, mirrors, screwjack, sunspot device",
    ),
    Action("theme", "Light/dark", ("h",), "h", "Black on white for the sun, and back"),
    Action("alerts", "Alerts", ("m",), "m", "Bell and terminal notifications, off or on"),
    Action("faster", "Faster", ("plus",), "+", "Emulator: let time pass faster"),
    Action("slower", "Slower", ("minus",), "-", "Emulator: let time pass slower"),
    Action("skip", "Skip ahead", ("w",), "w", "Emulator: skip to when the next point is due"),
    Action("quit", "Quit", ("ctrl+q",), "^Q", "Leave; the session file is complete at any moment"),
    Action(
        "stop", "STOP", ("f12", "ctrl+s", "s"), "F12 s ^S",
        "Stop every motion now; on every screen, without asking", stop=True,
    ),
)  # fmt: skip

BY_ID = {action.id: action for action in ACTIONS}

STOP_EVERYWHERE = Binding(
    "f12,ctrl+s", "perform('stop')", "STOP", priority=True, show=False, id="stop_now"
)
"""Works with a text field focused and on modal screens; ``s`` only where nothing is typed."""

QUIT_EVERYWHERE = Binding("ctrl+q", "perform('quit')", "Quit", priority=True, show=False)
"""On modal screens too; asks where something is going on."""


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
                raise ConfigurationError("keymap.toml: escape always leaves a dialog")
            if key in STOP_KEYS and action_id != "stop":
                raise ConfigurationError(f"keymap.toml: {shown_key(key)} is always STOP")
            if key in given:
                raise ConfigurationError(
                    f"keymap.toml: {shown_key(key)} is assigned to {given[key]} and to {action_id}"
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
