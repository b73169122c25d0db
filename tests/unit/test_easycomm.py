"""Conversations in EasyComm II, as transcripts; one that is not read to its end fails."""

from types import SimpleNamespace

import pytest
from scripted_link import ScriptedLines

from solarcal.errors import LinkError, ProcedureRefused, ProtocolError
from solarcal.mount.geometry import AxisLimits
from solarcal.unit.drivers import easycomm
from solarcal.unit.drivers.easycomm import (
    ANSWER_S,
    ASKED_AT_MOST,
    BOOT_S,
    VERSION_S,
    EasyCommRotator,
)
from solarcal.unit.tracker import ROTATOR

OPENING = (("AZ EL", "AZ180.0 EL45.0"), ("VE", "VESatNOGS-v2.2"))
SILENT = ("AZ EL",)


def opened(*exchanges):
    link = ScriptedLines(*OPENING, *exchanges)
    rotator = EasyCommRotator(lambda: link, "/dev/ttyUSB0")
    rotator.open()
    return rotator, link


def test_it_says_its_version_and_its_last_digit():
    link = ScriptedLines(*OPENING)
    identity = EasyCommRotator(lambda: link, "/dev/ttyUSB0").open()
    assert (identity.model, identity.version) == ("EasyComm II", "SatNOGS-v2.2")
    assert (identity.azimuth, identity.elevation) == (AxisLimits(0, 360), AxisLimits(0, 180))
    assert identity.read_out_deg == 0.1
    link.assert_finished()


def test_firmware_that_restarts_with_the_line_is_given_its_time_once(monkeypatch):
    monkeypatch.setattr(easycomm, "time", SimpleNamespace(monotonic=lambda: 0.0))
    waits = []

    class Restarting(ScriptedLines):
        def read_line(self, timeout_s):
            waits.append(timeout_s)
            return super().read_line(timeout_s)

    link = Restarting(SILENT, *OPENING)
    EasyCommRotator(lambda: link, "/dev/ttyUSB0").open()
    # Firmware that knows no version is waited for less.
    assert [wait_s for wait_s in waits if wait_s > 0.0][:3] == [BOOT_S, ANSWER_S, VERSION_S]
    assert 0.0 < VERSION_S < ANSWER_S < BOOT_S
    link.assert_finished()


def test_firmware_without_a_version_is_served_too():
    link = ScriptedLines(("AZ EL", "AZ180.0 EL45.0"), ("VE",))
    assert EasyCommRotator(lambda: link, "/dev/ttyUSB0").open().version == ""
    link.assert_finished()


def test_both_answers_may_stand_on_lines_of_their_own():
    rotator, link = opened(("AZ EL", "AZ181.5", "EL44.5"))
    assert rotator.position_deg() == (181.5, 44.5)
    link.assert_finished()


def test_it_is_sent_with_as_many_decimals_as_it_shows():
    rotator, link = opened(
        ("AZ180.4 EL45.4",), ("AZ EL", "AZ180.25 EL45.31"), ("AZ180.35 EL45.43",)
    )
    rotator.go_to(180.354, 45.432, rotator.stops())
    rotator.position_deg()
    rotator.go_to(180.354, 45.432, rotator.stops())
    link.assert_finished()


def test_it_is_sent_with_four_decimals_at_most():
    rotator, link = opened(("AZ EL", "AZ180.123456 EL45.0"), ("AZ180.1235 EL45.1235",))
    rotator.position_deg()
    rotator.go_to(180.123456, 45.123456, rotator.stops())
    link.assert_finished()


def test_stop_overtakes_and_what_was_decided_before_it_does_not_move():
    rotator, link = opened(("SA SE",))
    decided = rotator.stops()
    rotator.stop()
    with pytest.raises(ProcedureRefused, match="stopped or parked"):
        rotator.go_to(10.0, 20.0, decided)
    link.assert_finished()


def test_a_line_that_is_opened_anew_is_no_stop():
    rotator, link = opened(*OPENING, ("AZ180.4 EL45.4",))
    decided = rotator.stops()
    rotator.open()
    rotator.go_to(180.4, 45.4, decided)
    link.assert_finished()


def test_parking_stops_first():
    rotator, link = opened(("SA SE",), ("PARK",))
    rotator.park()
    link.assert_finished()


def test_what_comes_unasked_is_no_answer():
    rotator, link = opened(("SA SE", "AZ10.0 EL10.0"), ("AZ EL", "ALmotor hot", "AZ180.1 EL45.0"))
    rotator.stop()
    assert rotator.position_deg() == (180.1, 45.0)
    link.assert_finished()


def test_silence_and_damage_are_asked_again():
    rotator, link = opened(SILENT, ("AZ EL", b"AZ18\xff.1 EL45.0"), ("AZ EL", "AZ180.1 EL45.0"))
    assert rotator.position_deg() == (180.1, 45.0)
    link.assert_finished()


def test_a_read_out_that_jumps_is_asked_again():
    rotator, link = opened(("AZ EL", "AZ980.0 EL45.0"), ("AZ EL", "AZ120.0 EL45.0"),
                           ("AZ EL", "AZ180.0 EL45.0"), ("AZ EL", "AZ180.2 EL45.0"))  # fmt: skip
    with pytest.raises(ProtocolError, match=r"AZ 180 EL 45, then AZ 120 EL 45, then AZ 180 EL 45"):
        rotator.position_deg()
    assert link.closed


def test_an_axis_that_really_is_far_away_is_believed_when_read_twice():
    rotator, link = opened(("AZ EL", "AZ190.0 EL45.0"), ("AZ EL", "AZ190.4 EL45.0"))
    assert rotator.position_deg() == (190.4, 45.0)
    link.assert_finished()


def test_silence_to_the_end_gives_the_line_up():
    rotator, link = opened(*[SILENT] * ASKED_AT_MOST)
    with pytest.raises(LinkError, match="no answer from the rotator at /dev/ttyUSB0"):
        rotator.position_deg()
    assert link.closed
    with pytest.raises(LinkError, match="not open"):
        rotator.position_deg()


def test_another_protocol_is_named():
    answers = [("AZ EL", "?>")] * ASKED_AT_MOST
    with pytest.raises(ProtocolError, match=r"answers '\?>', which is no EasyComm position"):
        EasyCommRotator(lambda: ScriptedLines(*answers), "/dev/ttyUSB0").open()


def test_numbers_that_are_no_direction_are_damage():
    rotator, link = opened(
        ("AZ EL", "AZ1e3 EL45.0"), ("AZ EL", "AZ800.0 EL45.0"), ("AZ EL", "AZ180.0 EL45.0")
    )
    assert rotator.position_deg() == (180.0, 45.0)
    link.assert_finished()


def test_a_rotator_turns_where_it_is_sent_and_has_nothing_of_a_controller():
    for name in (
        "has_controller", "has_clock", "has_switches", "has_offsets", "stores_coefficients",
    ):  # fmt: skip
        assert not getattr(ROTATOR, name), name
    assert ROTATOR.has_link
