"""Before the workstation: which unit, which emulated one, which session; and the profile form.

The last choice comes first. A profile is kept as TOML in the config folder.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from msgspec.structs import replace
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.widgets import Input, OptionList, Select, Static
from textual.widgets.option_list import Option

from solarcal import __version__
from solarcal.config import Choice
from solarcal.errors import SolarcalError
from solarcal.profile_form import FIELDS, FieldError, form_texts, profile_from_form
from solarcal.profiles import Profile, load_profile, profile_names, save_profile
from solarcal.station.news import StepFailed
from solarcal.tui.base import ONE_IMPORT, MenuEntriesFound, StationModal, StationScreen
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import Choices, HeadLine, LogLine
from solarcal.unit.drivers import DEFAULT_DRIVER, DRIVERS, ON_A_LINE, has_line

if TYPE_CHECKING:
    from solarcal.station.opening import UnfinishedSessions

REPLAYS_SHOWN = 20
FIRST_WORDS = "Choose with the arrow keys, open with Enter."
BY_HAND = ("A real SolarTrak: type what its display shows", Choice(driver="typed"))


class StartScreen(StationScreen):
    """A list to choose from; ports and sessions are looked up while it is already shown."""

    DEFAULT_CSS = """
    StartScreen #address { height: 1; }
    StartScreen #address Static { width: auto; padding: 0 1; }
    StartScreen #driver { text-style: bold; color: $accent; }
    StartScreen #address Input { width: 1fr; height: 1; border: none; padding: 0; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("e", "profile", "Profile", show=False),
        Binding("t", "theme", "Theme", show=False),
        Binding("a", "address", "Address", show=False),
        Binding("d", "driver", "Driver", show=False),
        Binding("escape", "leave_address", "Back", show=False),
    ]

    def __init__(self) -> None:
        super().__init__()
        self._choices: dict[str, Choice] = {}
        self._continue = Choice()
        self._of_unit: UnfinishedSessions | None = None
        self._driver = DEFAULT_DRIVER
        self._offers: Any = None

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield HeadLine(id="profile")
        yield Choices(id="choices")
        with Horizontal(id="address"):
            yield Static("Other line [a]:", markup=False)
            yield Input(placeholder=DRIVERS[DEFAULT_DRIVER].address, compact=True)
            yield Static("", id="driver", markup=False)
        yield LogLine(id="log")
        yield ActionFooter(
            [
                FooterEntry("↵", "Open", "screen.open"),
                FooterEntry("e", "Profile", "screen.profile"),
                FooterEntry("a", "Address", "screen.address"),
                FooterEntry("F9", "Recalc", "app.perform('recompute')"),
                FooterEntry("t", "Theme", "screen.theme"),
                FooterEntry("g", "Calcs", "app.perform('calculators')"),
                FooterEntry("F1", "Help", "app.perform('help')"),
                FooterEntry("^Q", "Quit", "app.perform('quit')"),
            ]
        )

    def on_mount(self) -> None:
        self.query_one("#title", HeadLine).show(
            [f"solarcal {__version__}"], ["calibrate a sun tracker"]
        )
        self.show_profile()
        self._use_driver(self.workstation.profile.driver)
        self.query_one(OptionList).focus()
        self.say_on_line(FIRST_WORDS)
        self.call_after_refresh(self.look_up)

    def show_profile(self) -> None:
        self.query_one("#profile", HeadLine).show([self.workstation.profile.summary()])

    def step_failed(self, failed: StepFailed) -> None:
        self.say_on_line(str(failed.error), error=True)

    # -- what there is to choose -------------------------------------------------------------

    def look_up(self) -> None:
        """Ports and saved sessions, on a thread: a slow disk must not hold the first paint."""
        self.run_worker(self._look_up, thread=True, exclusive=True, exit_on_error=False)

    def _look_up(self) -> None:
        with ONE_IMPORT:
            from solarcal.tui.menu_entries import menu_entries

        offers = menu_entries(self.workstation.settings)
        self.post_message(MenuEntriesFound(offers))

    def on_menu_entries_found(self, message: MenuEntriesFound) -> None:
        self._offers = message.offers
        self._offer(message.offers)

    def _use_driver(self, name: str) -> None:
        """How what is opened next is talked to; what is remembered keeps its own driver."""
        self._driver = name if name in ON_A_LINE else DEFAULT_DRIVER
        self.query_one("#driver", Static).update(f"Driver [d]: {self._driver}")
        self.query_one(Input).placeholder = DRIVERS[self._driver].address
        self._offer(self._offers)

    def _by_driver(self, entries: list[tuple[str, Choice]]) -> list[tuple[str, Choice]]:
        """With the session to go on with: an emulated tracker of the same truth takes over."""
        more = {"driver": self._driver, "session": self._continue.session}
        return [(words, replace(choice, **more)) for words, choice in entries]

    def _offer(self, offers: Any) -> None:
        choices = self.query_one(OptionList)
        kept = choices.highlighted
        choices.clear_options()
        self._choices = {}
        for heading, entries in self._sections(offers):
            if not entries:
                continue
            choices.add_option(Option(Content.from_markup("[b $accent]" + heading), disabled=True))
            for words, choice in entries:
                key = f"choice-{len(self._choices)}"
                self._choices[key] = choice
                choices.add_option(Option(Content(f"  {words}"), id=key))
        # What was highlighted before the look-up may have moved; the first is the likeliest.
        choices.highlighted = 1 if kept is None or kept <= 1 else min(kept, len(choices.options))

    def _sections(self, offers: Any) -> Iterator[tuple[str, list[tuple[str, Choice]]]]:
        app = self.workstation
        if app.offline:
            replays = offers.replays[:REPLAYS_SHOWN] if offers is not None else []
            heading = "Saved sessions: replay" if replays else "Saved sessions: none found"
            yield heading, replays or [("look again", Choice())]
            return
        if self._of_unit is not None:
            yield "Unfinished sessions of this unit: continue", self._of_unit.entries
            yield "Or begin anew", [("a new session file", self._of_unit.anew)]
            return
        if session := self._continue.session:
            name, (words, typed) = Path(session).name, BY_HAND
            ports = self._by_driver(offers.ports if offers is not None else [])
            scenarios = self._by_driver(offers.scenarios if offers is not None else [])
            scenarios.sort(key=lambda entry: not name.startswith(entry[1].scenario))
            by_hand = (words, replace(typed, session=session))
            yield f"On which line is the unit of {name}?", [*ports, by_hand]
            yield "It was an emulated tracker", scenarios
            return
        if offers is not None:
            yield "Unfinished sessions: continue", offers.unfinished
        last = app.settings.last
        if last is not None:
            yield "Last time", [(last.words(), last)]
        ports = self._by_driver(list(offers.ports)) if offers is not None else []
        if app.profile.port and has_line(app.profile.driver):
            mine = Choice(
                port=app.profile.port, driver=app.profile.driver, baudrate=app.profile.baudrate
            )
            ports.insert(0, (f"{app.profile.port}  as in the profile", mine))
        if not has_line(app.profile.driver):
            yield "No line at all, as in the profile", [BY_HAND]
        heading = "Serial ports" if ports else "Serial ports: none found"
        yield heading, ports or [("look again", Choice())]
        if has_line(app.profile.driver):
            yield "No line at all", [BY_HAND]
        if offers is not None:
            yield "Emulated trackers, to learn and to try", self._by_driver(offers.scenarios)
            yield "Saved sessions: replay", offers.replays[:REPLAYS_SHOWN]

    def offer_unfinished(self, found: "UnfinishedSessions") -> None:
        """The unit on the line asked for has sessions to go on with."""
        self._of_unit = found
        self._offer(self._offers)
        self.query_one(OptionList).highlighted = 1
        self.say_on_line(f"{found}. Escape: all choices.")

    # -- choosing ----------------------------------------------------------------------------

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        choice = self._choices.get(event.option.id or "")
        if choice is None:
            return
        if choice == Choice():
            self.look_up()
        elif choice.session and not (choice.port or choice.scenario or not has_line(choice.driver)):
            self._continue = choice
            self.say_on_line("Choose the line its unit is on. Escape: back to all choices.")
            self.look_up()
        else:
            self.workstation.open_choice(choice)

    def action_open(self) -> None:
        self.query_one(OptionList).action_select()

    def action_address(self) -> None:
        self.query_one(Input).focus()

    def action_leave_address(self) -> None:
        if self._continue.session or self._of_unit is not None:
            self._continue, self._of_unit = Choice(), None
            self.say_on_line(FIRST_WORDS)
            self.look_up()
        self.query_one(OptionList).focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        address = event.value.strip()
        if address:
            choice = Choice(
                port=address,
                driver=self._driver,
                baudrate=self.workstation.profile.baudrate,
                session=self._continue.session,
            )
            self.workstation.open_choice(choice)

    def action_driver(self) -> None:
        self._use_driver(ON_A_LINE[(ON_A_LINE.index(self._driver) + 1) % len(ON_A_LINE)])
        self.say_on_line(f"Driver {self._driver}: {DRIVERS[self._driver].summary}.")

    def action_profile(self) -> None:
        def changed(saved: bool | None) -> None:
            if saved:
                self.show_profile()
                self._use_driver(self.workstation.profile.driver)
                self.look_up()

        self.app.push_screen(ProfileScreen(self.workstation.profile), changed)

    def action_theme(self) -> None:
        self.app.search_themes()


class _ProfileRows(VerticalScroll, inherit_bindings=False):
    """Scrolls to the field with the focus: the arrow keys go to the next one."""


class ProfileScreen(StationModal[bool]):
    """One row a field; Ctrl+W or Enter in the last field saves, Escape changes nothing."""

    DEFAULT_CSS = """
    ProfileScreen { background: $background; }
    ProfileScreen VerticalScroll { height: 1fr; }
    ProfileScreen .row { height: 1; padding: 0 1; }
    ProfileScreen .row Static { width: 32; }
    ProfileScreen Input { width: 1fr; height: 1; border: none; padding: 0 1; }
    ProfileScreen Input.-wrong { background: $error 40%; text-style: bold; }
    ProfileScreen Select { width: 1fr; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+w", "save", "Save", show=False, priority=True),
        Binding("down", "app.focus_next", "Next field", show=False),
        Binding("up", "app.focus_previous", "Previous field", show=False),
    ]

    def __init__(self, profile: Profile) -> None:
        super().__init__()
        self._profile = profile

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        with _ProfileRows(can_focus=False):
            names = profile_names()
            if len(names) > 1:
                yield Select(
                    [(name, name) for name in names],
                    prompt="another saved profile ...",
                    compact=True,
                    id="saved",
                )
            texts = form_texts(self._profile)
            for name, label, hint in FIELDS:
                with Horizontal(classes="row"):
                    yield Static(label, markup=False)
                    yield Input(texts[name], placeholder=hint, id=name, compact=True)
        yield LogLine(id="log")
        yield ActionFooter(
            [FooterEntry("^W", "Save", "screen.save"), FooterEntry("Esc", "Back", "screen.leave")]
        )

    def on_mount(self) -> None:
        self.query_one("#title", HeadLine).show(
            ["Site, unit and operator"], ["Ctrl+W saves, Escape changes nothing"]
        )
        self.say_on_line("Empty fields are taken from the unit.")
        self.query_one("#name", Input).focus()

    def on_select_changed(self, event: Select.Changed) -> None:
        if not isinstance(event.value, str):
            return
        try:
            self._profile = load_profile(event.value)
            texts = form_texts(self._profile)
        except SolarcalError as error:
            self.say_on_line(str(error), error=True)
            return
        for name, text in texts.items():
            self.query_one(f"#{name}", Input).value = text

    def on_input_submitted(self, event: Input.Submitted) -> None:
        if event.input.id == FIELDS[-1][0]:
            self.action_save()
        else:
            self.app.action_focus_next()

    def action_save(self) -> None:
        texts = {name: self.query_one(f"#{name}", Input).value for name, _, _ in FIELDS}
        for name in texts:
            self.query_one(f"#{name}", Input).remove_class("-wrong")
        try:
            profile = profile_from_form(texts, self._profile)
            save_profile(profile)
        except SolarcalError as error:
            self.say_on_line(str(error), error=True)
            if isinstance(error, FieldError):
                wrong = self.query_one(f"#{error.field}", Input)
                wrong.add_class("-wrong")
                wrong.focus()
            return
        app = self.workstation
        app.profile = profile
        app.remember(replace(app.settings, profile=profile.name))
        self.dismiss(True)
