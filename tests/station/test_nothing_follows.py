"""An axis that stands still, and a Sun that is nowhere to be seen, end a calibration in words."""

from dataclasses import replace
from pathlib import Path

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.errors import ProcedureRefused
from solarcal.session.journal import Journal
from solarcal.session.view import read_session
from solarcal.station.headless import Calibration, calibrate
from solarcal.station.technician import Schedule
from solarcal.timescale import parse_utc
from solarcal.unit.drivers.solartrak import SolarTrakUnit


class FreezingLink(InProcessLink):
    """A line to an emulator whose read-out of one axis stands still from some hours on."""

    def __init__(self, emulator: Emulator, axis: int, after_h: float) -> None:
        super().__init__(emulator)
        self._its, self._axis = emulator, axis
        self._at_s = emulator.now_s() + 3600.0 * after_h

    def write(self, data: bytes) -> None:
        if self._axis and self._its.now_s() >= self._at_s:
            self._its.freeze(self._axis)
            self._axis = 0
        super().write(data)


def calibrated(
    path: Path,
    *settings: str,
    axis: int = 0,
    after_h: float = 0.0,
    points: int = 12,
    checks: int = 2,
) -> Calibration:
    emulator = Emulator(load_scenario("tijeras-azel", list(settings)), seed=3, noise_deg=0.02)
    tracker = SolarTrakUnit(lambda: FreezingLink(emulator, axis, after_h))
    try:
        return calibrate(
            tracker,
            lambda header: Journal.create(path, header),
            Schedule(points=points, checks=checks),
            eye_sigma_deg=0.02,
            force="whatever it makes better",
        )
    finally:
        tracker.close()


@pytest.mark.parametrize(
    ("axis", "after_h", "points"),
    [(1, 4.0, 12), (2, 7.2, 12), (1, 0.5, 12), (2, 3.06, 4)],
)
def test_an_axis_that_does_not_move_is_named_within_the_day(tmp_path, axis, after_h, points):
    """Also behind the upload, where only check points are left to be taken."""
    path = tmp_path / "s.jsonl"
    with pytest.raises(
        ProcedureRefused, match=rf"axis {axis} does not move: it stands \d+\.\d deg"
    ):
        calibrated(path, axis=axis, after_h=after_h, points=points)
    session = read_session(path)
    first, last = (parse_utc(session.records[place].utc) for place in (0, -1))
    assert last - first < 3600.0 * (after_h + 1.5)
    assert len(session.accepted) >= min(points, int(after_h))
    assert len(session.uploads) == (points == 4)
    Journal.resume(path).close()


def test_a_calibration_without_the_check_points_it_was_to_take_is_not_completed(tmp_path):
    done = calibrated(tmp_path / "s.jsonl", points=4, checks=0)
    assert done.completed
    unproven = replace(done, checks=2)
    assert not unproven.completed
    assert "no check point could be taken" in unproven.failure


@pytest.mark.parametrize("wrong", ["truth.laptop_offset_s=3600", "unit.longitude_deg=106.48"])
def test_a_sun_that_is_looked_for_elsewhere_is_given_up_after_eight_slots(tmp_path, wrong):
    path = tmp_path / "s.jsonl"
    with pytest.raises(ProcedureRefused) as refused:
        calibrated(path, wrong)
    said = str(refused.value)
    for cause in ("at 8 slots in a row", "clouds", "hour or date", "sign of the longitude", "zone"):
        assert cause in said
    assert "the tower leans" in said
    session = read_session(path)
    assert parse_utc(session.records[-1].utc) - parse_utc(session.records[0].utc) < 86400.0
    Journal.resume(path).close()
