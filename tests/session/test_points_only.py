"""The second reader: what it takes at its word it reads as the first one does."""

from dataclasses import fields
from pathlib import Path

import msgspec
import numpy as np
import pytest
from session_samples import HEADER, UTC, note, point

from solarcal.session.lines import encode_record, sealed
from solarcal.session.parsing import NeedsWholeReader, read_points_only
from solarcal.session.points import PointTable
from solarcal.session.records import Answers, Closed, PointRecord, Record, Void
from solarcal.session.view import read_session

SAVED = sorted((Path(__file__).parents[2] / "sessions").glob("*.jsonl"))
ABORTED = {"status": "aborted", "answers": Answers(ref_check=False), "reason": "no ref check"}


def written(folder: Path, *records: Record, header=HEADER) -> Path:
    """A closed session of these records, numbered from one."""
    numbered = [
        msgspec.structs.replace(record, seq=seq)
        for seq, record in enumerate((*records, Closed(seq=0, utc=UTC, reason="done")), start=1)
    ]
    path = folder / "day.jsonl"
    path.write_bytes(b"".join(encode_record(record) for record in (header, *numbered)))
    return path


def assert_read_alike(path: Path) -> None:
    table = read_session(path).table.accepted()
    header, read = read_points_only(path)
    assert header == read_session(path).header
    for name in (field.name for field in fields(PointTable)):
        ours, theirs = getattr(read, name), getattr(table, name)
        if isinstance(theirs, np.ndarray):
            assert np.array_equal(ours, theirs, equal_nan=True), name
        else:
            assert ours == theirs, name


@pytest.mark.parametrize("path", SAVED, ids=lambda path: path.stem)
def test_saved_sessions_are_read_alike(path: Path) -> None:
    assert_read_alike(path)


def test_voids_and_voids_of_voids_are_followed(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        point(1), point(2), point(3, "rejected"), note(4),
        Void(seq=5, utc=UTC, voids=1, reason="bird"),
        Void(seq=6, utc=UTC, voids=2, reason="cloud"),
        Void(seq=7, utc=UTC, voids=6, reason="no cloud"),
        PointRecord(seq=8, utc=UTC, **ABORTED),
    )  # fmt: skip
    assert read_points_only(path)[1].labels == (2,)
    assert_read_alike(path)


@pytest.mark.parametrize("sigmas", [(None, None), (0.02, None), (None, 0.02), (0.02, 0.03)])
def test_sigmas_count_only_where_every_point_has_one(tmp_path: Path, sigmas) -> None:
    path = written(tmp_path, *(point(1, sigma_deg=sigma) for sigma in sigmas))
    read = read_points_only(path)[1].sigma_deg
    assert (None if read is None else read.tolist()) == (None if None in sigmas else [0.02, 0.03])
    assert_read_alike(path)


def test_a_point_without_a_time_of_its_own_has_its_records(tmp_path: Path) -> None:
    assert_read_alike(written(tmp_path, point(1, read_utc=None), point(2)))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda lines: lines[:-1],
        lambda lines: [*lines[:1], *lines[2:]],
        lambda lines: [*lines[:1], lines[2], lines[1], *lines[3:]],
        lambda lines: [lines[0], lines[1].replace(b"61.4", b"61.5"), *lines[2:]],
        lambda lines: [*lines[:-1], lines[-1][:-1]],
        lambda lines: lines[1:],
        lambda lines: [sealed(lines[0].replace(b'"format":2', b'"format":3')), *lines[1:]],
        lambda lines: [
            lines[0], sealed(lines[1].replace(b'"ideal_deg":[', b'"other":[')), *lines[2:]
        ],
    ],
    ids=["open", "gap", "order", "changed", "cut", "no header", "format", "no angles"],
)  # fmt: skip
def test_what_cannot_be_taken_at_its_word_is_left_to_the_first_reader(
    tmp_path: Path, spoil
) -> None:
    path = written(tmp_path, point(1), point(2), point(3))
    path.write_bytes(b"".join(spoil(path.read_bytes().splitlines(keepends=True))))
    with pytest.raises(NeedsWholeReader):
        read_points_only(path)


def test_a_void_of_what_comes_after_it_is_left_to_the_first_reader(tmp_path: Path) -> None:
    ahead = Void(seq=1, utc=UTC, voids=2, reason="bird")
    with pytest.raises(NeedsWholeReader, match="after"):
        read_points_only(written(tmp_path, ahead, point(2)))
