"""The lines that tell of the station: unit, mode and link; what to do next."""

from textual.content import Content
from textual.widgets import Static

from solarcal.station.next_step import NextStep, countdown_text
from solarcal.station.state import LinkState, StationState
from solarcal.tui.widgets.head_lines import HeadLine, Part


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
