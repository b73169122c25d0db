"""Plan: the rest of the day by half hours, struck out where clouds are, and what it comes to."""

import math
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.events import Click

from solarcal.decimals import counted
from solarcal.model.analysis import Analysis
from solarcal.model.plan import Plan
from solarcal.report.blocks import columns, lines_of
from solarcal.report.judgement import PLAN_ALIGNMENT, PLAN_HEADINGS, plan_row, verdict_blocks
from solarcal.station.guards import MIN_ELEVATION_DEG
from solarcal.station.news import FitReady
from solarcal.station.planning import DEFAULT_OPTIONS, HALF_HOUR_S, PlanOptions
from solarcal.station.state import StationState
from solarcal.timescale import time_of_day
from solarcal.tui.base import StationScreen, Workstation, show_once
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, NoticeLine, Words
from solarcal.tui.widgets.text_lines import ENDLESS, TextLines

HEADINGS = ("", "local", *PLAN_HEADINGS)
ALIGNMENT = f"<<{PLAN_ALIGNMENT}"
HEADING_ROWS = 2


def half_hours(
    plan: Plan, plan_options: PlanOptions, zone_west_h: float
) -> dict[float, tuple[str, ...]]:
    """Rows of every half hour from now to the day's last, by its beginning; those struck or chosen
    to leave at are among them. The local time is by the unit's zone."""
    stops = {_begin(stop.stop_utc_s - 1.0): stop for stop in plan.stops}
    begins = set(stops) | {b for b in plan_options.struck if b >= _begin(plan.at_utc_s)}
    leaving = None if plan_options.until_utc_s is None else _begin(plan_options.until_utc_s - 1.0)
    if leaving is not None:
        begins.add(leaving)
    if not begins:
        return {}
    first = min(_begin(plan.at_utc_s), *begins)
    count = round((max(begins) - first) / HALF_HOUR_S) + 1
    rows = {}
    for begin in (first + HALF_HOUR_S * k for k in range(count)):
        stop = stops.get(begin)
        when_utc_s = begin + HALF_HOUR_S if stop is None else stop.stop_utc_s
        remarks = ["x CLOUD"] if begin in plan_options.struck else []
        remarks += ["LEAVE"] if begin == leaving else []
        local = time_of_day(when_utc_s - 3600.0 * zone_west_h)
        rows[begin] = (local, *plan_row(plan, time_of_day(when_utc_s), stop, remarks))
    return rows


def _begin(utc_s: float) -> float:
    return HALF_HOUR_S * math.floor(utc_s / HALF_HOUR_S)


class HalfHours(TextLines):
    """The table; the chosen row has a mark, a click chooses."""

    chosen_utc_s: float | None = None
    """Beginning of the chosen half hour."""

    def show_plan(self, hours: dict[float, tuple[str, ...]], now: tuple[str, ...]) -> None:
        """Show these; the half hour chosen stays chosen where it is still there."""
        self._hours, self._now = hours, now
        if self.chosen_utc_s not in hours:
            self.chosen_utc_s = next(iter(hours), None)
        self._show_rows()

    def move(self, step: int) -> None:
        if self.chosen_utc_s is not None:
            self._choose(list(self._hours).index(self.chosen_utc_s) + step)

    def _choose(self, index: int) -> None:
        begins = list(self._hours)
        self.chosen_utc_s = begins[min(max(index, 0), len(begins) - 1)]
        self._show_rows()

    def _show_rows(self) -> None:
        marks = ["▶" if begin == self.chosen_utc_s else " " for begin in self._hours]
        rows = [[mark, *cells] for mark, cells in zip(marks, self._hours.values(), strict=True)]
        self.show(columns(HEADINGS, [["", "", *self._now], *rows], ALIGNMENT), pinned=HEADING_ROWS)
        self.keep_in_view(HEADING_ROWS + 1 + (marks.index("▶") if marks else 0))

    def on_click(self, event: Click) -> None:
        # The row of now comes before the half hours.
        index = self.line_at(event) - HEADING_ROWS - 1
        if self.chosen_utc_s is not None and 0 <= index < len(self._hours):
            self._choose(index)


def open_screen(app: Workstation) -> None:
    app.station_worker()
    show_once(app, PlanScreen, PlanScreen)


class PlanScreen(StationScreen):
    """Arrows choose a half hour; space strikes it, Enter leaves at its end."""

    DEFAULT_CSS = """
    PlanScreen #advice { height: 6; padding: 0 1; background: $boost; }
    PlanScreen #hours { height: 1fr; padding: 0 1; }
    PlanScreen #reasons { height: 5; padding: 0 1; border-top: solid $faint; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "move(-1)", "Up", show=False, priority=True),
        Binding("down", "move(1)", "Down", show=False, priority=True),
        Binding("space", "strike", "Strike", show=False, priority=True),
        Binding("enter", "until", "Leave then", show=False, priority=True),
        Binding("left", "points(-1)", "Fewer points", show=False, priority=True),
        Binding("right", "points(1)", "More points", show=False, priority=True),
        Binding("delete,backspace", "clear", "Clear changes", show=False, priority=True),
        Binding("escape", "back", "Back", show=False),
    ]
    AUTO_FOCUS = ""

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield Words("", id="advice", markup=False)
        yield HalfHours(id="hours")
        yield TextLines(id="reasons", wrap=True)
        yield NoticeLine()
        yield ActionFooter(
            [
                FooterEntry("↑", "Up", "screen.move(-1)"),
                FooterEntry("↓", "Down", "screen.move(1)"),
                FooterEntry("Spc", "Cloud", "screen.strike", "No point in this half hour"),
                FooterEntry("Ent", "Leave", "screen.until", "Leave at the end of this half hour"),
                FooterEntry("←", "Fewer", "screen.points(-1)", "One point fewer"),
                FooterEntry("→", "More", "screen.points(1)", "One point more"),
                FooterEntry("Del", "Reset", "screen.clear", "Forget clouds, leaving, points"),
                FooterEntry("e", "Report", "app.perform('report')"),
                FooterEntry("F1", "Help", "app.perform('help')"),
                FooterEntry("Esc", "Back", "screen.back"),
            ]
        )

    def on_mount(self) -> None:
        self._show()

    # -- told --------------------------------------------------------------------------------

    def show_state(self, state: StationState) -> None:
        self._show_title()

    def show_fit(self, fit: FitReady) -> None:
        self._show()

    def on_resize(self) -> None:
        self._show()

    # -- keys --------------------------------------------------------------------------------

    @property
    def plan_options(self) -> PlanOptions:
        return self.workstation.plan_options or DEFAULT_OPTIONS

    def _plan_with(self, plan_options: PlanOptions) -> None:
        self.workstation.plan_with(plan_options)
        self._show(planning=True)

    def action_move(self, step: int) -> None:
        self.query_one(HalfHours).move(step)

    def action_strike(self) -> None:
        begin_utc_s = self.query_one(HalfHours).chosen_utc_s
        if begin_utc_s is not None:
            self._plan_with(self.plan_options.strike(begin_utc_s))

    def action_until(self) -> None:
        begin_utc_s = self.query_one(HalfHours).chosen_utc_s
        if begin_utc_s is not None:
            self._plan_with(self.plan_options.leave_at(begin_utc_s + HALF_HOUR_S))

    def action_points(self, by: int) -> None:
        session, judgement = self.workstation.state.session, self.workstation.judgement
        if session is None or judgement is None or judgement.plan is None:
            return
        planned = judgement.plan.recommended.points
        self._plan_with(self.plan_options.points_more(by, len(session.accepted), planned))

    def action_clear(self) -> None:
        self._plan_with(DEFAULT_OPTIONS)

    # -- showing -----------------------------------------------------------------------------

    def _show(self, *, planning: bool = False) -> None:
        app = self.workstation
        session, judgement = app.state.session, app.judgement
        self._show_title(planning)
        if session is None or judgement is None or judgement.plan is None:
            self.query_one("#advice", Words).update(self._nothing_yet())
            return
        self.query_one("#advice", Words).update(advice(judgement, self.plan_options))
        zone_west_h = session.header.unit.zone_west_h
        self.query_one(HalfHours).show_plan(
            half_hours(judgement.plan, self.plan_options, zone_west_h),
            plan_row(judgement.plan, "now", judgement.plan.now),
        )
        self.query_one("#reasons", TextLines).show(
            lines_of(*verdict_blocks(judgement.verdict), width=ENDLESS)
        )

    def _nothing_yet(self) -> str:
        fit = self.workstation.fit
        if fit is not None and fit.reason:
            return fit.reason
        if fit is not None and fit.solution is not None:
            return "Planning ..."
        return (
            "The plan begins with the first accepted point. Take it as soon as the Sun is above "
            f"{MIN_ELEVATION_DEG:g} deg: the earlier, the more of the day is left."
        )

    def _show_title(self, planning: bool = False) -> None:
        now_utc_s = self.workstation.state.live.laptop_utc_s
        clock = "" if now_utc_s is None else f"now {time_of_day(now_utc_s)} UTC"
        self.query_one("#title", HeadLine).show(
            ["PLAN  the rest of the day"], ["planning ...  " if planning else "", clock]
        )


def advice(judgement: Analysis, plan_options: PlanOptions) -> Content:
    """The plan's sentence, its schedule, and what was asked for."""
    plan = judgement.plan
    assert plan is not None  # asked for with a plan only
    sentence = plan.sentence[:1].upper() + plan.sentence[1:] + "."
    times = "  ".join(time_of_day(time) for time in plan.recommended.times_utc_s)
    asked = []
    if plan_options.until_utc_s is not None:
        asked.append(f"leave at {time_of_day(plan_options.until_utc_s)}")
    if plan_options.points is not None:
        asked.append(f"{counted(plan_options.points, 'point')} in all")
    if plan_options.struck:
        asked.append(f"{counted(len(plan_options.struck), 'half hour')} of cloud")
    return Content.assemble(
        (sentence, "bold"),
        f"\nPoints at (UTC): {times or '-'}",
        f"\nAsked for: {', '.join(asked)}." if asked else "",
    )
