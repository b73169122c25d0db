"""What Set Sun Offset shows of the axes, and what it says."""

import math
from collections.abc import Iterable

from textual.content import Content

from solarcal.mount.formula import Offsets
from solarcal.session.records import SunOffset
from solarcal.station.jogging import TAKEN_UP_DEG, JogView
from solarcal.station.next_step import next_step
from solarcal.station.state import StationState
from solarcal.tui.base import Workstation
from solarcal.tui.dialogs.dialog import Tone
from solarcal.unit.tracker import Mode


def jog_table(view: JogView, *, follows: bool, words: str) -> Content:
    """Both axes side by side, in 42 columns."""
    status = view.status
    rows: list[str | tuple[str, str]] = [f"{'':10}{'axis 1':>15}{'axis 2':>15}\n"]

    def row(name: str, cells: tuple[str, str], style: str = "") -> None:
        rows.append((f"{name:10}{cells[0]:>15}{cells[1]:>15}\n", style))

    row("reading", _pair(status.reading_deg))
    row("ideal", _pair(status.ideal_deg))
    row("target", _pair(view.target_deg) if view.target_deg else ("-", "-"))
    row("off ideal", _two(f"{off:+z.4f}" for off in status.off_ideal_deg))
    row("offset O", (f"{status.offsets.O1:+z.4f}", f"{status.offsets.O2:+z.4f}"))
    row("moving", _two({1: "to +", -1: "to -"}.get(sense, "at rest") for sense in status.moving))
    row("Sun goes", _two("to +" if sense > 0 else "to -" for sense in view.senses))
    came = _two(
        "from behind"
        if ok
        else f"{forward:.2f} of {TAKEN_UP_DEG:g}"
        if math.isfinite(forward)
        else "?"
        for ok, forward in zip(view.watch.from_behind, view.watch.forward_deg, strict=True)
    )
    row("came", came, "" if all(view.watch.from_behind) else "bold $warning")
    aim = "follows the Sun" if follows else "fixed"
    rows.append(f"mode {status.mode}, aim {aim if view.aim else 'none yet'}\n")
    rows.append(f"update cycle {100.0 * status.update_phase:.0f} %\n")
    rows.append(words)
    return Content.assemble(*rows)


def big_numbers(view: JogView) -> tuple[str, tuple[float, float]]:
    """The spot's error where a device shows it, else reading minus ideal; what it is in words."""
    status, spot = view.status, view.spot
    if spot is not None and spot.visible:
        return "still to move, +: press right or up", (spot.error1_deg, spot.error2_deg)
    return "reading - ideal", status.off_ideal_deg


def no_reference(app: Workstation) -> str:
    key = app.keys_of("ref_check").split()[0]
    return (
        f"The unit has no reference: do a reference check [{key}]; then it can track and be jogged."
    )


def jog_warning(view: JogView, app: Workstation) -> str:
    """What the technician has to know of the axes and the side they came from; empty if nothing."""
    if not view.status.referenced:
        return no_reference(app)
    behind = view.watch.from_behind
    if view.aim is not None and any(view.aim.behind):
        return "Going behind the Sun; the axes then come forward automatically."
    if view.aim is not None and not all(behind):
        who = "Axes 1 and 2" if not any(behind) else f"Axis {1 + behind.index(False)}"
        return (
            f"{who} did NOT come from behind: the backlash is in the error. "
            "Press b: behind the Sun first, then forward."
        )
    if view.status.mode in (Mode.STOP, Mode.FAULT):
        return f"The unit is in mode {view.status.mode}: press t to track again."
    return ""


def came_words(view: JogView) -> tuple[str, Tone]:
    """The warning before has gone: both axes came from behind."""
    if view.spot is not None and not view.spot.visible:
        return (
            "Both axes came from behind, but no spot is on the plate: t goes to the Sun.",
            "plain",
        )
    return "Both axes came from behind. Centre the spot, then Enter.", "good"


def how_to_begin(app: Workstation, before: Offsets | None, is_set: bool, *, fields: bool) -> str:
    """``before``: the offsets that can be put back; ``is_set``: an offset waits for its point;
    ``fields``: whether there is a calculator."""
    sentences = ["Arrow keys jog: left/right axis 1, down/up axis 2. Nothing moves before one."]
    status = app.state.live.status
    if status is not None and status.mode is Mode.LIMIT:
        sentences.insert(0, "The unit waits at an axis limit, the Sun is beyond it.")
    elif status is None or status.mode is not Mode.TRACK:
        sentences.insert(0, "The unit does not track: press t, and it goes to its Sun.")
    if is_set:
        sentences.insert(0, f"The offset is set: {next_words(app)}")
    if fields:
        sentences.append("Tab reaches the plate's fields, Esc the arrows.")
    if before is not None:
        sentences.append(f"u: offsets back to {_offsets(before)}.")
    return " ".join(sentences)


def can_take_points(state: StationState) -> bool:
    """Whether the calibration was begun, or is to be proven."""
    session = state.session
    return session is not None and (session.initialised is not None or bool(session.uploads))


def next_words(app: Workstation) -> str:
    """What follows a Set Sun Offset."""
    if can_take_points(app.state):
        return "watch it a minute and through one update, then take the point [.]."
    step = next_step(app.state)
    key = app.keys_of(step.action).partition(" ")[0]
    return f"next{key and f' [{key}]'}: {step.sentence}"


def set_words(record: SunOffset, before: Offsets | None, then: str) -> str:
    """What was set, the step that follows, and the offsets that can be put back."""
    back = "" if before is None else f" u: back to {_offsets(before)}."
    if record.slack_axes:
        axes = " and ".join(map(str, record.slack_axes))
        then = f"axis {axes} did NOT come from behind; b, then Enter, sets it anew. Or {then}"
    return f"SET and recorded: {_offsets(record.offsets)} deg. Tracking: {then}{back}"


def _offsets(offsets: Offsets) -> str:
    return f"O1 {offsets.O1:+z.4f}, O2 {offsets.O2:+z.4f}"


def _pair(values: tuple[float, float]) -> tuple[str, str]:
    return f"{values[0]:z.3f}", f"{values[1]:z.3f}"


def _two(cells: Iterable[str]) -> tuple[str, str]:
    first, second = cells
    return first, second
