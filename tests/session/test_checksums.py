"""Format 2: what is written is proven line by line; format 1 is read as it was."""

import json
import re
from pathlib import Path

import pytest
from session_samples import HEADER, note, point

from solarcal.errors import SessionFileError
from solarcal.mount.formula import Offsets
from solarcal.session.journal import Journal
from solarcal.session.lines import checksums, crc32c, damaged_lines, encode_record, sealed
from solarcal.session.parsing import NeedsWholeReader, read_points_only
from solarcal.session.records import Closed, SunOffset
from solarcal.session.view import read_session, session_of

FORMAT_1 = Path(__file__).parent / "format_1_day.jsonl"
SAME_DAY = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"


def bit_by_bit(content: bytes) -> int:
    register = 0xFFFFFFFF
    for byte in content:
        register ^= byte
        for _ in range(8):
            register = (register >> 1) ^ (0x82F63B78 if register & 1 else 0)
    return register ^ 0xFFFFFFFF


def test_the_published_values_come_out() -> None:
    """RFC 3720 B.4, where the bytes of the sum stand lowest first, and the usual check value."""
    assert crc32c(b"123456789") == 0xE3069283
    assert crc32c(bytes(32)) == 0x8A9136AA
    assert crc32c(b"\xff" * 32) == 0x62A8AB43
    assert crc32c(bytes(range(32))) == 0x46DD794E


def test_lines_of_every_length_are_summed_at_once() -> None:
    lengths = [*range(40), 2047, 2048, 2049, 2050, 2053, 4095, 4097, 9000]
    lines = [bytes((7 * i + n) % 256 for i in range(n)) for n in lengths]
    assert list(checksums(lines)) == [bit_by_bit(line) for line in lines]
    assert list(checksums([])) == []


def test_of_a_long_file_every_line_has_its_own_sum_in_order() -> None:
    lines = [b"line %d of a thousand" % number for number in range(1000)]
    assert list(checksums(lines)) == [crc32c(line) for line in lines]


def test_a_sealed_line_that_was_changed_can_be_sealed_again() -> None:
    line = encode_record(note(1))
    assert sealed(line) == line
    assert sealed(line.replace(b"west", b"east")) == encode_record(note(1, "clouds from the east"))


def test_a_file_of_format_1_gives_the_same_records_and_its_lack_is_said_once(tmp_path) -> None:
    old, new = read_session(FORMAT_1), read_session(SAME_DAY)
    assert old.header.format == 1
    assert old.records == new.records
    assert old.warnings == (
        f"{FORMAT_1} is of format 1, without checksums: a changed byte in it can go unnoticed",
    )
    with pytest.raises(NeedsWholeReader):
        read_points_only(FORMAT_1)


def test_a_session_of_format_1_goes_on_with_checksums(tmp_path: Path) -> None:
    path = tmp_path / "old.jsonl"
    path.write_bytes(FORMAT_1.read_bytes())
    with Journal.resume(path) as journal:
        added = note(journal.next_seq)
        journal.append(added)
    content = path.read_bytes()
    assert read_session(path).records[-1] == added
    with pytest.raises(SessionFileError, match=r"^old\.jsonl:\d+: the line was changed"):
        session_of(content.replace(b"from the west", b"from the east"), "old.jsonl")


def test_a_missing_line_is_an_error_and_a_missing_end_a_warning() -> None:
    lines = SAME_DAY.read_bytes().splitlines(keepends=True)
    with pytest.raises(
        SessionFileError, match=r"^a:20: sequence number 20 after 18: lines are mis"
    ):
        session_of(b"".join(lines[:19] + lines[20:]), "a")
    assert session_of(b"".join(lines[:-1]), "a").warnings == (
        "a was not closed: the session goes on, or its end is missing",
    )


def test_a_whole_last_line_without_its_checksum_is_an_error_and_a_cut_one_a_warning() -> None:
    lines = SAME_DAY.read_bytes().splitlines(keepends=True)[:9]
    bare = re.sub(rb',"crc32c":"[0-9a-f]+"', b"", lines[-1])
    assert bare != lines[-1]
    with pytest.raises(SessionFileError, match=r"^a:9: "):
        session_of(b"".join(lines[:-1]) + bare, "a")
    assert any("a:9" in line for line in session_of(b"".join(lines)[:-40], "a").warnings)


def test_a_record_of_an_unknown_kind_is_kept_and_ignored() -> None:
    lines = SAME_DAY.read_bytes().splitlines(keepends=True)
    document = {
        "type": "moonrise",
        "seq": len(lines),
        "utc": "2026-06-04T00:46:00.000Z",
        "phase": 0.3,
    }
    new = sealed(json.dumps(document, separators=(",", ":")).encode())
    session = session_of(b"".join(lines) + new, "a")
    assert session.warnings == ()
    assert encode_record(session.records[-1]) == new


OFFSET = SunOffset(
    seq=1,
    utc="2026-06-21T15:29:58.250Z",
    ideal_deg=(61.123456789, 54.25),
    reading_deg=(61.4, 54.5),
    counts=(16140, -3050),
    offsets=Offsets(0.2, 0.1),
    coefficients=point(2).coefficients,
    approach=(1, -1),
)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({}, None),
        ({"error_deg": (0.276543211, 0.2502)}, r"reading 54.50000 - ideal 54.25000 of axis 2"),
        ({"error_deg": (0.276543211, 0.25009)}, None),
        ({"counts": (16140, -3051)}, r"point 2: its counts are not those .* record 1"),
        ({"offsets": Offsets(0.2, 0.11)}, r"point 2: its offsets are not those .* record 1"),
        ({"ideal_deg": (61.12346, 54.25)}, r"point 2: its ideal_deg are not those .* record 1"),
    ],
)
def test_numbers_recorded_twice_are_compared(changes: dict, complaint: str | None) -> None:
    records = (HEADER, OFFSET, point(2, **changes), Closed(seq=3, utc=OFFSET.utc, reason="end"))
    warnings = session_of(b"".join(map(encode_record, records)), "a").warnings
    if complaint is None:
        assert warnings == ()
    else:
        (warning,) = warnings
        assert re.search(complaint, warning)


def test_a_changed_line_is_named_with_the_checksum_it_has_and_the_one_it_should_have() -> None:
    line = encode_record(note(1)).rstrip(b"\n")
    own = re.search(rb'"([0-9a-f]{8})"}$', line)
    assert own is not None
    changed = line.replace(b"west", b"east")
    (complaint,) = damaged_lines([changed])
    should = crc32c(changed[: changed.rindex(b',"')])
    assert complaint == (
        f"the line was changed: its checksum is {own[1].decode()}, not {should:08x}"
    )
    assert list(damaged_lines([line])) == [None]
