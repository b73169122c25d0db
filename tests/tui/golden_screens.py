"""Screens kept as text; numbers may differ a little from machine to machine, the rest may not.

``SOLARCAL_WRITE_GOLDENS=1`` writes them anew: look at every one before committing it.
"""

import os
import re
from pathlib import Path
from typing import Any

from procedure_bench import PATIENCE, paints, screen_text, settled_text
from textual.pilot import Pilot

FOLDER = Path(__file__).parent / "goldens"
NUMBER = re.compile(r"[-+]?\d+\.\d+")
PLOT = re.compile(r"[│┤├░]")
CELLS_OF_A_PLOT_LINE = 6
"""A value on the edge between two cells may fall either way."""


def check_golden(name: str, text: str) -> None:
    """Compare a screen with the one kept; the first line that differs is named."""
    path = FOLDER / f"{name}.txt"
    text = "\n".join(line.rstrip() for line in text.split("\n"))
    if os.environ.get("SOLARCAL_WRITE_GOLDENS"):
        path.write_text(text + "\n", encoding="utf-8")
    kept = path.read_text(encoding="utf-8").rstrip("\n").split("\n")
    shown = text.split("\n")
    for number, (want, got) in enumerate(zip(kept, shown, strict=False), start=1):
        assert same_line(want, got), f"{name}, line {number}:\nkept  {want}\nshown {got}\n\n{text}"
    assert len(kept) == len(shown), f"{name}: {len(kept)} lines kept, {len(shown)} shown"


async def shows_golden(pilot: Pilot[Any], name: str) -> None:
    """Wait for the screen as it is kept: layout follows words, and fits follow points, in time."""
    if os.environ.get("SOLARCAL_WRITE_GOLDENS"):
        check_golden(name, await settled_text(pilot))
        return
    looked_at = -1
    for _ in range(PATIENCE):
        # Looked at again only when something was painted since.
        if looked_at != paints(pilot.app):
            looked_at = paints(pilot.app)
            try:
                check_golden(name, screen_text(pilot.app))
            except AssertionError:
                pass
            else:
                return
        await pilot.pause(0.02)
    check_golden(name, screen_text(pilot.app))


def same_line(want: str, got: str) -> bool:
    if want == got:
        return True
    if NUMBER.sub("#", want) == NUMBER.sub("#", got):
        pairs = zip(NUMBER.findall(want), NUMBER.findall(got), strict=True)
        return all(near(a, b) for a, b in pairs)
    if PLOT.search(want) and len(want) == len(got):
        return sum(a != b for a, b in zip(want, got, strict=True)) <= CELLS_OF_A_PLOT_LINE
    return False


def near(a: str, b: str) -> bool:
    """Equal within three units of the last place or two per cent."""
    last = 10.0 ** -len(a.partition(".")[2])
    return abs(float(a) - float(b)) <= max(3.001 * last, 0.02 * abs(float(a)))
