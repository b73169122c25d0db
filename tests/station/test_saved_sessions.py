"""The saved sessions can be replayed and fitted, and show what their README says."""

from pathlib import Path

import pytest

from solarcal.errors import ProcedureRefused
from solarcal.mount.formula import Coefficients
from solarcal.session.journal import Journal
from solarcal.session.reader import read_session
from solarcal.station.fitting import solve
from solarcal.station.saved_sessions import Replay
from solarcal.station.uploading import UnitOnTheLine

SESSIONS = Path(__file__).parents[2] / "sessions"
FILES = sorted(SESSIONS.glob("*.jsonl"))


def view(name: str):
    replay = Replay.open(SESSIONS / name)
    replay.jump(len(replay))
    return replay.view


def test_every_session_is_told_in_the_readme():
    readme = (SESSIONS / "README.md").read_text()
    assert len(FILES) >= 6
    assert all(f"`{file.name}`" in readme for file in FILES)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_saved_session_is_whole_and_its_last_fit_comes_out_again(file):
    session = view(file.name)
    assert read_session(file).warnings == ()
    solution = solve(session)
    assert solution is not None
    told = session.fits[-1]
    again = solution.coefficients().as_tuple()
    for number, (now, then) in enumerate(
        zip(again, told.coefficients.as_tuple(), strict=True), start=1
    ):
        # Other versions of numpy and of the fit may differ in the last digits, not in the answer.
        assert now == pytest.approx(then, abs=2e-4 if number > 4 else 0.02), f"P{number}"
    assert session.uploads[-1].verified


def test_the_one_with_aborted_and_rejected_points_has_them():
    statuses = [point.status for point in view("azel-aborted-and-rejected.jsonl").points]
    assert statuses.count("aborted") == 1
    assert statuses.count("rejected") == 2
    assert statuses.count("accepted") == 12


def test_the_southern_one_is_on_its_branch():
    session = view("southern-day.jsonl")
    assert session.header.ax1_centre_deg == 180.0
    assert all(0.0 < p.ideal_deg[0] < 360.0 for p in session.accepted)


def test_the_two_day_one_has_two_days():
    days = {point.utc[:10] for point in view("ns-tiltroll-two-days.jsonl").accepted}
    assert {"2026-06-10", "2026-06-11"} <= days


@pytest.mark.parametrize(
    ("setting", "what"),
    [
        (None, None),
        ("unit.ax1_centre_deg=10", "centre of the branch of axis 1"),
        ("site.latitude_deg=35.2", "latitude"),
    ],
)
def test_a_session_is_loaded_only_into_a_unit_that_is_set_up_as_it_was(bench, setting, what):
    b = bench()
    b.on_sun()
    b.technician.take_point()
    b.station.leave()
    other = bench(*(("tijeras-azel",) if setting is None else ("tijeras-azel", setting)))
    on_the_line = UnitOnTheLine(other.unit)
    journal = Journal.resume(b.path)
    try:
        if what is None:
            on_the_line.resume(journal)
            assert on_the_line.upload(Coefficients(P1=0.1), "linear", "").verified
        else:
            with pytest.raises(ProcedureRefused, match=f"another {what}"):
                on_the_line.resume(journal)
    finally:
        journal.close()
