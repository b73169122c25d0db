"""What a screen may use of the program, what the program calls on a screen, and its STOP.

And what comes to the app from other threads, as messages of its queue: that makes it safe.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar, cast

from textual.await_complete import AwaitComplete
from textual.binding import Binding, BindingType
from textual.dom import DOMNode
from textual.message import Message
from textual.message_pump import MessagePump
from textual.reactive import Reactive
from textual.screen import ModalScreen, Screen
from textual.widget import Widget

from solarcal.errors import SolarcalError
from solarcal.station.news import Done, FitReady, News, Progress, StateChanged, StepFailed
from solarcal.tui.behind import draw_behind
from solarcal.tui.widgets.lines import LogLine, say_if_too_small

if TYPE_CHECKING:
    from textual.geometry import Size
    from textual.notifications import SeverityLevel

    from solarcal.config import Choice, Settings
    from solarcal.model.analysis import Analysis
    from solarcal.profiles import Profile
    from solarcal.station.opening import OpenLine
    from solarcal.station.planning import PlanOptions
    from solarcal.station.state import StationState
    from solarcal.station.typed.forms import AskedForm
    from solarcal.station.worker import StationWorker
    from solarcal.tui.keys import Action
    from solarcal.tui.menu_entries import MenuEntries


Result = TypeVar("Result")
Computed = TypeVar("Computed")

ONE_IMPORT = threading.RLock()
"""Held by whoever imports a module that needs numpy, on whichever thread.

Numpy's modules import each other in a circle. Two threads that begin at once can each wait for a
module the other has half made; Python then hands out the half, the import fails, and numpy cannot
be imported a second time in the process. Nothing of it is imported before the first paint, so that
the first threads, and the first key, would begin at once.
"""


class Workstation(Protocol):
    """All that screens and action handlers use of the app.

    Attributes
    ----------
    worker : talks to the station while a line is open, else ``None``.
    line : the open line, else ``None``.
    fit : the newest fit; ``judgement`` is ``None`` while newer points are being fitted.
    offline : no unit and no emulator is opened.
    emulated_speed : virtual seconds a second of an emulated unit, ``None`` for a real one.
    """

    worker: "StationWorker | None"
    line: "OpenLine | None"
    fit: FitReady | None
    emulated_speed: float | None
    plan_options: "PlanOptions | None"
    settings: "Settings"
    profile: "Profile"
    actions: "tuple[Action, ...]"
    offline: bool

    @property
    def state(self) -> "StationState": ...
    @property
    def judgement(self) -> "Analysis | None": ...
    @property
    def silent_s(self) -> int: ...
    @property
    def session_name(self) -> str: ...
    @property
    def session_path(self) -> Path | None: ...
    @property
    def screen(self) -> Screen[Any]: ...
    @property
    def screen_stack(self) -> list[Screen[Any]]: ...

    def station_worker(self) -> "StationWorker": ...
    def plan_with(self, plan_options: "PlanOptions") -> None: ...
    def remember(self, settings: "Settings") -> None: ...
    def open_choice(self, choice: "Choice") -> None: ...
    def action_perform(self, action_id: str) -> None: ...
    def keys_of(self, action_id: str | None) -> str: ...
    def stop_keys(self) -> str: ...
    def change_theme(self) -> None: ...
    def search_themes(self) -> None: ...
    def leave_soon(self) -> None: ...
    def alert(self, words: str) -> None: ...
    def switch_alerts(self) -> None: ...
    def deliver_screenshot(self) -> str | None: ...
    def notify(
        self,
        message: str,
        *,
        title: str = "",
        severity: "SeverityLevel" = "information",
        timeout: float | None = None,
    ) -> None: ...
    def push_screen(
        self, screen: Screen[Any], callback: Callable[[Any], None] | None = None
    ) -> object: ...
    def switch_screen(self, screen: Screen[Any]) -> object: ...


def workstation_of(node: MessagePump) -> Workstation:
    """The app a screen or widget runs in. The only place that says which app it is."""
    return cast(Workstation, node.app)


def show_once(app: Workstation, kind: type[Screen[Any]], make: Callable[[], Screen[Any]]) -> None:
    """Show the screen of this kind: the one that is open, without those above it, or a new one."""
    if not any(isinstance(screen, kind) for screen in app.screen_stack):
        app.push_screen(make())
        return
    while not isinstance(app.screen, kind):
        app.screen.dismiss(None)


def is_typed(app: Workstation) -> bool:
    """Whether the connected unit is one whose display is read by a person."""
    return not app.state.live.capabilities.has_link


def refusal_words(app: Workstation, error: SolarcalError) -> str:
    """The message; with the keys of the action that is to come first, where there is one."""
    keys = app.keys_of(error.action)
    return f"{error} [{keys}]" if keys else str(error)


def raise_here(error: Exception) -> None:
    """A fault met on another thread, on the event loop: the program ends with it."""
    raise error


WARNED_S = 8.0
"""How long a warning stays."""


class ShowsNotices(DOMNode):
    """A screen with a line of its own for notices; nothing is covered by them."""

    def notice(self, sentence: str, severity: "SeverityLevel", seconds: float) -> None:
        """Show a notice for so long."""
        self.query(LogLine).first().notice(sentence, severity, seconds)

    def warn(self, sentence: str, severity: "SeverityLevel" = "warning") -> None:
        """A notice that takes the place of nothing that is asked."""
        self.notice(sentence, severity, WARNED_S)

    def say_on_line(self, sentence: str, *, error: bool = False, brief: bool = False) -> None:
        """On the line of the screen, until the next sentence; one that is ``brief`` in one row."""
        self.query_one("#log", LogLine).say(sentence, error=error, brief=brief)


class _StationHooks(ShowsNotices, Screen[Result]):
    """What every screen of the stack is called with, on the event loop, once it is mounted."""

    focused: Reactive[Widget | None] = Reactive(None, repaint=False)
    """As Textual's own, but only the widgets that lose and get the focus repaint themselves."""

    _asked_for = 0
    """How often something was to be computed."""

    @property
    def workstation(self) -> Workstation:
        return workstation_of(self)

    def dismiss(self, result: Result | None = None) -> AwaitComplete:
        """Leave, once: Textual takes away the screen on top, whichever that is by now."""
        if self.is_current:
            return super().dismiss(result)
        return AwaitComplete()

    def compute(
        self,
        work: Callable[[], Computed],
        show: Callable[[Computed], object],
        failed: Callable[[SolarcalError], object] = lambda error: None,
    ) -> None:
        """Do what takes long on a thread; what it returns goes to ``show``, here.

        Only the newest answer is shown, and none on a screen that was left meanwhile.
        """
        self._asked_for += 1
        number = self._asked_for

        def arrived(answer: Callable[[], object]) -> None:
            if number == self._asked_for and self.is_attached:
                answer()

        def run() -> None:
            try:
                answer = partial(show, work())
            except SolarcalError as error:
                answer = partial(failed, error)
            except Exception as error:
                # A fault of the program: it ends with it, and does not compute for ever.
                self.call_later(raise_here, error)
                raise
            self.call_later(arrived, answer)

        threading.Thread(target=run, name="computing", daemon=True).start()

    def on_mount(self) -> None:
        self.watch(self.app, "newest", self._newest_changed, init=False)
        self.watch(self.app, "fit", self._fit_changed, init=False)

    def _newest_changed(self) -> None:
        self.show_state(self.workstation.state)

    def _fit_changed(self) -> None:
        if (fit := self.workstation.fit) is not None:
            self.show_fit(fit)

    def on_screen_resume(self) -> None:
        # An older one may have been covered while the terminal changed.
        say_if_too_small(self.screen, self.screen.app.size)

    def show_size(self, size: "Size") -> None:
        """The terminal is this large now."""
        say_if_too_small(self.screen, size)

    def show_state(self, state: "StationState") -> None:
        """The station's newest state."""

    def show_fit(self, fit: FitReady) -> None:
        """The newest fit of the session."""

    def show_progress(self, progress: Progress) -> None:
        """How far a long step is."""

    def step_done(self, done: Done[Any]) -> None:
        """A step has returned; its kind says which, and carries what it returned."""

    def step_failed(self, failed: StepFailed) -> None:
        """A step was refused or failed."""


class StationScreen(_StationHooks[None]):
    """A full screen. Opaque: else Textual would draw those below it behind it, all of them."""

    DEFAULT_CSS = """
    StationScreen { background: $background; }
    """

    def action_back(self) -> None:
        """What Escape does where a screen binds it."""
        self.dismiss(None)


class StationModal(_StationHooks[Result], ModalScreen[Result]):
    """A dialog. ``escape`` leaves it and changes nothing; STOP works here too."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("s", "app.perform('stop')", "STOP", show=False, id="stop"),
        Binding("escape", "leave", "Back", show=False),
    ]

    def _render_content(self) -> None:
        if not draw_behind(self):
            super()._render_content()

    def palette_refused(self) -> None:
        """The palette was asked for, and does not open over a dialog."""

    def action_leave(self) -> None:
        self.dismiss(None)


@dataclass(frozen=True, eq=False)
class LineOpened:
    """A unit is connected and its session open."""

    line: "OpenLine"


@dataclass(frozen=True)
class LineFailed:
    """The line could not be opened; nothing is left open."""

    error: SolarcalError


class MenuEntriesFound(Message):
    """What there is to choose from has been looked up."""

    def __init__(self, offers: "MenuEntries") -> None:
        super().__init__()
        self.offers = offers


@dataclass(frozen=True)
class FormAsked:
    """The thread of the station waits for what a unit's display shows."""

    asked: "AskedForm"


LineNews = LineOpened | LineFailed | FormAsked


class Told(Message):
    """News of the station, of the opening of a line, or of a form to fill in."""

    def __init__(self, news: News | LineNews) -> None:
        super().__init__()
        self.news = news

    def can_replace(self, message: Message) -> bool:
        if not isinstance(message, Told):
            return False
        match self.news, message.news:
            case StateChanged(), StateChanged():
                return True
            case Progress(kind=kind), Progress(kind=other):
                return kind is other
        return False
