"""The station under the app: its worker, its newest state and fit, and who is notified of them."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from textual.app import App
from textual.events import Resize
from textual.reactive import var

from solarcal.errors import ProcedureRefused
from solarcal.station.news import (
    Done,
    FitReady,
    FitRecorded,
    Gathered,
    News,
    Progress,
    Reconnected,
    SpeedTold,
    StateChanged,
    StepFailed,
    Stopped,
)
from solarcal.tui.base import (
    ONE_IMPORT,
    FormAsked,
    LineFailed,
    LineNews,
    LineOpened,
    StationModal,
    StationScreen,
    Told,
)

if TYPE_CHECKING:
    from textual.notifications import SeverityLevel

    from solarcal.model.analysis import Analysis
    from solarcal.station.planning import Fitter, PlanOptions
    from solarcal.station.procedure import Station
    from solarcal.station.state import StationState
    from solarcal.station.worker import StationWorker

SILENT_AFTER_S = 3
"""A status comes every second, during a reference check every two: later the unit is silent."""

STOPPED = "STOP: every motion is stopped"


class StationApp(App[int]):
    """Messages of the worker and the fitter become the newest state, and go on to the screens.

    Screens watch ``newest`` and ``fit``; the app calls them for steps under way and done.

    Attributes
    ----------
    worker : talks to the station while a line is open, else ``None``.
    state, fit : the newest of the worker and the fitter.
    emulated_speed : virtual seconds a second of an emulated unit, ``None`` for a real one.
    plan_options : what the technician wants of the plan, ``None`` for nothing.
    """

    newest: var["StationState | None"] = var(None)
    fit: var[FitReady | None] = var(None)

    def __init__(self) -> None:
        super().__init__()
        self.worker: StationWorker | None = None
        self.emulated_speed: float | None = None
        self._fitter: Fitter | None = None
        self.plan_options: PlanOptions | None = None
        self._path: Path | None = None
        self._leaving = False
        self._unanswered_s = 0

    @property
    def state(self) -> "StationState":
        """The newest state of the worker; an empty one before there is a worker."""
        if self.newest is None:
            # Numpy comes with it: not before the first paint.
            with ONE_IMPORT:
                from solarcal.station.state import StationState

            self.set_reactive(StationApp.newest, StationState())
        assert self.newest is not None
        return self.newest

    def adopt(self, station: "Station") -> None:
        """Conduct this station from now on."""
        # Numpy and scipy come with them: not before the first paint.
        with ONE_IMPORT:
            from solarcal.station.planning import Fitter
            from solarcal.station.worker import StationWorker

        self._fitter = Fitter(self.tell)
        self._fitter.start()
        self.worker = StationWorker(station, self.tell)
        self.worker.start()
        if station.tracker.emulation is not None:
            self.emulated_speed = 1.0
        self.set_interval(1.0, self._count_silence)
        self._ask_speed()
        self._state_changed(station.state)

    def _ask_speed(self) -> None:
        """Another process may have changed an emulated unit's speed; only the unit knows it."""
        worker = self.station_worker()
        emulation = worker.station.tracker.emulation
        if emulation is not None:
            worker.submit(SpeedTold, lambda station: emulation.speed())

    def station_worker(self) -> "StationWorker":
        """The worker of the open line."""
        if self.worker is None:
            raise ProcedureRefused("no unit is connected; choose one on the start screen")
        return self.worker

    # -- telling the screens -------------------------------------------------------------------

    @property
    def _shows(self) -> bool:
        """Once screens are taken down, what still comes is for the file and not for them."""
        return self.is_running and not self._leaving

    def _station_screens(self) -> list[StationScreen | StationModal[Any]]:
        screens = self.screen_stack if self._shows else []
        kinds = (StationScreen, StationModal)
        # One that is still being put together reads the newest when it is there.
        return [s for s in screens if isinstance(s, kinds) and s.is_mounted]

    def on_unmount(self) -> None:
        # Its thread holds the app: it would wait for as long as the process lives.
        if self._fitter is not None:
            self._fitter.close()

    def on_resize(self, event: Resize) -> None:
        for screen in self._station_screens():
            screen.show_size(event.size)

    def tell(self, news: News) -> None:
        """Take news from any thread."""
        self.post_message(Told(news))

    def on_told(self, message: Told) -> None:
        match message.news:
            case StateChanged(state):
                self._state_changed(state)
            case FitReady() as fit:
                self._fit_ready(fit)
            case Progress() as progress:
                for screen in self._station_screens():
                    screen.show_progress(progress)
            case StepFailed() as failed:
                if failed.kind is Stopped and self.state.live.capabilities.has_link:
                    self._say_stop(str(failed.error), "error")
                for screen in self._station_screens():
                    screen.step_failed(failed)
            case Done() as done:
                self._step_done(done)
            case LineOpened() | LineFailed() | FormAsked() as news:
                self.line_told(news)

    def line_told(self, news: LineNews) -> None:
        """A line was opened or not, or a form has to be filled in."""

    def _state_changed(self, state: "StationState") -> None:
        if state.generation < self.state.generation:
            return
        lost = state.live.link == "lost"
        if lost and self.state.live.link != "lost":
            self.alert(f"link lost: {state.live.link_message}")
        if state.live.status is not self.state.live.status:
            self._unanswered_s = 0
        self.set_reactive(StationApp.newest, state)
        self._remember_file()
        self._fit_if_needed()
        if self._shows:
            self.mutate_reactive(StationApp.newest)

    def _count_silence(self) -> None:
        self._unanswered_s += 1
        if self.silent_s and self._shows:
            self.mutate_reactive(StationApp.newest)

    @property
    def silent_s(self) -> int:
        """How old the last answer of a connected unit is, where one is overdue; else 0."""
        live = self.state.live
        linked = live.link == "connected" and live.capabilities.has_link
        return self._unanswered_s if linked and self._unanswered_s > SILENT_AFTER_S else 0

    @property
    def session_name(self) -> str:
        """Name of the open session file."""
        return self._path.name if self._path is not None else ""

    @property
    def session_path(self) -> Path | None:
        """The open session file; ``None`` without one, or while it is kept in memory."""
        return self._path

    def _remember_file(self) -> None:
        path = self.worker.station.session_path if self.worker is not None else None
        if path is not None and path != self._path:
            self._path = path
            self.file_opened(path)

    def file_opened(self, path: Path) -> None:
        """The session goes into another file now."""

    @property
    def judgement(self) -> "Analysis | None":
        """Of the points as they are now; ``None`` while newer ones are being fitted."""
        session = self.state.session
        if self.fit is None or session is None or self.fit.session.points != session.points:
            return None
        return self.fit.judgement

    def plan_with(self, plan_options: "PlanOptions") -> None:
        """Plan the day with these from now on."""
        self.plan_options = plan_options
        self._fit_if_needed()

    def _fit_if_needed(self) -> None:
        if self._fitter is not None:
            self._fitter.fit_if_needed(self.state, self.plan_options)

    def _fit_ready(self, fit: FitReady) -> None:
        if self.fit is not None and fit.generation < self.fit.generation:
            return
        self.set_reactive(StationApp.fit, fit)
        self._record_fit(fit)
        if self._shows:
            self.mutate_reactive(StationApp.fit)

    def _record_fit(self, fit: FitReady) -> None:
        """Keep what the fit said after a point: the history of the coefficients."""
        solution = fit.solution
        if self.worker is None or solution is None or fit.session.fit_recorded:
            return

        def record(station: "Station") -> None:
            # Meanwhile another point may have come, or its own step has recorded the fit.
            session = station.session
            if not session.fit_recorded and solution.n_points == len(session.accepted):
                station.record_fit(solution)

        self.worker.submit(FitRecorded, record)

    def _say_stop(self, words: str, severity: "SeverityLevel") -> None:
        """On every screen; a dialog has its own words for it."""
        if not isinstance(self.screen, StationModal):
            self.notify(words, severity=severity)

    def alert(self, words: str) -> None:
        """Notify a person who does not look at the screen."""

    def _step_done(self, done: Done[Any]) -> None:
        match done:
            case Stopped():
                self._say_stop(STOPPED, "warning")
            case Gathered():
                self.alert("gathered; store the point or not")
            case SpeedTold(float(speed)):
                # Another one may have been asked for while this was on its way: the unit knows.
                if self.worker is not None and self.worker.busy:
                    self._ask_speed()
                else:
                    self.emulated_speed = speed
            case Reconnected():
                self._ask_speed()
        for screen in self._station_screens():
            screen.step_done(done)
