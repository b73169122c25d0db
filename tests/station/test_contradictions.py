"""What a unit says twice is compared, what is written can be undone: live and after a resume."""

import msgspec
import pytest

from solarcal.errors import ProcedureRefused, SolarcalError, UnitRefused
from solarcal.model.evidence.direct import direct_findings
from solarcal.model.evidence.read_outs import losses
from solarcal.model.evidence.unit_state import held_evidence
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.journal import Journal
from solarcal.session.records import (
    InForce,
    PointRecord,
    RefCheck,
    Restarted,
    UploadBegun,
    UploadRecord,
)
from solarcal.session.view import read_session, view_session
from solarcal.station.clocks import EmulatedClock
from solarcal.station.next_step import next_step
from solarcal.station.procedure import Station
from solarcal.station.sign_off import sign_off
from solarcal.station.state import newest_upload
from solarcal.unit.frames import Code


def kinds(session):
    found = (*direct_findings(session), *held_evidence([session]))
    return [f.kind for f in found if f.certainty == "found"]


# -- the error is reading - ideal ------------------------------------------------------------------


def reports_offset(bench, monkeypatch, wrong: Offsets):
    """The unit reports another O than it drives by, with a right CRC."""
    honest = bench.unit.status

    def status():
        return msgspec.structs.replace(honest(), offsets=wrong)

    monkeypatch.setattr(bench.unit, "status", status)


def take(bench):
    station = bench.station
    station.begin_point()
    for _ in range(3):
        station.answer(True)
    return station.gather_point()


@pytest.mark.parametrize("off", [0.5, 500.0, -180.5])
def test_a_wrong_offset_refuses_the_point_before_it_is_stored(bench, monkeypatch, off):
    b = bench()
    b.on_sun()
    right = b.unit.status().offsets
    reports_offset(b, monkeypatch, Offsets(right.O1 + off, right.O2))
    with pytest.raises(ProcedureRefused, match=r"axis 1: the read-out less the ideal angle is"):
        take(b)
    (attempt,) = [r for r in read_session(b.path).records if isinstance(r, PointRecord)]
    assert attempt.status == "aborted"
    assert attempt.error_deg is None


def test_a_gathered_point_is_reading_less_ideal(bench):
    b = bench()
    b.on_sun()
    # The offset was set on the unit's own keys: the station has not seen it.
    b.unit.set_sun_offset()
    point = take(b)
    assert point.basis == "gathering"
    for axis in (0, 1):
        assert point.error_deg[axis] == pytest.approx(
            point.reading_deg[axis] - point.ideal_deg[axis], abs=1e-6
        )


def test_an_error_is_recorded_to_the_millionth_of_a_degree(bench, monkeypatch):
    b = bench()
    b.on_sun()
    b.unit.set_sun_offset()
    honest = b.unit.status

    def finer():
        status = honest()
        ideal1, ideal2 = status.ideal1_deg + 3e-6, status.ideal2_deg - 4e-6
        return msgspec.structs.replace(status, ideal1_deg=ideal1, ideal2_deg=ideal2)

    monkeypatch.setattr(b.unit, "status", finer)
    point = take(b)
    for axis in (0, 1):
        assert point.error_deg[axis] == pytest.approx(
            point.reading_deg[axis] - point.ideal_deg[axis], abs=1e-6
        )


def test_an_honest_offset_is_innocent_and_a_recorded_contradiction_is_found(bench):
    b = bench()
    b.on_sun()
    take(b)
    b.station.store(True)
    session = b.station.session
    assert "offsets" not in kinds(session)
    (point,) = session.accepted
    o = point.offsets
    bad = msgspec.structs.replace(point, offsets=Offsets(o.O1, o.O2 + 0.5))
    records = tuple(bad if r is point else r for r in session.records)
    assert "offsets" in kinds(view_session(session.header, records))
    shifted = msgspec.structs.replace(point, error_deg=(point.error_deg[0] + 0.5, 0.0))
    records = tuple(shifted if r is point else r for r in session.records)
    assert "offsets" in kinds(view_session(session.header, records))


# -- what an upload replaces -----------------------------------------------------------------------


def refuse_store(bench, monkeypatch):
    honest = bench.unit._talk.command

    def command(verb, *arguments, **more):
        if verb == "STORE":
            raise UnitRefused(Code.BUSY, "permanent memory busy", "STORE")
        return honest(verb, *arguments, **more)

    monkeypatch.setattr(bench.unit._talk, "command", command)


def test_a_refused_store_leaves_a_record_that_rolls_back(bench, monkeypatch):
    b = bench()
    b.on_sun()
    before = b.unit.stored()
    with monkeypatch.context() as patched:
        refuse_store(b, patched)
        with pytest.raises(SolarcalError, match="busy"):
            b.station.upload(Coefficients(P1=0.5), method="linear")
    assert b.unit.stored().coefficients == Coefficients(P1=0.5)
    *_, begun, outcome = read_session(b.path).records
    assert isinstance(begun, UploadBegun)
    assert isinstance(outcome, UploadRecord)
    assert not outcome.verified
    assert "busy" in outcome.failure
    assert begun.old_coefficients == outcome.old_coefficients == before.coefficients
    assert "The upload failed" in next_step(b.station.state).sentence
    assert b.station.rollback().verified
    assert b.unit.stored().coefficients == before.coefficients


def test_the_record_before_the_first_write_alone_is_enough_to_roll_back(bench):
    """As after a power cut of the laptop between the write and its outcome."""
    b = bench()
    b.on_sun()
    before = b.unit.stored()
    b.station.upload(Coefficients(P1=0.5), method="linear")
    session = read_session(b.path)
    cut = view_session(session.header, session.records[:-1])
    assert isinstance(cut.records[-1], UploadBegun)
    unfinished = newest_upload(cut.uploads)
    assert not unfinished.verified
    assert unfinished.old_coefficients == before.coefficients
    assert unfinished.new_coefficients == Coefficients(P1=0.5)


def test_nothing_is_recorded_of_an_upload_that_wrote_nothing(bench, monkeypatch):
    b = bench()
    b.on_sun()

    def silent():
        raise UnitRefused(Code.BUSY, "busy", "COEF")

    monkeypatch.setattr(b.unit, "stored", silent)
    with pytest.raises(SolarcalError):
        b.station.upload(Coefficients(P1=0.5), method="linear")
    assert not [r for r in read_session(b.path).records if isinstance(r, UploadBegun)]


# -- restarts --------------------------------------------------------------------------------------


def test_a_noticed_restart_explains_the_counts_of_the_next_check(bench):
    b = bench()
    b.on_sun()
    b.station.poll()
    before = b.station.session.records[-1]
    b.emulator.reboot()
    b.station.poll()
    b.station.poll()
    (restarted,) = b.station.session.restarts
    # Somewhen since what was recorded last.
    assert isinstance(restarted, Restarted)
    assert (restarted.seq, restarted.since) == (before.seq + 1, before.utc)
    b.station.ref_check()
    session = b.station.session
    check = session.ref_checks[-1]
    assert check.number == session.ref_checks[-2].number + 1
    assert any(abs(counts) > 5 for counts in check.difference_counts)
    assert losses(session) == ()
    assert "missed_counts" not in kinds(session)


def test_the_same_counts_without_a_restart_are_missed_counts(bench):
    b = bench()
    b.on_sun()
    b.station.ref_check()
    session = b.station.session
    check = session.ref_checks[-1]
    guilty = msgspec.structs.replace(check, difference_counts=(768, 0))
    records = tuple(guilty if r is check else r for r in session.records)
    assert "missed_counts" in kinds(view_session(session.header, records))
    restarted = Restarted(seq=check.seq, utc=check.utc)
    later = msgspec.structs.replace(guilty, seq=check.seq + 1)
    records = tuple(
        x for r in session.records for x in ((restarted, later) if r is check else (r,))
    )
    assert "missed_counts" not in kinds(view_session(session.header, records))


def test_the_numbers_of_checks_go_on_through_a_resume(bench):
    b = bench()
    b.on_sun()
    first = b.station.session.ref_checks[-1].number
    b.station.leave()
    b.emulator.reboot()
    b.unit.open()
    b.station.connect()
    b.station.resume_session(Journal.resume(b.path))
    b.station.ref_check()
    assert isinstance(b.station.session.records[-1], RefCheck)
    assert b.station.session.ref_checks[-1].number == first + 1
    assert losses(read_session(b.path)) == ()


def test_a_reference_lost_between_two_sessions_is_recorded_as_a_restart(bench):
    """Also where the only complete check is the first record of the file."""
    b = bench()
    b.station.ref_check()
    assert isinstance(b.station.session.records[0], RefCheck)
    b.station.leave()
    b.emulator.reboot()
    b.unit.open()
    later = Station(b.unit, EmulatedClock(b.emulation))
    later.connect()
    later.resume_session(Journal.resume(b.path))
    later.poll()
    assert [type(r) for r in later.session.restarts] == [Restarted]


# -- what is in force ------------------------------------------------------------------------------


def test_a_unit_that_lost_the_upload_gets_no_check_point_until_it_is_uploaded_again(bench):
    b = bench()
    b.on_sun()
    before = b.unit.stored()
    b.station.upload(Coefficients(P1=0.5), method="linear")
    b.unit.write_coefficients(Coefficients(), Offsets())
    b.station.track()
    with pytest.raises(ProcedureRefused, match="does not hold what was uploaded"):
        b.station.begin_point(check=True)
    session = b.station.session
    assert isinstance(session.records[-1], InForce)
    assert "not_held" in kinds(session)
    assert "upload again" in next_step(b.station.state).sentence
    assert "does not hold" in sign_off([session], None).reason
    again = b.station.upload_again()
    assert again.verified
    assert again.new_coefficients == b.unit.stored().coefficients == Coefficients(P1=0.5)
    assert "not_held" not in kinds(b.station.session)
    b.station.track()
    b.station.begin_point(check=True)
    b.station.abort_attempt("enough")
    # A rollback still leads to what the unit held before the first of the two.
    assert b.station.rollback().new_coefficients == before.coefficients


def test_it_is_compared_when_a_session_is_gone_on_with(bench):
    b = bench()
    b.on_sun()
    b.station.upload(Coefficients(P1=0.5), method="linear")
    b.station.leave()
    b.unit.open()
    b.unit.write_coefficients(Coefficients(P1=0.4), Offsets())
    b.station.connect()
    b.station.resume_session(Journal.resume(b.path))
    assert not b.station.session.holds_upload
    (found,) = held_evidence([read_session(b.path)])
    assert "P1 0.4 instead of 0.5" in found.sentence


def test_a_unit_that_holds_the_upload_is_innocent(bench):
    b = bench()
    b.on_sun()
    b.station.upload(Coefficients(P1=0.5), method="linear")
    assert b.station.compare_in_force()
    assert b.station.session.in_force == ()
