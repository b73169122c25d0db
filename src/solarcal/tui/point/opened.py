"""A point opened: its errors and residuals, what the fit is without it, its evidence, its records.

It can be struck out and restored from here; nothing is ever removed from the file.
"""

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.content import Content
from textual.widgets import Input, Static

from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.report.blocks import columns, number
from solarcal.report.session_report import record_lines
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView
from solarcal.station.news import Done, PointStruck, StepFailed
from solarcal.station.point_judgement import PointInfluence, point_evidence, point_influence
from solarcal.station.question_evidence import found_words
from solarcal.station.state import StationState
from solarcal.timescale import second_of_day
from solarcal.tui.base import StationScreen
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import HeadLine, LogLine
from solarcal.tui.widgets.text_lines import Line, TextLines


class PointScreen(StationScreen):
    """One point of a session; ``[`` and ``]`` go to its neighbours.

    Parameters
    ----------
    session : as it stands; a running one is followed.
    seq : record number of the point.
    writable : whether it can be struck out from here; a replay cannot.
    """

    DEFAULT_CSS = """
    PointScreen #point { padding: 0 1; }
    PointScreen #reason { height: 1; display: none; }
    PointScreen #reason Static { width: auto; padding: 0 1; }
    PointScreen #reason Input { width: 1fr; height: 1; border: none; padding: 0; }
    PointScreen #reason.-open { display: block; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("x", "strike", "Strike out or restore", show=False, id="void"),
        Binding("right_square_bracket,right", "next(1)", "Next point", show=False),
        Binding("left_square_bracket,left", "next(-1)", "Previous point", show=False),
        Binding("escape,q", "back", "Back", show=False),
    ]
    AUTO_FOCUS = "#point"

    def __init__(self, session: SessionView, seq: int, *, writable: bool) -> None:
        super().__init__()
        self._session = session
        self._seq = seq
        self._writable = writable
        self._points = tuple(r.seq for r in session.records if isinstance(r, PointRecord))
        self._influence: PointInfluence | None = None

    def compose(self) -> ComposeResult:
        yield HeadLine(id="title")
        yield TextLines(id="point", wrap=True)
        with Horizontal(id="reason"):
            yield Static("Reason:", markup=False)
            yield Input(compact=True)
        yield LogLine(id="log")
        strike = [FooterEntry("x", "Strike", "screen.strike")] if self._writable else []
        yield ActionFooter(
            [
                *strike,
                FooterEntry("←", "Prev", "screen.next(-1)"),
                FooterEntry("→", "Next", "screen.next(1)"),
                FooterEntry("F1", "Help", "app.perform('help')"),
                FooterEntry("Esc", "Back", "screen.back"),
            ]
        )

    def on_mount(self) -> None:
        self._open()

    @property
    def point(self) -> PointRecord | None:
        found = (r for r in self._session.records if r.seq == self._seq)
        return next((r for r in found if isinstance(r, PointRecord)), None)

    # -- the station ---------------------------------------------------------------------------

    def show_state(self, state: StationState) -> None:
        session = state.session
        if not self._writable or session is None or session.records == self._session.records:
            return
        self._session = session
        self._points = tuple(r.seq for r in session.records if isinstance(r, PointRecord))
        self._open()

    def step_done(self, done: Done[Any]) -> None:
        if isinstance(done, PointStruck):
            result = done.result
            restored = result.voids != self._seq
            self.say_on_line(f"{'Restored' if restored else 'Struck out'} (record {result.seq}).")

    def step_failed(self, failed: StepFailed) -> None:
        self.say_on_line(str(failed.error), error=True)

    # -- keys ----------------------------------------------------------------------------------

    def action_next(self, step: int) -> None:
        at = self._points.index(self._seq) + step
        if 0 <= at < len(self._points):
            self._seq = self._points[at]
            self._open()

    def action_strike(self) -> None:
        if not self._writable or self.point is None:
            return
        struck = point_evidence(self._session, self.point).void is not None
        reason = self.query_one("#reason")
        reason.add_class("-open")
        reason.query_one(Input).focus()
        what = "restored" if struck else "struck out"
        self.say_on_line(
            f"Why is this point {what}? Enter stores it, Esc cancels. F12 or ^S stops."
        )

    def on_input_submitted(self, event: Input.Submitted) -> None:
        event.stop()
        reason, point = event.value.strip(), self.point
        if not reason:
            self.say_on_line("A reason is needed; it goes into the file.")
            return
        if point is None:
            return
        void = point_evidence(self._session, point).void
        seq = point.seq if void is None else void.seq

        self._close_reason()
        self.workstation.station_worker().submit(
            PointStruck, lambda station: station.void(seq, reason), needs_unit=False
        )

    def _close_reason(self) -> None:
        reason = self.query_one("#reason")
        reason.remove_class("-open")
        reason.query_one(Input).value = ""
        self.query_one("#point").focus()

    def action_back(self) -> None:
        if self.query_one("#reason").has_class("-open"):
            self._close_reason()
        else:
            self.dismiss(None)

    # -- showing -------------------------------------------------------------------------------

    def _open(self) -> None:
        """Show what is known at once; the fits with and without it come from a thread."""
        self._influence = None
        self._show()
        point, session = self.point, self._session
        if point is not None and point.status == "accepted":
            self.compute(partial(point_influence, session, point), self._show_influence)

    def _show_influence(self, found: PointInfluence) -> None:
        # Not where another point was opened meanwhile.
        if found.point.seq == self._seq:
            self._influence = found
            self._show()

    def _show(self) -> None:
        point = self.point
        if point is None:
            return
        at = self._points.index(self._seq) + 1
        struck = point_evidence(self._session, point).void is not None
        state = "STRUCK OUT" if struck else point.status
        self.query_one("#title", HeadLine).show(
            [f"Point {at} of {len(self._points)}  record {point.seq}  {state}"], ["← → others"]
        )
        self.query_one("#point", TextLines).show(point_lines(self._session, point, self._influence))


def _heading(text: str) -> Content:
    return Content.styled(text, "bold $accent")


def point_lines(
    session: SessionView, point: PointRecord, influence: PointInfluence | None
) -> list[Line]:
    """Everything about one point; ``influence`` is ``None`` while it is being computed."""
    lines: list[Line] = [_heading("Errors")]
    lines += _error_lines(point, influence)
    lines += ["", _heading("Without it"), *_without_lines(session, point, influence), ""]
    lines += [_heading("Evidence"), *_evidence_lines(session, point), "", _heading("Records")]
    lines += record_lines(point_evidence(session, point).records)
    return lines


def _error_lines(point: PointRecord, influence: PointInfluence | None) -> Sequence[str]:
    if point.error_deg is None or point.ideal_deg is None:
        return [f"No error was measured: {point.reason or point.status}."]
    judged = influence.judged if influence is not None else None
    residual = influence.residual_deg if influence is not None else None
    rows = []
    for axis in range(2):
        one = judged.axes[axis] if judged is not None else None
        rows.append(
            [
                f"axis {axis + 1}",
                number(point.ideal_deg[axis], 3),
                number(point.error_deg[axis], 4, True),
                number(None if residual is None else residual[axis], 4, True),
                number(None if one is None else one.off_deg, 4, True),
                number(None if one is None else one.sigmas, 1, True),
            ]
        )
    headings = ("", "ideal", "error, deg", "residual", "off the others", "in sigmas")
    lines = columns(headings, rows, "<>>>>>")
    if residual is not None:
        sky = math.hypot(math.sin(math.radians(point.ideal_deg[1])) * residual[0], residual[1])
        lines.append(f"Residual on the sky: {sky:.4f} deg")
    if influence is not None and influence.leverage is not None:
        lines.append(
            f"Leverage {influence.leverage:.2f}: the fit follows {influence.leverage:.0%} of an "
            "error of this point."
        )
    return lines


def _without_lines(
    session: SessionView, point: PointRecord, influence: PointInfluence | None
) -> Sequence[str]:
    if point.status != "accepted":
        return [f"It is {point.status}: the fit does not use it."]
    if influence is None:
        return ["computing ..."]
    if influence.trouble:
        return [influence.trouble]
    with_it, without = influence.with_it, influence.without
    if with_it is None or without is None:
        return ["It is the only point: nothing is left without it."]
    pairs = (with_it.solution.coefficients(), without.solution.coefficients())
    rows = []
    for name, now, other in zip(
        COEFFICIENT_NAMES, pairs[0].as_tuple(), pairs[1].as_tuple(), strict=True
    ):
        decimals = 6 if name in ("P5", "P6") else 4
        rows.append(
            [
                name,
                number(now, decimals, True),
                number(other, decimals, True),
                number(other - now, decimals, True),
            ]
        )
    lines = columns(("", "with it", "without", "change"), rows, "<>>>")
    lines.append(
        f"Year, 95 % of the time within: {with_it.forecast.year_p95_deg:.3f} deg with it, "
        f"{without.forecast.year_p95_deg:.3f} deg without it."
    )
    if point_evidence(session, point).void is not None:
        lines.append("It is struck out: the fit in force is the one without it.")
    return lines


_TAKEN_FROM = {
    "sun_offset": "its Set Sun Offset",
    "gathering": "the gathering",
    "moon": "the read-outs at rest on the Moon",
}


def _evidence_lines(session: SessionView, point: PointRecord) -> Sequence[str]:
    found = point_evidence(session, point)
    answers = point.answers
    asked = (
        (answers.ref_check, "check"),
        (answers.sun_offset, "offset"),
        (answers.tracking, "tracking"),
    )
    words = {True: "yes", False: "NO", None: "not asked"}
    lines = ["Answers: " + ", ".join(f"{what} {words[given]}" for given, what in asked)]
    if point.basis is not None:
        of = _TAKEN_FROM[point.basis]
        lines.append(f"Error taken from {of}" + (f": {point.reason}" if point.reason else ""))
    check = found.ref_check
    lines.append(
        "Reference check: none before it"
        if check is None
        else f"Reference check no. {check.number}, {second_of_day(check.utc)} UTC: "
        f"{found_words(check)}"
    )
    if found.sun_offset is not None:
        offset = found.sun_offset
        came = ", ".join({1: "+", -1: "-", 0: "not known"}[side] for side in offset.approach)
        lines.append(
            f"Set Sun Offset {second_of_day(offset.utc)} UTC: O1 {offset.offsets.O1:+z.4f}, "
            f"O2 {offset.offsets.O2:+z.4f} deg, approach {came}"
        )
    if found.clock_set is not None:
        lines.append(
            f"Clock set {second_of_day(found.clock_set.utc)} UTC: unit - laptop "
            f"{found.clock_set.after_s:+z.3f} s then"
        )
    if point.unit_minus_laptop_s is not None:
        lines.append(f"Clock at the point: unit - laptop {point.unit_minus_laptop_s:+z.3f} s")
    if point.expected_counts is not None and point.found_counts is not None:
        pairs = zip(point.expected_counts, point.found_counts, strict=True)
        counts = ", ".join(f"{found} of {wanted:.0f} expected" for wanted, found in pairs)
        lines.append(f"Counts since the previous point: {counts}")
    if point.distance_to_limits_deg is not None:
        lines.append(f"Distance to the nearest limit: {point.distance_to_limits_deg:.1f} deg")
    if found.void is not None:
        lines.append(f"STRUCK OUT at {second_of_day(found.void.utc)} UTC: {found.void.reason}")
    return lines
