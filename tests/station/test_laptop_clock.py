"""Whose word is taken for the laptop's clock."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import pytest

from solarcal.config import Choice
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.model.analysis import Analysis
from solarcal.profiles import Profile
from solarcal.session.records import ClockSet
from solarcal.session.view import read_session, view_session
from solarcal.station import opening
from solarcal.station.analysing import analyse_session
from solarcal.station.clocks import laptop_clock
from solarcal.unit.drivers.solartrak import SolarTrakUnit

SESSIONS = Path(__file__).parents[2] / "sessions"
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


def judged(*signals: tuple[int, float]) -> Analysis:
    """A good day with time signals, seconds from the laptop's clock, after these records."""
    day = read_session(SESSIONS / "azel-good-day.jsonl")
    records = []
    for record in day.records:
        records.append(record)
        for after, off_s in signals:
            if record.seq == after:
                tick = ClockSet(
                    seq=after, utc=record.utc, before_s=0.0, after_s=0.0,
                    tick_minus_laptop_s=off_s, tick_sigma_s=0.5,
                )  # fmt: skip
                records.append(tick)
    numbered = [msgspec.structs.replace(r, seq=i) for i, r in enumerate(records, start=1)]
    analysis = analyse_session(view_session(day.header, tuple(numbered)))
    assert analysis is not None
    return analysis


BEFORE_POINTS, AFTER_POINTS = 1, 39


@pytest.mark.parametrize(
    "signals",
    [
        ((BEFORE_POINTS, 20.0),),
        ((AFTER_POINTS, -20.0),),
        # Corrected in the evening: the points were taken before.
        ((BEFORE_POINTS, 60.0), (AFTER_POINTS, 0.0)),
        # Set wrong in the evening, perhaps before the last point.
        ((BEFORE_POINTS, 0.0), (AFTER_POINTS, 60.0)),
    ],
)
def test_a_laptop_known_to_be_off_by_more_than_half_the_tolerance_fits_nothing(signals):
    analysis = judged(*signals)
    assert analysis.verdict.state == "does_not_fit"
    (told,) = [f for f in analysis.findings if f.kind == "laptop_clock"]
    assert told.certainty == "found"
    assert "correct the laptop's clock" in told.sentence


def test_a_laptop_corrected_before_the_first_point_is_right():
    analysis = judged((BEFORE_POINTS, 60.0), (2, 0.0), (AFTER_POINTS, 0.1))
    assert analysis.verdict.state == "done"
    (told,) = [f for f in analysis.findings if f.kind == "laptop_clock"]
    assert told.certainty == "not_determinable"
    assert "the signal was +0.1 +- 0.5 s from it" in told.sentence


def test_what_the_laptop_is_known_to_be_off_widens_the_year():
    exact, off = judged((BEFORE_POINTS, 0.0)), judged((BEFORE_POINTS, 10.0))
    sure, less = (a.forecast.probability_within_tolerance for a in (exact, off))
    assert less < sure - 0.02
    assert off.forecast.year_p95_deg > exact.forecast.year_p95_deg
