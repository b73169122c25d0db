"""The form for a site, unit and operator profile; kept as TOML in the config folder."""

from typing import ClassVar

import msgspec
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.widgets import Input, Select, Static

from solarcal.errors import SolarcalError
from solarcal.profile_form import FIELDS, FieldError, form_texts, profile_from_form
from solarcal.profiles import Profile, load_profile, profile_names, save_profile
from solarcal.tui.base import StationModal
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, LogLine


class _Rows(VerticalScroll, inherit_bindings=False):
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
        with _Rows(can_focus=False):
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
        app.remember(msgspec.structs.replace(app.settings, profile=profile.name))
        self.dismiss(True)
