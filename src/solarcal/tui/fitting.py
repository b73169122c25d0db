"""The fit of the session, computed on a thread of its own: the newest session wins."""

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from textual.message import Message

from solarcal.errors import SolarcalError
from solarcal.tui.messages import FitReady

if TYPE_CHECKING:
    from solarcal.station.state import SessionView


class Fitter:
    """One thread, one waiting place.

    Parameters
    ----------
    post : where ``FitReady`` goes; must be safe to call from another thread.
    """

    def __init__(self, post: Callable[[Message], object]) -> None:
        self._post = post
        self._wanted: tuple[int, SessionView] | None = None
        self._change = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="fit", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def fit(self, generation: int, session: "SessionView") -> None:
        """Fit this session; one still waiting is forgotten."""
        with self._change:
            self._wanted = (generation, session)
            self._change.notify()

    def close(self) -> None:
        with self._change:
            self._closing = True
            self._change.notify()

    def _run(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._closing or self._wanted is not None)
                if self._closing or self._wanted is None:
                    return
                generation, session = self._wanted
                self._wanted = None
            self._post(fit_message(generation, session))


def fit_message(generation: int, session: "SessionView") -> FitReady:
    """The fit of a session as the message that carries it."""
    from solarcal.station.fitting import solve

    try:
        return FitReady(generation, session, solve(session))
    except SolarcalError as error:
        return FitReady(generation, session, None, str(error))
