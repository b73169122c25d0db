"""Which rule files are judged by, and what is said of it where files or options differ."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import AxisLimits
from solarcal.report.blocks import plain_text
from solarcal.report.certificate import make_certificate
from solarcal.session.journal import Journal
from solarcal.session.records import PointRecord
from solarcal.session.view import read_session
from solarcal.site import BoltCircle, Inclinometer
from solarcal.station.analysing import FileAnalysis, analyse_files, read_files
from solarcal.stopping_rule import Unmodelled

DAY = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"


@pytest.fixture
def other(tmp_path: Path) -> Any:
    """A function that writes a week later's session of the same unit, its header changed."""

    def write(**header: Any) -> Path:
        session, path = read_session(DAY), tmp_path / "other.jsonl"
        with Journal.create(path, msgspec.structs.replace(session.header, **header)) as journal:
            for record in session.accepted:
                journal.append(_a_week_later(record, journal.next_seq))
        return path

    return write


def _a_week_later(record: PointRecord, seq: int) -> PointRecord:
    assert record.read_utc is not None
    read = record.read_utc.replace("-06-0", "-06-1")
    return msgspec.structs.replace(record, seq=seq, read_utc=read)


def judged(*paths: Path, **options: Any) -> FileAnalysis:
    return analyse_files(read_files(paths, {}), **options)


def differing(found: FileAnalysis) -> list[str]:
    return [text for text in found.warnings if "the sessions differ" in text]


@pytest.mark.parametrize("swapped", [False, True])
def test_the_strictest_rule_counts_in_any_order_of_the_files(other, swapped: bool) -> None:
    paths = [DAY, other(tolerance_deg=0.02, done_probability=0.9)]
    found = judged(*(reversed(paths) if swapped else paths))
    assert found.rule.tolerance_deg == 0.02
    assert found.rule.probability == 0.95
    tolerance, probability = differing(found)
    assert probability.startswith("the sessions differ in probability for done (")
    assert f"0.1 deg in {DAY}" in tolerance
    assert f"0.02 deg in {paths[1]}" in tolerance
    assert tolerance.endswith("the strictest counts")


def test_widths_of_the_sessions_are_the_largest_of_each(other) -> None:
    wide = Unmodelled(sag_deg=0.5, air=0.01, large_chance=0.2, large_collimation_chance=0.01)
    found = judged(DAY, other(unmodelled=wide))
    assert (found.rule.unmodelled.sag_deg, found.rule.unmodelled.air) == (0.5, 0.05)
    assert found.rule.unmodelled.large_chances == (0.05, 0.2)
    said = differing(found)
    assert len(said) == 4
    assert f"unmodelled sag_deg (0.02 in {DAY}; 0.5 in " in said[-2] + said[-1]


def test_an_option_counts_before_every_session_and_is_no_difference(other) -> None:
    path = other(tolerance_deg=0.02, done_probability=0.9)
    found = judged(DAY, path, tolerance_deg=0.2, done_probability=0.8)
    assert (found.rule.tolerance_deg, found.rule.probability) == (0.2, 0.8)
    assert not differing(found)
    assert found.asked_for[:2] == (
        "tolerance 0.2 deg, not 0.02 deg",
        "probability for done 0.8, not 0.95",
    )


@pytest.mark.parametrize("swapped", [False, True])
def test_limits_leans_and_last_coefficients_that_differ_are_said(other, swapped: bool) -> None:
    unit = read_session(DAY).header.unit
    limits = msgspec.structs.replace(unit.limits, axis1=AxisLimits(-90.0, 90.0))
    lean = Inclinometer(lean_north_deg=0.1, lean_east_deg=0.2, sigma_deg=0.5)
    path = other(
        unit=msgspec.structs.replace(unit, limits=limits),
        inclinometer=lean,
        last_coefficients=Coefficients(P1=0.3),
    )
    first, second = (path, DAY) if swapped else (DAY, path)
    by_limits, by_lean, by_last = differing(judged(first, second))
    assert "axis 1 -90 to 90, axis 2" in by_limits
    assert lean.words() in by_lean
    assert by_limits.endswith(f": that of {first} counts")
    assert by_lean.endswith(f": that of {path} counts"), "the newest reading"
    for text in (f"none in {DAY}", f"+0.3 +0 +0 +0 +0 +0 in {path}"):
        assert text in by_last
    assert by_last.endswith(f": that of {first} counts")


def test_sessions_of_one_rule_differ_in_nothing(other) -> None:
    assert not differing(judged(DAY, other()))
    assert judged(DAY).asked_for == ()


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"tolerance_deg": 0.05}, "tolerance 0.05 deg, not 0.1 deg"),
        ({"done_probability": 0.6}, "probability for done 0.6, not 0.95"),
        ({"unmodelled": {"sag_deg": 0.001}}, "unmodelled sag_deg 0.001, not 0.02"),
        ({"unmodelled": {"large_chance": 0.2}}, "unmodelled large_chance 0.2, not 0.05"),
        ({"method": "exact"}, "method exact, not robust"),
        ({"last_coefficients": Coefficients(P1=0.3)}, "last coefficients +0.3 +0 +0 +0 +0 +0"),
        ({"bolt_circle": BoltCircle(400.0, 4)}, "bolt circle 400,4"),
    ],
)
def test_the_certificate_shows_every_option_it_was_made_with(option, words: str) -> None:
    text = plain_text(make_certificate(judged(DAY, **option), ()))
    subject = text[text.index("What was calibrated") : text.index("\nVerdict\n")]
    assert f"asked for        {words}" in subject
    assert "asked for" not in plain_text(make_certificate(judged(DAY), ()))
