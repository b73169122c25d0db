"""Other programs' files: recognised by their text, read with their own signs and units."""

from pathlib import Path

import numpy as np
import pytest

from solarcal.errors import ConfigurationError, InputFileError
from solarcal.session.interchange import point_format, read_table, write_table
from solarcal.session.interchange.tpoint_model import (
    TpointModel,
    read_tpoint_model,
    write_tpoint_model,
)

CSV = """\
# geometry=azel
# lat_deg=35.05
# lon_deg=-106.48
utc,ax1_deg,ax2_deg,err1_deg,err2_deg
,61.5,54.25,0.25,-0.125
,20,30,0.25,-0.1
,-40,40,0.2,-0.1
"""

TPOINT = """\
Made-up night
: ALTAZ
+35 03 00
100.0 40.0 99.9 40.1
200.0 50.0 199.9 50.1
END
"""

PMFIT = """\
Made-up night
A
35.05
100.0 40.0 99.9 40.1
200.0 50.0 199.9 50.1 17.5

 10.0 30.0   9.9 30.1
"""

MODEL = """\
Made-up model
T   61   17.4100   0.0000   0.0000
  IA      -100.0000    1.5000
& IE      -200.0000    2.5000
= TX       +60.0000
HASA2       +3.5000    0.5000
END
"""

OFFSETS = """\
# ---------
# Telescope
# ---------
# Location: Made-up dish
# Latitude: -74.7 deg
# Longitude: 164.1
#
# azimuth: of the Sun's centroid from ephemerides [deg]
# offset_az: observed azimuth - solar azimuth [deg]
# offset_el: observed elevation - solar elevation [deg]

map_id\ttimestamp\tazimuth\televation\toffset_az\toffset_el\ttemperature\tpressure\thumidity
a1\t2026-01-03T00:02:35Z\t14.0\t37.0\t-0.08\t0.07\tNaN\tNaN\tNaN
a2\t2026-01-03T00:32:35Z\t4.0\t38.0\t-0.08\t0.07\t-3.0\t980\t0.2
a3\t2026-01-03T01:02:35Z\t354.0\t38.0\tNaN\tNaN\t-3.0\t980\t0.2
"""

OBSERVED = """\
# azimuth: observed azimuth, deg
# elevation: observed elevation, deg
# offset_az: solar azimuth - observed azimuth, deg
# offset_el: solar elevation - observed elevation, deg
timestamp\tazimuth\televation\toffset_az\toffset_el
2026-01-03T00:02:35Z\t13.92\t37.07\t0.08\t-0.07
"""

SESSION = '{"type":"header","format":1}\n{"type":"note"}\n'
PAINT = '{"motor_position": {"Axis1MotorPosition": 1, "Axis2MotorPosition": 2}, "focal_spot": {}}'
HELIOSTAT = '{"heliostat_position": [50.9, 6.4, 88.0], "kinematic_properties": {}}'
TOWER = '{"power_plant_properties": {"ID": "X"}}'


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("a.csv", TPOINT, "this looks like a TPOINT pointing file; name it .dat"),
        ("a.csv", PMFIT, "this looks like a PMFIT file; name it .dat"),
        ("a.dat", CSV, "this looks like a points CSV; name it .csv"),
        ("a.dat", "sep=;\n" + CSV.replace(",", ";"), "this looks like a points CSV"),
        ("a.jsonl", CSV, "this looks like a points CSV; name it .csv"),
        ("a.csv", OFFSETS, "this looks like a solaris-pointing offsets file; name it .tsv"),
        ("a.dat", SESSION, "this looks like a session; name it .jsonl"),
        ("a.dat", MODEL, "this looks like a TPOINT model; .* the model to --compare"),
        ("a.json", HELIOSTAT, "this looks like a PAINT heliostat properties file; .*--heliostat"),
        ("a.json", TOWER, "this looks like a PAINT tower measurements file; .*--tower"),
        ("a.dat", PAINT, "this looks like a PAINT calibration record; name it .json"),
        ("a.dat", PAINT.replace(": {}", ":\n{}\n"), "this looks like a PAINT calibration record"),
        ("a.dat", SESSION + '"note', "this looks like a session; name it .jsonl"),
    ],
)
def test_a_known_format_under_another_name_is_named(
    tmp_path: Path, name: str, text: str, complaint: str
) -> None:
    path = write(tmp_path, name, text)
    with pytest.raises(InputFileError, match=complaint):
        read_table(path)


@pytest.mark.parametrize("name", ["no.csv", "no.dat", "no.jsonl", "no.tsv", "no.xyz"])
def test_a_missing_file_is_called_missing(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputFileError, match="is missing: no such file"):
        point_format(tmp_path / name)


def test_an_ending_of_no_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"points are read from files ending in \.csv"):
        read_table(write(tmp_path, "a.xls", "what is this"))


@pytest.mark.parametrize("line", ["sep=,\n", "sep=,\r\n", '"sep=,"\n', "SEP=,\n"])
def test_a_spreadsheets_separator_line_changes_nothing(tmp_path: Path, line: str) -> None:
    plain = read_table(write(tmp_path, "plain.csv", CSV))
    marked = read_table(write(tmp_path, "marked.csv", line + CSV))
    np.testing.assert_array_equal(marked.err1_deg, plain.err1_deg)
    assert marked.labels == tuple(label + 1 for label in plain.labels)
    assert (marked.geometry, marked.latitude_deg) == ("azel", 35.05)


def test_the_separator_a_spreadsheet_names_is_used(tmp_path: Path) -> None:
    points = read_table(write(tmp_path, "a.csv", "sep=;\n" + CSV.replace(",", ";")))
    np.testing.assert_array_equal(points.err1_deg, [0.25, 0.25, 0.2])
    with pytest.raises(InputFileError, match=r"a\.csv:5: the header line separates .* by commas"):
        read_table(write(tmp_path, "a.csv", "sep=;\n" + CSV))


def test_pmfit_rows_are_encoder_minus_true(tmp_path: Path) -> None:
    points = read_table(write(tmp_path, "a.dat", PMFIT))
    assert (points.latitude_deg, points.labels) == (35.05, (4, 5, 7))
    assert points.status == ("accepted",) * 3
    np.testing.assert_allclose(points.ax1_deg, [80.0, -20.0, 170.0], atol=1e-12)
    np.testing.assert_allclose(points.err1_deg, 0.1, atol=1e-12)
    np.testing.assert_allclose(points.err2_deg, -0.1, atol=1e-12)
    assert points.warnings == ()


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("\nA\n", "\nE\n", r"a\.dat:2: mount 'E': only altazimuth PMFIT files"),
        ("35.05", "95.05", r"a\.dat:3: '95.05' is not a latitude in decimal degrees"),
        ("99.9 40.1", "99.9", r"a\.dat:4: 3 numbers where an observation has four or five"),
        ("99.9 40.1", "99.9 4O.1", r"a\.dat:4: '4O.1' \(number 4 of the line\) is not a number"),
        ("99.9 40.1", "99.9 400.1", r"a\.dat:4: azimuths must lie within"),
        ("17.5", "17.5 1", r"a\.dat:5: 6 numbers"),
    ],
)
def test_a_bad_pmfit_line_is_named(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    with pytest.raises(InputFileError, match=complaint):
        read_table(write(tmp_path, "a.dat", PMFIT.replace(old, new, 1)))


def test_a_model_is_read_with_its_flags(tmp_path: Path) -> None:
    model = read_tpoint_model(write(tmp_path, "a.mod", MODEL))
    assert model.names == ("IA", "IE", "TX", "HASA2")
    assert model.values == (-100.0, -200.0, 60.0, 3.5)
    assert model.sigmas == (1.5, 2.5, None, 0.5)
    assert (model.method, model.observations, model.sky_rms_arcsec) == ("T", 61, 17.41)


def test_a_model_survives_being_written(tmp_path: Path) -> None:
    model = TpointModel("one.dat", "T", 12, 0.25, ("IA", "TX"), (-100.1234, 60.5), (1.25, None))
    write_tpoint_model(model, tmp_path / "a.mod")
    assert read_tpoint_model(tmp_path / "a.mod") == model


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("END\n", "", r"a\.mod has no END line"),
        ("T   61", "T   x", r"a\.mod:2: the method, the number of observations"),
        ("-100.0000    1.5000", "", r"a\.mod:3: a term, its value and its sigma"),
        ("HASA2", "IA", r"a\.mod:6: term IA is given twice"),
        ("& IE      -200.0000    2.5000", "&", r"a\.mod:4: no term after '&'"),
    ],
)
def test_a_bad_model_line_is_named(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    with pytest.raises(InputFileError, match=complaint):
        read_tpoint_model(write(tmp_path, "a.mod", MODEL.replace(old, new, 1)))


def test_solar_offsets_are_observed_minus_solar(tmp_path: Path) -> None:
    points = read_table(write(tmp_path, "a.tsv", OFFSETS))
    assert (points.latitude_deg, points.longitude_deg) == (-74.7, 164.1)
    assert (points.unit, points.ax1_centre_deg) == ("Made-up dish", 180.0)
    assert points.status == ("accepted", "accepted", "rejected")
    np.testing.assert_allclose(points.ax1_deg[:2], [166.0, 176.0], atol=1e-12)
    np.testing.assert_allclose(points.ax2_deg[:2], [53.0, 52.0], atol=1e-12)
    # AX1 = 180 - A and AX2 = 90 - E turn the sign of observed minus solar.
    np.testing.assert_allclose(points.err1_deg[:2], 0.08, atol=1e-12)
    np.testing.assert_allclose(points.err2_deg[:2], -0.07, atol=1e-12)
    assert "taken as plain azimuth" in points.warnings[0]
    assert points.warnings[1].endswith("a.tsv: 1 of 3 rows have no offset and are left out")


def test_older_files_give_the_observed_place_and_the_other_sign(tmp_path: Path) -> None:
    points = read_table(write(tmp_path, "a.tsv", OBSERVED), latitude_deg=-74.7)
    assert not any("no offset" in warning for warning in points.warnings)
    np.testing.assert_allclose(points.ax1_deg, [166.0], atol=1e-12)
    np.testing.assert_allclose(points.ax2_deg, [53.0], atol=1e-12)
    np.testing.assert_allclose(points.err1_deg, [0.08], atol=1e-12)
    np.testing.assert_allclose(points.err2_deg, [-0.07], atol=1e-12)


def test_offsets_on_the_sky_are_divided_by_the_cosine_of_elevation(tmp_path: Path) -> None:
    path = write(tmp_path, "a.tsv", OFFSETS)
    points = read_table(path, offsets="on-sky")
    np.testing.assert_allclose(points.err1_deg[0], 0.08 / np.cos(np.radians(37.0)), atol=1e-12)
    said = write(
        tmp_path, "b.tsv", OFFSETS.replace("solar azimuth [deg]", "solar azimuth * cos(el)")
    )
    assert "on the sky" in read_table(said).warnings[0]
    np.testing.assert_allclose(read_table(said).err1_deg[0], points.err1_deg[0])


@pytest.mark.parametrize("kind", ["plain", "on-sky"])
def test_the_data_say_what_the_metadata_do_not(tmp_path: Path, kind: str) -> None:
    generator = np.random.default_rng(5)
    azimuth, elevation = generator.uniform(0, 360, 60), generator.uniform(10, 75, 60)
    a, e = np.radians(azimuth), np.radians(elevation)
    # Azimuth zero, collimation and a lean, as a rigid mount has them; plain azimuth.
    plain = -0.4 - 0.2 / np.cos(e) - 0.1 * np.sin(a) * np.tan(e) + generator.normal(0, 1e-3, 60)
    offset = plain if kind == "plain" else plain * np.cos(e)
    rows = "".join(
        f"2026-01-03T00:00:00Z\t{az:.4f}\t{el:.4f}\t{off:.6f}\t0.01\n"
        for az, el, off in zip(azimuth, elevation, offset, strict=True)
    )
    head = "# Location: dish\ntimestamp\tazimuth\televation\toffset_az\toffset_el\n"
    points = read_table(write(tmp_path, "a.tsv", head + rows), latitude_deg=10.0)
    assert "fits a mount" in points.warnings[0]
    np.testing.assert_allclose(points.err1_deg, -plain, atol=1e-4)
    other = "on-sky" if kind == "plain" else "plain"
    contradicted = read_table(
        write(tmp_path, "a.tsv", head + rows), latitude_deg=10.0, offsets=other
    )
    assert "as asked; but" in contradicted.warnings[0]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("37.0\t-0.08", "37.0\tx", r"a\.tsv:13: column offset_az: 'x' is not a number"),
        ("37.0\t-0.08", "97.0\t-0.08", r"a\.tsv:13: column elevation: '97.0' is not between"),
        ("37.0\t-0.08", "90.0\t-0.08", r"a\.tsv:13: column elevation: '90.0' is at the zenith"),
        ("2026-01-03T00:02:35Z", "noon", r"a\.tsv:13: column timestamp: 'noon' is not a date"),
        ("-0.08\t0.07", "-180.5\t0.07", r"a\.tsv:13: column offset_az: '-180.5' is not between"),
        ("-0.08\t0.07", "-0.08\t180.5", r"a\.tsv:13: column offset_el: '180.5' is not between"),
        ("-74.7 deg", "south", r"a\.tsv: latitude 'south' is not a number"),
    ],
)
def test_a_bad_offset_is_named(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    with pytest.raises(InputFileError, match=complaint):
        read_table(write(tmp_path, "a.tsv", OFFSETS.replace(old, new, 1)))


def test_pure_noise_is_taken_as_plain_azimuth(tmp_path: Path) -> None:
    generator = np.random.default_rng(7)
    rows = "".join(
        f"2026-01-03T00:00:00Z\t{az:.4f}\t{el:.4f}\t{off:.6f}\t0.01\n"
        for az, el, off in zip(
            generator.uniform(0, 360, 60),
            generator.uniform(10, 30, 60),
            generator.normal(0, 0.02, 60),
            strict=True,
        )
    )
    head = "# Location: dish\ntimestamp\tazimuth\televation\toffset_az\toffset_el\n"
    points = read_table(write(tmp_path, "a.tsv", head + rows), latitude_deg=10.0)
    assert "neither metadata nor data say otherwise" in points.warnings[0]


@pytest.mark.parametrize("name", ["a.bin", "a.tsv", "a"])
def test_points_are_written_under_two_endings_only(tmp_path: Path, name: str) -> None:
    points = read_table(write(tmp_path, "b.csv", CSV))
    with pytest.raises(ConfigurationError, match=r"written as \.csv or \.dat"):
        write_table(points, tmp_path / name)
    assert not (tmp_path / name).exists()
