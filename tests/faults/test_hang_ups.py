"""The line is lost in every step of the procedure: it resumes, and nothing wrong is stored."""

from pathlib import Path

import pytest
from faulty_bench import UPLOADED, PersistentTechnician, faulty_line

from solarcal.mount.formula import Offsets
from solarcal.session.records import (
    CheckRecord,
    LinkLost,
    LinkRestored,
    PointRecord,
    SunOffset,
    UploadRecord,
)
from solarcal.session.view import SessionView

STEPS = [
    "clock", "reference check", "initialise",
    "centre", "sun offset", "watch", "questions", "gather", "store", "wait",
    "upload",
    "check centre", "check sun offset", "check watch", "check questions", "check gather",
    "check store",
    "rollback",
]  # fmt: skip


class OneHangUp:
    """Breaks the line once in every step: at its ``after``-th frame."""

    def __init__(self, after: int, *, delivered: bool) -> None:
        self.after, self.delivered = after, delivered
        self.steps: dict[str, int] = {}
        self.technician: PersistentTechnician | None = None

    def __call__(self, step: str) -> None:
        assert self.technician is not None
        self.steps[step] = self.steps.get(step, 0) + 1
        if self.steps[step] == 1:
            self.technician.line.hang_up(self.after, delivered=self.delivered)


def accepted(session: SessionView) -> list[PointRecord]:
    return [point for point in session.points if point.status == "accepted"]


def run(
    path: Path, after: int, delivered: bool
) -> tuple[SessionView, PersistentTechnician, OneHangUp]:
    trouble = OneHangUp(after, delivered=delivered)
    technician = PersistentTechnician(faulty_line(), path, trouble)
    trouble.technician = technician
    return technician.whole_procedure(points=3), technician, trouble


@pytest.mark.parametrize("delivered", [False, True], ids=["lost", "reply-lost"])
@pytest.mark.parametrize("after", [0, 1, 2, 3, 5, 7])
def test_after_a_hang_up_in_any_step_the_procedure_resumes(tmp_path, after, delivered):
    session, technician, trouble = run(tmp_path / "s.jsonl", after, delivered)
    assert set(trouble.steps) == set(STEPS)
    # A step of fewer frames passes the hang-up on to the next one.
    assert len(technician.losses) >= 8
    assert len(accepted(session)) == 3
    assert len({point.read_utc for point in accepted(session)}) == 3
    assert all(point.basis == "sun_offset" for point in accepted(session))
    checks = [r for r in session.records if isinstance(r, CheckRecord) and r.status == "accepted"]
    assert len(checks) == 1
    lost = [r for r in session.records if isinstance(r, LinkLost)]
    back = [r for r in session.records if isinstance(r, LinkRestored)]
    assert 8 <= len(back) == len(lost) <= len(technician.losses)


@pytest.mark.parametrize("delivered", [False, True], ids=["lost", "reply-lost"])
@pytest.mark.parametrize("after", range(8))
def test_an_upload_cut_off_anywhere_is_rolled_back_to_what_the_unit_held_before(
    tmp_path, after, delivered
):
    class InTheUpload(OneHangUp):
        def __call__(self, step: str) -> None:
            if step == "upload":
                super().__call__(step)

    trouble = InTheUpload(after, delivered=delivered)
    technician = PersistentTechnician(faulty_line(), tmp_path / "s.jsonl", trouble)
    trouble.technician = technician
    before = technician.unit.stored()
    session = technician.whole_procedure(points=1)
    assert technician.losses == ["upload"]
    upload, *others, rollback = (r for r in session.records if isinstance(r, UploadRecord))
    # What the first try replaced is on record before it wrote; its outcome after.
    assert (upload, *others)[-1].verified
    assert upload.new_coefficients == UPLOADED
    assert upload.old_coefficients == before.coefficients != UPLOADED
    assert rollback.verified
    unit = technician.unit
    unit.open()
    assert unit.stored().permanent_coefficients == before.coefficients


@pytest.mark.parametrize("delivered", [False, True], ids=["lost", "reply-lost"])
@pytest.mark.parametrize("after", range(6))
def test_a_check_points_offset_never_stays_in_force(tmp_path, after, delivered):
    """What was uploaded is P with O = 0; a line lost while the check is stored changes nothing."""

    class InTheStore(OneHangUp):
        def __call__(self, step: str) -> None:
            if step == "check store":
                super().__call__(step)
            if step == "rollback":
                assert self.technician is not None
                stored = self.technician.unit.stored()
                assert stored.offsets == Offsets()
                assert stored.coefficients == UPLOADED

    trouble = InTheStore(after, delivered=delivered)
    technician = PersistentTechnician(faulty_line(), tmp_path / "s.jsonl", trouble)
    trouble.technician = technician
    session = technician.whole_procedure(points=1)
    checks = [r for r in session.records if isinstance(r, CheckRecord) and r.status == "accepted"]
    assert len(checks) == 1


def test_a_reply_from_before_the_hang_up_is_not_taken_for_one_after_it(tmp_path):
    line = faulty_line()
    technician = PersistentTechnician(line, tmp_path / "s.jsonl", lambda step: None)
    seen = technician.station.poll()
    line.hang_up(delivered=True)
    technician.once("poll", technician.station.poll)
    technician.step("wait", lambda: technician.station.clock.wait(500.0))
    assert technician.losses == ["poll"]
    assert technician.station.poll().unit_utc_s >= seen.unit_utc_s + 500.0


def test_the_points_are_those_of_the_clean_line_when_only_frames_are_repeated(tmp_path):
    """A hang-up costs time but no truth: errors stay those of the mechanism."""
    clean, _, _ = run(tmp_path / "clean.jsonl", 10**9, False)
    broken, technician, _ = run(tmp_path / "broken.jsonl", 1, True)
    assert technician.losses
    for session in (clean, broken):
        found = accepted(session)
        offsets = [r for r in session.records if isinstance(r, SunOffset)]
        # Every accepted point is one the unit really reported, number for number.
        for point in found:
            assert any(
                (o.reading_deg, o.counts, o.ideal_deg)
                == (point.reading_deg, point.counts, point.ideal_deg)
                for o in offsets
            )
    for one, other in zip(accepted(clean), accepted(broken), strict=True):
        assert one.error_deg is not None
        assert other.error_deg is not None
        assert one.error_deg == pytest.approx(other.error_deg, abs=0.15)
