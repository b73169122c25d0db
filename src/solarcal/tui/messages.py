"""What the worker tells the screens. Posted from its thread; Textual's queue makes that safe."""

from typing import TYPE_CHECKING

from textual.message import Message

from solarcal.errors import SolarcalError

if TYPE_CHECKING:
    from solarcal.model.analysis import Analysis
    from solarcal.model.fit import Solution
    from solarcal.station.state import SessionView, StationState
    from solarcal.tui.opening import OpenLine
    from solarcal.tui.start.menu_entries import MenuEntries


class StateChanged(Message):
    """The station's state. A newer one replaces an older one still waiting."""

    def __init__(self, state: "StationState") -> None:
        super().__init__()
        self.state = state

    def can_replace(self, message: Message) -> bool:
        return isinstance(message, StateChanged)


class FitReady(Message):
    """Fit and judgement of the session as it was at ``generation``; late ones are ignored.

    Where one of them is missing ``reason`` says why, unless there are simply too few points.
    """

    def __init__(
        self,
        generation: int,
        session: "SessionView",
        solution: "Solution | None",
        judgement: "Analysis | None" = None,
        reason: str = "",
    ) -> None:
        super().__init__()
        self.judgement = judgement
        self.reason = reason
        self.generation = generation
        self.session = session
        self.solution = solution


class StepStarted(Message):
    def __init__(self, name: str) -> None:
        super().__init__()
        self.name = name


class StepDone(Message):
    """A station command has returned."""

    def __init__(self, name: str, result: object) -> None:
        super().__init__()
        self.name = name
        self.result = result


class StepFailed(Message):
    """A station command was refused or failed; ``error`` says it in one line."""

    def __init__(self, name: str, error: SolarcalError) -> None:
        super().__init__()
        self.name = name
        self.error = error


class Progress(Message):
    """How far a long step is, 0..1 or seconds so far, in words."""

    def __init__(self, name: str, fraction: float | None, words: str) -> None:
        super().__init__()
        self.name = name
        self.fraction = fraction
        self.words = words

    def can_replace(self, message: Message) -> bool:
        return isinstance(message, Progress) and message.name == self.name


class LineOpened(Message):
    """A unit is connected and its session open."""

    def __init__(self, line: "OpenLine") -> None:
        super().__init__()
        self.line = line


class LineFailed(Message):
    """The line could not be opened; nothing is left open."""

    def __init__(self, error: SolarcalError) -> None:
        super().__init__()
        self.error = error


class MenuEntriesFound(Message):
    """What there is to choose from has been looked up."""

    def __init__(self, offers: "MenuEntries") -> None:
        super().__init__()
        self.offers = offers
