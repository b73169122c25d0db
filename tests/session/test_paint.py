"""PAINT calibration records: a heliostat on two screwjacks as a mount with known errors."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from paint_samples import GEOMETRY, TARGETS, write_heliostat, write_tower
from session_samples import assert_same_points

from solarcal.cli import run_command
from solarcal.errors import InputFileError
from solarcal.mount.drive import Jack, JackHeliostat
from solarcal.mount.mechanism import Mechanism
from solarcal.session.interchange import read_paint, read_table
from solarcal.session.interchange.paint import paint_files, paint_table
from solarcal.session.interchange.paint_records import enu_m

TRUTH = Mechanism(P1=0.4, P2=-0.25, P3=-0.3, P4=0.35, P5=0.001, P6=-0.0005)


def test_a_jack_closes_its_triangle() -> None:
    jack = Jack(1000.0, 0.5, 0.4, 0.3, 10.0, clockwise=False)
    # 3-4-5: the pivots stand at a right angle at stroke 0.5, the joint at its initial angle.
    assert jack.joint_deg(np.array([0.0]))[0] == pytest.approx(10.0)
    longer = jack.joint_deg(np.array([100.0]))[0]
    corner = np.degrees(np.arccos((0.4**2 + 0.3**2 - 0.6**2) / (2 * 0.4 * 0.3)))
    assert longer == pytest.approx(10.0 + corner - 90.0)
    turned = Jack(1000.0, 0.5, 0.4, 0.3, 10.0, clockwise=True)
    assert turned.joint_deg(np.array([100.0]))[0] == pytest.approx(10.0 - corner + 90.0)
    np.testing.assert_allclose(jack.steps_at(np.array([longer])), [100.0], atol=1e-9)


def test_the_mirrors_centre_turns_with_the_joints() -> None:
    jack = Jack(1000.0, 0.5, 0.4, 0.3, 0.0, clockwise=False)
    heliostat = JackHeliostat((jack, jack), (10.0, 20.0, 5.0), concentrator=(0.0, -0.4, 0.0))
    # Joint angles 0: the mirror looks South, its face 0.4 m in front of the axis.
    centre = heliostat.centre_enu(np.array([90.0, 0.0]), np.array([90.0, 90.0]))
    np.testing.assert_allclose(centre, [[10.0, 19.6, 5.0], [10.0, 20.0, 5.4]], atol=1e-12)


def test_places_become_metres() -> None:
    # One arc minute of latitude is a nautical mile, 1852 m, to a part in 300.
    east, north, up = enu_m((50.9, 6.4, 88.0), (50.9 + 1 / 60, 6.4 - 1 / 60, 90.0))
    assert north == pytest.approx(1852.0, rel=4e-3)
    assert east == pytest.approx(-1852.0 * np.cos(np.radians(50.9)), rel=4e-3)
    assert up == 2.0


def test_the_points_have_the_errors_the_heliostat_was_made_with(tmp_path: Path) -> None:
    records = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH)
    points = paint_table(read_paint(records, {}))
    assert (points.geometry, points.unit, len(points)) == ("tiltroll-ew", "AA23", 12)
    assert points.labels[0] == 100000
    assert set(points.note) == set(TARGETS)
    e1, e2 = TRUTH.errors_deg(GEOMETRY, points.ax1_deg, points.ax2_deg)
    np.testing.assert_allclose(points.err1_deg, e1, atol=1e-6)
    np.testing.assert_allclose(points.err2_deg, e2, atol=1e-6)


def test_a_fit_finds_the_mechanism_and_the_beam_returns_to_the_spot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    records = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH, records=24)
    assert run_command(["fit", *map(str, records), "--method", "exact", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["points"]["used"] == 24
    found = document["mechanism"]
    assert found["lean_deg"] == pytest.approx(np.hypot(0.4, 0.3), abs=1e-3)
    assert document["beam"]["rms_before_mrad"] > 5.0
    assert document["beam"]["rms_mrad"] < 0.01


def test_a_joint_that_is_not_displaced_need_not_be_said(tmp_path: Path) -> None:
    records = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH)
    (place,) = tmp_path.glob("AA23/Properties/*.json")
    whole = json.loads(place.read_text())
    actuators = {"actuators": whole["kinematic_properties"]["actuators"]}
    joints = ("first_joint", "second_joint", "concentrator")
    zeros = {f"{joint}_translation_{axis}": 0.0 for joint in joints for axis in "enu"}
    tables = []
    for kinematics in (actuators, actuators | zeros):
        place.write_text(json.dumps(whole | {"kinematic_properties": kinematics}))
        tables.append(paint_table(read_paint(records, {})))
    assert_same_points(*tables)


def test_the_other_methods_spot_is_another_point(tmp_path: Path) -> None:
    records = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH)
    utis = paint_table(read_paint(records, {}))
    helios = paint_table(read_paint(records, {"spot": "HeliOS"}))
    # Half a metre at 90 m turns the normal by half of 5.6 mrad.
    turned = np.hypot(helios.ax1_deg - utis.ax1_deg, helios.ax2_deg - utis.ax2_deg)
    assert 0.05 < np.median(turned) < 0.25


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"UTIS": [', '"UTIX": [', r"no focal spot by UTIS; --spot HeliOS is there"),
        ('"Sun_elevation": ', '"Sun_elevation": -', r"the Sun's elevation -.* is not above 0"),
        (
            '"Sun_elevation": ',
            '"Sun_elevation": 0, "was": ',
            r"the Sun's elevation 0 is not above 0",
        ),
        (
            '"target_name": "upper"',
            '"target_name": 3',
            r"no PAINT calibration record: .*target_name",
        ),
        ("50.9", "48.9", r"the spot is .* m from the heliostat; .* must be of one plant"),
    ],
)
def test_a_bad_record_is_named(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    record = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH)[0]
    text = record.read_text()
    assert old in text
    record.write_text(text.replace(old, new))
    with pytest.raises(InputFileError, match=f"100000-calibration.*{complaint}"):
        read_table(record)


def test_motors_beyond_the_jacks_reach_are_named_by_the_first_record(tmp_path: Path) -> None:
    records = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH)[:3]
    text = re.sub(
        r'"Axis1MotorPosition": [\d.]+', '"Axis1MotorPosition": 1e7', records[1].read_text()
    )
    records[1].write_text(text)
    with pytest.raises(InputFileError, match=r"^[^ ]*100000-calibration.* and its like: "):
        paint_files(records).shots()


def test_the_heliostat_is_the_one_beside_the_first_record(tmp_path: Path) -> None:
    records = write_heliostat(tmp_path, write_tower(tmp_path), TRUTH)[:2]
    elsewhere = records[1].rename(tmp_path / records[1].name)
    assert paint_files([records[0], elsewhere]).name == "AA23"


def test_what_belongs_to_a_record_is_asked_for(tmp_path: Path) -> None:
    tower = write_tower(tmp_path)
    record = write_heliostat(tmp_path, tower, TRUTH)[0]
    place = next((tmp_path / "AA23" / "Properties").iterdir())
    elsewhere = tmp_path / "elsewhere"
    place.rename(elsewhere)
    with pytest.raises(InputFileError, match=r"not in \.\./Properties; give it with --heliostat"):
        read_table(record)
    assert len(read_table(record, heliostat=elsewhere)) == 1
    tower.rename(tmp_path / "tower.json")
    with pytest.raises(InputFileError, match="give it with --tower"):
        read_table(record, heliostat=elsewhere)
    assert len(read_table(record, heliostat=elsewhere, tower=tmp_path / "tower.json")) == 1
    with pytest.raises(InputFileError, match="no PAINT tower measurements"):
        read_table(record, heliostat=elsewhere, tower=elsewhere)
    with pytest.raises(InputFileError, match="no PAINT heliostat properties"):
        read_table(record, heliostat=tmp_path / "tower.json", tower=tmp_path / "tower.json")


def test_a_field_of_heliostats_is_a_fleet(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tower = write_tower(tmp_path)
    for at, lean in enumerate((0.1, 1.2, 0.3)):
        write_heliostat(tmp_path, tower, Mechanism(P1=lean), seed=at, noise_deg=0.01, name=f"H{at}")
    (tmp_path / "H2" / "Calibration" / "100003-calibration-properties.json").write_text("{}")
    assert run_command(["fleet", str(tmp_path), "--worst-by", "lean", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["files"], document["fitted"]) == (3, 2)
    worst = document["sessions"][0]
    assert "H1-heliostat" in worst["file"]
    assert worst["lean_deg"] == pytest.approx(1.2, abs=0.3)
    assert "100003-calibration" in document["unreadable"][0]["reason"]
    assert run_command(["fleet", str(tmp_path), "--worst-by", "lean"]) == 0
    rows = [line.split()[0] for line in capsys.readouterr().out.splitlines() if " 12 " in line]
    assert rows == ["H1", "H0"]
