"""Reading session files: ours, older, newer, and broken ones."""

import json
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from session_samples import HEADER, UTC, note, point

from solarcal.errors import SessionFileError, SolarcalError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.lines import decode_record, encode_record, sealed
from solarcal.session.parsing import parse_session
from solarcal.session.records import (
    Answers,
    CheckRecord,
    ClockSet,
    Closed,
    FitRecord,
    Header,
    InForce,
    Initialised,
    KnownRecord,
    LinkLost,
    LinkRestored,
    Override,
    Record,
    RefCheck,
    Restarted,
    SunOffset,
    Typed,
    UnknownRecord,
    UploadBegun,
    UploadRecord,
    Void,
)
from solarcal.session.view import read_session, view_session
from solarcal.session.voids import live_records, refuse_void

HEAD = encode_record(HEADER)

ONE_OF_EACH: tuple[Record, ...] = (
    Initialised(seq=1, utc=UTC, distance_to_limits_deg=12.5),
    ClockSet(seq=2, utc=UTC, before_s=-3.25, after_s=0.01),
    RefCheck(seq=3, utc=UTC, number=1, complete=True, difference_counts=(0, -1)),
    SunOffset(
        seq=4,
        utc=UTC,
        ideal_deg=(1.0, 2.0),
        reading_deg=(1.1, 2.1),
        counts=(110, -210),
        offsets=Offsets(0.1, 0.1),
        coefficients=Coefficients(),
        approach=(1, 0),
    ),
    point(5),
    CheckRecord(seq=6, utc=UTC, status="accepted", answers=Answers(), error_deg=(0.01, -0.02)),
    FitRecord(seq=7, utc=UTC, method="linear", points=5, coefficients=Coefficients(P5=1e-300),
              sigmas=None, sky_rms_deg=0.1 + 0.2),
    UploadRecord(seq=8, utc=UTC, old_coefficients=Coefficients(), old_offsets=Offsets(1.0, 2.0),
                 new_coefficients=Coefficients(P1=-0.0), new_offsets=Offsets(), verified=True),
    note(9, 'quotes " and \\ and \n newline \u2028'),
    Void(seq=10, utc=UTC, voids=9, reason="typing error"),
    Override(seq=11, utc=UTC, guard="limits", reason="no other time"),
    LinkLost(seq=12, utc=UTC, reason="silent"),
    LinkRestored(seq=13, utc=UTC, serial="0001"),
    Closed(seq=14, utc=UTC, reason="end of day", next="b.jsonl"),
    UploadBegun(seq=15, utc=UTC, old_coefficients=Coefficients(), old_offsets=Offsets(),
                new_coefficients=Coefficients(P1=0.5), new_offsets=Offsets(), forced="asked for"),
    InForce(seq=16, utc=UTC, coefficients=Coefficients(), offsets=Offsets(), as_uploaded=False),
    Restarted(seq=17, utc=UTC, since=UTC),
    Typed(seq=18, utc=UTC, form="point", read_utc=UTC, values={"AX1": "12.30"}, kept=("AX1",)),
    UnknownRecord(seq=19, utc=UTC, type="moonrise", fields={"phase": [1, {"a": None}]}),
)  # fmt: skip


def parse(*records: Record) -> tuple[Record, ...]:
    content = HEAD + b"".join(encode_record(r) for r in records)
    return tuple(parse_session(content, "day.jsonl").records)


def lines(*documents: dict[str, Any]) -> bytes:
    return HEAD + b"".join(sealed(json.dumps(d).encode()) for d in documents)


def test_every_kind_of_record_survives_the_file() -> None:
    assert parse(*ONE_OF_EACH) == ONE_OF_EACH
    assert {type(r) for r in ONE_OF_EACH} == {*get_args(KnownRecord), UnknownRecord} - {Header}


def test_unknown_fields_are_ignored() -> None:
    document = {**json.loads(encode_record(note(1))), "mood": "sunny"}
    assert parse_session(lines(document), "day.jsonl").records == [note(1)]


def test_an_unknown_record_still_needs_a_place_in_the_sequence() -> None:
    for bad in ({"type": "moonrise", "utc": UTC}, {"type": "moonrise", "seq": True, "utc": UTC}):
        with pytest.raises(SessionFileError, match=r"day\.jsonl:2: a 'moonrise' record without"):
            parse_session(lines(bad), "day.jsonl")


def test_a_future_format_is_refused_by_its_number(tmp_path: Path) -> None:
    path = tmp_path / "future.jsonl"
    path.write_text('{"type":"header","format":3,"other":"fields"}\n{"seq":"new"}\n')
    with pytest.raises(SessionFileError, match=r"newer solarcal \(format 3; this one reads 2\)"):
        read_session(path)


@pytest.mark.parametrize("version", ["0", "-1", "null", '"1"', "1.5"])
def test_a_format_that_never_was_is_refused(version: str) -> None:
    content = sealed(HEAD.replace(b'"format":2', b'"format":' + version.encode()))
    with pytest.raises(SessionFileError, match=r"day\.jsonl:1: .* is no session format"):
        parse_session(content, "day.jsonl")


def test_a_header_without_the_later_fields_is_read() -> None:
    document = json.loads(HEAD)
    for name in ("unknown", "continues", "weather", "operator", "tolerance_deg", "offsets"):
        del document[name]
    header = parse_session(sealed(json.dumps(document).encode()), "old.jsonl").header
    assert header.tolerance_deg == 0.1
    assert header.unknown == ()


@pytest.mark.parametrize(
    ("document", "complaint"),
    [
        ({"type": "note", "seq": 1, "utc": UTC}, r"missing required field `text`"),
        ({"type": "note", "seq": "1", "utc": UTC, "text": ""}, r"Expected `int`, got `str`"),
        ({"type": "note", "seq": 1, "utc": "noon", "text": ""}, r"'noon' is not a date and time"),
        ({"type": "note", "seq": 0, "utc": UTC, "text": ""}, r"sequence number 0 after 0"),
        ({"type": "void", "seq": 1, "utc": UTC, "voids": 1, "reason": ""}, r"no earlier record"),
        ({"type": "void", "seq": 1, "utc": UTC, "voids": 0, "reason": ""}, r"no earlier record"),
        ({"seq": 1, "utc": UTC}, r"missing required field `type`"),
        (json.loads(HEAD), r"a second header"),
        (
            {"type": "point", "seq": 1, "utc": UTC, "status": "accepted", "answers": {}},
            r"an accepted point without ideal_deg",
        ),
        (
            {"type": "point", "seq": 1, "utc": UTC, "status": "fine", "answers": {}},
            r"Invalid enum value 'fine'",
        ),
    ],
)
def test_a_bad_record_is_named_by_line_and_by_what_is_wrong(
    document: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(SessionFileError, match=r"^day\.jsonl:2: .*" + complaint):
        parse_session(lines(document), "day.jsonl")


def test_a_bad_site_in_the_header_is_named_too() -> None:
    content = sealed(HEAD.replace(b'"latitude_deg":35.05', b'"latitude_deg":95.0'))
    with pytest.raises(SessionFileError, match=r"^day\.jsonl:1: latitude 95 is not between"):
        parse_session(content, "day.jsonl")


def test_sequence_numbers_follow() -> None:
    assert [r.seq for r in parse(note(1), note(2))] == [1, 2]
    with pytest.raises(SessionFileError, match=r"day\.jsonl:3: sequence number 5 after 1: lines"):
        parse(note(1), note(5))
    with pytest.raises(SessionFileError, match=r"day\.jsonl:3: sequence number 1 after 1: lines"):
        parse(note(1), note(1))


@pytest.mark.parametrize("content", [b"", b"\n\n", b"hello\n", b'{"type":"note"}\n', b"\xff\xfe"])
def test_what_is_no_session_is_said_so(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.jsonl"
    path.write_bytes(content)
    with pytest.raises(SessionFileError, match=r"is empty|no complete|first line is no header"):
        read_session(path)


def test_missing_files_and_folders(tmp_path: Path) -> None:
    for path in (tmp_path / "none.jsonl", tmp_path, "a\0b"):
        with pytest.raises(SessionFileError, match=r"cannot be read|is missing: no such file"):
            read_session(path)


def test_the_order_of_many_records_is_checked() -> None:
    body = b"".join(encode_record(point(seq)) for seq in range(1, 1001))
    assert len(parse_session(HEAD + body, "day.jsonl").records) == 1000
    with pytest.raises(SessionFileError, match="sequence number"):
        parse_session(HEAD + 2 * body, "day.jsonl")


# -- voids -------------------------------------------------------------------------------------


def void(seq: int, voids: int) -> Void:
    return Void(seq=seq, utc=UTC, voids=voids, reason="wrong")


def test_a_void_strikes_and_a_void_of_the_void_restores() -> None:
    records: list[Record] = [point(1), point(2, "rejected"), void(3, 1)]
    assert [p.seq for p in view_session(HEADER, tuple(records)).points] == [2]
    assert [r.seq for r in live_records(records)] == [2, 3]
    records.append(void(4, 3))
    assert [p.seq for p in view_session(HEADER, tuple(records)).points] == [1, 2]
    records.append(void(5, 4))
    assert [p.seq for p in view_session(HEADER, tuple(records)).points] == [2]


def test_voids_that_strike_nothing_are_refused() -> None:
    records = [point(1), void(2, 1), point(3)]
    with pytest.raises(SessionFileError, match="the header, which cannot be voided"):
        refuse_void(HEADER, records, 0)
    with pytest.raises(SessionFileError, match=r"no record 9 in this session \(the last is 3\)"):
        refuse_void(HEADER, records, 9)
    with pytest.raises(SessionFileError, match="void already; to restore it, void record 2"):
        refuse_void(HEADER, records, 1)
    refuse_void(HEADER, records, 2)


@pytest.mark.parametrize("kind", ["in_force", "restarted", "upload_begun", "upload"])
def test_what_the_unit_was_seen_to_hold_or_to_do_cannot_be_struck(kind: str) -> None:
    seen = next(record for record in ONE_OF_EACH if record.__struct_config__.tag == kind)
    with pytest.raises(SessionFileError, match=f"record {seen.seq} says what the unit was seen"):
        refuse_void(HEADER, ONE_OF_EACH, seen.seq)


# -- any content at all ------------------------------------------------------------------------

finite = st.floats(allow_nan=False, allow_infinity=False)
pairs = st.tuples(finite, finite)
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=40)
point_records = st.builds(
    point,
    st.integers(1, 10**9),
    st.sampled_from(["accepted", "aborted", "rejected"]),
    ideal_deg=pairs,
    error_deg=pairs,
    reason=texts,
    sigma_deg=st.none() | finite,
    counts=st.none() | st.tuples(st.integers(-(2**62), 2**62), st.integers(-5, 5)),
)
json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | finite | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=8,
)
unknown_records = st.builds(
    UnknownRecord,
    seq=st.integers(1, 10**9),
    utc=st.just(UTC),
    type=texts.map(lambda t: "new " + t),
    fields=st.dictionaries(texts.filter(lambda k: k not in ("type", "seq", "utc")), json_values),
)


@settings(derandomize=True, max_examples=150, deadline=None)
@given(record=point_records | unknown_records | st.builds(note, st.integers(1, 99), texts))
def test_records_round_trip_to_the_last_bit(record: Record) -> None:
    line = encode_record(record)
    assert line.count(b"\n") == 1
    again = decode_record(line)
    assert again == record
    assert encode_record(again) == line


WHOLE = HEAD + b"".join(encode_record(r) for r in ONE_OF_EACH)


def read_or_refuse(content: bytes) -> None:
    refusal = ""
    try:
        parse_session(content, "fuzz.jsonl")
    except SolarcalError as error:
        refusal = str(error)
    assert "\n" not in refusal


@settings(derandomize=True, max_examples=200, deadline=None)
@given(content=st.binary(max_size=300), behind_header=st.booleans())
def test_random_bytes_are_only_ever_refused(content: bytes, behind_header: bool) -> None:
    read_or_refuse(HEAD + content if behind_header else content)


@settings(derandomize=True, max_examples=300, deadline=None)
@given(
    at=st.integers(0, len(WHOLE) - 1),
    length=st.integers(0, 30),
    patch=st.binary(max_size=6) | st.sampled_from([b"null", b"1e999", b'"', b"{", b"[" * 9999]),
)
def test_damaged_files_are_read_or_refused(at: int, length: int, patch: bytes) -> None:
    read_or_refuse(WHOLE[:at] + patch + WHOLE[at + length :])


def test_nothing_is_encoded_that_json_cannot_hold() -> None:
    with pytest.raises(SessionFileError, match="cannot be written"):
        encode_record(UnknownRecord(seq=1, utc=UTC, type="new", fields={"x": object()}))
    with pytest.raises(msgspec.ValidationError):
        decode_record(b'{"type":"note"}')
