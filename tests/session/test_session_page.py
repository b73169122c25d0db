"""docs/session-file.md and docs/formats.md say what the code does."""

import re
from pathlib import Path
from typing import get_args

import pytest

from solarcal.session.interchange import read_table
from solarcal.session.interchange.tpoint_model import read_tpoint_model
from solarcal.session.records import Header, KnownRecord, PointRecord, UnitRecord
from solarcal.session.view import read_session

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "session-file.md").read_text("utf-8")
NAMES = set(re.findall(r"`([^`\n]+)`", PAGE))
FORMATS = re.findall(
    r"```\n(.*?)```",
    (Path(__file__).resolve().parents[2] / "docs" / "formats.md").read_text("utf-8"),
    re.DOTALL,
)
EXAMPLES = re.findall(r"```\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("kind", [*get_args(KnownRecord), UnitRecord])
def test_every_record_and_field_is_described(kind: type) -> None:
    fields = set(kind.__struct_fields__)  # type: ignore[attr-defined]
    assert fields <= NAMES
    if kind not in (Header, UnitRecord):
        assert kind.__struct_config__.tag in NAMES  # type: ignore[attr-defined]


def test_the_example_session_is_read_and_has_every_kind_of_record(tmp_path: Path) -> None:
    lines = re.findall(r'^    (\{"type":.+)$', PAGE, re.MULTILINE)
    (tmp_path / "example.jsonl").write_text("\n".join(lines) + "\n")
    session = read_session(tmp_path / "example.jsonl")
    assert session.warnings == ()
    assert {type(record) for record in session.records} | {Header} == set(get_args(KnownRecord))
    point = next(r for r in session.records if isinstance(r, PointRecord))
    assert point.error_deg is not None
    assert point.reading_deg is not None
    assert point.ideal_deg is not None
    assert point.error_deg[0] == pytest.approx(point.reading_deg[0] - point.ideal_deg[0])


def test_the_example_of_points_is_read(tmp_path: Path) -> None:
    (example,) = EXAMPLES
    (tmp_path / "a.csv").write_text(example)
    table = read_table(tmp_path / "a.csv")
    assert (len(table), table.warnings) == (1, ())


@pytest.mark.parametrize(
    ("begins", "name"),
    [("Test mount, 2026 Jun 21\n: ALTAZ", "a.dat"), ("8m", "a.dat"), ("#", "a.tsv")],
)
def test_the_examples_of_other_formats_are_read(tmp_path: Path, begins: str, name: str) -> None:
    (example,) = [text for text in FORMATS if text.startswith(begins)]
    (tmp_path / name).write_text(example)
    assert len(read_table(tmp_path / name, latitude_deg=-74.7)) == 1


def test_the_example_of_a_model_is_read(tmp_path: Path) -> None:
    (example,) = [text for text in FORMATS if "\nT " in text]
    (tmp_path / "a.mod").write_text(example)
    assert read_tpoint_model(tmp_path / "a.mod").names == ("IA", "TX")
