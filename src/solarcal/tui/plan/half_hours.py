"""The rest of a day as a table of half hours, one of them chosen."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from textual.events import Click

from solarcal.model.plan import Plan, PlannedStop
from solarcal.report.blocks import columns, number
from solarcal.station.planning import HALF_HOUR_S, PlanOptions
from solarcal.timescale import format_utc
from solarcal.tui.widgets.text_lines import TextLines

HEADINGS = ("", "until", "local", "points at, UTC", "points", "rms", "95 %", "P", "")
ALIGNMENT = "<<<<>>>><"
HEADING_ROWS = 2


def utc_clock(utc_s: float) -> str:
    return format_utc(utc_s, 0)[11:16]


@dataclass(frozen=True, slots=True)
class HalfHour:
    """One row: what is planned in it, and what stopping at its end would give.

    ``local``: the end by the unit's zone.
    """

    begin_utc_s: float
    end_utc_s: float
    local: str
    planned_utc_s: tuple[float, ...]
    stop: PlannedStop | None
    advised: bool
    reaches: bool
    struck: bool
    leaving: bool

    def cells(self, chosen: bool) -> list[str]:
        said = []
        if self.struck:
            said.append("x CLOUD")
        if self.leaving:
            said.append("LEAVE")
        if self.advised:
            said.append("<- advised")
        if self.reaches:
            said.append("reaches")
        stop = self.stop
        return [
            "▶" if chosen else " ",
            utc_clock(self.end_utc_s),
            self.local,
            " ".join(utc_clock(time) for time in self.planned_utc_s),
            "" if stop is None else str(stop.points),
            number(None if stop is None else stop.year_rms_deg, 3),
            number(None if stop is None else stop.year_p95_deg, 3),
            number(None if stop is None else stop.probability, 2),
            ", ".join(said),
        ]


def half_hours(plan: Plan, plan_options: PlanOptions, zone_west_h: float) -> tuple[HalfHour, ...]:
    """Every half hour from now to the day's last, those struck or chosen to leave at among them."""
    stops = {_begin(stop.stop_utc_s - 1.0): stop for stop in plan.stops}
    begins = set(stops) | {b for b in plan_options.struck if b >= _begin(plan.at_utc_s)}
    leaving = None if plan_options.until_utc_s is None else _begin(plan_options.until_utc_s - 1.0)
    if leaving is not None:
        begins.add(leaving)
    if not begins:
        return ()
    first = min(_begin(plan.at_utc_s), *begins)
    count = round((max(begins) - first) / HALF_HOUR_S) + 1
    rows = []
    for begin in (first + HALF_HOUR_S * k for k in range(count)):
        stop = stops.get(begin)
        end_utc_s = begin + HALF_HOUR_S
        times = plan.recommended.times_utc_s
        rows.append(
            HalfHour(
                begin_utc_s=begin,
                end_utc_s=end_utc_s,
                local=utc_clock(end_utc_s - 3600.0 * zone_west_h),
                planned_utc_s=tuple(t for t in times if begin <= t < end_utc_s),
                stop=stop,
                advised=stop is not None and stop is plan.recommended,
                reaches=stop is not None and plan.reached_by(stop),
                struck=begin in plan_options.struck,
                leaving=begin == leaving,
            )
        )
    return tuple(rows)


def _begin(utc_s: float) -> float:
    return HALF_HOUR_S * math.floor(utc_s / HALF_HOUR_S)


class HalfHours(TextLines):
    """The table; the chosen row has a mark, a click chooses."""

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._hours: tuple[HalfHour, ...] = ()
        self._chosen = 0

    @property
    def chosen_utc_s(self) -> float | None:
        """Beginning of the chosen half hour."""
        return self._hours[self._chosen].begin_utc_s if self._hours else None

    @property
    def chosen_end_utc_s(self) -> float:
        return self._hours[self._chosen].end_utc_s

    def show_plan(self, hours: Sequence[HalfHour], now: PlannedStop) -> None:
        """Show these; the half hour chosen stays chosen where it is still there."""
        kept = self.chosen_utc_s
        self._now = now
        self._hours = tuple(hours)
        begins = [hour.begin_utc_s for hour in self._hours]
        self._chosen = begins.index(kept) if kept in begins else 0
        self._show_rows()

    def move(self, step: int) -> None:
        if self._hours:
            self._chosen = min(max(self._chosen + step, 0), len(self._hours) - 1)
            self._show_rows()

    def _show_rows(self) -> None:
        now = ["", "now", "", "", "0", number(self._now.year_rms_deg, 3)]
        now += [number(self._now.year_p95_deg, 3), number(self._now.probability, 2), ""]
        rows = [hour.cells(index == self._chosen) for index, hour in enumerate(self._hours)]
        self.show(columns(HEADINGS, [now, *rows], ALIGNMENT), pinned=HEADING_ROWS)
        # The row of now comes before the half hours.
        self._keep_in_view(HEADING_ROWS + 1 + self._chosen)

    def _keep_in_view(self, line: int) -> None:
        height, top = self.size.height, self.scroll_offset.y
        if height and line < top + HEADING_ROWS + 1:
            self.scroll_to(y=max(0, line - HEADING_ROWS - 1), animate=False)
        elif height and line > top + height - 1:
            self.scroll_to(y=line - height + 1, animate=False)

    def on_click(self, event: Click) -> None:
        row = event.y if event.y < HEADING_ROWS else event.y + self.scroll_offset.y
        index = row - HEADING_ROWS - 1
        if 0 <= index < len(self._hours):
            self._chosen = index
            self._show_rows()
