"""What a power cut leaves in the file, at every byte, and how the session goes on behind it."""

from pathlib import Path

import pytest
from session_samples import HEADER, note, point

from solarcal.errors import SessionFileError
from solarcal.session.journal import Journal
from solarcal.session.lines import encode_record, sealed, torn_marker
from solarcal.session.parsing import parse_session
from solarcal.session.view import read_session

HEAD = encode_record(HEADER)
FIRST = encode_record(note(1, "Süden ☀"))
LAST = encode_record(point(2))


def parse(content: bytes) -> tuple[list[int], int]:
    """Sequence numbers read, and how many warnings came with them."""
    text = parse_session(content, "day.jsonl")
    return [record.seq for record in text.records], len(text.warnings)


def test_a_header_cut_anywhere_is_a_clear_refusal() -> None:
    for cut in range(len(HEAD) - 1):
        with pytest.raises(SessionFileError, match=r"is empty|no complete session header"):
            parse(HEAD[:cut])
    assert parse(HEAD[:-1]) == ([], 0)


@pytest.mark.parametrize(
    "content",
    [b"utc,ax1_deg,ax2_deg\n1,2,3\n", (HEAD + FIRST).decode().encode("utf-16"), b"\x00" * 400],
    ids=["a table", "saved as UTF-16", "zeros"],
)
def test_what_was_no_session_is_not_called_an_empty_one(content: bytes) -> None:
    with pytest.raises(SessionFileError, match="not a session file"):
        parse(content)


def test_the_last_line_cut_anywhere_is_ignored_and_reported() -> None:
    whole = HEAD + FIRST + LAST
    for cut in range(len(HEAD + FIRST), len(whole) + 1):
        missing = len(whole) - cut
        if missing <= 1:
            expected = ([1, 2], 0)
        elif cut == len(HEAD + FIRST):
            expected = ([1], 0)
        else:
            expected = ([1], 1)
        assert parse(whole[:cut]) == expected, cut


def test_a_session_cut_anywhere_can_be_continued_and_cut_again(tmp_path: Path) -> None:
    """Kill, resume, kill, resume: after every pair of cuts both survivors are read.

    Of the second cuts every third byte, another third for each first cut, and the ends of lines.
    """
    path = tmp_path / "day.jsonl"
    whole = HEAD + FIRST + LAST
    first_cuts = [*range(len(HEAD), len(whole), 37), len(whole) - 2, len(whole) - 1]
    for number, first_cut in enumerate(first_cuts):
        path.write_bytes(whole[:first_cut])
        with Journal.resume(path) as journal:
            survived = [r.seq for r in journal.records]
            journal.append(note(journal.next_seq, "second day"))
        continued = path.read_bytes()
        assert continued.startswith(whole[:first_cut])
        assert parse(continued)[0] == [*survived, len(survived) + 1]
        cuts = set(range(first_cut + number % 3, len(continued), 3))
        ends = [at for at, byte in enumerate(continued) if byte == ord("\n")]
        cuts |= {at + more for at in ends for more in (-1, 0, 1)}
        for cut in sorted(cut for cut in cuts if first_cut <= cut < len(continued)):
            path.write_bytes(continued[:cut])
            assert parse(continued[:cut])[0][: len(survived)] == survived
            with Journal.resume(path) as journal:
                known = [r.seq for r in journal.records]
                journal.append(note(journal.next_seq, "third day"))
            session = read_session(path)
            assert [r.seq for r in session.records] == [*known, len(known) + 1]
            assert session.records[-1] == note(len(known) + 1, "third day")


def test_zeros_in_place_of_the_last_block_are_a_torn_line() -> None:
    assert parse(HEAD + FIRST + b"\0" * 512) == ([1], 1)


def test_a_line_nested_too_deeply_is_a_torn_one_with_and_without_escapes() -> None:
    for text in (b"plain", b"\\u001b"):
        deep = b'{"type":"note","seq":2,"text":"%s","x":%s}' % (text, b"[" * 3000 + b"]" * 3000)
        assert parse(HEAD + FIRST + sealed(deep)) == ([1], 1)


def test_the_warning_names_the_line() -> None:
    text = parse_session(HEAD + FIRST + LAST[:20], "day.jsonl")
    assert text.warnings[0].startswith("day.jsonl:3: the last line is torn")
    healed = HEAD + FIRST + LAST[:20] + b"\n" + torn_marker(21) + encode_record(note(2))
    text = parse_session(healed, "day.jsonl")
    assert text.warnings == ["day.jsonl:3: a line torn while written was ignored"]
    assert [r.seq for r in text.records] == [1, 2]


@pytest.mark.parametrize("offset", [1, 20, 60])
def test_a_broken_line_in_the_middle_is_an_error_that_names_it(offset: int) -> None:
    broken = HEAD + FIRST[:offset] + b"\n" + LAST
    with pytest.raises(SessionFileError, match=r"^day\.jsonl:2: cut or changed"):
        parse(broken)


def test_a_marker_that_fits_no_line_is_an_error() -> None:
    for size in (5, 22, len(HEAD) + 500, 10**9, 0):
        with pytest.raises(SessionFileError, match=r"day\.jsonl:3"):
            parse(HEAD + LAST[:20] + b"\n" + torn_marker(size) + FIRST)


def test_a_marker_never_reaches_into_the_header() -> None:
    with pytest.raises(SessionFileError, match="declares torn bytes"):
        parse(HEAD + torn_marker(len(HEAD)))


def test_a_marker_covers_an_unacknowledged_whole_line() -> None:
    """Written, not synced: the retry's marker takes it back."""
    content = HEAD + encode_record(note(1, "unsynced")) + b"\n"
    content += torn_marker(len(content) - len(HEAD)) + encode_record(note(1, "synced"))
    text = parse_session(content, "day.jsonl")
    assert text.records == [note(1, "synced")]


def test_a_declaration_that_cannot_be_read_declares_nothing() -> None:
    for damaged in (torn_marker(21)[:-4] + b"\n", torn_marker(21).replace(b"21", b"no")):
        with pytest.raises(SessionFileError, match=r"^day\.jsonl:[23]: .*changed"):
            parse(HEAD + LAST[:20] + b"\n" + damaged + FIRST)


def test_a_last_line_with_a_checksum_at_its_end_was_written_whole() -> None:
    """Two bytes changed on the disk, one in the checksum's name: no cut line ends so."""
    changed = bytearray(LAST)
    changed[0] ^= 1
    changed[LAST.rindex(b"crc32c")] ^= 1
    with pytest.raises(SessionFileError, match=r"^day\.jsonl:3: cut or changed"):
        parse(HEAD + FIRST + bytes(changed))
