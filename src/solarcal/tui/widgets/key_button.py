"""A key as a target for mouse or finger: three rows high, the key in its frame."""

from dataclasses import dataclass

from textual.binding import Binding
from textual.content import Content
from textual.widgets import Static


@dataclass(frozen=True, slots=True)
class DialogKey:
    """One thing a dialog can be told. ``action`` is the screen's; the first key is shown."""

    action: str
    label: str
    keys: str
    shown: str
    button: bool = True

    def binding(self) -> Binding:
        return Binding(self.keys, self.action, self.label, show=False)


class KeyButton(Static):
    """Shows a key and what it does; a click does it too. Never takes the focus from a field."""

    DEFAULT_CSS = """
    KeyButton {
        width: auto; height: 3; padding: 0 1; margin-right: 1; border: round $primary;
        border-title-color: $accent; border-title-style: bold; content-align: center middle;
    }
    KeyButton:hover { background: $primary; color: $background; }
    KeyButton.-stop { border: heavy $error; color: $error; text-style: bold; }
    KeyButton.-stop:hover { background: $error; color: $background; }
    """

    def __init__(self, shown: str, label: str, action: str, *, stop: bool = False) -> None:
        # A frame's title needs the room for the key and its corners.
        super().__init__(Content(label.center(len(shown) + 2)))
        self.border_title = shown
        self.runs = action
        self.set_class(stop, "-stop")

    async def on_click(self) -> None:
        await self.app.run_action(self.runs, default_namespace=self.screen)
