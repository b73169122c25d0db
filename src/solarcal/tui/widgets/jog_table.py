"""The axes while they are jogged: where they stand, where they go, from which side they came."""

import math
from collections.abc import Iterable

from textual.content import Content

from solarcal.station.jogging import TAKEN_UP_DEG, JogView


def jog_table(view: JogView, *, follows: bool, words: str) -> Content:
    """Both axes side by side, in 42 columns."""
    status = view.status
    readings = (status.reading1_deg, status.reading2_deg)
    ideals = (status.ideal1_deg, status.ideal2_deg)
    rows: list[str | tuple[str, str]] = [f"{'':10}{'axis 1':>15}{'axis 2':>15}\n"]

    def row(name: str, cells: tuple[str, str], style: str = "") -> None:
        rows.append((f"{name:10}{cells[0]:>15}{cells[1]:>15}\n", style))

    row("reading", _pair(readings))
    row("ideal", _pair(ideals))
    row("target", _pair(view.target_deg) if view.target_deg else ("-", "-"))
    row("off ideal", _two(f"{r - i:+.4f}" for r, i in zip(readings, ideals, strict=True)))
    row("offset O", (f"{status.offsets.O1:+.4f}", f"{status.offsets.O2:+.4f}"))
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
    aim = "follows the Sun" if follows else "stands still"
    rows.append(f"mode {status.mode}, aim {aim if view.aim else 'none yet'}\n")
    rows.append(f"update cycle {100.0 * status.update_phase:.0f} %\n")
    rows.append(words)
    return Content.assemble(*rows)


def _pair(values: tuple[float, float]) -> tuple[str, str]:
    return f"{values[0]:.3f}", f"{values[1]:.3f}"


def _two(cells: Iterable[str]) -> tuple[str, str]:
    first, second = cells
    return first, second
