"""A reference check at the unit's own keys; the counts its display showed are typed."""

from collections.abc import Iterable
from typing import ClassVar

from textual.widget import Widget
from textual.widgets import Static

from solarcal.errors import SolarcalError
from solarcal.report.tables import ref_checks_table
from solarcal.session.records import RefCheck
from solarcal.station.state import StationState
from solarcal.tui.screens.dialog import Dialog
from solarcal.tui.screens.ref_check import SHOWN_CHECKS, ref_check_words
from solarcal.tui.widgets.key_button import DialogKey

CHECK = "ref_check"


class HandRefCheckDialog(Dialog):
    """The checks so far; the next one is done at the unit, and typed."""

    HEADING = "Reference check, at the unit"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("type", "It is done: type it", "enter,y", "Enter y"),
    )

    DEFAULT_CSS = """
    HandRefCheckDialog #guide { height: auto; margin-bottom: 1; }
    HandRefCheckDialog #checks { height: auto; max-height: 9; }
    """

    def body(self) -> Iterable[Widget]:
        yield Static(
            "Start it at the unit (Alt-F5, or its RESET key) and watch BOTH axes reach their "
            "switches. Note the counts its display shows there, just before they become zero.",
            id="guide",
            markup=False,
        )
        yield Static("", id="checks")

    def on_mount(self) -> None:
        super().on_mount()
        self.say("When it has ended, Enter: type what it showed.")

    def state_changed(self, state: StationState) -> None:
        if state.session is not None:
            self.query_one("#checks", Static).update(
                ref_checks_table(state.session.ref_checks[-SHOWN_CHECKS:])
            )

    def action_type(self) -> None:
        self.offer()
        self.submit(CHECK, lambda station: station.ref_check())

    def step_done(self, name: str, result: object) -> None:
        super().step_done(name, result)
        if name == CHECK and isinstance(result, RefCheck):
            self.offer("type")
            session = self.station_app.state.session
            self.say(*ref_check_words(result, session.ref_checks if session is not None else ()))

    def step_failed(self, name: str, error: SolarcalError) -> None:
        super().step_failed(name, error)
        if name == CHECK:
            self.offer("type")
