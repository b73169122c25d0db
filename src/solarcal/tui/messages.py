"""What comes to the app from other threads, as messages of its queue; that makes it safe."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from textual.message import Message

from solarcal.errors import SolarcalError
from solarcal.station.news import News, Progress, StateChanged

if TYPE_CHECKING:
    from solarcal.station.opening import OpenLine
    from solarcal.tui.start.menu_entries import MenuEntries
    from solarcal.tui.typed_form.form_asked import AskedForm


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
