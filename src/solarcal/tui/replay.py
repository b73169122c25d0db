"""A saved session on the workstation's own screen: play, pause, forward, BACK, jump to a point."""

from collections.abc import Callable, Iterable
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.widget import Widget

from solarcal.decimals import counted
from solarcal.report.session_report import record_line
from solarcal.station.news import FitReady
from solarcal.station.planning import Fitter
from solarcal.station.saved_sessions import Replay
from solarcal.station.state import LiveView, StationState
from solarcal.timescale import format_utc, parse_utc
from solarcal.tui.base import Told
from solarcal.tui.dialogs.dialog import Dialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.point.opened import PointScreen
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import Field, HeadLine, LogLine, Words
from solarcal.tui.workstation.lines import TitleLine, verdict_words
from solarcal.tui.workstation.view import PanesScreen, WorkstationView


class JumpDialog(Dialog):
    """One number, counted from one."""

    HEADING = "Jump to a point"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (DialogKey("jump", "Jump", "enter", "Enter"),)
    AUTO_FOCUS = "Input"

    def __init__(self, points: int, jump: Callable[[int], None]) -> None:
        super().__init__()
        self._points, self._jump = points, jump

    def body(self) -> Iterable[Widget]:
        yield Field("number", f"Point, 1 to {self._points}")

    def on_input_submitted(self) -> None:
        self.action_jump()

    def action_jump(self) -> None:
        text = self.query_one(Field).value
        number = int(text) if text.isdecimal() else 0
        if 1 <= number <= self._points:
            self.dismiss(None)
            self._jump(number)
        else:
            self.say(f"There is no point {text!r}.", "warning")


VERDICT_ROWS = 2
TICK_S = 0.1
SPEEDS = (1.0, 10.0, 60.0, 300.0, 600.0, 1800.0, 3600.0)
DEFAULT_SPEED = 600.0


class ReplayScreen(PanesScreen):
    """Time runs at ``speed`` while playing; every step shows the state as it stood then."""

    DEFAULT_CSS = """
    ReplayScreen #bar, ReplayScreen #verdict { background: $boost; }
    ReplayScreen #verdict { height: 2; padding: 0 1; text-wrap: nowrap; }
    ReplayScreen.-alone #file, ReplayScreen.-alone #verdict { display: none; }
    """
    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "play", "Play or pause", show=False, priority=True),
        Binding("right", "step(1)", "Forward", show=False, priority=True),
        Binding("left", "step(-1)", "Back", show=False, priority=True),
        Binding("pagedown", "point(1)", "Next point", show=False, priority=True),
        Binding("pageup", "point(-1)", "Point before", show=False, priority=True),
        Binding("home", "end(False)", "Beginning", show=False, priority=True),
        Binding("end", "end(True)", "End", show=False, priority=True),
        Binding("plus,up", "speed(1)", "Faster", show=False, priority=True),
        Binding("minus,down", "speed(-1)", "Slower", show=False, priority=True),
        Binding("j", "jump", "Jump to a point", show=False),
        Binding("escape,q", "back", "Back", show=False),
    ]

    def __init__(self, replay: Replay, file_name: str, speed: float | None = None) -> None:
        super().__init__()
        self.replay = replay
        self._file_name = file_name
        self._playing = False
        self._speed = DEFAULT_SPEED if speed is None else speed
        self._utc_s = replay.utc_s
        self._points_seen: object = None
        self._evidence_seen: int | None = None
        self._judged: FitReady | None = None
        self._fitter = Fitter(lambda fit: self.post_message(Told(fit)))

    def compose(self) -> ComposeResult:
        yield TitleLine(id="title")
        yield HeadLine(id="file")
        yield HeadLine(id="bar")
        yield Words("", id="verdict", markup=False)
        yield WorkstationView(id="view")
        yield LogLine(id="log")
        yield ActionFooter(
            [
                FooterEntry("Spc", "Play", "screen.play"),
                FooterEntry("←", "Back", "screen.step(-1)"),
                FooterEntry("→", "Step", "screen.step(1)"),
                FooterEntry("PgUp", "Prev", "screen.point(-1)"),
                FooterEntry("PgDn", "Next", "screen.point(1)"),
                FooterEntry("j", "Jump", "screen.jump"),
                FooterEntry("v", "Plot", "app.perform('next_plot')"),
                FooterEntry("+", "Faster", "screen.speed(1)"),
                FooterEntry("-", "Slower", "screen.speed(-1)"),
                FooterEntry("Home", "Top", "screen.end(False)"),
                FooterEntry("End", "End", "screen.end(True)"),
                FooterEntry("F1", "Help", "app.perform('help')"),
                FooterEntry("Esc", "Close", "screen.back"),
                FooterEntry("^Q", "Quit", "app.perform('quit')"),
            ]
        )

    def on_mount(self) -> None:
        self._fitter.start()
        self.set_interval(TICK_S, self._tick)
        self._show()
        if self.replay.warnings:
            self.say_on_line(self.replay.warnings[0], error=True)

    def on_resize(self) -> None:
        self._show_lines(self._state())

    # -- what is shown -----------------------------------------------------------------------

    def _state(self) -> StationState:
        return StationState(
            session=self.replay.view,
            live=LiveView(laptop_utc_s=self._utc_s),
            generation=self.replay.position,
        )

    def _show(self) -> None:
        """Show the session as it stands; nothing of what comes later is known."""
        state = self._state()
        self._show_lines(state)
        view = self.query_one(WorkstationView)
        session = state.session
        assert session is not None  # a replay always has one
        self._points_seen = session.points
        if session.newest_evidence != self._evidence_seen:
            self._evidence_seen = session.newest_evidence
            # Planned from the newest point: from then on the technician knew what to do.
            self._fitter.fit(self.replay.position, session)
        view.show_state(state)
        seen = self.replay.records[: self.replay.position]
        told = record_line(seen[-1]) if seen else "the session file is open; nothing recorded yet"
        self.say_on_line(told)

    def _show_lines(self, state: StationState) -> None:
        self.query_one("#title", TitleLine).show_state(state, replay=True)
        count = len(state.session.accepted) if state.session is not None else 0
        self.query_one("#file", HeadLine).show(
            [
                ("File ", "bold"),
                (self._file_name, "bold $accent"),
                f"   {counted(count, 'point')} so far",
            ]
        )
        judged = self.judged_now
        words = verdict_words(
            state.session,
            judged.judgement if judged is not None else None,
            judged.reason if judged is not None else "",
        )
        width = max(self.app.size.width - 2, 20)
        lines = words.fitted(width, VERDICT_ROWS)
        self.query_one("#verdict", Words).update(Content("\n").join(lines))
        self._show_bar()

    @property
    def judged_now(self) -> FitReady | None:
        """The fit of the points seen now, once it has come."""
        judged = self._judged
        known = judged is not None and judged.session.points == self._points_seen
        return judged if known else None

    def _show_bar(self) -> None:
        total = len(self.replay)
        width = max(10, min(60, self.app.size.width - 60))
        share = self.replay.position / total if total else 1.0
        full = round(share * width)
        playing = "▶ playing" if self._playing else "‖ paused "
        self.query_one("#bar", HeadLine).show(
            [
                (playing, "bold"),
                f" x{self._speed:<5g} {format_utc(self._utc_s, 0)[:19].replace('T', ' ')}  ",
                ("━" * full + "╸" + "─" * (width - full), "$accent"),
                f" {self.replay.position}/{total}",
            ]
        )

    def on_told(self, message: Told) -> None:
        """A fit of other points than those seen now comes too late."""
        message.stop()
        fit = message.news
        if isinstance(fit, FitReady) and fit.session.points == self._points_seen:
            self._judged = fit
            self._show_lines(self._state())
            self.query_one(WorkstationView).show_fit(fit.solution, fit.judgement)

    def on_unmount(self) -> None:
        self._fitter.close()

    # -- time --------------------------------------------------------------------------------

    def _tick(self) -> None:
        if not self._playing:
            return
        self._utc_s += TICK_S * self._speed
        before = self.replay.position
        while (due := self._next_utc_s()) is not None and due <= self._utc_s:
            self.replay.step()
        if self._next_utc_s() is None:
            self._playing = False
            self._utc_s = self.replay.utc_s
        if self.replay.position != before or not self._playing:
            self._show()
        else:
            self.query_one(WorkstationView).show_state(self._state())
            self._show_bar()

    def _next_utc_s(self) -> float | None:
        if self.replay.position >= len(self.replay):
            return None
        return parse_utc(self.replay.records[self.replay.position].utc)

    def _stand(self) -> None:
        """After a step: show, and go on playing from this record's time."""
        self._utc_s = self.replay.utc_s
        self._show()

    # -- keys --------------------------------------------------------------------------------

    def action_play(self) -> None:
        if not self._playing and self.replay.position >= len(self.replay):
            self.replay.jump(0)
            self._utc_s = self.replay.utc_s
        self._playing = not self._playing
        self._show()

    def action_step(self, records: int) -> None:
        self.replay.step(records)
        self._stand()

    def action_point(self, step: int) -> None:
        places, at = self.replay.point_positions, self.replay.position
        wanted = [p for p in places if p > at][:1] if step > 0 else [p for p in places if p < at]
        if wanted:
            self.replay.jump(wanted[-1])
            self._stand()

    def action_end(self, last: bool) -> None:
        self.replay.jump(len(self.replay) if last else 0)
        self._stand()

    def action_speed(self, step: int) -> None:
        now = self._speed
        if step > 0:
            self._speed = next((speed for speed in SPEEDS if speed > now), max(now, SPEEDS[-1]))
        else:
            self._speed = next((s for s in reversed(SPEEDS) if s < now), min(now, SPEEDS[0]))
        self._show_bar()

    def action_jump(self) -> None:
        def jump(number: int) -> None:
            self.replay.jump_to_point(number)
            self._stand()

        self.app.push_screen(JumpDialog(len(self.replay.point_positions), jump))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Where the plot is alone its arrows, + and - are the plot's."""
        del parameters
        moves = ("step", "point", "end", "speed")
        return not (action in moves and self.has_class("-alone"))

    def on_workstation_view_point_opened(self, event: WorkstationView.PointOpened) -> None:
        self.app.push_screen(PointScreen(self.replay.view, event.point.seq, writable=False))
