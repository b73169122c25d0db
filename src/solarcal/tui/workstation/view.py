"""The workstation's panes: side by side where there is room, as tabs where there is not.

Fed with a state and a fit, whether they come from a unit or from a replay.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.message import Message
from textual.reactive import reactive
from textual.widgets import Static

from solarcal.model.analysis import Analysis
from solarcal.model.solution import Solution
from solarcal.report.blocks import lines_of
from solarcal.report.scales import View
from solarcal.report.tables import points_table
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView
from solarcal.station.state import StationState
from solarcal.tui.base import StationScreen
from solarcal.tui.widgets.footer import ROOMY_COLUMNS, FooterEntry, KeysInLine
from solarcal.tui.widgets.plot import PLOTS, ExploredPlot
from solarcal.tui.widgets.text_lines import ENDLESS, ChosenLines, TextLines
from solarcal.tui.workstation.lines import CoefficientsPane, check_lines
from solarcal.tui.workstation.live_pane import LivePane

WIDE = (138, 36)
"""From this size on all panes are side by side."""

SECOND_PLOT_ROWS = 42
"""From this height of the terminal on there is room for a second plot below the first."""

TABS = (
    ("now", "Now"),
    ("points", "Points"),
    ("coefficients", "P1-P6"),
    ("plot", "Plot"),
    ("checks", "Checks"),
)


class Tab(Static):
    """One tab of the compact form; the open one is marked by brackets, not by colour alone."""

    DEFAULT_CSS = """
    Tab { width: auto; padding: 0 1; background: $panel; }
    Tab.-open { text-style: bold reverse; }
    """

    def __init__(self, name: str, number: int, label: str) -> None:
        super().__init__(f" {number} {label} ", id=f"tab-{name}", markup=False)
        self._pane_name, self._number, self._label = name, number, label

    def mark(self, is_open: bool) -> None:
        self.set_class(is_open, "-open")
        shown = f"[{self._number} {self._label}]" if is_open else f" {self._number} {self._label} "
        self.update(Content(shown), layout=False)

    def on_click(self) -> None:
        self.query_ancestor(WorkstationView).tab = self._pane_name


class WorkstationView(Vertical):
    """Live pane, coefficients, points, error plot and second plot."""

    DEFAULT_CSS = """
    WorkstationView { height: 1fr; }
    WorkstationView #tabs { height: 1; background: $panel; }
    WorkstationView #panes { height: 1fr; }
    WorkstationView .pane { height: 1fr; }
    WorkstationView #left { width: 1fr; }
    WorkstationView #right { width: 1fr; }
    WorkstationView.-wide #tabs, WorkstationView.-alone #tabs { display: none; }
    WorkstationView.-wide #left { width: 60; }
    WorkstationView.-wide #now {
        height: 17; border: round $faint; border-title-color: $primary;
    }
    WorkstationView.-wide #coefficients {
        border: round $faint; border-title-color: $primary;
    }
    WorkstationView.-wide #plot { height: 1fr; }
    WorkstationView.-wide #second { height: 1fr; }
    WorkstationView.-wide #points, WorkstationView.-wide #checks {
        height: 12; border: round $faint; border-title-color: $primary;
    }
    WorkstationView.-wide #coefficients:focus, WorkstationView.-wide #points:focus,
    WorkstationView.-wide #checks:focus { border: round $accent; }
    """

    # Each pane repaints itself: all of them for a change of one take as long as the first paint.
    tab: reactive[str] = reactive("now", repaint=False)
    plot: reactive[int] = reactive(0, repaint=False)
    """Of the compact form's only plot; the wide form's second plot skips the first kind."""
    wide: reactive[bool] = reactive(False, repaint=False)
    alone: reactive[bool] = reactive(False, repaint=False)
    """The plot alone on the whole screen."""

    @dataclass
    class PointOpened(Message):
        """A point was opened, from the table or at the cursor of a plot."""

        point: PointRecord

    PANES: ClassVar[dict[str, str]] = {
        "now": "left", "coefficients": "left", "plot": "right", "points": "right",
        "checks": "right",
    }  # fmt: skip

    def __init__(self, id: str | None = None, beside_tabs: Sequence[FooterEntry] = ()) -> None:
        super().__init__(id=id)
        self._beside_tabs = tuple(beside_tabs)
        self._session: SessionView | None = None
        self.solution: Solution | None = None
        """The fit that is shown."""
        self._judgement: Analysis | None = None
        self._shown: object = None
        self._version = 0
        self._second = 1
        self._solution_before: Solution | None = None
        self._review = False

    def compose(self) -> ComposeResult:
        with Horizontal(id="tabs"):
            for number, (name, label) in enumerate(TABS, start=1):
                yield Tab(name, number, label)
            yield KeysInLine(self._beside_tabs, id="beside-tabs")
        with Horizontal(id="panes"):
            with Vertical(id="left"):
                yield LivePane(id="now", wrap=True, classes="pane")
                yield CoefficientsPane(id="coefficients", wrap=True, classes="pane")
            with Vertical(id="right"):
                yield ExploredPlot(id="plot")
                yield ExploredPlot(id="second")
                yield ChosenLines(id="points")
                yield TextLines(id="checks", wrap=True)

    def on_mount(self) -> None:
        self.query_one("#now").border_title = "Now"
        self.query_one("#coefficients").border_title = "Coefficients"
        self.query_one("#points").border_title = "Points (5: checks)"
        self.query_one("#checks").border_title = "Checks (2: points)"
        self._fit_in()

    def on_resize(self) -> None:
        self._fit_in()

    def _fit_in(self) -> None:
        """Before the first layout too: else a large screen is laid out and drawn small first."""
        size = self.app.size
        self.wide = size.width >= WIDE[0] and size.height >= WIDE[1]
        # A wider footer has them.
        self.query_one("#beside-tabs").display = size.width < ROOMY_COLUMNS
        self._arrange()

    # -- what is shown -----------------------------------------------------------------------

    def show_state(self, state: StationState) -> None:
        self.query_one(LivePane).show_state(state)
        self._session = state.session
        self._show_session()

    def show_fit(self, solution: Solution | None, judgement: Analysis | None = None) -> None:
        before = self.solution
        if before is not None and (solution is None or solution.n_points != before.n_points):
            self._solution_before = before
        self.solution, self._judgement = solution, judgement
        self._show_session()

    def _show_session(self) -> None:
        """Tables and plots, only when what they show has changed."""
        session = self._session
        if session is None or not self.query("#checks"):
            # Left while it was being built: the innermost panes are not there.
            return
        shown = (session.header, session.records, id(self.solution), id(self._judgement))
        if shown == self._shown:
            return
        self._shown = shown
        self._version += 1
        self.query_one(CoefficientsPane).show_fit(session, self.solution, self._judgement)
        points = points_table(session, self.solution)
        # A remark is folded to the pane, whatever its width.
        table = lines_of(*points, width=ENDLESS)
        # The table's heading and rule stay in view.
        self.query_one("#points", ChosenLines).show(table, pinned=2 if len(table) > 2 else 0)
        self.query_one("#checks", TextLines).show(check_lines(session))
        self._show_plots()

    def _show_plots(self) -> None:
        session = self._session
        if session is None:
            return
        first = PLOTS[0] if self._two_plots else PLOTS[self.plot]
        for place, kind in (("#plot", first), ("#second", PLOTS[self._second])):
            review = self._review and kind == "error"
            what = (kind, self._version, review)
            solution = self._solution_before if review else self.solution
            plot = self.query_one(place, ExploredPlot)
            plot.show_plot(kind, session, solution, self._judgement, what)

    # -- what is in view ---------------------------------------------------------------------

    @property
    def _two_plots(self) -> bool:
        return self.wide and self.app.size.height >= SECOND_PLOT_ROWS

    def next_plot(self) -> str:
        """Go to the next plot; its name."""
        if self._two_plots:
            self._second = self._second % (len(PLOTS) - 1) + 1
            name = PLOTS[self._second]
        elif not self.wide and self.tab != "plot":
            self.tab = "plot"
            name = PLOTS[self.plot]
        else:
            self.plot = (self.plot + 1) % len(PLOTS)
            name = PLOTS[self.plot]
        self._show_plots()
        return name

    def show_review(self, pane: str) -> None:
        """After a stored point: the parameters, then the point on the curve of the fit before."""
        self._review = pane == "plot"
        self.tab = pane
        if not self._review or self._session is None:
            # From the top: the coefficients with what changed.
            self.query_one(CoefficientsPane).scroll_home(animate=False)
            return
        self.plot = 0
        self._show_plots()
        self.query_one("#plot", ExploredPlot).go_to_newest()

    def end_review(self, tab: str) -> None:
        self._review = False
        self.query_one("#plot", ExploredPlot).view = View()
        self.tab = tab
        self._show_plots()

    def show_alone(self) -> str:
        """The plot alone on the screen, or everything again; its name."""
        self.alone = not self.alone
        return PLOTS[self._second if self._two_plots else self.plot]

    def watch_tab(self) -> None:
        if self.is_mounted:
            self._arrange()
            self.focus_pane()

    def watch_alone(self) -> None:
        self.watch_tab()

    def focus_pane(self) -> None:
        """Give the keys that scroll, walk and zoom to the pane that is looked at."""
        if not self.query("#checks"):
            return
        place = self.tab
        if self.alone:
            # The second plot where there are two: its kind is the one that was chosen.
            place = "second" if self._two_plots else "plot"
        pane = self.query_one(f"#{place}")
        self.screen.set_focus(pane if pane.can_focus else None, scroll_visible=False)

    def on_chosen_lines_opened(self, event: ChosenLines.Opened) -> None:
        event.stop()
        for point in self._session.records if self._session is not None else ():
            if point.seq == event.number and isinstance(point, PointRecord):
                self.post_message(self.PointOpened(point))

    def on_explored_plot_point_opened(self, event: ExploredPlot.PointOpened) -> None:
        event.stop()
        self.post_message(self.PointOpened(event.point))

    def next_tab(self, step: int = 1) -> None:
        names = [name for name, _ in TABS]
        self.tab = names[(names.index(self.tab) + step) % len(names)]

    def _arrange(self) -> None:
        """Show all panes, or the one whose tab is open."""
        self.set_class(self.wide, "-wide")
        self.set_class(self.alone, "-alone")
        if self.alone:
            for name in self.PANES:
                self.query_one(f"#{name}").display = name == "plot" and not self._two_plots
            self.query_one("#second").display = self._two_plots
            self.query_one("#left").display = False
            self.query_one("#right").display = True
            self._show_plots()
            return
        for name, side in self.PANES.items():
            self.query_one(f"#{name}").display = self.wide or name == self.tab
            if not self.wide and name == self.tab:
                self.query_one("#left").display = side == "left"
                self.query_one("#right").display = side == "right"
        if self.wide:
            self.query_one("#left").display = self.query_one("#right").display = True
            # These two share a place.
            self.query_one("#points").display = self.tab != "checks"
            self.query_one("#checks").display = self.tab == "checks"
        self.query_one("#second").display = self._two_plots
        for name, _ in TABS:
            self.query_one(f"#tab-{name}", Tab).mark(name == self.tab)
        self._show_plots()


class PanesScreen(StationScreen):
    """A screen with the panes on it: their keys."""

    BINDINGS: ClassVar[list[BindingType]] = [
        *(
            Binding(str(number), f"tab('{name}')", label, show=False)
            for number, (name, label) in enumerate(TABS, start=1)
        ),
        Binding("z", "alone", "Plot alone", show=False),
        Binding("tab", "next_tab(1)", "Next pane", show=False, priority=True),
    ]

    def next_plot(self) -> None:
        name = self.query_one(WorkstationView).next_plot()
        self.say_on_line(f"{name}: {ExploredPlot.HELP}")

    def action_alone(self) -> None:
        view = self.query_one(WorkstationView)
        name = view.show_alone()
        self.set_class(view.alone, "-alone")
        words = f"{name}: {ExploredPlot.HELP}" if view.alone else ""
        self.say_on_line(words)

    def action_tab(self, name: str) -> None:
        self.query_one(WorkstationView).tab = name

    def action_next_tab(self, step: int) -> None:
        self.query_one(WorkstationView).next_tab(step)
