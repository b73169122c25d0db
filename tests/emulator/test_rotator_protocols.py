"""An emulated rotator as other people's clients meet it: rotctld's answers, and EasyComm II."""

import pytest

from solarcal.emulator.rotator_protocols import EasyCommProtocol, RotctldProtocol
from solarcal.mount.limits import AxisLimits


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
