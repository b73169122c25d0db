"""The field calculators: their list, and of each its form, its result, its drawings."""

from functools import partial
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.content import Content
from textual.timer import Timer
from textual.widgets import Input, OptionList
from textual.widgets.option_list import Option

from solarcal.errors import SolarcalError
from solarcal.instruments.catalogue import BY_ID, INSTRUMENTS
from solarcal.instruments.form import Answer, Drawing, FormError, Instrument
from solarcal.timescale import SystemClock
from solarcal.tui.base import StationScreen, Workstation, show_once
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.form_rows import ChoiceBox, FormRow, FormRows
from solarcal.tui.widgets.lines import Choices, HeadLine, LogLine
from solarcal.tui.widgets.plot import AnsiPlot
from solarcal.tui.widgets.text_lines import TextLines

TYPING_PAUSE_S = 0.3
"""How long nothing must be typed before what stands there is computed."""


class CalculatorScreen(StationScreen):
    """Computes on a thread whenever the form has changed; what was typed is remembered.

    ``Ctrl+N`` shows, one after the other, everything, each drawing alone and the text alone.
    """

    DEFAULT_CSS = """
    CalculatorScreen { overflow: hidden; }
    CalculatorScreen #top { height: 1fr; min-height: 10; }
    CalculatorScreen #result {
        height: auto; max-height: 40%; min-height: 4; border-top: solid $faint;
    }
    CalculatorScreen.-drawing FormRows, CalculatorScreen.-drawing #result { display: none; }
    CalculatorScreen.-text #top { display: none; }
    CalculatorScreen.-text #result { height: 1fr; max-height: 100%; border-top: none; }
    CalculatorScreen.-wide FormRows { width: 52; }
    CalculatorScreen.-wide FormRows .label { width: 24; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        # Priority: a field takes every letter, so what is done beside one needs another key.
        Binding("ctrl+n", "view", "View", show=False, priority=True),
        Binding("v", "view", "View", show=False, id="next_plot"),
        Binding("pagedown", "scroll_result(1)", "Result down", show=False),
        Binding("pageup", "scroll_result(-1)", "Result up", show=False),
        Binding("ctrl+r", "defaults", "Defaults", show=False),
        # Priority: what is typed right after the arrow belongs into the next field.
        Binding("down", "next_field", "Next field", show=False, priority=True),
        Binding("up", "previous_field", "Previous field", show=False, priority=True),
        Binding("enter", "compute", "Compute", show=False),
        Binding("escape", "back", "Back", show=False),
    ]

    def __init__(self, calculator: Instrument) -> None:
        super().__init__()
        self.calculator = calculator
        self.answer: Answer | None = None
        self._pause: Timer | None = None
        self._view = 0
        self._typed: dict[str, str] = {}

    def compose(self) -> ComposeResult:
        # Beside a field a letter would be typed into it.
        keys = self.workstation.keys_of("calculators").split()
        list_key = next((key for key in keys if len(key) > 1), keys[0])
        yield HeadLine(id="title")
        with Horizontal(id="top"):
            yield FormRows(self.calculator.rows, self._first_values())
            yield AnsiPlot(id="drawing")
        yield TextLines(id="result", wrap=True)
        yield LogLine(id="log")
        yield ActionFooter(
            [
                FooterEntry("↵", "Compute", "screen.compute"),
                FooterEntry("^N", "View", "screen.view"),
                FooterEntry("PgDn", "More", "screen.scroll_result(1)"),
                FooterEntry("^R", "Reset", "screen.defaults"),
                FooterEntry(list_key, "List", "app.perform('calculators')"),
                FooterEntry("F1", "Help", "app.perform('help')"),
                FooterEntry("Esc", "Back", "screen.back"),
            ]
        )

    def on_mount(self) -> None:
        one = self.calculator
        self.query_one("#title", HeadLine).show([f"{one.group}: {one.title}"], [one.purpose])
        self.query_one(FormRow).entry.focus()
        self.action_compute()

    def on_unmount(self) -> None:
        if self._typed:
            self._remember()

    def on_resize(self) -> None:
        self.set_class(self.app.size.width >= 120, "-wide")
        if self.answer is not None:
            self.call_after_refresh(self._show_answer)

    # -- what stands in the fields -----------------------------------------------------------

    def _defaults(self) -> dict[str, str]:
        """Of the form, with the place of the open session or of the profile."""
        values = {field.name: field.first_text for field in self.calculator.rows}
        session = self.workstation.state.session
        site = session.header.site if session is not None else self.workstation.profile.site
        if site is not None and "lon" in values:
            values |= {
                "lat": f"{site.latitude_deg:g}",
                "lon": f"{site.longitude_deg:g}",
                "elevation": f"{site.elevation_m:g}",
            }
        return values

    def _first_values(self) -> dict[str, str]:
        values = self._defaults()
        kept = self.workstation.settings.calculators.get(self.calculator.id, {})
        return values | {name: text for name, text in kept.items() if name in values}

    def _remember(self) -> None:
        """Keep what differs from the defaults: those may change with the profile."""
        app, defaults = self.workstation, self._defaults()
        kept = {name: text for name, text in self._typed.items() if text != defaults[name]}
        settings = app.settings.with_calculator(self.calculator.id, kept)
        if settings != app.settings:
            app.remember(settings)

    # -- computing ---------------------------------------------------------------------------

    def on_input_changed(self, event: Input.Changed) -> None:
        event.stop()
        self._compute_soon()

    def on_choice_box_changed(self, event: ChoiceBox.Changed) -> None:
        event.stop()
        self._compute_soon()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        event.stop()
        self.action_compute()
        self._remember()

    def _compute_soon(self) -> None:
        self._typed = self.query_one(FormRows).values()
        if self._pause is not None:
            self._pause.stop()
        self._pause = self.set_timer(TYPING_PAUSE_S, self.action_compute)

    def action_compute(self) -> None:
        """Compute what stands in the form."""
        if self._pause is not None:
            self._pause.stop()
            self._pause = None
        self._typed = self.query_one(FormRows).values()
        form = self.calculator.form(self._typed, self._now_utc_s())
        self.compute(partial(self.calculator.answer, form), self._answered, self._refused)

    def _now_utc_s(self) -> float:
        """The session's time where a unit is connected: an emulated one has its own."""
        app = self.workstation
        laptop = app.state.live.laptop_utc_s if app.worker is not None else None
        return SystemClock().utc_s() if laptop is None else laptop

    def _answered(self, answer: Answer) -> None:
        self.answer = answer
        self.query_one(FormRows).mark_wrong(None)
        self.say_on_line("Arrow keys: fields, choices. PgDn: more result. ^N: enlarge. Esc: back.")
        self._show_answer()

    def _refused(self, error: SolarcalError) -> None:
        # A result that belongs to other values must not stay.
        self.answer = None
        self.query_one(FormRows).mark_wrong(error.field if isinstance(error, FormError) else None)
        missing = isinstance(error, FormError) and error.missing
        self.say_on_line(f"{error}; type it" if missing else str(error), error=not missing)
        self._show_answer()

    # -- showing -----------------------------------------------------------------------------

    @property
    def drawings(self) -> tuple[Drawing, ...]:
        return self.answer.drawings if self.answer is not None else ()

    def _show_answer(self) -> None:
        views = ["all", *(f"drawing{number}" for number in range(len(self.drawings))), "text"]
        self._view %= len(views)
        view = views[self._view]
        self.set_class(view.startswith("drawing"), "-drawing")
        self.set_class(view == "text", "-text")
        at = int(view.removeprefix("drawing")) if view.startswith("drawing") else 0
        plot = self.query_one("#drawing", AnsiPlot)
        plot.show(self.drawings[at].draw if self.drawings else lambda sheet: "")
        self.query_one(TextLines).show(self.answer.lines if self.answer else ["no result"])

    def action_scroll_result(self, pages: int) -> None:
        """The form keeps the focus."""
        result = self.query_one(TextLines)
        result.scroll_relative(y=pages * max(1, result.size.height - 1), animate=False)

    def action_view(self) -> None:
        self._view += 1
        self._show_answer()
        if self.has_class("-text"):
            self.query_one(TextLines).focus()
        elif not self.has_class("-drawing"):
            self.query_one(FormRow).entry.focus()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Where the form is away the arrow keys scroll the text."""
        del parameters
        return not (action.endswith("_field") and self._view)

    def action_next_field(self) -> None:
        self.focus_next()

    def action_previous_field(self) -> None:
        self.focus_previous()

    def action_defaults(self) -> None:
        """Everything as it was at first."""
        self.query_one(FormRows).fill(self._defaults())
        self.action_compute()

    def action_back(self) -> None:
        """From an enlarged view to everything, from there out."""
        if self._view:
            self._view = -1
            self.action_view()
        else:
            self.dismiss(None)


class CalculatorsScreen(StationScreen):
    """Choose with the arrow keys, open with Enter; Escape goes back."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape,q", "back", "Back", show=False)]

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield Choices(id="calculators")
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
        self.say_on_line("Choose with the arrow keys, open with Enter.")
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


def open_list(app: Workstation) -> None:
    """Show the list; from a calculator go back to it."""
    if isinstance(app.screen, CalculatorScreen):
        app.screen.dismiss(None)
    show_once(app, CalculatorsScreen, CalculatorsScreen)


def open_calculator(app: Workstation, calculator: Instrument) -> None:
    """Show a calculator, in place of another one that is open."""
    screen = CalculatorScreen(calculator)
    if isinstance(app.screen, CalculatorScreen):
        app.switch_screen(screen)
    else:
        app.push_screen(screen)
