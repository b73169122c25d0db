"""Whose word is taken for the laptop's clock."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from solarcal.config import Choice
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.profiles import Profile
from solarcal.station import opening
from solarcal.station.clocks import laptop_clock
from solarcal.unit.drivers.solartrak import SolarTrakUnit

CHRONY = """Reference ID    : C0A80101 (192.168.1.1)
System time     : 0.000012345 seconds fast of NTP time
Leap status     : {}
"""
NTPQ = """     remote           refid      st t when poll reach
==============================================
{}10.0.0.1        .GPS.            1 u   33   64  377
"""


@pytest.mark.parametrize(
    ("tools", "synchronised", "said"),
    [
        ({"chronyc": CHRONY.format("Normal")}, True, "0.000012345 s off"),
        ({"chronyc": CHRONY.format("Not synchronised")}, False, "chrony has NOT"),
        ({"timedatectl": "NTPSynchronized=yes\n"}, True, "timedatectl"),
        ({"timedatectl": "NTPSynchronized=no\n"}, False, "NOT synchronised"),
        ({"ntpq": NTPQ.format("*")}, True, "ntpd"),
        ({"ntpq": NTPQ.format(" ")}, False, "follows no server"),
        ({}, None, "compare it with a time signal"),
        ({"timedatectl": "gibberish\n", "ntpq": NTPQ.format("*")}, True, "ntpd"),
    ],
)
def test_the_first_tool_that_knows_is_believed(
    tools: dict[str, str], synchronised: bool | None, said: str
) -> None:
    def ask(command: Sequence[str]) -> str | None:
        return tools.get(command[0])

    answer = laptop_clock(ask)
    assert answer.synchronised is synchronised
    assert said in answer.sentence


def test_this_laptop_answers_whatever_it_has() -> None:
    assert laptop_clock().sentence.endswith(".")


def test_an_emulated_unit_goes_by_an_exact_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The time is the emulator's: what the laptop's clock is known to does not matter."""
    monkeypatch.setattr(opening, "clock_sigma_s", lambda: 5.0)
    emulator = Emulator(load_scenario("tijeras-azel"), seed=1)
    unit = SolarTrakUnit(lambda: InProcessLink(emulator))
    unit.open()
    line = opening.open_line(unit, Choice(), Profile(), output=tmp_path / "new.jsonl")
    assert line.station.session.header.unmodelled.clock_s == 1.0
    line.close()
