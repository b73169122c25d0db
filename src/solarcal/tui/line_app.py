"""The line under the app: a choice becomes an open line or a replay, and what comes of that."""

import threading
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from solarcal.config import Choice, Settings, save_settings
from solarcal.errors import ConfigurationError, SolarcalError
from solarcal.profiles import Profile
from solarcal.tui.base import (
    ONE_IMPORT,
    FormAsked,
    LineFailed,
    LineNews,
    LineOpened,
    Told,
    raise_here,
)
from solarcal.tui.start_screen import StartScreen
from solarcal.tui.station_app import StationApp

if TYPE_CHECKING:
    from solarcal.station.opening import OpenLine
    from solarcal.station.typed.forms import AskedForm, WaitingDisplay


class LineApp(StationApp):
    """Opens what is chosen, on a thread, and remembers it.

    ``line``: the open line, else ``None``; and what ``StationApp`` has.
    """

    def __init__(
        self,
        settings: Settings | None,
        profile: Profile | None,
        output: Path | None,
        trace: str | None,
        remember: bool,
        offline: bool,
    ) -> None:
        super().__init__()
        self.line: OpenLine | None = None
        self.settings = settings or Settings()
        self.profile = profile or Profile()
        self._output, self._trace = output, trace
        self._remember = remember
        self.offline = offline
        """No unit and no emulator is opened: for pages of a browser, and for the desk."""
        self._opening = False
        self._reader: WaitingDisplay | None = None

    def remember(self, settings: Settings) -> None:
        """Keep settings, in the config folder too unless this run shall leave no trace."""
        self.settings = settings
        if not self._remember:
            return
        try:
            save_settings(settings)
        except ConfigurationError as error:
            self.notify(str(error), severity="warning")

    def open_choice(self, choice: Choice) -> None:
        """Open a unit or an emulated one, or replay a session."""
        if choice.replay:
            self._open_replay(choice)
        elif self.offline:
            self._tell_start(
                "this workstation is offline: it opens saved sessions only", error=True
            )
        elif self.line is not None or self._opening:
            self.notify("a unit is connected already; quit first", severity="warning")
        else:
            self._opening = True
            self._tell_start(f"opening {choice.words()} ...")
            arguments = (choice, self.profile)
            threading.Thread(
                target=self._open_in_thread, args=arguments, name="opening", daemon=True
            ).start()

    def _open_replay(self, choice: Choice) -> None:
        with ONE_IMPORT:
            from solarcal.station.saved_sessions import Replay
            from solarcal.tui.replay import ReplayScreen

        try:
            replay = Replay.open(Path(choice.replay))
        except SolarcalError as error:
            self._tell_start(str(error), error=True)
            return
        self.remember(msgspec.structs.replace(self.settings, last=choice))
        self.push_screen(ReplayScreen(replay, Path(choice.replay).name, choice.speed))

    def _open_in_thread(self, choice: Choice, profile: Profile) -> None:
        try:
            with ONE_IMPORT:
                from solarcal.emulated_units import open_choice

            line = open_choice(
                choice, profile, output=self._output, trace=self._trace, display=self.display_reader
            )
        except SolarcalError as error:
            self.post_message(Told(LineFailed(error)))
        except Exception as error:
            # A fault of the program: it ends with it, and does not say "opening" for ever.
            self.call_later(raise_here, error)
            raise
        else:
            self.post_message(Told(LineOpened(line)))

    @property
    def display_reader(self) -> "WaitingDisplay":
        """Where a person who reads a unit's display is asked."""
        if self._reader is None:
            with ONE_IMPORT:
                from solarcal.station.typed.forms import WaitingDisplay

            self._reader = WaitingDisplay(lambda asked: self.post_message(Told(FormAsked(asked))))
        return self._reader

    def line_told(self, news: LineNews) -> None:
        match news:
            case LineOpened(line):
                self._line_opened(line)
            case LineFailed(error):
                self._line_failed(error)
            case FormAsked(asked):
                self._form_asked(asked)

    def _form_asked(self, asked: "AskedForm") -> None:
        with ONE_IMPORT:
            from solarcal.tui.typed_form import DisplayFormScreen

        if self._leaving:
            asked.answer(None)
        elif not asked.done:
            self.push_screen(DisplayFormScreen(asked))

    def _line_failed(self, error: SolarcalError) -> None:
        with ONE_IMPORT:
            from solarcal.station.opening import UnfinishedSessions

        self._opening = False
        if isinstance(error, UnfinishedSessions):
            for screen in self.screen_stack:
                if isinstance(screen, StartScreen):
                    screen.offer_unfinished(error)
            return
        self._tell_start(str(error), error=True)

    def _line_opened(self, line: "OpenLine") -> None:
        with ONE_IMPORT:
            from solarcal.tui.workstation.screen import WorkstationScreen

        self._opening = False
        self.line = line
        self._output = None
        self.adopt(line.station)
        self.push_screen(WorkstationScreen(line.noticed))

    def file_opened(self, path: Path) -> None:
        """On which line each session was taken: after a crash it goes on there."""
        if self.line is None:
            return
        plain = msgspec.structs.replace(self.line.choice, session="")
        settings = msgspec.structs.replace(self.settings, last=plain)
        self.remember(settings.with_line(path, plain))

    def _tell_start(self, sentence: str, *, error: bool = False) -> None:
        for screen in self.screen_stack:
            if isinstance(screen, StartScreen):
                screen.say_on_line(sentence, error=error)
