"""The lines above and below the panes: title, file, what to do next, log."""

from textual.content import Content
from textual.widgets import Static

from solarcal.station.next_step import NextStep, countdown_text
from solarcal.station.state import LinkState, StationState

Part = str | tuple[str, str]


class HeadLine(Static):
    """One row, parts on the left and on the right."""

    DEFAULT_CSS = """
    HeadLine { height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; padding: 0 1; }
    """

    def show(self, left: list[Part], right: list[Part] | None = None) -> None:
        start, end = Content.assemble(*left), Content.assemble(*(right or []))
        # Not the size of this widget: before the first layout it has none.
        room = max(self.app.size.width - 2, 20)
        gap = room - start.cell_length - end.cell_length
        if gap < 1:
            start = start.truncate(max(1, room - end.cell_length - 1), ellipsis=True)
            gap = 1
        self.update(Content.assemble(start, " " * gap, end), layout=False)


class TitleLine(HeadLine):
    """The program, the unit, its mode, and the link."""

    DEFAULT_CSS = """
    TitleLine { background: $primary; color: $background; text-style: bold; }
    TitleLine.-lost { background: $error; color: $background; }
    """

    def show_state(self, state: StationState, *, replay: bool = False) -> None:
        live = state.live
        lost = live.link is LinkState.LOST
        self.set_class(lost, "-lost")
        unit = ""
        if live.identity is not None:
            unit = f"{live.identity.model} {live.identity.serial}"
        elif state.session is not None:
            unit = f"{state.session.header.unit.model} {state.session.header.unit.serial}"
        geometry = state.session.header.geometry if state.session is not None else ""
        mode = str(live.status.mode) if live.status is not None else ""
        link = {
            LinkState.CONNECTED: "● LINK OK",
            LinkState.LOST: "✖ LINK LOST",
            LinkState.CLOSED: "○ no link",
        }[live.link]
        name = "solarcal REPLAY" if replay else "solarcal"
        self.show(
            [f"{name}  {unit} {geometry}"], ["saved session" if replay else f"{mode}   {link}"]
        )


class NextLine(Static):
    """What to do next, with the key for it and the time left."""

    DEFAULT_CSS = """
    NextLine { height: 2; width: 1fr; padding: 0 1; background: $boost; }
    """

    def show_step(self, step: NextStep, key: str, utc_s: float | None) -> None:
        parts: list[Part] = [("▶ ", "bold $accent"), (step.sentence, "bold")]
        if key:
            parts.append((f"  [{key}]", "bold $footer-key-foreground"))
        left = step.countdown_s(utc_s)
        if left:
            parts.append((f"  due in {countdown_text(left)}", "$accent"))
        elif left is not None:
            parts.append(("  due NOW", "bold reverse $accent"))
        self.update(Content.assemble(*parts), layout=False)


class LogLine(HeadLine):
    """The newest thing worth telling; an error stays until something else happens."""

    DEFAULT_CSS = """
    LogLine { background: $background; }
    LogLine.-error { background: $error; color: $background; text-style: bold; }
    """

    def say(self, sentence: str, *, error: bool = False) -> None:
        self.set_class(error, "-error")
        # A long error matters more than one row: it is also shown as a notification.
        self.show([("! " if error else "") + sentence])
