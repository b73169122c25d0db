"""The one thread that talks to the station: commands in order, a status every second between them.

Screens submit steps and get messages back; they never wait. STOP does not queue: it goes out on a
thread of its own, at once. A lost line is reported at once, recorded, and reopened with growing
pauses.
"""

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from solarcal.errors import LinkError, ProcedureRefused, SolarcalError
from solarcal.station.news import (
    Done,
    Kind,
    LossRecorded,
    News,
    Progress,
    Reconnected,
    StateChanged,
    StatusRead,
    StepFailed,
    Stopped,
)
from solarcal.station.state import LinkState

if TYPE_CHECKING:
    from solarcal.station.procedure import Station

POLL_S = 1.0
FIRST_RETRY_S = 1.0
LONGEST_RETRY_S = 15.0
TURNS_HELD = 5
"""So many steps or polls after a reconnection the line counts as held, the pauses begin anew."""

Result = TypeVar("Result")
Post = Callable[[News], object]


@dataclass(frozen=True, slots=True)
class _Submitted:
    kind: Kind
    step: Callable[["Station"], Any]
    stops: int | None = None
    """How often STOP had been pressed, for a step that moves something."""
    needs_unit: bool = True


class StationWorker:
    """Runs a ``Station`` on a thread.

    Parameters
    ----------
    station : connected or not; ``open_line`` connects it.
    post : where messages go; must be safe to call from another thread.
    """

    def __init__(self, station: "Station", post: Post) -> None:
        self.station = station
        self._post = post
        self._steps: queue.Queue[_Submitted | None] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name="worker", daemon=True)
        self._busy = threading.Event()
        self._closing = threading.Event()
        self._retry_now = threading.Event()
        self._stops = 0
        station.subscribe(lambda state: self._post(StateChanged(state)))

    def start(self) -> None:
        self._thread.start()

    @property
    def busy(self) -> bool:
        """A step is running or waiting."""
        return self._busy.is_set() or not self._steps.empty()

    def submit(
        self,
        kind: type[Done[Result]],
        step: Callable[["Station"], Result],
        *,
        moves: bool = False,
        needs_unit: bool = True,
    ) -> None:
        """Run ``step`` after those submitted before it; a ``kind`` or ``StepFailed`` follows.

        One that ``moves`` something is not begun when STOP is pressed while it waits. While the
        link is down none is that ``needs_unit``; what only writes into the session file is.
        """
        if needs_unit and self.station.state.live.link is LinkState.LOST:
            self._refuse(kind)
            return
        self._steps.put(_Submitted(kind, step, self._stops if moves else None, needs_unit))

    def submit_beside(self, kind: type[Done[Result]], step: Callable[["Station"], Result]) -> None:
        """Run a step that touches no state of the station, beside a long one that is running."""
        if not self._busy.is_set():
            self.submit(kind, step)
            return

        def run() -> None:
            try:
                result = step(self.station)
            except SolarcalError as error:
                self._post(StepFailed(kind, error))
            else:
                self._post(kind(result))

        threading.Thread(target=run, name="beside", daemon=True).start()

    def stop_motion(self) -> None:
        """STOP, now, past everything that waits."""
        # Counted before it is sent: what was asked for earlier must not undo it.
        self._stops += 1
        threading.Thread(target=self._stop_now, name="stop", daemon=True).start()

    def progress(self, kind: Kind, fraction: float | None, words: str) -> None:
        self._post(Progress(kind, fraction, words))

    def reconnect_now(self) -> None:
        """Do not wait for the next try."""
        self._retry_now.set()
        self._steps.put(None)

    def close(self) -> None:
        """End the thread after the step that is running. The session stays as it is."""
        self._closing.set()
        self._retry_now.set()
        self._steps.put(None)
        if self._thread.is_alive():
            self._thread.join(timeout=10.0)

    # -- the thread --------------------------------------------------------------------------

    def _stop_now(self, *, again: bool = False) -> None:
        try:
            self.station.stop()
        except SolarcalError as error:
            self._post(StepFailed(Stopped, error))
        else:
            if not again:
                self._post(Stopped(None))

    def _run(self) -> None:
        pause_s = FIRST_RETRY_S
        turns = 0
        while not self._closing.is_set():
            if self.station.state.live.link is LinkState.LOST:
                pause_s = self._try_again(pause_s)
                turns = 0
                continue
            turns += 1
            if turns > TURNS_HELD:
                pause_s = FIRST_RETRY_S
            try:
                submitted = self._steps.get(timeout=POLL_S)
            except queue.Empty:
                if self.station.state.live.link is LinkState.CONNECTED:
                    self._perform(StatusRead, lambda station: station.poll(), quiet=True)
                continue
            if submitted is not None:
                self._begin(submitted)

    def _begin(self, submitted: _Submitted) -> None:
        kind = submitted.kind
        if submitted.stops not in (None, self._stops):
            refused = ProcedureRefused(f"{kind.name}: not done, STOP was pressed")
            self._post(StepFailed(kind, refused))
            return
        self._perform(kind, submitted.step)
        if submitted.stops not in (None, self._stops):
            # The two may have passed each other on the line: STOP has the last word.
            self._stop_now(again=True)

    def _perform(
        self, kind: Kind, step: Callable[["Station"], Any], *, quiet: bool = False
    ) -> None:
        self._busy.set()
        try:
            result = step(self.station)
        except LinkError as error:
            if self.station.state.live.link is LinkState.CONNECTED:
                self._lose_link(error)
            self._post(StepFailed(kind, error))
        except SolarcalError as error:
            self._post(StepFailed(kind, error))
        else:
            if not quiet:
                self._post(kind(result))
        finally:
            self._busy.clear()

    def _lose_link(self, error: LinkError) -> None:
        """Record it; where the file cannot be written either, say so and go on reconnecting."""
        try:
            self.station.link_lost(error)
        except SolarcalError as unrecorded:
            self._post(StepFailed(LossRecorded, unrecorded))

    def _try_again(self, pause_s: float) -> float:
        """Wait, try to reopen the line, and return the next pause."""
        left_s = pause_s
        while left_s > 0.0 and not self._retry_now.is_set():
            words = f"next try in {left_s:.0f} s; press L to try now"
            self._post(Progress(Reconnected, 1.0 - left_s / pause_s, words))
            self._attend_while_lost(min(1.0, left_s))
            left_s -= 1.0
        self._retry_now.clear()
        if self._closing.is_set():
            return pause_s
        while self._attend_while_lost(0.0):
            pass
        try:
            self.station.reconnect()
        except LinkError:
            pass
        except SolarcalError as error:
            self._post(StepFailed(Reconnected, error))
            return LONGEST_RETRY_S
        else:
            self._post(Reconnected(None))
        # A line that comes and goes is not opened anew every second either.
        return min(2.0 * pause_s, LONGEST_RETRY_S)

    def _attend_while_lost(self, patience_s: float) -> bool:
        """Whether something was waiting. What needs the unit is refused, not done later in a new
        situation."""
        try:
            waiting = self._steps.get(timeout=patience_s)
        except queue.Empty:
            return False
        if waiting is not None:
            if waiting.needs_unit:
                self._refuse(waiting.kind)
            else:
                self._begin(waiting)
        return True

    def _refuse(self, kind: Kind) -> None:
        self._post(StepFailed(kind, LinkError(f"{kind.name}: not done, the link is down")))
