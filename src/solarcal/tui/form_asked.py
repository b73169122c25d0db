"""Forms asked by the thread that talks to the station, answered on the screen."""

import threading
from collections.abc import Callable

from solarcal.errors import ProcedureRefused
from solarcal.station.typed.forms import DisplayForm, TypedAnswer
from solarcal.timescale import Clock, SystemClock

GIVEN_UP = "given up: nothing was typed, nothing is recorded"


class AskedForm:
    """A form that waits for its answer.

    Attributes
    ----------
    form : what is asked.
    clock : the laptop's, for the moment of a look.
    """

    def __init__(self, form: DisplayForm, clock: Clock) -> None:
        self.form = form
        self.clock = clock
        self._answer: TypedAnswer | None = None
        self._done = threading.Event()

    @property
    def done(self) -> bool:
        """Answered or given up."""
        return self._done.is_set()

    def answer(self, answer: TypedAnswer | None) -> None:
        """The answer, or ``None``: given up. The first one counts."""
        if not self._done.is_set():
            self._answer = answer
            self._done.set()

    def wait(self) -> TypedAnswer:
        """The answer, once there is one.

        Raises
        ------
        ProcedureRefused
            It was given up.
        """
        self._done.wait()
        if self._answer is None:
            raise ProcedureRefused(GIVEN_UP)
        return self._answer


class ScreenDisplay:
    """A ``Display`` that asks on the screen.

    Parameters
    ----------
    post : takes a form that is asked to the app; safe to call from another thread.
    """

    def __init__(self, post: Callable[[AskedForm], object], clock: Clock | None = None) -> None:
        self._post = post
        self._clock = clock or SystemClock()
        self._asked: AskedForm | None = None
        self._closed = False

    def ask(self, form: DisplayForm) -> TypedAnswer:
        if self._closed:
            raise ProcedureRefused(GIVEN_UP)
        self._asked = AskedForm(form, self._clock)
        self._post(self._asked)
        return self._asked.wait()

    @property
    def asking(self) -> bool:
        """A form waits for its answer."""
        return self._asked is not None and not self._asked.done

    def close(self) -> None:
        """Ask no more; a form that still waits is given up."""
        self._closed = True
        if self._asked is not None:
            self._asked.answer(None)
