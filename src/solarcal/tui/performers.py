"""What each action of the workstation does: the screen it opens, or why it does not.

The modules of the screens are imported when their key is first pressed, so that the first paint
does not wait for them.
"""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from solarcal.tui.workstation_actions import WORKSTATION_PERFORMERS

if TYPE_CHECKING:
    from solarcal.tui.app import SolarcalApp

Performer = Callable[["SolarcalApp"], None]

_OPENERS = {
    "link": "link",
    "initialise": "initialise",
    "ref_check": "ref_check",
    "sun_offset": "sun_offset",
    "take_point": "take_point",
    "upload": "upload",
    "recompute": "recompute",
    "clock": "clock",
    "plan": "plan",
    "report": "report",
    "void": "void_note:open_void",
    "note": "void_note:open_note",
    "calculators": "calculators:open_list",
}
"""Action id to module of ``solarcal.tui.screens`` and, after a colon, its function (``open``)."""


def _opener(place: str) -> Performer:
    module, _, function = place.partition(":")

    def perform(app: "SolarcalApp") -> None:
        screens = import_module(f"solarcal.tui.screens.{module}")
        getattr(screens, function or "open_screen")(app)

    return perform


PERFORMERS: dict[str, Performer] = {
    **{name: _opener(place) for name, place in _OPENERS.items()},
    **WORKSTATION_PERFORMERS,
}
