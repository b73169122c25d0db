"""The whole manual procedure with a rotator that knows nothing, in a world whose truth is known."""

import pytest

from solarcal.emulated_units import emulated_unit
from solarcal.errors import ConfigurationError
from solarcal.model.evidence.read_outs import losses
from solarcal.session.journal import Journal
from solarcal.session.view import read_session, view_session
from solarcal.station.headless import calibrate
from solarcal.station.technician import Schedule


def calibrated(path, scenario="tijeras-azel", *settings, points=8, **world):
    unit = emulated_unit(scenario, "rotctld", settings=settings, seed=3, **world)
    return calibrate(
        unit.tracker,
        lambda header: Journal.create(path, header),
        Schedule(points=points, checks=1),
        eye_sigma_deg=unit.noise_deg,
    )


def test_a_day_recovers_the_lean_and_the_rotator_points_from_then_on(tmp_path):
    done = calibrated(tmp_path / "day.jsonl", "tijeras-azel", "truth.backlash1_deg=0.05")
    truth = done.truth_before.coefficients
    found = done.solution.coefficients()
    assert done.completed
    assert pytest.approx((truth.P1, truth.P3), abs=0.04) == (found.P1, found.P3)
    assert pytest.approx(truth.P2, abs=0.04) == found.P2
    assert done.truth_before.year_rms_deg > 0.5
    assert done.truth_after.year_rms_deg < 0.04
    session = view_session(*_of(tmp_path / "day.jsonl"))
    assert [check.status for check in session.checks] == ["accepted"]
    assert session.checks[0].sky_error_deg < 0.1
    assert all(1 in point.approach or -1 in point.approach for point in session.accepted)


def test_the_file_says_that_its_reference_checks_prove_no_counts(tmp_path):
    calibrated(tmp_path / "day.jsonl", "missed-counts", points=3)
    session = view_session(*_of(tmp_path / "day.jsonl"))
    assert not session.header.unit.has_switches
    assert len(session.ref_checks) == 3
    assert not any(check.at_switches for check in session.ref_checks)
    assert losses(session) == ()


def test_the_same_seed_gives_the_same_session_byte_for_byte(tmp_path):
    for name in ("one", "two"):
        calibrated(tmp_path / name, points=3)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_south_of_the_equator_the_sun_passes_north(tmp_path):
    done = calibrated(tmp_path / "day.jsonl", "southern", points=6)
    assert done.completed
    assert done.truth_after.year_rms_deg < 0.06


def test_a_mount_that_is_no_azel_is_refused():
    with pytest.raises(ConfigurationError, match="choose an azel scenario"):
        emulated_unit("polar", "rotctld")


def _of(path):
    session = read_session(path)
    return session.header, tuple(session.records)
