"""The SolarTrak driver, as transcripts of what it says and hears."""

import msgspec
import pytest
from scripted_link import NOISE, OPENING, SITE, ScriptedLink
from test_fields import PARAMETERS, STATUS, STATUS_TEXT

from solarcal.errors import ConfigurationError, LinkError, ProtocolError, UnitRefused
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.station.connect import open_tracker
from solarcal.unit import fields
from solarcal.unit.conversation import Timing
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.fields import parameters_to_texts
from solarcal.unit.tracker import ROTATOR, TYPED, Capabilities, Mode, RefCheckResult, Spot, Truth


def connected(*exchanges, opening=OPENING):
    link = ScriptedLink(*opening, *exchanges)
    unit = SolarTrakUnit(lambda: link, port="/dev/ttyTEST")
    unit.open()
    return unit, link


def reading_parameters(seq):
    """The exchanges of ``parameters()``, its first request numbered ``seq``."""
    return [
        (f"{seq + k:04X} PARAM {name}", f"{seq + k:04X} OK {text}")
        for k, (name, text) in enumerate(parameters_to_texts(PARAMETERS).items())
    ]


def test_open_says_who_answers():
    link = ScriptedLink(*OPENING)
    unit = SolarTrakUnit(lambda: link)
    identity = unit.open()
    assert (identity.model, identity.serial, unit.capabilities.emulated) == (
        "SOLARTRAK-EMU",
        "0007",
        True,
    )
    link.assert_finished()


def test_a_controller_on_a_line_has_all_that_a_station_may_have_to_do_itself():
    own = msgspec.to_builtins(SolarTrakUnit(lambda: ScriptedLink()).capabilities)
    assert own.pop("emulated") is False
    assert set(own.values()) == {True}
    # A display is read by a person; a rotator has a line, and nothing of a controller.
    assert msgspec.structs.replace(TYPED, has_link=True) == Capabilities()
    assert {name for name, has in msgspec.to_builtins(ROTATOR).items() if has} == {"has_link"}


def test_open_survives_a_dirty_line():
    link = ScriptedLink(
        ("0001 OPEN ?", NOISE),
        ("0001 OPEN ?", "0001 OK DEADBEEF"),
        ("0001 OPEN ?", "0001 OK ?"),
        OPENING[1],
    )
    SolarTrakUnit(lambda: link).open()
    link.assert_finished()


def test_another_version_of_the_protocol_is_refused():
    link = ScriptedLink(OPENING[0], ("0002 ID", "0002 OK M S F 2 -"))
    with pytest.raises(ProtocolError, match="version 2"):
        SolarTrakUnit(lambda: link).open()


def test_opening_again_goes_on_with_new_numbers_and_another_nonce():
    first = ScriptedLink(*OPENING)
    second = ScriptedLink(
        ("0003 OPEN ?", "0001 OK 12345678", "0002 OK old", "0003 OK ?"),
        ("0004 ID", "0004 OK OTHER 2 1.0 1 -"),
    )
    links = iter([first, second])
    unit = SolarTrakUnit(lambda: next(links))
    unit.open()
    assert unit.open().model == "OTHER"
    assert first.closed
    assert not second.closed
    assert first.nonce != second.nonce
    assert unit.emulation is None
    second.assert_finished()


def test_without_open_there_is_no_line():
    with pytest.raises(LinkError, match="not open"):
        SolarTrakUnit(lambda: ScriptedLink()).status()


def test_close_closes_the_line_and_may_be_repeated():
    unit, link = connected()
    unit.close()
    unit.close()
    assert link.closed
    with pytest.raises(LinkError):
        unit.status()


def test_the_last_frames_are_shown_while_the_line_is_open():
    unit, _ = connected()
    assert any("OPEN" in frame for frame in unit.recent_traffic())
    unit.close()
    assert unit.recent_traffic() == ()


def test_status_asks_the_zone_once():
    unit, link = connected(
        ("0003 STATUS", f"0003 OK {STATUS_TEXT}"),
        ("0004 SITE", f"0004 {SITE}"),
        ("0005 STATUS", f"0005 OK {STATUS_TEXT}"),
    )
    assert unit.status() == STATUS
    assert unit.status() == STATUS
    link.assert_finished()


@pytest.mark.parametrize(
    ("flags", "referenced", "memories_differ"),
    [("00", False, False), ("01", True, False), ("02", False, True), ("03", True, True)],
)
@pytest.mark.parametrize(
    ("request_", "ask"),
    [("STATUS", SolarTrakUnit.status), ("OFFSET SET", SolarTrakUnit.set_sun_offset)],
)
def test_each_bit_of_the_flags_has_its_own_meaning(
    request_, ask, flags, referenced, memories_differ
):
    """As the protocol page has them: 1 referenced since power-up, 2 the memories differ."""
    text = STATUS_TEXT.replace(" 03 55", f" {flags} 55")
    unit, link = connected(("0003 SITE", f"0003 {SITE}"), (f"0004 {request_}", f"0004 OK {text}"))
    unit.site()
    status = ask(unit)
    assert (status.referenced, status.memories_differ) == (referenced, memories_differ)
    assert fields.status(7.0).write(status) == text.split()
    link.assert_finished()


@pytest.mark.parametrize(
    ("texts", "moving", "approach"),
    [
        (".. ..", (0, 0), (0, 0)),
        ("+. ..", (1, 0), (0, 0)),
        (".- ..", (0, -1), (0, 0)),
        (".. -.", (0, 0), (-1, 0)),
        (".. .+", (0, 0), (0, 1)),
    ],
)
def test_each_axis_moves_and_approached_by_its_own_sign(texts, moving, approach):
    text = STATUS_TEXT.replace(".+ +-", texts)
    unit, link = connected(("0003 SITE", f"0003 {SITE}"), ("0004 STATUS", f"0004 OK {text}"))
    unit.site()
    status = unit.status()
    assert (status.moving, status.approach) == (moving, approach)
    link.assert_finished()


def test_a_bad_field_names_port_request_and_field():
    bad = STATUS_TEXT.replace("45.67891", "nan")
    unit, _ = connected(("0003 SITE", f"0003 {SITE}"), ("0004 STATUS", f"0004 OK {bad}"))
    unit.site()
    with pytest.raises(ProtocolError, match="/dev/ttyTEST, reply to STATUS: field ideal2: 'nan'"):
        unit.status()


def test_parameters():
    unit, link = connected(*reading_parameters(3))
    assert unit.parameters() == PARAMETERS
    link.assert_finished()


def test_the_clock_is_set_in_the_units_local_time():
    unit, link = connected(
        ("0003 SITE", f"0003 {SITE}"),
        ("0004 CLOCK SET 20260621T090000.125", "0004 NO 20 locked"),
        ("0005 UNLOCK", "0005 OK 60"),
        ("0006 CLOCK SET 20260621T090000.125", "0006 OK 20260621T090000.125 7.00"),
    )
    unit.set_clock(STATUS.unit_utc_s)
    link.assert_finished()


def test_a_zone_changed_behind_our_back_is_noticed_when_the_clock_is_set():
    unit, _ = connected(
        ("0003 SITE", f"0003 {SITE}"),
        ("0004 CLOCK SET 20260621T090000.125", "0004 OK 20260621T090000.125 6.00"),
    )
    with pytest.raises(ProtocolError, match="zone"):
        unit.set_clock(STATUS.unit_utc_s)


def test_modes_jog_stop_and_stow():
    unit, link = connected(
        ("0003 MODE TRACK", "0003 OK TRACK"),
        ("0004 MODE MANUAL", "0004 OK MANUAL"),
        ("0005 JOG -12.50000 45.00000", "0005 OK -12.50000 45.00000"),
        ("0006 STOP", "0006 OK STOP"),
        ("0007 STOW", "0007 OK STOW"),
    )
    unit.set_mode(Mode.TRACK)
    unit.set_mode(Mode.MANUAL)
    unit.jog(-12.5, 45.0)
    unit.stop()
    unit.stow()
    link.assert_finished()


def test_only_track_and_manual_can_be_set():
    unit, link = connected()
    with pytest.raises(ConfigurationError):
        unit.set_mode(Mode.REF)
    link.assert_finished()


def test_a_jog_to_nowhere_is_never_sent():
    unit, link = connected()
    with pytest.raises(ProtocolError):
        unit.jog(float("nan"), 0.0)
    link.assert_finished()


def test_a_unit_that_takes_another_target_is_not_believed():
    unit, _ = connected(("0003 JOG 10.00000 20.00000", "0003 OK 10.00000 21.00000"))
    with pytest.raises(ProtocolError, match="jog"):
        unit.jog(10.0, 20.0)


def test_set_sun_offset_returns_that_instant():
    unit, link = connected(
        ("0003 OFFSET SET", f"0003 OK {STATUS_TEXT}"), ("0004 SITE", f"0004 {SITE}")
    )
    assert unit.set_sun_offset() == STATUS
    link.assert_finished()


def test_the_reference_check():
    unit, link = connected(
        ("0003 REF START", "0003 OK 4"),
        ("0004 REF", "0004 OK 4 RUNNING 0 0"),
        ("0005 REF", "0005 OK 4 DONE 1 -2"),
    )
    unit.start_ref_check()
    assert unit.ref_check_result() == RefCheckResult(4, False, 0, 0, running=True)
    assert unit.ref_check_result() == RefCheckResult(4, True, 1, -2)
    link.assert_finished()


OLD = "0.0100 0.0200 0.0000 0.0000 0.000000 0.000000 0.5000 -0.5000"
NEW = "0.0512 -0.1200 0.3000 0.0000 0.000300 -0.000100 0.0000 0.0000"
NEW_P = Coefficients(0.05123, -0.12, 0.3, -0.00001, 0.0003, -0.0001)


def test_coefficients_are_written_stored_and_read_back_in_one_go():
    unit, link = connected(
        *reading_parameters(3),
        (f"000E COEF SET {NEW}", "000E NO 20 locked"),
        ("000F UNLOCK", "000F OK 60"),
        (f"0010 COEF SET {NEW}", f"0010 OK {NEW}"),
        ("0011 COEF", f"0011 OK {NEW}"),
        ("0012 STORE", "0012 OK 1"),
        ("0013 COEF STORED", f"0013 OK {NEW}"),
    )
    kept = unit.write_coefficients(NEW_P, Offsets())
    assert kept.coefficients == kept.permanent_coefficients == NEW_P.rounded(4, 6)
    assert kept.offsets == kept.permanent_offsets == Offsets()
    link.assert_finished()


def test_a_lost_reply_to_coef_set_is_repeated_under_the_same_number():
    unit, link = connected(
        *reading_parameters(3),
        (f"000E COEF SET {NEW}",),
        (f"000E COEF SET {NEW}", NOISE),
        (f"000E COEF SET {NEW}", f"000E OK {NEW}"),
        ("000F COEF", f"000F OK {NEW}"),
        ("0010 STORE", "0010 OK 1"),
        ("0011 COEF STORED", f"0011 OK {NEW}"),
    )
    unit.write_coefficients(NEW_P, Offsets())
    link.assert_finished()


def test_coefficients_the_unit_kept_otherwise_are_not_stored():
    unit, link = connected(
        *reading_parameters(3),
        (f"000E COEF SET {NEW}", f"000E OK {OLD}"),
        ("000F COEF", f"000F OK {OLD}"),
        ("0010 COEF STORED", f"0010 OK {OLD}"),
    )
    kept = unit.write_coefficients(NEW_P, Offsets())
    assert kept.coefficients != NEW_P.rounded(4, 6)
    link.assert_finished()


def test_a_unit_that_knows_of_no_target_is_no_heliostat():
    """Units older than the parameters refuse their names; any other refusal is one."""
    exchanges = reading_parameters(3)
    older = [
        (request, reply if " target" not in request and " mirror" not in request
         else f"{request[:4]} NO 13 bad argument")
        for request, reply in exchanges
    ]  # fmt: skip
    unit, link = connected(*older)
    assert unit.parameters().heliostat is None
    link.assert_finished()
    unit, _ = connected(("0003 PARAM axis1.drive", "0003 NO 13 bad argument"))
    with pytest.raises(UnitRefused):
        unit.parameters()


def test_both_memories_are_read():
    unit, link = connected(("0003 COEF", f"0003 OK {NEW}"), ("0004 COEF STORED", f"0004 OK {OLD}"))
    stored = unit.stored()
    assert stored.coefficients.P1 == 0.0512
    assert stored.permanent_offsets == Offsets(0.5, -0.5)
    link.assert_finished()


TIMES = "2026-06-21T16:00:00.000Z 2026-06-21T15:59:36.000Z"


def test_the_emulators_own_requests():
    unit, link = connected(
        ("0003 X TIME", f"0003 OK {TIMES} 60.000"),
        ("0004 X TIME", f"0004 OK {TIMES} 60.000"),
        ("0005 X ADVANCE 12.500000", f"0005 OK {TIMES}"),
        ("0006 X SPOT", "0006 OK 1 0.10000 -0.20000"),
        ("0007 X TRUTH", "0007 OK 0.1000 0 0 0 0.000100 0 0.01 0.02 0.03"),
        ("0008 X FAULT mute", "0008 OK mute"),
    )
    emulation = unit.emulation
    times = (1782057600.0, 1782057576.0)
    assert emulation.time() == times
    assert emulation.speed() == 60.0
    assert emulation.advance(12.5) == times
    assert emulation.spot() == Spot(True, 0.1, -0.2)
    assert emulation.truth() == Truth(Coefficients(P1=0.1, P5=0.0001), 0.01, 0.02, 0.03)
    emulation.fault("mute")
    link.assert_finished()


def test_a_time_that_only_advance_moves_is_asked_for_once():
    later = "2026-06-21T16:00:12.500Z 2026-06-21T15:59:48.500Z"
    unit, link = connected(
        ("0003 X TIME", f"0003 OK {TIMES} 0.000"),
        ("0004 X ADVANCE 12.500000", f"0004 OK {later}"),
        ("0005 X SPEED 60.000", "0005 OK 60.000"),
        ("0006 X TIME", f"0006 OK {later} 60.000"),
        ("0007 X TIME", f"0007 OK {TIMES} 0.000"),
    )
    emulation = unit.emulation
    assert [emulation.time()[0], emulation.speed()] == [1782057600.0, 0.0]
    emulation.advance(12.5)
    assert [unit.emulation.time()[0], emulation.speed()] == [1782057612.5, 0.0]
    emulation.set_speed(60.0)
    assert emulation.speed() == 60.0
    assert [emulation.time()[0], emulation.speed()] == [1782057600.0, 0.0]
    link.assert_finished()


def test_more_than_a_day_passes_in_pieces():
    unit, link = connected(
        ("0003 X ADVANCE 86400.000000", f"0003 OK {TIMES}"),
        ("0004 X ADVANCE 3600.000000", f"0004 OK {TIMES}"),
    )
    unit.emulation.advance(90000.0)
    link.assert_finished()
    for seconds in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ConfigurationError):
            unit.emulation.advance(seconds)


def test_x_requests_never_reach_a_unit_that_does_not_announce_them():
    emulator = ScriptedLink(*OPENING)
    real = ScriptedLink(
        ("0003 OPEN ?", "0003 OK ?"),
        ("0004 ID", "0004 OK SOLARTRAK 1 4.2 1 -"),
    )
    links = iter([emulator, real])
    unit = SolarTrakUnit(lambda: next(links))
    unit.open()
    left_over = unit.emulation
    unit.open()
    assert unit.emulation is None
    with pytest.raises(UnitRefused) as refusal:
        left_over.advance(1.0)
    assert refusal.value.code == 30
    real.assert_finished()


def test_an_unknown_driver_is_one_clear_line():
    with pytest.raises(ConfigurationError, match="no driver 'belt'; there is: solartrak"):
        open_tracker("/dev/null", driver="belt")


def test_only_an_advance_is_asked_for_longer():
    """A day of virtual time takes a while to compute; nothing else of an emulator does."""
    timing = Timing(answer_s=1.0, advance_s=50.0, repeats_after_silence=3)
    advance, spot = "0003 X ADVANCE 1.000000", "0004 X SPOT"
    silent = [(advance,)] * 20
    link = ScriptedLink(*OPENING, *silent, (advance, f"0003 OK {TIMES}"), *[(spot,)] * 4)
    unit = SolarTrakUnit(lambda: link, timing=timing)
    unit.open()
    unit.emulation.advance(1.0)
    with pytest.raises(LinkError):
        unit.emulation.spot()
    link.assert_finished()
