"""Steps that are done at a unit's own keys: what the unit did is typed, not read over a line."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solarcal.tui.app import SolarcalApp


def by_hand(app: "SolarcalApp") -> bool:
    """Whether the connected unit is one whose display is read by a person."""
    return not app.state.live.capabilities.has_link
