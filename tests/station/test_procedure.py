"""The procedure as the manual tells it, and what it does not allow."""

import msgspec
import pytest

from solarcal.errors import LinkError, ProcedureRefused, SolarcalError, UnitRefused
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.journal import Journal
from solarcal.session.records import (
    CheckRecord,
    Closed,
    LinkLost,
    Override,
    PointRecord,
    RefCheck,
)
from solarcal.session.view import read_session
from solarcal.station.gathering import READINGS
from solarcal.station.question_evidence import question_evidence
from solarcal.station.state import PENDING, QUESTIONS, Activity, LinkState
from solarcal.tui.keys import BY_ID
from solarcal.unit.frames import Code
from solarcal.unit.tracker import Mode


def test_connecting_and_opening_the_file_moves_and_writes_nothing(bench):
    b = bench()
    before = b.unit.status()
    b.station.poll()
    after = b.unit.status()
    assert (before.mode, before.counts1, before.counts2) == (
        after.mode,
        after.counts1,
        after.counts2,
    )
    assert read_session(b.path).records == ()
    assert b.unit.stored().coefficients == Coefficients()


def test_a_point_needs_an_initialised_file(bench):
    b = bench()
    b.station.set_unit_clock()
    b.station.ref_check()
    b.station.track()
    with pytest.raises(ProcedureRefused, match="initialise the data file first"):
        b.station.begin_point()


def test_setting_the_clock_records_the_difference_before_and_after_to_a_millisecond(bench):
    b = bench("tijeras-azel", "truth.unit_offset_s=12.3456")
    found_s = b.station.poll().unit_utc_s - b.station.clock.utc_s()
    record = b.station.set_unit_clock()
    left_s = b.station.poll().unit_utc_s - b.station.clock.utc_s()
    assert record.before_s == pytest.approx(found_s, abs=0.00051)
    assert record.after_s == pytest.approx(left_s, abs=0.00051)
    assert record.before_s == pytest.approx(12.3456, abs=0.01)
    assert abs(record.after_s) < 0.01


def test_initialise_asks_for_confirmation_and_happens_once_per_file(bench):
    b = bench()
    with pytest.raises(ProcedureRefused, match="confirmation"):
        b.station.initialise(confirmed=False)
    b.technician.prepare()
    with pytest.raises(ProcedureRefused, match="closes this file"):
        b.station.initialise(confirmed=True)


def test_a_second_initialise_keeps_the_old_file_and_carries_the_evidence_over(bench):
    b = bench()
    b.on_sun()
    second = b.folder / "second.jsonl"
    b.station.initialise(confirmed=True, start_next=lambda h: Journal.create(second, h))
    old = read_session(b.path)
    assert isinstance(old.records[-1], Closed)
    assert old.records[-1].next == "second.jsonl"
    new = read_session(second)
    assert new.header.continues == "session.jsonl"
    assert new.header.site == old.header.site
    kinds = [type(r).__name__ for r in new.records]
    assert kinds == ["ClockSet", "RefCheck", "SunOffset", "Initialised"]
    assert b.station.session.fresh_sun_offset is not None


def test_near_a_limit_nothing_is_initialised_unless_overruled_with_a_reason(bench):
    b = bench("tijeras-azel", "unit.limits1_deg=[-128.0, 95.0]", "unit.reference1_deg=94.5",
              "truth.stands1_deg=92.0")  # fmt: skip
    b.station.set_unit_clock()
    b.station.ref_check()
    with pytest.raises(ProcedureRefused, match=r"0\.\d\d deg from a limit"):
        b.station.initialise(confirmed=True)
    with pytest.raises(ProcedureRefused, match="needs a reason"):
        b.station.initialise(confirmed=True, override_reason=" ")
    b.station.initialise(confirmed=True, override_reason="limit switch checked by hand")
    overrides = [r for r in b.station.session.records if isinstance(r, Override)]
    assert [o.reason for o in overrides] == ["limit switch checked by hand"]
    with pytest.raises(ProcedureRefused, match="a data point refused: the axes stand 0"):
        b.station.begin_point()


def test_the_three_questions_come_in_the_manuals_order(bench):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    asked = []
    while (attempt := b.station.state.attempt) and attempt.question:
        asked.append(attempt.question)
        b.station.answer(True)
    assert [q.split("?")[0] for q in asked] == [
        "Did you do a reference check",
        "Did you do a 'Set Sun Offset'",
        "Do you like the way it is tracking",
    ]
    assert b.station.state.activity is Activity.READY


@pytest.mark.parametrize("no_at", [0, 1, 2])
def test_the_first_no_ends_the_attempt_and_keeps_it_as_aborted(bench, no_at):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    for _ in range(no_at):
        b.station.answer(True)
    b.station.answer(False)
    point = b.station.session.points[-1]
    assert point.status == "aborted"
    answers = (point.answers.ref_check, point.answers.sun_offset, point.answers.tracking)
    assert answers == tuple([True] * no_at + [False] + [None] * (2 - no_at))
    assert point.error_deg is None
    assert b.station.state.activity is Activity.IDLE
    with pytest.raises(ProcedureRefused):
        b.station.gather_point()


def test_a_point_stands_on_the_set_sun_offset_it_was_taken_after(bench):
    b = bench(noise_deg=0.0)
    b.on_sun()
    offset = b.station.session.sun_offsets[-1]
    b.station.begin_point()
    for _ in range(3):
        b.station.answer(True)
    b.station.gather_point()
    point = b.station.store(True)
    assert isinstance(point, PointRecord)
    assert point.basis == "sun_offset"
    assert point.ideal_deg == offset.ideal_deg
    assert point.error_deg == pytest.approx(
        [r - i for r, i in zip(offset.reading_deg, offset.ideal_deg, strict=True)], abs=1e-6
    )
    # reading - ideal is E(P in force) + O; P is zero here.
    assert point.error_deg == pytest.approx([offset.offsets.O1, offset.offsets.O2], abs=2e-4)
    assert b.station.session.fresh_sun_offset is None


def gathered(b, check=False):
    """All questions answered with YES, and what is gathered stored."""
    b.station.begin_point(check=check)
    for _ in range(3):
        b.station.answer(True)
    b.station.gather_point()
    return b.station.store(True)


@pytest.mark.parametrize("seen", [True, False])
def test_a_point_on_an_offset_of_before_is_refused(bench, seen):
    """E(P) + O of an O that nobody has set on the Sun is no measurement."""
    b = bench(noise_deg=0.0)
    if seen:
        b.on_sun()
        assert gathered(b).basis == "sun_offset"
    else:
        b.technician.prepare()
        b.station.track()
        b.station.clock.wait(120.0)
    state = b.station.state
    told = " ".join(f.sentence for f in question_evidence(1, state.session, state.live))
    assert "and O is as it was: set it first" in told
    with pytest.raises(ProcedureRefused, match="O is one it had before"):
        gathered(b)
    assert b.station.state.activity is Activity.IDLE
    assert b.station.session.points[-1].status == "aborted"
    assert "O is one it had before" in b.station.session.points[-1].reason


def test_an_offset_set_on_the_units_own_keys_is_gathered(bench):
    b = bench(noise_deg=0.0)
    b.on_sun()
    gathered(b)
    assert b.technician.sight.centre()
    b.unit.set_sun_offset()
    b.station.track()
    b.station.clock.wait(60.0)
    second = gathered(b)
    assert second.basis == "gathering"
    assert "no Set Sun Offset seen" in second.reason


def test_a_check_point_on_the_offset_that_an_upload_wrote_is_refused(bench):
    b = bench(noise_deg=0.0)
    b.on_sun()
    gathered(b)
    b.station.upload(Coefficients(P1=0.1), method="linear", forced="to see what it leaves")
    b.station.track()
    b.station.clock.wait(300.0)
    with pytest.raises(ProcedureRefused, match="set the Sun offset first"):
        gathered(b, check=True)
    b.on_sun()
    check = gathered(b, check=True)
    assert check.sky_error_deg > 0.0
    # The check has put O back to zero, struck out or not.
    b.station.void(check.seq, "a bird")
    b.station.clock.wait(120.0)
    assert b.station.session.fresh_sun_offset is None
    with pytest.raises(ProcedureRefused, match="set the Sun offset first"):
        gathered(b, check=True)


def test_nothing_is_gathered_from_a_unit_that_does_not_track(bench):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    for _ in range(3):
        b.station.answer(True)
    b.unit.set_mode(Mode.MANUAL)
    with pytest.raises(ProcedureRefused, match="not tracking"):
        b.station.gather_point()
    assert b.station.session.points[-1].status == "aborted"


def test_a_rejected_point_stays_in_the_file_and_is_not_fitted(bench):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    for _ in range(3):
        b.station.answer(True)
    b.station.gather_point()
    b.station.store(False, "cloud came in")
    assert b.station.session.accepted == ()
    assert read_session(b.path).records[-1].reason == "cloud came in"


def test_a_unit_that_stops_answering_in_mid_point_leaves_an_aborted_attempt(bench):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    for _ in range(3):
        b.station.answer(True)
    b.emulation.fault("mute")
    with pytest.raises(LinkError):
        b.station.gather_point()
    records = read_session(b.path).records
    assert [type(r) for r in records[-2:]] == [LinkLost, PointRecord]
    assert records[-1].status == "aborted"
    assert b.station.state.live.link is LinkState.LOST
    assert b.station.state.activity is Activity.IDLE


def test_after_a_lost_line_the_same_unit_is_taken_up_again_and_another_is_refused(bench):
    b = bench()
    b.station.link_lost(LinkError("cable pulled"))
    b.station.reconnect()
    assert b.station.state.live.link is LinkState.CONNECTED
    assert [type(r).__name__ for r in b.station.session.records] == ["LinkLost", "LinkRestored"]
    b.station.link_lost(LinkError("cable pulled"))
    other = bench("tijeras-azel", "unit.serial=B-9999")
    b.station.tracker = other.unit
    with pytest.raises(ProcedureRefused, match="another unit answers"):
        b.station.reconnect()


@pytest.mark.parametrize(
    ("setting", "what"),
    [
        ("unit.ax1_centre_deg=10", "centre of the branch of axis 1"),
        ("site.latitude_deg=35.2", "latitude"),
    ],
)
def test_a_unit_that_was_set_up_again_while_the_line_was_lost_is_refused(bench, setting, what):
    b = bench()
    b.station.link_lost(LinkError("cable pulled"))
    ours, b.station.tracker = b.station.tracker, bench("tijeras-azel", setting).unit
    with pytest.raises(ProcedureRefused, match=f"another {what}"):
        b.station.reconnect()
    assert b.station.state.live.link is LinkState.LOST
    # Why it is still lost is what the screens show.
    assert f"another {what}" in b.station.state.live.link_message
    with pytest.raises(LinkError, match="not open"):
        b.station.tracker.status()
    b.station.tracker = ours
    b.station.reconnect()
    kinds = [type(r).__name__ for r in b.station.session.records]
    assert kinds == ["LinkLost", "LinkRestored"]


def test_a_line_that_comes_and_goes_fills_no_file(bench):
    b = bench()
    for _ in range(50):
        b.station.link_lost(LinkError("loose plug"))
        b.station.reconnect()
        b.station.clock.wait(5.0)
    kinds = [type(r).__name__ for r in b.station.session.records]
    assert kinds == ["LinkLost", "LinkRestored", "LinkLost"]
    # Held for half a minute it is back; how often it went meanwhile is in the record.
    b.station.clock.wait(30.0)
    b.station.poll()
    restored = b.station.session.records[-1]
    assert (type(restored).__name__, restored.losses) == ("LinkRestored", 48)
    b.station.clock.wait(60.0)
    b.station.link_lost(LinkError("loose plug"))
    assert type(b.station.session.records[-1]).__name__ == "LinkLost"


def test_what_is_done_on_a_line_that_came_back_stands_behind_its_return(bench):
    b = bench()
    for _ in range(3):
        b.station.link_lost(LinkError("loose plug"))
        b.station.reconnect()
    b.station.note("plug pushed in")
    kinds = [type(r).__name__ for r in b.station.session.records]
    assert kinds == ["LinkLost", "LinkRestored", "LinkLost", "LinkRestored", "Note"]
    assert b.station.session.records[3].losses == 1


def test_upload_is_one_transaction_and_clears_the_offsets(bench):
    b = bench()
    b.on_sun()
    assert b.unit.status().offsets != Offsets()
    wanted = Coefficients(0.12345678, -0.2, 0.3, 0.1, 0.00012345, -0.0002)
    upload = b.station.upload(wanted, method="linear")
    assert upload.verified
    assert upload.new_coefficients == Coefficients(0.1235, -0.2, 0.3, 0.1, 0.000123, -0.0002)
    stored = b.unit.stored()
    assert stored.coefficients == stored.permanent_coefficients == upload.new_coefficients
    # The correction must be applied once: offsets that survived would add to the coefficients.
    assert stored.offsets == stored.permanent_offsets == Offsets()
    assert b.unit.status().offsets == Offsets()


def test_rollback_restores_what_the_newest_upload_replaced(bench):
    b = bench()
    b.on_sun()
    before = b.unit.stored()
    b.station.upload(Coefficients(P1=0.5), method="linear")
    back = b.station.rollback()
    assert back.rollback
    assert back.verified
    assert b.unit.stored().coefficients == before.coefficients
    assert b.unit.stored().offsets == before.offsets


def test_a_rollback_is_repeated_only_where_the_unit_does_not_hold_it(bench):
    b = bench()
    before = b.unit.stored()
    b.station.upload(Coefficients(P1=0.5), method="linear")
    b.station.rollback()
    with pytest.raises(ProcedureRefused, match="is rolled back already"):
        b.station.rollback()
    assert len(b.station.session.uploads) == 2
    b.unit.write_coefficients(Coefficients(P1=0.7), Offsets())
    assert b.station.rollback().verified
    assert b.unit.stored().coefficients == before.coefficients
    b.station.upload(Coefficients(P1=0.4), method="linear")
    assert b.station.rollback().verified


def test_rollback_passes_over_an_upload_that_changed_nothing(bench):
    b = bench()
    before = b.unit.stored()
    for _ in range(2):
        b.station.upload(Coefficients(P1=0.5), method="linear")
    first, second = b.station.session.uploads
    assert first.changed
    assert not second.changed
    b.station.rollback()
    assert b.unit.stored().coefficients == before.coefficients


def test_check_points_come_after_an_upload_and_leave_no_offset_behind(bench):
    b = bench()
    b.on_sun()
    with pytest.raises(ProcedureRefused, match="after an upload"):
        b.station.begin_point(check=True)
    b.station.upload(Coefficients(), method="linear")
    b.station.track()
    b.on_sun()
    check = b.technician.take_point(check=True)
    assert isinstance(check, CheckRecord)
    assert check.sky_error_deg is not None
    assert check.sky_error_deg > 0.1  # nothing was corrected: the lean is still there
    offset = b.station.session.sun_offsets[-1]
    assert (check.read_utc, check.ideal_deg) == (offset.instant, offset.ideal_deg)
    assert b.unit.status().offsets == Offsets()


def test_a_jog_beyond_the_limits_is_refused_on_our_side_too(bench):
    b = bench()
    with pytest.raises(ProcedureRefused, match="beyond a limit"):
        b.station.jog(140.0, 40.0)


def test_stop_interrupts_a_reference_check(bench):
    b = bench()
    seen: list[float] = []

    def stop_soon(waited: float) -> None:
        seen.append(waited)
        if len(seen) == 2:
            b.station.stop()

    check = b.station.ref_check(stop_soon)
    assert isinstance(check, RefCheck)
    assert not check.complete
    assert b.unit.status().mode is Mode.STOP


def test_voiding_a_point_takes_it_out_of_the_fit_and_voiding_the_void_restores_it(bench):
    b = bench()
    b.on_sun()
    b.technician.take_point()
    (point,) = b.station.session.accepted
    void = b.station.void(point.seq, "spot was in a cloud")
    assert b.station.session.accepted == ()
    b.station.void(void.seq, "no, it was fine")
    assert b.station.session.accepted == (point,)
    with pytest.raises(SolarcalError, match="no record 999"):
        b.station.void(999, "x")


def test_nothing_is_shown_that_is_not_in_the_file(bench):
    b = bench()
    on_disk: list[int] = []

    def count(state):
        shown = len(state.session.records) if state.session else 0
        on_disk.append(len(read_session(b.path).records) - shown)

    b.station.subscribe(count)
    b.on_sun()
    b.technician.take_point()
    assert len(on_disk) > 20
    assert min(on_disk) >= 0


def test_a_line_lost_while_a_checks_offset_is_taken_back_leaves_no_accepted_check(
    bench, monkeypatch
):
    b = bench()
    b.on_sun()
    b.station.upload(Coefficients(), method="linear")
    b.station.track()
    b.on_sun()
    b.station.begin_point(check=True)
    for _ in range(3):
        b.station.answer(True)
    b.station.gather_point()

    def lost(*_: object) -> None:
        raise LinkError("cable pulled")

    with monkeypatch.context() as patch:
        patch.setattr(b.unit, "write_coefficients", lost)
        with pytest.raises(LinkError):
            b.station.store(True)
    assert all(check.status != "accepted" for check in b.station.session.checks)


def test_an_upload_that_got_through_unrecorded_still_rolls_back_to_what_was_before(bench):
    b = bench()
    b.on_sun()
    before = b.station.session.header
    new = Coefficients(P1=0.5)
    # The line was lost after the unit had taken the numbers and before they were recorded.
    b.unit.write_coefficients(new, Offsets())
    upload = b.station.upload(new, method="linear")
    assert upload.old_coefficients == before.coefficients
    assert upload.old_offsets == before.offsets
    b.station.rollback()
    assert b.unit.stored().coefficients == before.coefficients


@pytest.mark.parametrize("got_through", [False, True])
def test_an_upload_repeated_after_a_lost_line_replaces_what_the_first_had(
    bench, monkeypatch, got_through
):
    b = bench()
    b.on_sun()
    before = b.unit.stored()
    new = Coefficients(P1=0.5)
    write = b.unit.write_coefficients

    def lost(*numbers, **how):
        if got_through:
            write(*numbers, **how)
        raise LinkError("cable pulled")

    for _ in range(2):
        with monkeypatch.context() as patch:
            patch.setattr(b.unit, "write_coefficients", lost)
            with pytest.raises(LinkError):
                b.station.upload(new, method="linear")
    upload = b.station.upload(new, method="linear")
    assert upload.verified
    assert upload.replaces == (before.coefficients, before.offsets)
    assert b.station.rollback().writes == upload.replaces


@pytest.mark.parametrize("at_reading", [1, 4])
def test_offsets_changed_at_the_unit_while_gathering_spoil_the_point(bench, at_reading):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    for _ in range(3):
        b.station.answer(True)
    shown = b.unit.status().offsets

    def at_the_keys(fraction: float) -> None:
        if fraction == pytest.approx(at_reading / READINGS):
            b.unit.write_coefficients(Coefficients(), Offsets(shown.O1 + 0.001, shown.O2))

    with pytest.raises(ProcedureRefused, match="offsets changed while gathering"):
        b.station.gather_point(at_the_keys)
    assert b.station.session.points[-1].status == "aborted"
    assert b.station.session.accepted == ()


@pytest.mark.parametrize(
    "wrong", ["coefficients", "permanent_coefficients", "offsets", "permanent_offsets"]
)
def test_an_upload_is_verified_only_if_both_memories_hold_all_of_it(bench, monkeypatch, wrong):
    b = bench()
    b.on_sun()
    write = b.unit.write_coefficients
    other = Offsets(O2=0.0001) if "offsets" in wrong else Coefficients(P6=0.000001)

    def kept_otherwise(coefficients, offsets):
        return msgspec.structs.replace(write(coefficients, offsets), **{wrong: other})

    with monkeypatch.context() as patch:
        patch.setattr(b.unit, "write_coefficients", kept_otherwise)
        upload = b.station.upload(Coefficients(P1=0.5), method="linear")
    assert not upload.verified
    assert not read_session(b.path).records[-1].verified
    assert b.station.upload(Coefficients(P1=0.5), method="linear").verified


def test_no_point_stands_on_a_set_sun_offset_from_before_an_upload(bench):
    """The upload clears O: where the collector was centred then says nothing of the new P."""
    b = bench()
    b.on_sun()
    assert b.station.session.fresh_sun_offset is not None
    b.station.upload(Coefficients(P1=0.1), method="linear")
    assert b.station.session.fresh_sun_offset is None
    b.on_sun()
    assert b.station.session.fresh_sun_offset == b.station.session.sun_offsets[-1]


@pytest.mark.parametrize("no_at", [1, 2, 3])
def test_a_no_opens_no_further_question(bench, no_at):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    asked = []

    def seen(state):
        if state.activity is Activity.QUESTIONS and state.attempt is not None:
            question_evidence(state.attempt.asked, state.session, state.live)
            asked.append(state.attempt.asked)

    b.station.subscribe(seen)
    for number in range(1, no_at + 1):
        b.station.answer(number < no_at)
    assert max(asked, default=0) < no_at


@pytest.mark.parametrize("code", [Code.BUSY, Code.SUN_DOWN, Code.LOCKED])
def test_only_a_lost_reference_sends_the_technician_to_a_reference_check(bench, monkeypatch, code):
    b = bench()
    b.technician.prepare()
    checks = len(b.station.session.ref_checks)

    def refused():
        raise UnitRefused(code, "not now", "TRACK")

    monkeypatch.setattr(b.station, "track", refused)
    with pytest.raises(UnitRefused, match="not now"):
        b.technician.take_points()
    assert len(b.station.session.ref_checks) == checks


@pytest.mark.parametrize("code", [Code.MOVING, Code.SUN_DOWN])
def test_a_unit_that_refuses_to_track_is_referenced_again_only_where_it_says_so(
    bench, monkeypatch, code
):
    b = bench()
    checks = len(b.station.session.ref_checks)

    def refused():
        raise UnitRefused(code, "not now", "TRACK")

    monkeypatch.setattr(b.station, "track", refused)
    monkeypatch.setattr(b.technician, "take_point", lambda check: None)
    with pytest.raises(UnitRefused, match="not now"):
        b.technician.take_checks()
    assert len(b.station.session.ref_checks) == checks


def test_the_technician_lets_a_unit_that_lost_its_reference_find_it_and_track(bench):
    b = bench()
    b.on_sun()
    checks = len(b.station.session.ref_checks)
    b.emulator.reboot()
    b.technician._track()
    status = b.station.poll()
    assert (status.referenced, status.mode) == (True, Mode.TRACK)
    assert len(b.station.session.ref_checks) == checks + 1
    b.technician._track()
    assert len(b.station.session.ref_checks) == checks + 1


def test_a_refused_step_says_what_is_pending_and_the_action_that_settles_it(bench):
    b = bench()
    b.on_sun()
    b.station.begin_point()
    with pytest.raises(ProcedureRefused, match="questions of a point are open; answer") as refused:
        b.station.ref_check()
    assert refused.value.action == "take_point"
    with pytest.raises(ProcedureRefused, match="no point to store or reject: the questions"):
        b.station.store(True)
    for _ in QUESTIONS:
        b.station.answer(True)
    b.station.gather_point()
    with pytest.raises(ProcedureRefused, match="not stored yet; store or reject it") as refused:
        b.station.ref_check()
    assert refused.value.action == "take_point"
    b.station.store(True)
    with pytest.raises(ProcedureRefused, match="no question to answer: no point is being taken"):
        b.station.answer(True)


def test_whatever_is_pending_has_a_sentence_and_an_action_that_there_is():
    assert set(PENDING) == set(Activity) - {Activity.IDLE}
    assert {pending.action for pending in PENDING.values()} <= {*BY_ID, None}
