"""One-row lines every screen has: title, file, log."""

from textual.content import Content
from textual.widgets import Static

Part = str | tuple[str, str] | Content


class HeadLine(Static):
    """One row, parts on the left and on the right."""

    DEFAULT_CSS = """
    HeadLine {
        height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; padding: 0 1;
        link-color: $foreground; link-background: $panel; link-style: bold;
    }
    """

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._shown: tuple[list[Part], list[Part]] | None = None

    def on_resize(self) -> None:
        # What was cut to the old width may have room now.
        if self._shown is not None:
            self.show(*self._shown)

    def show(self, left: list[Part], right: list[Part] | None = None) -> None:
        self._shown = (left, right or [])
        start, end = Content.assemble(*left), Content.assemble(*(right or []))
        # Not the size of this widget: before the first layout it has none.
        room = max(self.app.size.width - 2, 20)
        gap = room - start.cell_length - end.cell_length
        if gap < 1:
            start = start.truncate(max(1, room - end.cell_length - 1), ellipsis=True)
            gap = 1
        self.update(Content.assemble(start, " " * gap, end), layout=False)


class LogLine(HeadLine):
    """The newest thing worth telling; an error stays until something else happens."""

    DEFAULT_CSS = """
    LogLine { background: $background; }
    LogLine.-error {
        background: $error; color: $background; text-style: bold;
        height: auto; max-height: 4; text-wrap: wrap; text-overflow: fold;
    }
    """

    def say(self, sentence: str, *, error: bool = False) -> None:
        self.set_class(error, "-error")
        self._shown = None
        if error:
            # An error is worth more than one row.
            self.update(Content(f"! {sentence}"))
        else:
            self.show([sentence])
