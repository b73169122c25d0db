"""Every session of a fleet is answered as by the ordinary fit, and no file stops it."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.made_up_fleet import write_fleet
from solarcal.cli import run_command
from solarcal.errors import SolarcalError
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.session.interchange import session_from_table
from solarcal.session.lines import sealed
from solarcal.session.parsing import NeedsWholeReader, read_points_only
from solarcal.session.points import merge_tables
from solarcal.session.view import read_session
from solarcal.station.analysing import load_points
from solarcal.station.fitting import solve_table
from solarcal.station.fleet import FleetMember, fit_fleet, session_files

FILES = sorted((Path(__file__).parents[2] / "sessions").glob("*.jsonl"))
TOLERANCE_SIGMA = 1e-2
"""Single fit and batch come near the same place on ways of their own."""


def assert_answered_as_by_the_ordinary_fit(member: FleetMember) -> None:
    table, session = load_points(Path(member.path), {})
    assert session is not None
    solution = solve_table(table, "robust", header=session.header)
    assert isinstance(solution, MechanismSolution)
    posterior, mechanism = solution.posterior, solution.mechanism
    sigma = np.sqrt(np.diag(posterior.covariance))
    assert np.abs((member.values - posterior.mean) / sigma).max() < TOLERANCE_SIGMA
    assert member.sigmas == pytest.approx(tuple(sigma), rel=TOLERANCE_SIGMA)
    assert member.lean_deg == pytest.approx(mechanism.lean_deg, rel=TOLERANCE_SIGMA)
    assert member.lean_sigma_deg == pytest.approx(mechanism.lean_sigma_deg, rel=TOLERANCE_SIGMA)
    assert member.noise_deg == pytest.approx(mechanism.noise_deg, rel=TOLERANCE_SIGMA)
    assert member.sky_rms_deg == pytest.approx(solution.sky_rms_deg, rel=TOLERANCE_SIGMA)
    assert member.sky_max_deg == pytest.approx(solution.sky_max_deg, rel=TOLERANCE_SIGMA)
    assert member.points == solution.n_points
    assert member.outliers == solution.outliers
    assert (member.unit, member.geometry) == (table.unit, table.geometry)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_session_is_answered_as_by_the_ordinary_fit(path: Path) -> None:
    (member,) = fit_fleet([path]).members
    assert_answered_as_by_the_ordinary_fit(member)


def test_a_made_up_fleet_is_answered_session_by_session(tmp_path: Path) -> None:
    """Forty sites in both hemispheres, blunders, struck points, inclinometers."""
    write_fleet(tmp_path, sessions=40, seed=3)
    fleet = fit_fleet(session_files(tmp_path))
    assert len(fleet.members) == 40
    for member in fleet.members:
        assert_answered_as_by_the_ordinary_fit(member)
    assert {member.points for member in fleet.members} == {11, 12}
    assert any(member.outliers for member in fleet.members)
    headers = [read_session(member.path).header for member in fleet.members]
    assert any(header.inclinometer is not None for header in headers)


def test_two_readings_of_one_instant_are_one_point_of_a_fleet_too(tmp_path: Path) -> None:
    path = tmp_path / "twice.jsonl"
    table = read_session(FILES[0]).table.accepted()
    again = replace(table, err2_deg=table.err2_deg + 0.1, sources=("again",) * len(table))
    session_from_table(merge_tables((table, again)), path, utc_s=0.0)
    (member,) = fit_fleet([path]).members
    assert member.points == len(table)
    assert_answered_as_by_the_ordinary_fit(member)


@pytest.mark.parametrize("ideal", ["apparent", "airless", "solartrak"])
@pytest.mark.parametrize("sigma", ["", "0.02"])
def test_imported_points_too(tmp_path: Path, ideal: str, sigma: str) -> None:
    rows = [
        f"2026-06-03T{16 + hour}:00:00Z,{ax1},{ax2},{0.2 + 0.03 * hour},-0.1,{sigma}"
        for hour, (ax1, ax2) in enumerate([(75, 42), (60, 30), (20, 15), (-45, 25), (-70, 38)])
    ]
    site = f"# geometry=azel\n# lat_deg=35\n# lon_deg=-106\n# elevation_m=1800\n# ideal={ideal}"
    head = "utc,ax1_deg,ax2_deg,err1_deg,err2_deg,sigma_deg"
    (tmp_path / "points.csv").write_text("\n".join([site, head, *rows]) + "\n")
    session = tmp_path / "points.jsonl"
    assert run_command(["import", str(tmp_path / "points.csv"), str(session)]) == 0
    (member,) = fit_fleet([session]).members
    assert read_points_only(session)[1].ideal == ideal
    assert_answered_as_by_the_ordinary_fit(member)


def test_a_heliostat_goes_the_ordinary_way(tmp_path: Path) -> None:
    """Its angles are those of the mirror's normal, half a Sun away from the batched fit's."""
    head, _, rest = FILES[1].read_bytes().partition(b"\n")
    header = json.loads(head)
    header["unit"]["heliostat"] = {"target": {"azimuth_deg": 10, "zenith_deg": 80, "distance": 99}}
    path = tmp_path / "heliostat.jsonl"
    path.write_bytes(sealed(json.dumps(header).encode()) + rest)
    assert read_session(path).header.unit.heliostat is not None
    (member,) = fit_fleet([path]).members
    assert_answered_as_by_the_ordinary_fit(member)


def test_last_coefficients_count_as_in_the_ordinary_fit(tmp_path: Path) -> None:
    head, _, rest = FILES[1].read_bytes().partition(b"\n")
    header = json.loads(head)
    header["last_coefficients"] = dict.fromkeys(COEFFICIENT_NAMES, 0.0) | {"P2": -0.2}
    path = tmp_path / "last.jsonl"
    path.write_bytes(sealed(json.dumps(header).encode()) + rest)
    assert read_session(path).header.last_coefficients is not None
    (member,) = fit_fleet([path]).members
    assert_answered_as_by_the_ordinary_fit(member)


@pytest.mark.parametrize(
    ("axis", "angle_deg", "words"), [(0, 1100.0, "more than two turns"), (1, 0.001, "AX2 0.001")]
)
def test_a_session_with_an_impossible_angle_is_refused_in_the_words_of_the_ordinary_fit(
    tmp_path: Path, axis: int, angle_deg: float, words: str
) -> None:
    lines = FILES[1].read_bytes().splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if b'"status":"accepted"' in line)
    point = json.loads(lines[at])
    point["ideal_deg"][axis] = angle_deg
    lines[at] = sealed(json.dumps(point).encode())
    path = tmp_path / "turned.jsonl"
    path.write_bytes(b"".join(lines))
    ((name, reason),) = fit_fleet([path]).unreadable
    assert name == str(path)
    with pytest.raises(SolarcalError) as refused:
        solve_table(load_points(path, {})[0], "robust")
    assert reason == str(refused.value)
    assert words in reason


def test_the_second_reader_knows_what_was_struck(tmp_path: Path) -> None:
    path = Path(shutil.copy(FILES[0], tmp_path))
    labels = read_points_only(path)[1].labels
    assert run_command(["void", str(path), str(labels[3]), "--reason", "cloud"]) == 0
    assert read_points_only(path)[1].labels == labels[:3] + labels[4:]


def test_a_torn_file_is_left_to_the_first_reader(tmp_path: Path) -> None:
    path = tmp_path / "torn.jsonl"
    path.write_bytes(FILES[1].read_bytes()[:-7])
    with pytest.raises(NeedsWholeReader):
        read_points_only(path)
    assert len(fit_fleet([path]).members) == 1


def test_reading_and_fitting_are_told_from_the_first_file_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("solarcal.station.fleet._READ_BETWEEN_REPORTS", 2)
    told: list[tuple[str, int, int]] = []
    fit_fleet([FILES[0]] * 3, lambda *said: told.append(said))
    assert told[:3] == [("reading", 0, 3), ("reading", 2, 3), ("reading", 3, 3)]
    assert told[-1] == ("fitting", 3, 3)
