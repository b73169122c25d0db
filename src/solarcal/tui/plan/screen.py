"""Plan: the rest of the day by half hours, struck out where clouds are, and what it comes to."""

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.content import Content

from solarcal.model.analysis import Analysis
from solarcal.report.blocks import wrapped
from solarcal.report.judgement import STATE_WORDS
from solarcal.station.guards import MIN_ELEVATION_DEG
from solarcal.station.news import FitReady
from solarcal.station.planning import DEFAULT_OPTIONS, PlanOptions
from solarcal.station.state import StationState
from solarcal.tui.base import StationScreen, Workstation
from solarcal.tui.plan.half_hours import HalfHours, half_hours, utc_clock
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, NoticeLine, Words
from solarcal.tui.widgets.text_lines import TextLines


def open_screen(app: Workstation) -> None:
    app.station_worker()
    if not isinstance(app.screen, PlanScreen):
        app.push_screen(PlanScreen())


class PlanScreen(StationScreen):
    """Arrows choose a half hour; space strikes it, Enter leaves at its end."""

    DEFAULT_CSS = """
    PlanScreen #title { background: $primary; color: $background; text-style: bold; }
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

    def __init__(self) -> None:
        super().__init__()
        self._ready = False

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield Words("", id="advice", markup=False)
        yield HalfHours(id="hours")
        yield TextLines(id="reasons")
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
        self._ready = True
        self._show()

    # -- told --------------------------------------------------------------------------------

    def show_state(self, state: StationState) -> None:
        if self._ready:
            self._show_title()

    def show_fit(self, fit: FitReady) -> None:
        if self._ready:
            self._show()

    def on_resize(self) -> None:
        if self._ready:
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
        hours = self.query_one(HalfHours)
        if hours.chosen_utc_s is not None:
            self._plan_with(self.plan_options.leave_at(hours.chosen_end_utc_s))

    def action_points(self, by: int) -> None:
        session, judgement = self.workstation.state.session, self.workstation.judgement
        if session is None or judgement is None or judgement.plan is None:
            return
        planned = judgement.plan.recommended.points
        self._plan_with(self.plan_options.points_more(by, len(session.accepted), planned))

    def action_clear(self) -> None:
        self._plan_with(DEFAULT_OPTIONS)

    def action_back(self) -> None:
        self.dismiss(None)

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
            half_hours(judgement.plan, self.plan_options, zone_west_h), judgement.plan.now
        )
        lines = [STATE_WORDS[judgement.verdict.state]]
        for reason in judgement.verdict.reasons:
            lines += wrapped(f"- {reason}", hang=2)
        self.query_one("#reasons", TextLines).show(lines)

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
        clock = "" if now_utc_s is None else f"now {utc_clock(now_utc_s)} UTC"
        self.query_one("#title", HeadLine).show(
            ["PLAN  the rest of the day"], ["planning ...  " if planning else "", clock]
        )


def advice(judgement: Analysis, plan_options: PlanOptions) -> Content:
    """The plan's sentence, its schedule, and what was asked for."""
    plan = judgement.plan
    assert plan is not None  # asked for with a plan only
    sentence = plan.sentence[:1].upper() + plan.sentence[1:] + "."
    times = "  ".join(utc_clock(time) for time in plan.recommended.times_utc_s)
    asked = []
    if plan_options.until_utc_s is not None:
        asked.append(f"leave at {utc_clock(plan_options.until_utc_s)}")
    if plan_options.points is not None:
        asked.append(f"{plan_options.points} points in all")
    if plan_options.struck:
        plural = "" if len(plan_options.struck) == 1 else "s"
        asked.append(f"{len(plan_options.struck)} half hour{plural} of cloud")
    return Content.assemble(
        (sentence, "bold"),
        f"\nPoints at (UTC): {times or '-'}",
        f"\nAsked for: {', '.join(asked)}." if asked else "",
    )
