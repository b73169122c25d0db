"""An emulated rotator as other people's clients meet it: rotctld's answers, and EasyComm II."""

import re
from pathlib import Path

import pytest

from solarcal.emulator.rotator import EmulatedRotator
from solarcal.emulator.rotator_protocols import EasyCommProtocol, RotctldProtocol
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_tcp
from solarcal.mount.geometry import AxisLimits

PAGE = Path(__file__).parents[2] / "docs" / "emulator.md"


class Turntable:
    """Turns at once; remembers what it was sent."""

    azimuth = AxisLimits(50.0, 310.0)
    elevation = AxisLimits(2.0, 88.0)

    def __init__(self):
        self.at = (180.0, 45.5)
        self.calls = []

    def stands_deg(self):
        return self.at

    def go_to(self, azimuth_deg, elevation_deg):
        self.calls.append((azimuth_deg, elevation_deg))
        return self.azimuth.distance_deg(azimuth_deg) >= 0.0

    def stop(self):
        self.calls.append("stop")

    def park(self):
        self.calls.append("park")


# The right-hand sides are what Hamlib 4.5's rotctld with its dummy rotator answers to the same.
@pytest.mark.parametrize(
    ("line", "reply"),
    [
        ("p", ["180.00", "45.50"]),
        ("\\get_pos", ["180.00", "45.50"]),
        ("+p", ["get_pos:", "Azimuth: 180.00", "Elevation: 45.50", "RPRT 0"]),
        (";p", ["get_pos:;Azimuth: 180.00;Elevation: 45.50;RPRT 0"]),
        ("P 120 30", ["RPRT 0"]),
        ("P120 30", ["RPRT 0"]),
        ("+P 120 30", ["set_pos: 120 30", "RPRT 0"]),
        ("+\\set_pos 120 30", ["set_pos: 120 30", "RPRT 0"]),
        ("P 9999 0", ["RPRT -1"]),
        ("+P 9999 0", ["set_pos: 9999 0", "RPRT -1"]),
        ("P abc def", ["RPRT -1"]),
        ("S", ["RPRT 0"]),
        ("+K", ["park:", "RPRT 0"]),
        ("xyzzy", ["RPRT -1"]),
        ("\\nonsense", []),
        ("", []),
    ],
)
def test_rotctld_in_short_and_long_form(line, reply):
    assert RotctldProtocol().answer(Turntable(), line.encode()) == reply


def test_rotctlds_state_in_both_forms():
    protocol, machine = RotctldProtocol(), Turntable()
    plain = protocol.answer(machine, b"\\dump_state")
    assert plain[0] == "1"
    assert plain[2:4] == ["min_az=50.000000", "max_az=310.000000"]
    assert plain[-1] == "done"
    extended = protocol.answer(machine, b"+\\dump_state")
    assert extended[1] == "rotctld Protocol Ver: 1"
    assert "Maximum Elevation: 88.000000" in extended
    assert extended[-1] == "RPRT 0"


def test_easycomm_answers_questions_and_nothing_else():
    protocol, machine = EasyCommProtocol(decimals=1), Turntable()
    assert protocol.answer(machine, b"AZ EL\r") == ["AZ180.0 EL45.5"]
    assert protocol.answer(machine, b"EL") == ["EL45.5"]
    assert protocol.answer(machine, b"VE") == ["VEemulated-1.0"]
    for line in (b"AZ120.4 EL30.1", b"EL40.0", b"AZ9.0", b"SA SE", b"PARK", b"UP145000000 UMFM"):
        assert protocol.answer(machine, line) == []
    assert machine.calls == [
        (120.4, 30.1), (180.0, 40.0), (50.0, 45.5), "stop", "stop", "park",
    ]  # fmt: skip


def test_easycomm_goes_to_an_azimuth_on_the_turn_that_its_range_holds():
    """South of the equator the range holds North: the station sends 0 to 360 deg."""
    protocol, machine = EasyCommProtocol(), Turntable()
    machine.azimuth = AxisLimits(-128.0, 128.0)
    for line in (b"AZ350.0 EL60.0", b"AZ10.0 EL60.0", b"AZ-20.0 EL60.0", b"AZ180.0 EL60.0"):
        protocol.answer(machine, line)
    assert [azimuth for azimuth, _ in machine.calls] == [-10.0, 10.0, -20.0, 128.0]


def test_the_pages_client_follows_the_sun_and_misses_it_by_the_towers_lean():
    (block,) = re.findall(r"```python\n(import socket\n.*?)```", PAGE.read_text(), re.DOTALL)
    assert len([line for line in block.splitlines() if line.strip()]) <= 20
    page: dict = {}
    exec(block, page)
    site = page["Site"](35.05, -106.48, 1830.0)
    upright = ["truth.lean_deg=0", *(f"truth.{p}=0" for p in ("P2", "P4", "P5", "P6"))]
    missed = {}
    for name, settings in (("leaning", ["truth.noise_deg=0"]), ("upright", upright)):
        start = "start=2026-06-03T16:00:00Z"
        rotator = EmulatedRotator(load_scenario("tijeras-azel", [start, *settings]))
        with serve_tcp(rotator) as url:
            client = page["Client"]("127.0.0.1", int(url.rpartition(":")[2]), site)
            # The axes are on their way for a minute: the Sun of when they have arrived.
            utc_s = rotator.world.true_utc_s(120.0)
            assert client.follow(utc_s)
            rotator.advance(120.0)
            azimuth, elevation = client.reads()
            assert rotator.azimuth.distance_deg(azimuth) > 0.0
            assert elevation > 10.0
            client.lines.close()
        spot = rotator.spot()
        assert spot.visible
        missed[name] = max(abs(spot.error1_deg), abs(spot.error2_deg))
    assert missed["leaning"] > 0.3
    assert missed["upright"] < 0.1
