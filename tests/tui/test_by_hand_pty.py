"""The real program in a terminal, a unit by hand: one point by real keys, decimal commas too."""

import time
from datetime import UTC, datetime
from pathlib import Path

import pytest
from msgspec.structs import replace
from pty_bench import ALT_F3, ALT_F7, CTRL_S, DOWN, ENTER, ESC, F6, Terminal, in_real_time
from typed_screens import MOUNT, TRUTH

from solarcal.config import write_toml
from solarcal.mount.formula import Offsets, correction_deg
from solarcal.profiles import Profile
from solarcal.session.records import PointRecord, Typed
from solarcal.session.view import read_session
from solarcal.site import Site
from solarcal.station.described_unit import TypedControllerModel, unit_parameters, unit_site

F5 = b"\x1b[15~"


class Tracker:
    """A leaning tracker where it is an hour before noon now; knows what its display shows."""

    def __init__(self) -> None:
        hours = time.time() % 86400.0 / 3600.0
        # In the last hour of the UTC day that is across the date line.
        site = Site(15.0, ((11.0 - hours) * 15.0 + 180.0) % 360.0 - 180.0)
        self.zone_west_h = float(round(-site.longitude_deg / 15.0))
        mount = replace(MOUNT, zone_west_h=self.zone_west_h)
        self.profile = Profile(name="by-hand", driver="typed", site=site, mount=mount)
        self._held = TypedControllerModel(unit_site(mount, site), unit_parameters(mount, site))
        error = correction_deg(TRUTH, *self._held.ideal_deg(time.time()))
        self.offsets = Offsets(*(round(float(one), 3) for one in error))

    def clock(self, ahead_s: float = 0.0) -> str:
        shown_s = time.time() + ahead_s - 3600.0 * self.zone_west_h
        return datetime.fromtimestamp(shown_s, UTC).strftime("%H:%M:%S")

    def axes(self) -> tuple[str, str]:
        """As somebody types them whose keyboard has a comma."""
        reading = self._held.target_deg(time.time(), self.offsets)
        return f"{reading[0]:.2f}".replace(".", ","), f"{reading[1]:.2f}".replace(".", ",")


@pytest.mark.slow
@in_real_time
def test_one_point_by_real_keys(tmp_path: Path) -> None:
    tracker = Tracker()
    site, path = tmp_path / "by-hand.toml", tmp_path / "sessions" / "day.jsonl"
    write_toml(site, tracker.profile)
    o1, o2 = f"{tracker.offsets.O1:.3f}", f"{tracker.offsets.O2:.3f}"
    terminal = Terminal(tmp_path, "--site", str(site), "-o", str(path))
    try:
        terminal.shows("A real SolarTrak: type what its display shows")
        terminal.press(ENTER)
        terminal.shows("What the unit shows now")
        # P1..P6 and both offsets are zero: only the clock is typed.
        terminal.press(*[DOWN] * 8, tracker.clock(), ENTER)
        terminal.shows("TYPED BY HAND", "day.jsonl", "nothing yet of the axes")
        terminal.press(CTRL_S)
        terminal.shows("PRESS STOP ON THE UNIT")
        terminal.press(F5)
        terminal.shows("Reference check, at the unit")
        terminal.press(ENTER)
        terminal.shows("Did both reach their switches")
        terminal.press("yes", ENTER, "0", ENTER, "0", ENTER)
        terminal.shows("Check no. 1 complete")
        terminal.press(ESC)
        terminal.shows_no("Check no. 1 complete")
        terminal.press(F6)
        terminal.shows("Set Sun Offset, at the unit")
        terminal.press(ENTER)
        terminal.shows("Axis 1 came last in sense")
        ax1, ax2 = tracker.axes()
        # Both read-outs in the wrong field, then put right.
        terminal.press(ax2, ENTER, ax1, ENTER, o1, ENTER, o2, ENTER, ENTER, ENTER, ENTER)
        terminal.shows("AX1 and AX2 exchanged?")
        terminal.press(ax1, DOWN, ax2, ENTER)
        terminal.shows("Set Sun Offset: O =")
        terminal.press(ALT_F3)
        terminal.shows("Are you sure?")
        terminal.press("y")
        terminal.shows_no("Are you sure?")
        terminal.press(ALT_F7)
        for words in ("1. Did", "2. Did", "3. Do"):
            terminal.shows(words)
            terminal.press("y")
        terminal.shows("Type what the display shows")
        terminal.press(*(part for text in (*tracker.axes(), o1, o2, "") for part in (text, ENTER)))
        terminal.shows("Store it?")
        terminal.press("y")
        terminal.shows("1 point")
        assert terminal.quit() == 0
    finally:
        terminal.close()
    records = read_session(path).records
    (point,) = [record for record in records if isinstance(record, PointRecord)]
    assert (point.status, point.basis) == ("accepted", "sun_offset")
    assert point.error_deg == (tracker.offsets.O1, tracker.offsets.O2)
    typed = [record for record in records if isinstance(record, Typed)]
    assert [record.form for record in typed] == ["open", "reference", "offset", "point"]
    assert len(typed[2].corrected) == 1
