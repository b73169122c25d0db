"""kill -9 at twenty seeded moments; a thousand are in the soak."""

import os

import pytest

from soak.journal_writer import HEADER, note, text_of
from soak.kills import LostRecord, kill_writers, read_back
from solarcal.errors import SessionFileError
from solarcal.session.journal import Journal
from solarcal.session.lines import sealed
from solarcal.session.view import read_session


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks its writers")
def test_twenty_killed_writers_lose_nothing_they_acknowledged(tmp_path):
    done = kill_writers(tmp_path, 20, seed=1)
    assert done.kills == 20
    assert done.acknowledged > 20
    for path in tmp_path.glob("*.jsonl"):
        if b"\n" not in path.read_bytes():
            continue  # killed before its header was written: nothing was promised
        with Journal.resume(path) as journal:
            journal.append(note(journal.next_seq))
        assert [r.text for r in read_session(path).records] == [
            text_of(seq) for seq in range(1, journal.next_seq)
        ]


def test_the_measure_sees_a_record_that_is_missing_or_another(tmp_path):
    path = tmp_path / "s.jsonl"
    with Journal.create(path, HEADER) as journal:
        for seq in (1, 2, 3):
            journal.append(note(seq))
    assert read_back(path, begun=True, promised=3) == ([1, 2, 3], 0)
    with pytest.raises(LostRecord, match="4 records were acknowledged, 3 are there"):
        read_back(path, begun=True, promised=4)
    path.write_bytes(path.read_bytes().replace(b"2:xx", b"2:xy"))
    with pytest.raises(SessionFileError, match=r":3: the line was changed"):
        read_back(path, begun=True, promised=3)
    path.write_bytes(b"".join(map(sealed, path.read_bytes().splitlines())))
    with pytest.raises(LostRecord, match="record 2 is not what was written"):
        read_back(path, begun=True, promised=3)
    path.write_bytes(b'{"type":"hea')
    assert read_back(path, begun=False, promised=0) == (None, 0)
    with pytest.raises(SessionFileError):
        read_back(path, begun=True, promised=0)
