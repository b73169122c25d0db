"""The list of field calculators."""

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from solarcal.instruments.catalogue import BY_ID, INSTRUMENTS
from solarcal.instruments.form import Instrument
from solarcal.tui.base import StationScreen, Workstation
from solarcal.tui.calculators.screen import CalculatorScreen
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, LogLine


class CalculatorsScreen(StationScreen):
    """Choose with the arrow keys, open with Enter; Escape goes back."""

    DEFAULT_CSS = """
    CalculatorsScreen #title { background: $primary; color: $background; text-style: bold; }
    CalculatorsScreen OptionList {
        height: 1fr; padding: 0 1; background: $background;
        text-wrap: nowrap; text-overflow: ellipsis;
    }
    CalculatorsScreen OptionList, CalculatorsScreen OptionList:focus { border: none; }
    CalculatorsScreen OptionList > .option-list--option-highlighted { text-style: bold reverse; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,q", "back", "Back", show=False),
    ]

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield OptionList(id="calculators")
        yield LogLine(id="log")
        yield ActionFooter(
            [
                FooterEntry("↵", "Open", "screen.open"),
                FooterEntry("F1", "Help", "app.perform('help')"),
                FooterEntry("Esc", "Back", "screen.back"),
            ]
        )

    def on_mount(self) -> None:
        self.query_one("#title", HeadLine).show(
            ["Field calculators"], ["form in, result and drawing out"]
        )
        self.query_one("#log", LogLine).say("Choose with the arrow keys, open with Enter.")
        choices, group = self.query_one(OptionList), ""
        for one in INSTRUMENTS:
            if one.group != group:
                group = one.group
                choices.add_option(Option(Content.styled(group, "bold $accent"), disabled=True))
            choices.add_option(Option(Content(f"  {one.title:20} {one.purpose}"), id=one.id))
        choices.highlighted = 1
        choices.focus()

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        open_calculator(self.workstation, BY_ID[event.option.id or ""])

    def action_open(self) -> None:
        self.query_one(OptionList).action_select()

    def action_back(self) -> None:
        self.dismiss(None)


def open_list(app: Workstation) -> None:
    """Show the list; from a calculator go back to it."""
    if isinstance(app.screen, CalculatorScreen):
        app.screen.dismiss(None)
    if not any(isinstance(screen, CalculatorsScreen) for screen in app.screen_stack):
        app.push_screen(CalculatorsScreen())


def open_calculator(app: Workstation, calculator: Instrument) -> None:
    """Show a calculator, in place of another one that is open."""
    screen = CalculatorScreen(calculator)
    if isinstance(app.screen, CalculatorScreen):
        app.switch_screen(screen)
    else:
        app.push_screen(screen)
