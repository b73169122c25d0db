"""What a session records twice is compared; a contradiction is named and keeps it from done."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from solarcal.model.evidence.direct import Evidence, direct_findings
from solarcal.model.evidence.unit_state import check_evidence, held_evidence
from solarcal.model.finding import Finding
from solarcal.mount.drive import RotaryDrive, ScrewjackDrive, register
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.records import (
    Answers,
    CheckRecord,
    LinkRestored,
    PointRecord,
    Record,
    RefCheck,
    Restarted,
    UploadBegun,
)
from solarcal.session.view import SessionView, held_instead, read_session, view_session
from solarcal.station.analysing import analyse_session
from solarcal.station.sign_off import sign_off

SAVED = Path(__file__).parents[2] / "sessions"
DAY = read_session(SAVED / "azel-good-day.jsonl")
FIRST, FOURTH = DAY.accepted[0], DAY.accepted[3]
CHECK = next(r for r in DAY.records if isinstance(r, CheckRecord) and r.status == "accepted")
change = msgspec.structs.replace


def rewritten(edit: Callable[[Record], Record]) -> SessionView:
    return view_session(DAY.header, tuple(edit(record) for record in DAY.records))


def edited(seq: int, **changes: object) -> SessionView:
    return rewritten(lambda record: change(record, **changes) if record.seq == seq else record)


def of_the_unit(**changes: object) -> SessionView:
    header = change(DAY.header, unit=change(DAY.header.unit, **changes))
    return view_session(header, DAY.records)


def with_records(*more: Record, before: int) -> SessionView:
    """The day with these records in front of record ``before``; numbers are given anew."""
    at = next(i for i, record in enumerate(DAY.records) if record.seq == before)
    records = [*DAY.records[:at], *more, *DAY.records[at:]]
    return view_session(
        DAY.header, tuple(change(record, seq=i) for i, record in enumerate(records, start=1))
    )


def found(session: SessionView, kind: str) -> list[Finding]:
    """What is read in the records outranks residuals, and its subject is what it speaks of."""
    both = [f for f in direct_findings(session) if f.kind == kind and f.certainty == "found"]
    assert all(f.direct and (f.subject in f.sentence or f.subject[:4] != "axis") for f in both)
    return both


def state(session: SessionView) -> str:
    analysis = analyse_session(session)
    assert analysis is not None
    return analysis.verdict.state


@pytest.mark.parametrize("path", sorted(SAVED.glob("*.jsonl")), ids=lambda path: path.stem)
def test_no_saved_session_contradicts_itself(path: Path) -> None:
    kinds = {
        "counts",
        "limits",
        "answers",
        "another_unit",
        "restarted",
        "check_point",
        "offsets",
        "upload",
    }
    assert [f for kind in {*kinds, "offsets"} for f in found(read_session(path), kind)] == []
    assert state(DAY) == "done"


def test_counts_and_read_outs() -> None:
    first, second = FIRST.counts
    moved = edited(FIRST.seq, counts=(first + 1500, second))
    (finding,) = found(moved, "counts")
    assert finding.labels == (FIRST.seq,)
    assert f"{first + 1500:+d} counts are {FIRST.reading_deg[0] + 1.5:.3f}" in finding.sentence
    assert f"the read-out is {FIRST.reading_deg[0]:.3f} deg" in finding.sentence
    assert state(moved) == "does_not_fit"
    # A count or two, and what a read-out is rounded to, contradict nothing.
    assert found(edited(FIRST.seq, counts=(first + 2, second - 2)), "counts") == []
    for unread in ({"counts": None}, {"reading_deg": None}):
        assert found(edited(FIRST.seq, **unread), "counts") == []


@pytest.mark.parametrize(("off", "contradicts"), [(0, False), (1, True), (-1, True)])
def test_counts_of_a_coarse_drive_are_right_to_one(off: int, contradicts: bool) -> None:
    """A tenth of a degree each; a rounded one that is off by one is up to one and a half off."""
    unit = change(DAY.header.unit, drive1=RotaryDrive(counts_per_deg=10.0))

    def coarse(record: Record) -> Record:
        if not isinstance(record, PointRecord) or record.reading_deg is None:
            return record
        exact = (record.reading_deg[0] - unit.reference1_deg) * 10.0
        return change(record, counts=(round(exact) + off, record.counts[1]))

    session = view_session(change(DAY.header, unit=unit), tuple(map(coarse, DAY.records)))
    assert bool(found(session, "counts")) == contradicts


@pytest.mark.parametrize(
    "changes",
    [{"drive2": change(DAY.header.unit.drive2, counts_per_deg=900.0)}, {"reference1_deg": 100.0}],
    ids=["drive", "reference"],
)
def test_counts_by_another_drive_or_reference(changes: dict[str, object]) -> None:
    (finding,) = found(of_the_unit(**changes), "counts")
    assert finding.labels == tuple(p.seq for p in DAY.accepted)
    assert state(of_the_unit(**changes)) == "does_not_fit"


def test_counts_that_no_position_of_a_screwjack_has() -> None:
    jack = ScrewjackDrive(R1=40.0, R2=12.0, R3=2.5, beta_deg=70.0, counts_per_length=1200.0)
    header = change(DAY.header, unit=change(DAY.header.unit, drive2=jack))

    def of_the_jack(record: Record) -> Record:
        if not isinstance(record, PointRecord) or record.reading_deg is None:
            return record
        counts = register(jack, header.unit.reference2_deg, record.reading_deg[1])
        return change(record, counts=(record.counts[0], counts))

    whole = tuple(of_the_jack(record) for record in DAY.records)
    assert found(view_session(header, whole), "counts") == []
    bad = (FIRST.counts[0], 99_999_999)
    records = tuple(change(r, counts=bad) if r.seq == FIRST.seq else r for r in whole)
    (finding,) = found(view_session(header, records), "counts")
    assert (finding.subject, finding.labels, finding.number) == ("axis 2", (FIRST.seq,), None)
    assert "+99999999 counts are no angle by" in finding.sentence


def test_read_outs_beyond_the_limits() -> None:
    limits = DAY.header.unit.limits
    narrow = change(limits, axis1=change(limits.axis1, high_deg=100.0))
    (finding,) = found(of_the_unit(limits=narrow), "limits")
    said = f"(point {FIRST.seq}: axis 1: {FIRST.reading_deg[0]:.3f} is beyond -128..100"
    assert said in finding.sentence
    assert finding.labels == tuple(p.seq for p in DAY.accepted if p.reading_deg[0] > 100.1)
    assert len(finding.labels) > 1
    assert state(of_the_unit(limits=narrow)) == "does_not_fit"
    nearly = change(limits, axis1=change(limits.axis1, high_deg=FIRST.reading_deg[0] - 0.1))
    assert found(of_the_unit(limits=nearly), "limits") == []
    beyond = change(limits, axis1=change(limits.axis1, high_deg=FIRST.reading_deg[0] - 0.3))
    assert found(of_the_unit(limits=beyond), "limits") != []


@pytest.mark.parametrize("question", ["ref_check", "sun_offset", "tracking"])
def test_an_accepted_point_whose_answer_was_no(question: str) -> None:
    answers = change(FIRST.answers, **{question: False})
    (finding,) = found(edited(FIRST.seq, answers=answers), "answers")
    assert f"point {FIRST.seq} was accepted although" in finding.sentence
    assert state(edited(FIRST.seq, answers=answers)) == "continue"
    assert found(edited(FIRST.seq, answers=Answers()), "answers") == []
    refused = edited(FIRST.seq, answers=answers, status="rejected")
    assert found(refused, "answers") == []


@pytest.mark.parametrize(
    ("name", "number"),
    [("reading_deg", (100.0, 50.0)), ("ideal_deg", (100.0, 50.0)), ("offsets", Offsets(1.5, 0.0))],
)
def test_a_point_unlike_its_set_sun_offset(name: str, number: object) -> None:
    offset = next(o for o in DAY.sun_offsets if o.instant == FIRST.read_utc)
    other = edited(offset.seq, **{name: number})
    (finding,) = found(other, "offsets")
    assert finding.labels == (FIRST.seq,)
    assert f"Set Sun Offset (record {offset.seq})" in finding.sentence
    assert state(other) == "does_not_fit"


def test_another_unit_on_the_line() -> None:
    restored = LinkRestored(seq=0, utc=FOURTH.utc, serial="0002")
    other = with_records(restored, before=FOURTH.seq)
    (finding,) = found(other, "another_unit")
    assert "unit 0002 answered" in finding.sentence
    assert f"of unit {DAY.header.unit.serial}" in finding.sentence
    assert len(finding.labels) == len(DAY.accepted) - 3
    assert state(other) == "does_not_fit"
    ours = change(restored, serial=DAY.header.unit.serial)
    assert found(with_records(ours, before=FOURTH.seq), "another_unit") == []
    assert found(with_records(restored, ours, before=FOURTH.seq), "another_unit") == []
    still = with_records(restored, before=DAY.records[-1].seq)
    (finding,) = found(still, "another_unit")
    assert finding.labels == ()
    assert state(still) == "does_not_fit"


def test_points_between_a_restart_and_the_next_reference_check() -> None:
    restart = Restarted(seq=0, utc=FOURTH.utc)
    lost = with_records(restart, before=FOURTH.seq)
    (finding,) = found(lost, "restarted")
    labels = [p.seq for p in lost.accepted]
    assert finding.labels[0] == labels[3]
    checked = next(c.seq for c in lost.ref_checks if c.seq > labels[3])
    assert finding.labels == tuple(seq for seq in labels[3:] if seq < checked)
    assert state(lost) == "continue"
    check = RefCheck(seq=0, utc=FOURTH.utc, number=9, complete=True, difference_counts=(0, 0))
    assert found(with_records(restart, check, before=FOURTH.seq), "restarted") == []
    broken = change(check, complete=False)
    assert found(with_records(restart, broken, before=FOURTH.seq), "restarted") != []


def test_a_check_point_of_two_errors() -> None:
    smaller = edited(CHECK.seq, sky_error_deg=CHECK.sky_error_deg + 0.2)
    (finding,) = found(smaller, "check_point")
    assert f"recorded as {CHECK.sky_error_deg + 0.2:.4f}" in finding.sentence
    assert state(smaller) == "continue"
    larger = edited(CHECK.seq, error_deg=(0.5, 0.4))
    (finding,) = found(larger, "check_point")
    assert "+0.5000 and +0.4000 deg, O of its Set Sun Offset" in finding.sentence
    no = edited(CHECK.seq, answers=change(CHECK.answers, tracking=False))
    (finding,) = found(no, "check_point")
    assert "accepted although the answer on tracking was NO" in finding.sentence
    assert found(edited(CHECK.seq, error_deg=(0.5, 0.4), status="rejected"), "check_point") == []


def test_the_two_records_of_an_upload() -> None:
    (written,) = DAY.uploads
    fields = ("utc", "old_coefficients", "old_offsets", "new_coefficients", "new_offsets")
    begun = UploadBegun(seq=0, **{name: getattr(written, name) for name in fields})
    assert found(with_records(begun, before=written.seq), "upload") == []
    other = change(begun, new_coefficients=change(begun.new_coefficients, P1=1.5))
    two = with_records(other, before=written.seq)
    (finding,) = found(two, "upload")
    assert f"P1 {written.new_coefficients.P1:g} instead of 1.5" in finding.sentence
    assert f"records {written.seq} and {written.seq + 1}" in finding.sentence
    assert state(two) == "continue"
    other = change(begun, new_offsets=Offsets(2.0, 0.0))
    (finding,) = found(with_records(other, before=written.seq), "upload")
    assert "O1 0 instead of 2" in finding.sentence


def test_a_check_point_under_other_coefficients_than_were_uploaded() -> None:
    offset = next(o for o in DAY.sun_offsets if o.instant == CHECK.read_utc)
    under = edited(offset.seq, coefficients=change(offset.coefficients, P2=1.5))
    (finding,) = found(under, "check_point")
    assert "the unit did not hold what was uploaded: P2 1.5 instead of" in finding.sentence
    assert state(under) == "continue"


def test_a_session_without_a_reference_check_says_what_is_not_known() -> None:
    without = view_session(DAY.header, tuple(r for r in DAY.records if not isinstance(r, RefCheck)))
    (finding,) = [f for f in direct_findings(without) if f.kind == "missed_counts"]
    assert finding.certainty == "not_determinable"
    assert "no reference check is recorded" in finding.sentence
    rotator = change(DAY.header, unit=change(DAY.header.unit, has_switches=False))
    session = view_session(rotator, without.records)
    assert [f for f in direct_findings(session) if f.kind == "missed_counts"] == []


def test_a_point_that_is_not_fitted_contradicts_nothing() -> None:
    first, second = FIRST.counts
    moved = edited(FIRST.seq, counts=(first + 1500, second))
    used = {(p.seq, p.ideal_deg[1]) for p in DAY.accepted[1:]}
    assert [f for f in direct_findings(moved, used=used) if f.kind == "counts"] == []


def test_points_after_a_reference_check_that_was_broken_off() -> None:
    first = DAY.ref_checks[0]
    assert first.seq < FIRST.seq
    broken = edited(first.seq, complete=False)
    (finding,) = found(broken, "restarted")
    before = tuple(p.seq for p in DAY.accepted if p.seq < DAY.ref_checks[1].seq)
    assert finding.labels == before
    assert finding.sentence.startswith("reference check 1 did not end (record 2), and no ")
    assert state(broken) == "continue"


def test_a_point_that_repeats_the_offset_of_the_one_before() -> None:
    before = DAY.accepted[2]
    repeated = edited(FOURTH.seq, basis="gathering", read_utc=FOURTH.utc, offsets=before.offsets)
    (finding,) = [f for f in found(repeated, "answers") if "repeats" in f.sentence]
    assert finding.labels == (FOURTH.seq,)
    assert state(repeated) != "done"
    # Set on the unit's own keys: an O that it never had.
    anew = edited(FOURTH.seq, basis="gathering", read_utc=FOURTH.utc, offsets=Offsets(0.123, 0.4))
    assert found(anew, "answers") == []


@pytest.mark.parametrize(
    ("session", "told"),
    [
        (
            edited(CHECK.seq, read_utc=CHECK.utc, error_deg=(0.0, 0.0), sky_error_deg=0.0),
            "no Set Sun Offset was made for it",
        ),
        (edited(CHECK.seq, read_utc="2026-06-03T20:02:32.000Z"), "it was read before the upload"),
        (edited(CHECK.seq, read_utc=FOURTH.read_utc), "it was read before the upload"),
        (edited(CHECK.seq, ideal_deg=(10.0, 20.0)), "its Sun is not that of its Set Sun Offset"),
        (
            with_records(Restarted(seq=0, utc=CHECK.utc), before=CHECK.seq),
            "the unit had lost its reference, and no reference check was made before it",
        ),
        (
            with_records(LinkRestored(seq=0, utc=CHECK.utc, serial="9999"), before=CHECK.seq),
            "unit 9999 was on the line",
        ),
        (
            with_records(
                RefCheck(seq=0, utc=CHECK.utc, number=4, complete=True, difference_counts=(0, 500)),
                before=CHECK.seq + 1,
            ),
            "reference check 4 after it found +500 counts missed on axis 2",
        ),
    ],
)
def test_what_takes_a_check_point_its_meaning(session: SessionView, told: str) -> None:
    said = found(session, "check_point")
    assert any(told in one.sentence and "proves nothing" in one.sentence for one in said)
    assert state(session) != "done"
    assert not sign_off([session], analyse_session(session)).signed_off


@pytest.mark.parametrize("missing", ["error_deg", "ideal_deg"])
def test_a_check_point_whose_errors_or_sun_are_not_recorded_is_compared_with_nothing(
    missing: str,
) -> None:
    assert found(edited(CHECK.seq, **{missing: None}), "check_point") == []


def test_a_check_point_needs_a_reference_only_where_it_was_lost() -> None:
    """A rotator has no reference switches, and after a restart one check is enough."""
    records = [record for record in DAY.records if not isinstance(record, RefCheck)]
    assert found(view_session(DAY.header, tuple(records)), "check_point") == []
    again = RefCheck(seq=0, utc=CHECK.utc, number=4, complete=True, difference_counts=None)
    restart = Restarted(seq=0, utc=CHECK.utc)
    assert found(with_records(restart, again, before=CHECK.seq), "check_point") == []


def test_a_check_point_after_the_line_came_back_to_the_same_unit() -> None:
    ours = LinkRestored(seq=0, utc=CHECK.utc, serial=DAY.header.unit.serial)
    assert found(with_records(ours, before=CHECK.seq), "check_point") == []


def test_what_the_unit_had_when_it_was_seen_last_is_held_against_the_upload() -> None:
    (upload,) = DAY.uploads
    assert held_instead([DAY]) is None
    other = change(upload.new_coefficients, P2=1.5)
    later = edited(DAY.sun_offsets[-1].seq, coefficients=other)
    assert held_instead([later]) == (other, upload)
    (finding,) = held_evidence([later])
    assert "P2 1.5 instead of" in finding.sentence
    assert finding.direct
    assert state(later) == "continue"
    # A later session of the unit begins with other numbers, or with these.
    for held, same in ((upload.old_coefficients, False), (upload.new_coefficients, True)):
        header = change(DAY.header, utc="2026-06-10T13:00:00.000Z", coefficients=held)
        next_week = view_session(header, ())
        assert (held_instead([DAY, next_week]) is None) == same
        proof = sign_off([DAY, next_week], analyse_session(DAY))
        assert proof.signed_off == same
        assert ("does not hold what was uploaded" in proof.reason) != same
        # And an earlier one says nothing.
        before = view_session(change(header, utc="2026-05-10T13:00:00.000Z"), ())
        assert held_instead([before, DAY]) is None


def test_counts_missed_are_dated_by_the_points_of_one_session_alone() -> None:
    """Numbers of points of several files name no point."""
    second = DAY.ref_checks[1]
    lost = edited(second.seq, difference_counts=(0, 500))
    (finding,) = [f for f in analyse_session(lost).findings if f.kind == "missed_counts"]
    assert "likely" in finding.sentence
    table = lost.table
    other = replace(table, sources=("other.csv", *table.sources[1:]))
    assert len(Evidence(table, (lost,)).losses) == 1
    assert Evidence(other, (lost,)).losses == ()
    assert Evidence(table, (lost, DAY)).losses == ()


@pytest.mark.parametrize(
    ("earlier", "checks"),
    [
        ({}, 2),
        ({"verified": False}, 0),
        ({"new_coefficients": Coefficients(P2=1.5)}, 0),
        ({"new_offsets": Offsets(0.1, 0.0)}, 0),
    ],
)
def test_the_same_numbers_written_again_leave_check_points_their_meaning(
    earlier: dict[str, object], checks: int
) -> None:
    (upload,) = DAY.uploads
    again = change(upload, seq=DAY.records[-1].seq + 1)
    records = [change(r, **earlier) if r.seq == upload.seq else r for r in DAY.records]
    view = view_session(DAY.header, (*records, again))
    assert len(view.checks_after(view.uploads[-1])) == checks
    # A rejected one has no meaning to keep.
    refused = [change(r, status="rejected") if isinstance(r, CheckRecord) else r for r in records]
    assert view_session(DAY.header, tuple(refused)).checks_after(upload) == []


@pytest.mark.parametrize(
    ("sky_deg", "noise_deg", "proven"),
    [(0.09, 0.0, True), (0.11, 0.0, False), (0.5, 0.3, True), (0.6, 0.3, False), (None, 0.0, True)],
)
def test_a_check_point_beyond_the_tolerance_and_its_noise_proves_that_it_does_not_point(
    sky_deg: float | None, noise_deg: float, proven: bool
) -> None:
    """0.1 deg; one that is right on it reads more than 1.645 sigmas above it once in twenty."""
    findings = check_evidence(edited(CHECK.seq, sky_error_deg=sky_deg), noise_deg)
    assert (findings == ()) == proven
    for finding in findings:
        assert (finding.labels, finding.number, finding.direct) == ((CHECK.seq,), sky_deg, True)
        assert finding.sentence.startswith("1 of 2 check points after the upload: beyond the ")
    # A data point since then is judged by its own residual.
    later = change(FIRST, seq=DAY.records[-1].seq + 1)
    records = (*edited(CHECK.seq, sky_error_deg=sky_deg).records, later)
    assert check_evidence(view_session(DAY.header, records), noise_deg) == ()
