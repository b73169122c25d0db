"""What a terminal too small for the program says, and the STOP it may have cut off."""

from typing import TYPE_CHECKING

from textual.screen import Screen
from textual.widgets import Static

if TYPE_CHECKING:
    from textual.geometry import Size

LEAST = (80, 24)
"""Columns and rows everything is laid out for."""


class TooSmall(Static):
    """One row on top; a click on it is a STOP, for STOP's own place may be out of sight."""

    DEFAULT_CSS = """
    TooSmall {
        dock: top; height: 1; width: 100%; background: $error; color: $background;
        text-style: bold; text-wrap: nowrap;
    }
    """

    async def on_click(self) -> None:
        await self.run_action("app.perform('stop')")


def say_if_too_small(screen: Screen[object], size: "Size") -> None:
    """Put the row there, or take it away."""
    there = screen.query(TooSmall)
    if size.width >= LEAST[0] and size.height >= LEAST[1]:
        there.remove()
        return
    words = f"STOP: F12 or here. {size.width}x{size.height}: make it {LEAST[0]}x{LEAST[1]}"
    if there:
        there.first().update(words)
    elif screen.is_mounted:
        screen.mount(TooSmall(words))
