"""The unit's end of the wire: what docs/protocol.md promises a station."""

import pytest

from solarcal.emulator.protocol_server import REPLIES_REMEMBERED
from solarcal.unit.frames import Request, decode_reply, encode_request
from solarcal.unit.tracker import Mode

WRITES = (
    "CLOCK SET 20260603T060000.000",
    "SITE SET 35.0 -106.0 1800 7.00",
    "PARAM update_range 0.2",
    "MODE TRACK",
    "MODE MANUAL",
    "JOG 100.0 70.0",
    "OFFSET SET",
    "REF START",
    "COEF SET 0 0 0 0 0 0 0 0",
    "STORE",
)


def test_it_says_who_it_is(rig):
    assert rig().ask("ID") == ("SOLARTRAK-EMU", "0001", "1.0", "1", "X")


@pytest.mark.parametrize("request_text", WRITES)
def test_what_writes_or_moves_is_refused_while_locked(rig, request_text):
    tracker = rig(referenced=True)
    tracker.ask("LOCK")
    before = (tracker.status(), tracker.ask("COEF"), tracker.ask("CLOCK"), tracker.ask("SITE"))
    assert tracker.refusal(request_text) == 20
    after = (tracker.status(), tracker.ask("COEF"), tracker.ask("CLOCK"), tracker.ask("SITE"))
    assert after == before
    tracker.ask("UNLOCK")
    assert tracker.refusal(request_text) != 20


def test_the_unlock_times_out_after_a_minute_without_use(rig):
    tracker = rig()
    assert tracker.ask("UNLOCK") == ("60",)
    tracker.advance(59.0)
    tracker.ask("STORE")
    tracker.advance(59.0)
    assert tracker.status().unlocked_s == 1.0
    tracker.advance(1.0)
    assert tracker.refusal("STORE") == 20


def test_stop_and_stow_never_need_the_unlock(rig):
    tracker = rig(referenced=True)
    tracker.ask("LOCK")
    assert tracker.ask("STOW") == ("STOW",)
    tracker.advance(2.0)
    assert tracker.status().moving != (0, 0)
    assert tracker.ask("STOP") == ("STOP",)
    status = tracker.status()
    assert (status.mode, status.moving) == (Mode.STOP, (0, 0))


def test_a_damaged_line_is_answered_at_once(rig):
    emulator = rig().emulator
    good = encode_request(Request(1, "STATUS"))
    for bad in (good.replace(b"STATUS", b"STATUZ"), b"hello", b"\xff\xfe", b">0001 STATUS"):
        (line,) = emulator.handle_input(bad.rstrip() + b"\r\n")
        reply = decode_reply(line)
        assert (reply.seq, reply.code, reply.text) == (None, 10, "damaged frame")


def test_a_repeated_offset_set_is_executed_once(rig):
    tracker = rig(referenced=True)
    tracker.ask("UNLOCK")
    first = tracker.reply("OFFSET SET", seq=0xA000)
    tracker.advance(30.0)
    repeated = tracker.reply("OFFSET SET", seq=0xA000)
    assert repeated == first
    # Executed anew it would have taken up the Sun's way of half a minute.
    now = tracker.status().offsets
    assert f"{now.O1:.4f}" == first.fields[10]


def test_a_repeated_jog_does_not_renew_its_target(rig):
    tracker = rig(referenced=True)
    tracker.ask("UNLOCK")
    tracker.reply("JOG 60.0 60.0", seq=0xA000)
    for _ in range(6):
        tracker.advance(1.0)
        tracker.reply("JOG 60.0 60.0", seq=0xA000)
    status = tracker.status()
    assert status.mode is Mode.MANUAL
    assert status.reading1_deg == pytest.approx(118.0 - 5.0 * 0.8, abs=0.05)


def test_a_used_number_with_another_text_is_refused(rig):
    tracker = rig()
    tracker.reply("ID", seq=0xA000)
    assert tracker.reply("STATUS", seq=0xA000).code == 12
    assert tracker.reply("ID", seq=0xA000).fields[0] == "SOLARTRAK-EMU"


def test_only_so_many_replies_are_remembered(rig):
    tracker = rig()
    tracker.ask("UNLOCK")
    tracker.reply("LOCK", seq=0xA000)
    for _ in range(REPLIES_REMEMBERED - 1):
        tracker.ask("ID")
    assert tracker.reply("STATUS", seq=0xA000).code == 12
    tracker.ask("ID")
    assert not tracker.reply("STATUS", seq=0xA000).refused


def test_open_clears_the_memory_and_the_unlock_but_its_repetition_is_remembered(rig):
    tracker = rig(referenced=True)
    tracker.reply("UNLOCK", seq=0xA009)
    tracker.reply("JOG 60.0 60.0", seq=0xA010)
    assert tracker.reply("OPEN 0123ABCD", seq=0xA009).fields == ("0123ABCD",)
    status = tracker.status()
    assert (status.mode, status.unlocked_s, status.moving) == (Mode.MANUAL, 0.0, (0, 0))
    tracker.ask("UNLOCK")
    assert tracker.reply("OPEN 0123ABCD", seq=0xA009).fields == ("0123ABCD",)
    assert tracker.status().unlocked_s > 0.0
    assert tracker.refusal("OPEN 0123abcd") == 13


def test_stop_overtakes_what_waits_with_it_in_the_input(rig):
    tracker = rig(referenced=True)
    tracker.ask("UNLOCK")
    data = b"".join(
        encode_request(Request(seq, verb, arguments))
        for seq, verb, arguments in (
            (101, "ID", ()),
            (102, "JOG", ("60.0", "60.0")),
            (103, "MODE", ("TRACK",)),
            (104, "STOP", ()),
        )
    )
    replies = [decode_reply(line) for line in tracker.emulator.handle_input(data)]
    assert [reply.seq for reply in replies] == [104, 101, 102, 103]
    # What was sent before the STOP comes after it and must not move anything any more.
    assert [reply.code for reply in replies] == [None, None, 26, 26]
    assert tracker.status().mode is Mode.STOP
    assert tracker.refusal("REF START") == 26
    assert tracker.unlocked("MODE MANUAL") == ("MANUAL",)
    assert tracker.refusal("JOG 60.0 60.0") is None


def test_input_may_come_in_any_pieces(rig):
    emulator = rig().emulator
    data = encode_request(Request(1, "ID")) + encode_request(Request(2, "SITE"))
    replies = [line for byte in data for line in emulator.handle_input(bytes([byte]))]
    assert [decode_reply(line).seq for line in replies] == [1, 2]


@pytest.mark.parametrize(
    "request_text",
    [
        "JOG 10.0", "JOG a b", "COEF SET 1 2 3", "COEF GET", "MODE FLY", "PARAM speed",
        "PARAM tilt_decimals 3", "PARAM axis1.drive rotary:0", "PARAM axis1.limits 5:1",
        "PARAM update_range 0", "CLOCK SET yesterday", "SITE SET 95 0 0 0", "REF NOW",
        "OPEN", "X ADVANCE -1", "X ADVANCE 90000", "X FAULT plague", "X SPOT now", "STATUS now",
    ],
)  # fmt: skip
def test_a_bad_argument_is_refused_with_its_code(rig, request_text):
    tracker = rig(referenced=True)
    tracker.ask("UNLOCK")
    assert tracker.refusal(request_text) == 13


def test_unknown_requests_are_refused(rig):
    tracker = rig()
    assert tracker.refusal("FIRE") == 11
    assert tracker.refusal("X RAY") == 11
    assert tracker.refusal("X") == 11


def test_parameters_are_written_and_read_back(rig):
    tracker = rig()
    for name, value in (
        ("axis1.drive", "rotary:-1234.5"),
        ("axis2.limits", "10.00000:80.00000"),
        ("axis1.reference", "99.00000"),
        ("update_range", "0.25000"),
    ):
        assert tracker.unlocked(f"PARAM {name} {value}") == (value,)
        assert tracker.ask(f"PARAM {name}") == (value,)
    assert tracker.ask("PARAM tilt_decimals") == ("4",)


def test_the_site_can_be_set_and_moves_the_unit_s_sun(rig):
    tracker = rig()
    before = tracker.status()
    answer = tracker.unlocked("SITE SET 35.05 -106.48 1830.0 8.00")
    assert answer[3:] == ("8.00", "azel", "0.00000")
    # Same local clock, another zone: the unit now believes it is an hour later.
    assert tracker.status().unit_utc_s - before.unit_utc_s == pytest.approx(3600.0)
    assert tracker.status().ideal2_deg < before.ideal2_deg - 10.0


def test_temporary_and_permanent_memory(rig):
    tracker = rig()
    answer = tracker.unlocked("COEF SET 0.11114 0 0 0 0.0000004 0 1.5 0")
    assert answer[:4] == ("0.1111", "0.0000", "0.0000", "0.0000")
    assert answer[4:] == ("0.000000", "0.000000", "1.5000", "0.0000")
    assert tracker.ask("COEF STORED")[0] == "0.0000"
    assert tracker.status().memories_differ
    tracker.unlocked("STORE")
    assert tracker.ask("COEF STORED") == answer
    assert not tracker.status().memories_differ
    tracker.unlocked("COEF SET 0.5 0 0 0 0 0 0 0")
    tracker.ask("X FAULT reboot")
    assert tracker.ask("COEF") == answer


def test_mute_and_garbage_begin_and_end_with_their_own_reply(rig):
    tracker = rig()
    emulator = tracker.emulator
    assert tracker.ask("X FAULT mute") == ("mute",)
    assert emulator.handle_input(encode_request(Request(900, "ID"))) == []
    assert tracker.ask("X FAULT none") == ("none",)
    assert tracker.ask("X FAULT garbage") == ("garbage",)
    (noise,) = emulator.handle_input(encode_request(Request(901, "ID")))
    assert noise.endswith(b"\r\n")
    assert b"<0385" not in noise
    assert tracker.ask("X FAULT none") == ("none",)
    assert tracker.ask("ID")


def test_a_frozen_read_out_stands_still_while_the_other_moves(rig):
    tracker = rig(referenced=True)
    tracker.ask("X FAULT freeze1")
    before = tracker.status()
    tracker.unlocked("MODE TRACK")
    tracker.advance(600.0)
    after = tracker.status()
    assert after.counts1 == before.counts1
    assert after.counts2 != before.counts2
    tracker.ask("X FAULT none")
    assert tracker.status().counts1 != before.counts1


def test_a_reboot_loses_the_reference_but_not_the_clock(rig):
    tracker = rig(referenced=True)
    tracker.ask("X FAULT reboot")
    status = tracker.status()
    assert (status.mode, status.referenced, status.approach) == (Mode.MANUAL, False, (0, 0))
    assert status.unit_utc_s == pytest.approx(tracker.emulator.times_utc_s()[0], abs=1e-3)
    assert tracker.ask("REF")[:2] == ("0", "NONE")
