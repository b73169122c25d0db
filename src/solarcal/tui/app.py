"""The workstation: its life, the line it opens, its keys."""

import asyncio
import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import msgspec
from textual import events
from textual.binding import BindingType
from textual.command import Provider
from textual.notifications import SeverityLevel
from textual.screen import Screen

from solarcal.config import Choice, Settings
from solarcal.errors import SolarcalError, harmless
from solarcal.profiles import Profile
from solarcal.station.news import StepFailed
from solarcal.tui.base import ONE_IMPORT, ShowsNotices, StationModal, is_typed, refusal_words
from solarcal.tui.keys import (
    ACTIONS,
    QUIT_EVERYWHERE,
    STOP_EVERYWHERE,
    Action,
    bound_actions,
    modified_f3,
)
from solarcal.tui.line_app import LineApp
from solarcal.tui.palette import (
    DEFAULT_THEME,
    SUNLIGHT,
    ActionProvider,
    OwnThemesFirst,
    Palette,
    axis_colours,
    begin_with_theme,
)
from solarcal.tui.start_screen import StartScreen

PRESS_STOP_S = 8.0
"""How long the notice stays that STOP is at the unit."""


class SolarcalApp(LineApp):
    """Choices become an open line, keys become what a handler does.

    Parameters
    ----------
    settings, profile, keymap : the user's; defaults without them.
    start : open this at once instead of asking.
    output, trace : the first session file; a transcript of the line.
    remember : write settings back to the config folder.

    Its attributes are those of ``LineApp``.
    """

    TITLE = "solarcal"
    CSS_PATH = "solarcal.tcss"
    ALLOW_SELECT = False
    """A double click or a drag marks no text. The styles of our screens have no colour for it, and
    Textual fails without one; with Shift the terminal's own marking copies."""
    COMMANDS: ClassVar[set[type[Provider] | Callable[[], type[Provider]]]] = {ActionProvider}
    """Without Textual's own provider: the palette lists what it has beside our actions."""

    BINDINGS: ClassVar[list[BindingType]] = [
        *(action.binding() for action in ACTIONS),
        STOP_EVERYWHERE,
        QUIT_EVERYWHERE,
    ]

    def __init__(
        self,
        *,
        settings: Settings | None = None,
        profile: Profile | None = None,
        keymap: Mapping[str, str] | None = None,
        start: Choice | None = None,
        output: Path | None = None,
        trace: str | None = None,
        remember: bool = False,
        offline: bool = False,
    ) -> None:
        super().__init__(settings, profile, output, trace, remember, offline)
        self.actions: tuple[Action, ...] = bound_actions(keymap or {})
        self._start = start
        self._keymap_given = dict(keymap or {})
        begin_with_theme(self, self.settings.theme)
        self._theme_before = self.theme if self.theme != SUNLIGHT.name else DEFAULT_THEME

    # -- life ----------------------------------------------------------------------------------

    def get_default_screen(self) -> Screen[Any]:
        return StartScreen()

    def notify(
        self,
        message: str,
        *,
        title: str = "",
        severity: SeverityLevel = "information",
        timeout: float | None = None,
        markup: bool = False,
    ) -> None:
        """On the line of the screen on top. Messages quote units, files and people: no markup."""
        del markup
        seconds = self.NOTIFICATION_TIMEOUT if timeout is None else timeout
        words = f"{title}. {message}" if title else message
        for screen in reversed(self.screen_stack):
            mounted = screen.is_mounted
            if isinstance(screen, ShowsNotices):
                # One that is still being put together shows it as soon as it can.
                show = screen.notice if mounted else partial(screen.call_later, screen.notice)
                show(words, severity, seconds)
                return

    def action_command_palette(self) -> None:
        """Ours has STOP on it. In the middle of a step it would begin another one: not there."""
        if isinstance(self.screen, StationModal):
            self.screen.palette_refused()
            return
        if not isinstance(self.screen, Palette):
            self.push_screen(Palette(id="--command-palette"))

    def search_themes(self) -> None:
        """The themes to choose from, those made for this program first."""
        self.push_screen(Palette(providers=[OwnThemesFirst], placeholder="Search for themes…"))

    def get_theme_variable_defaults(self) -> dict[str, str]:
        return axis_colours(self.current_theme.dark)

    def on_mount(self) -> None:
        self.theme_changed_signal.subscribe(self, lambda theme: self._theme_chosen(theme.name))
        if self._keymap_given:
            self.set_keymap(self._keymap_given)
        self.call_after_refresh(self._after_first_paint)

    def _after_first_paint(self) -> None:
        """What takes long to import is fetched while the technician reads the first screen."""
        threading.Thread(target=_prewarm, name="prewarm", daemon=True).start()
        if self._start is not None:
            self.open_choice(self._start)

    def change_theme(self) -> None:
        """To the one for the sun, or from it to the dark one it took the place of."""
        self.theme = SUNLIGHT.name if self.theme != SUNLIGHT.name else self._theme_before

    def _theme_chosen(self, name: str) -> None:
        if name != SUNLIGHT.name:
            self._theme_before = name
        if name != self.settings.theme:
            self.remember(msgspec.structs.replace(self.settings, theme=name))

    def alert(self, words: str) -> None:
        """Bell and terminal notification, for a person who does not look at the screen."""
        if not self.settings.alerts or self._driver is None:
            return
        self.bell()
        plain = harmless(words)
        self._driver.write(f"\x1b]9;solarcal: {plain}\x07\x1b]777;notify;solarcal;{plain}\x07")
        self._driver.flush()

    def switch_alerts(self) -> None:
        """Bell and notifications off, or on again; kept in the settings."""
        on = not self.settings.alerts
        self.remember(msgspec.structs.replace(self.settings, alerts=on))
        self.notify(f"Bell and notifications {'on' if on else 'off'}.")

    def leave_soon(self) -> None:
        """Begin to leave; the screens stay until file and line are closed."""
        self.run_worker(self.leave(), exit_on_error=True)

    async def leave(self) -> None:
        """Close file and line, and end the program. All acknowledged records are in the file."""
        self._leaving = True
        worker, line = self.worker, self.line
        if self._reader is not None:
            self._reader.close()
        if worker is not None:
            await asyncio.to_thread(worker.close)
        if self._fitter is not None:
            self._fitter.close()
        if line is not None:
            try:
                await asyncio.to_thread(line.close)
            except SolarcalError as error:
                self.exit(error.exit_code, message=f"solarcal: {error}")
                return
        # Initialised a second time the session has gone on in another file.
        path = self.session_path or (line.path if line is not None else None)
        self.exit(0, message=f"session file: {path}" if path is not None else None)

    def release(self) -> None:
        """After a crash of the program itself: free file and line; nothing is written."""
        if self.line is not None:
            self.line.resources.close()

    # -- keys to commands ----------------------------------------------------------------------

    def action_perform(self, action_id: str) -> None:
        """Do what a key, a click or the palette asked for."""
        if action_id == "stop":
            self._stop()
            return
        with ONE_IMPORT:
            from solarcal.tui.action_handlers import ACTION_HANDLERS

        handler = ACTION_HANDLERS.get(action_id)
        if handler is None:
            return
        try:
            handler(self)
        except SolarcalError as error:
            self.notify(refusal_words(self, error), severity="warning")
            self.tell(StepFailed(None, error))

    def _stop(self) -> None:
        if is_typed(self) or (self._reader is not None and self._reader.asking):
            self.notify(
                "There is no line to it: this program cannot stop it.",
                title="PRESS STOP ON THE UNIT",
                severity="error",
                timeout=PRESS_STOP_S,
            )
        if self.worker is not None:
            self.worker.stop_motion()

    async def action_quit(self) -> None:
        """Textual's own way out takes ours."""
        self.action_perform("quit")

    def on_cursor_position(self, event: events.CursorPosition) -> None:
        """Turn the report that is none back into the key it was."""
        key = modified_f3(event.y + 1, event.x + 1)
        if key is not None:
            self.simulate_key(key)

    def stop_keys(self) -> str:
        """The keys of STOP on a screen where nothing is typed, the user's letter among them."""
        stop = next(action for action in self.actions if action.stop)
        letters = [key for key in stop.shown.split() if len(key) == 1]
        return " ".join(["F12", *letters[:1], "^S"])

    def keys_of(self, action_id: str | None) -> str:
        """The keys of an action as bound now, for a sentence; the first two."""
        action = next((a for a in self.actions if a.id == action_id), None)
        return " ".join(action.shown.split()[:2]) if action is not None else ""


def _prewarm() -> None:
    """Import what the first plot and the first Sun need, part by part: a line may be opening."""
    with ONE_IMPORT:
        import erfa  # noqa: F401
    with ONE_IMPORT:
        import plotext  # noqa: F401
    with ONE_IMPORT:
        import solarcal.tui.workstation.view  # noqa: F401
