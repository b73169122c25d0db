"""The screen a technician uses all day: everything the station says, and every key."""

from collections.abc import Sequence
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.events import Key
from textual.markup import escape

from solarcal.decimals import counted
from solarcal.report.session_report import record_line
from solarcal.session.records import CheckRecord, PointRecord, Typed
from solarcal.station.news import (
    Done,
    FitReady,
    Progress,
    Reconnected,
    SpeedTold,
    StepFailed,
    Stored,
)
from solarcal.station.next_step import next_step
from solarcal.station.state import LinkState, StationState
from solarcal.station.sun_path import sun_now
from solarcal.tui.base import Workstation, refusal_words
from solarcal.tui.point.opened import PointScreen
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, LogLine, Part
from solarcal.tui.workstation.lines import NextLines, TitleLine, verdict_words
from solarcal.tui.workstation.view import PanesScreen, WorkstationView

REVIEW_FROM, REVIEW_FROM_WIDE = 5, 3
"""Accepted points from which the parameters come up after a point is stored."""

STORED_S = 5.0
NOTICED_S = 20.0
"""How long something noticed while opening stays on the screen."""

WINDOW_KEYS = frozenset({"tab", "shift+tab", "f12", "ctrl+s", "ctrl+q", "ctrl+p"})

FOOTER = (
    ("help", "Help"), ("link", "Link"), ("initialise", "Init"), ("plan", "Plan"),
    ("ref_check", "Ref"), ("sun_offset", "Offset"), ("take_point", "Point"),
    ("upload", "Upload"), ("recompute", "Recalc"), ("clock", "Clock"), ("next_plot", "Plot"),
    ("void", "Void"), ("note", "Note"), ("quit", "Quit"),
)  # fmt: skip
BESIDE_TABS = (("report", "Report"), ("calculators", "Calcs"))
"""Where the footer has no room for them they stand in the row of the tabs, the palette too."""

ONLY_ROOMY = (("theme", "Light"),)

PALETTE = FooterEntry("^P", "All", "app.command_palette", "Every action by its name")


def _footer_key(app: Workstation, name: str) -> str:
    """The first of its keys; beside the tabs there is only room for the shortest."""
    keys = app.keys_of(name).split()
    return min(keys, key=len) if name in dict(BESIDE_TABS) else keys[0]


class WorkstationScreen(PanesScreen):
    """Title, file, what to do next, verdict, panes, log, footer.

    ``noticed`` while the line was opened: sentences to read first.
    """

    DEFAULT_CSS = """
    WorkstationScreen.-alone #file, WorkstationScreen.-alone #next { display: none; }
    """
    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("shift+tab", "next_tab(-1)", "Previous pane", show=False, priority=True)
    ]

    def __init__(self, noticed: Sequence[str] = ()) -> None:
        super().__init__()
        self._noticed = tuple(noticed)
        self._told_records = -1
        self._review: str | None = None
        self._tab_before = "now"
        self._was_due = True

    def compose(self) -> ComposeResult:
        app = self.workstation
        yield TitleLine(id="title")
        yield HeadLine(id="file")
        yield NextLines(id="next")
        tooltips = {action.id: action.tooltip for action in app.actions}
        entries = [
            FooterEntry(_footer_key(app, name), label, f"app.perform('{name}')", tooltips[name])
            for name, label in (*FOOTER, *BESIDE_TABS, *ONLY_ROOMY)
        ]
        entries.append(PALETTE)
        beside_tabs = [*entries[len(FOOTER) : len(FOOTER) + len(BESIDE_TABS)], PALETTE]
        yield WorkstationView(id="view", beside_tabs=beside_tabs)
        yield LogLine(id="log")
        yield ActionFooter(entries)

    def on_mount(self) -> None:
        self.show_state(self.workstation.state)
        if self.workstation.fit is not None:
            self.show_fit(self.workstation.fit)
        for sentence in self._noticed:
            self.notice(sentence, "warning", NOTICED_S)

    def on_resize(self) -> None:
        self._show_lines(self.workstation.state)

    # -- told --------------------------------------------------------------------------------

    def show_state(self, state: StationState) -> None:
        self._show_lines(state)
        self._log_newest(state)
        self.query_one(WorkstationView).show_state(state)

    def _show_lines(self, state: StationState) -> None:
        self.query_one("#title", TitleLine).show_state(state, silent_s=self.workstation.silent_s)
        session, live = state.session, state.live
        sun = sun_now(session, live) if session is not None else None
        app = self.workstation
        step = next_step(state, sun.elevation_deg if sun is not None else None, app.judgement)
        reason = app.fit.reason if app.fit is not None else ""
        due = step.countdown_s(live.laptop_utc_s) == 0.0
        if due and not self._was_due:
            app.alert(f"due now: {step.sentence}")
        self._was_due = due
        self.query_one("#next", NextLines).show_step(
            step,
            app.keys_of(step.action),
            live.laptop_utc_s,
            verdict_words(session, app.judgement, reason),
        )
        if session is not None:
            count = len(session.accepted)
            self.query_one("#file", HeadLine).show(
                [
                    ("File ", "bold"),
                    (self.workstation.session_name, "bold $accent"),
                    f"  {counted(count, 'point')}"
                    + ("" if session.initialised is not None else ", not begun"),
                ],
                self._time_words(),
            )

    def _time_words(self) -> list[Part]:
        app = self.workstation
        if app.emulated_speed is None:
            return [app.profile.operator]
        words = f"time x{app.emulated_speed:g}" if app.emulated_speed else "clock paused"
        keys = {name: app.keys_of(name).split()[0] for name in ("faster", "slower", "skip")}
        targets = " ".join(
            f"[@click=app.perform('{name}')]{escape(key)}[/]" for name, key in keys.items()
        )
        return [f"{words} [", Content.from_markup(targets), "]"]

    def _log_newest(self, state: StationState) -> None:
        """A record that has just come is shown; what is in the log is in the file."""
        if state.live.link is LinkState.LOST:
            self.say_on_line(state.live.link_message, error=True)
            return
        if self._review is not None:
            # What the review says stays until a key goes on.
            return
        records = state.session.records if state.session is not None else ()
        if len(records) != self._told_records:
            self._told_records = len(records)
            newest = record_line(records[-1]) if records else "connected; the session file is open"
            # What was typed was read as it was typed: it is not worth a row of the pane above.
            brief = bool(records) and isinstance(records[-1], Typed)
            self.say_on_line(newest, brief=brief)

    def show_fit(self, fit: FitReady) -> None:
        self._show_lines(self.workstation.state)
        self.query_one(WorkstationView).show_fit(fit.solution, fit.judgement)
        if fit.reason:
            self.say_on_line(fit.reason, error=True)

    def show_progress(self, progress: Progress) -> None:
        if progress.kind is Reconnected:
            message = self.workstation.state.live.link_message
            self.say_on_line(f"{message}: {progress.words}", error=True)
            return
        share = "" if progress.fraction is None else f"  {100.0 * progress.fraction:.0f} %"
        self.say_on_line(f"{progress.words}{share}")

    def step_done(self, done: Done[Any]) -> None:
        match done:
            case Stored(record) if record.status == "accepted":
                self._stored(record)
            case SpeedTold():
                self._show_lines(self.workstation.state)

    def step_failed(self, failed: StepFailed) -> None:
        self.say_on_line(refusal_words(self.workstation, failed.error), error=True)

    # -- keys --------------------------------------------------------------------------------

    def on_screen_resume(self) -> None:
        super().on_screen_resume()
        self.query_one(WorkstationView).focus_pane()

    # -- after a stored point ------------------------------------------------------------------

    def _stored(self, record: PointRecord | CheckRecord) -> None:
        """The parameters with what changed come up, as in the manual; any key goes on."""
        view, session = self.query_one(WorkstationView), self.workstation.state.session
        least = REVIEW_FROM_WIDE if view.wide else REVIEW_FROM
        if isinstance(record, CheckRecord) or session is None or len(session.accepted) < least:
            what = "Check point" if isinstance(record, CheckRecord) else "Point"
            self.notice(f"{what} stored as record {record.seq}.", "information", STORED_S)
            return
        if self._review is None:
            self._tab_before = view.tab
        self._review = "coefficients"
        view.show_review("coefficients")
        self.say_on_line(
            f"Stored as record {record.seq}: parameters and changes. Any key: the error plot."
        )

    def on_key(self, event: Key) -> None:
        """A key that is no action's goes on in the review of a stored point."""
        if self._review is None or event.key in WINDOW_KEYS:
            return
        if any(event.key in action.keys for action in self.workstation.actions):
            self._end_review()
            return
        event.stop()
        event.prevent_default()
        if self._review == "coefficients":
            self._review = "plot"
            self.query_one(WorkstationView).show_review("plot")
            self.say_on_line("The new point on the curve of the previous fit. Any key: back.")
        else:
            self._end_review()

    def _end_review(self) -> None:
        self._review = None
        self.query_one(WorkstationView).end_review(self._tab_before)
        self._told_records = -1
        self._log_newest(self.workstation.state)

    def on_workstation_view_point_opened(self, event: WorkstationView.PointOpened) -> None:
        session = self.workstation.state.session
        if session is not None:
            self.app.push_screen(PointScreen(session, event.point.seq, writable=True))
