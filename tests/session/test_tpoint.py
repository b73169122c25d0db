"""TPOINT alt-azimuth files, in and out."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from session_samples import table

from solarcal.errors import ConfigurationError, InputFileError, SolarcalError
from solarcal.optics.offset_mirror import Heliostat, MirrorOffset
from solarcal.optics.reflection import Target
from solarcal.session.interchange.altaz import (
    COLONS,
    DECIMAL,
    SPACED,
    many_rows,
    refuse_radians,
    sexagesimal_row,
)
from solarcal.session.interchange.tpoint import read_tpoint, write_tpoint
from solarcal.session.points import PointTable
from solarcal.units import wrap_deg

REFERENCE = Path(__file__).resolve().parents[3] / "shared" / "data" / "tpoint"

SMALL = """\
! observer: Ada
Test mount, 2026 Jun 21
: ALTAZ
: NODA
-30 14 40.2 2026 06 21.5 12.0 780.0 2700.0 0.3
350.5 45.0 350.4 45.1 300.0      ! first
! 120.0 30.0 119.9 30.1
* 200.0 60.0 199.9 60.1 12.5 1.5
! focus changed at 4 15
0.05 20.0 359.95 19.9
END
nothing after the end counts
"""


def read(tmp_path: Path, text: str, **options: Any) -> PointTable:
    path = tmp_path / "run.dat"
    path.write_text(text, encoding="utf-8")
    return read_tpoint(path, **options)


def test_observations_become_native_angles_and_encoder_errors(tmp_path: Path) -> None:
    points = read(tmp_path, SMALL)
    assert points.geometry == "azel"
    assert points.latitude_deg == -30.2445
    assert (points.longitude_deg, points.elevation_m) == (None, 2700.0)
    assert points.ax1_centre_deg == 180.0
    np.testing.assert_allclose(points.ax1_deg, [189.5, 60.0, 340.0, 179.95], atol=1e-12)
    np.testing.assert_allclose(points.ax2_deg, [45.0, 60.0, 30.0, 70.0], atol=1e-12)
    # Encoder minus true, as AX1 = 180 - A and AX2 = 90 - E turn it round.
    np.testing.assert_allclose(points.err1_deg, [0.1, 0.1, 0.1, 0.1], atol=1e-12)
    np.testing.assert_allclose(points.err2_deg, [-0.1, -0.1, -0.1, 0.1], atol=1e-12)
    assert points.status == ("accepted", "rejected", "rejected", "accepted")
    assert points.labels == (6, 7, 8, 10)
    assert np.isnan(points.utc_s).all()
    assert points.warnings == (f"{tmp_path / 'run.dat'}: 2 observations used, 2 masked",)


def test_blank_lines_between_observations_are_passed_over(tmp_path: Path) -> None:
    spaced = SMALL.replace("* 200.0", "\n   \n* 200.0").replace(": NODA\n", ": NODA\n\n")
    assert read(tmp_path, spaced).ax1_deg.tolist() == read(tmp_path, SMALL).ax1_deg.tolist()


def test_north_of_the_equator_the_branch_is_centred_on_south(tmp_path: Path) -> None:
    points = read(tmp_path, SMALL.replace("-30 14", "+30 14"))
    assert points.ax1_centre_deg == 0.0
    np.testing.assert_allclose(points.ax1_deg, [-170.5, 60.0, -20.0, 179.95], atol=1e-12)


def test_an_observation_commented_out_in_another_way_of_writing_is_a_remark(
    tmp_path: Path,
) -> None:
    other = "! 120:00:00 30:00:00 119:54:00 30:06:00"
    points = read(tmp_path, SMALL.replace("! 120.0 30.0 119.9 30.1", other))
    assert points.labels == (6, 8, 10)


@pytest.mark.parametrize("empty", ["!", "#", ";", "! \t", "!!", "! # nothing"])
def test_a_comment_without_a_word_is_a_remark(tmp_path: Path, empty: str) -> None:
    points = read(tmp_path, SMALL.replace("! 120.0 30.0 119.9 30.1", empty))
    assert points.labels == (6, 8, 10)


def test_angles_with_colons_below_zero_keep_their_sign(tmp_path: Path) -> None:
    row = "-0:30:00 -0:06:00 -0:24:00 -00:12:00"
    points = read(tmp_path, f"caption\n: ALTAZ\n-35\n{row}\nEND\n")
    # Azimuth -0.5 deg, elevation -0.1 deg; encoders at -0.4 and -0.2 deg.
    assert points.ax1_deg[0] == pytest.approx(180.5, abs=1e-12)
    assert points.ax2_deg[0] == pytest.approx(90.1, abs=1e-12)
    assert points.err1_deg[0] == pytest.approx(-0.1, abs=1e-12)
    assert points.err2_deg[0] == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize(
    ("dms", "latitude_deg"),
    [
        ("-00 30 00", -0.5),
        ("0 30 0", 0.5),
        ("+38 25 59", 38 + 25 / 60 + 59 / 3600),
        ("90 0 0", 90),
        ("-30.2445", -30.2445),
    ],
)
def test_latitudes(tmp_path: Path, dms: str, latitude_deg: float) -> None:
    found = read(tmp_path, SMALL.replace("-30 14 40.2", dms)).latitude_deg
    assert found == pytest.approx(latitude_deg, abs=1e-14)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("350.4 45.1 300.0 ", "350.4", r"dat:6: 3 numbers where an observation has four"),
        ("350.4 45.1", "350.4 45,1", r"dat:6: '45,1' \(number 4 of the line\) is not a number"),
        ("300.0 ", "nan ", r"dat:6: 'nan' \(number 5 of the line\) is not a number"),
        ("350.5 45.0", "350.5 90.5", r"dat:6: .* elevations within -90\.\.90"),
        ("350.5 45.0", "350.5 -90.5", r"dat:6: .* elevations within -90\.\.90"),
        ("350.5 45.0", "3505. 45.0", r"dat:6: azimuths must lie within"),
        ("-30 14 40.2", "95 14 40.2", r"dat:5: a latitude of 95\.2445 deg is beyond the pole"),
        ("-30 14 40.2", "-30 61 40.2", r"dat:5: minutes or seconds .* not below 60"),
        ("-30 14 40.2", "-30 -1 40.2", r"dat:5: minutes or seconds .* not below 60"),
        ("-30 14 40.2", "-30 14 -0.5", r"dat:5: minutes or seconds .* not below 60"),
        ("-30 14 40.2", "south", r"dat:5: 'south' is not a number; the latitude comes here"),
        (
            "-30 14 40.2 2026 06 21.5 12.0 780.0 2700.0 0.3", "-30.2445 14 40.2",
            r"dat:5: the latitude needs degrees, minutes and seconds",
        ),
        (": ALTAZ\n", "", r"no ': ALTAZ' line"),
        (
            "! observer: Ada\nTest mount, 2026 Jun 21\n: ALTAZ", "120.0 30.0 119.9 30.1",
            r"dat:1: a TPOINT file begins with its caption",
        ),
    ],
)  # fmt: skip
def test_a_bad_line_is_named(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    assert old in SMALL
    with pytest.raises(InputFileError, match=complaint) as refusal:
        read(tmp_path, SMALL.replace(old, new, 1))
    assert "\n" not in str(refusal.value)


def test_a_decimal_latitude_goes_on_as_the_other(tmp_path: Path) -> None:
    points = read(tmp_path, SMALL.replace("-30 14 40.2", "-30.2445"))
    assert (points.latitude_deg, points.elevation_m) == (-30.2445, 2700.0)


INDEXED = """\
Made-up night, IA -100 and IE -200 arcsec
: ALTAZ
+35 00 00
{rows}END
"""

# A - A_enc = 100 arcsec, E - E_enc = -200 arcsec in every row.
DECIMAL_ROWS = """\
100.0 40.0 99.9722222222 40.0555555556 12.5 ; exposure 26
;300.0 60.0 298.0 61.0 12.6 ; seen through a cloud
200.0 50.0 199.9722222222 50.0555555556 12.6
10.0 30.0 9.9722222222 30.0555555556 12.7
"""
SPACED_ROWS = """\
100 00 00.0 +40 00 00.0 099 58 20.0 +40 03 20.0
; 300 00 00.0 +60 00 00.0 298 00 00.0 +61 00 00.0
200 00 00.0 +50 00 00.0 199 58 20.0 +50 03 20.0 17 280.5
010 00 00.0 -00 30 00.0 009 58 20.0 -00 26 40.0
"""
COLON_ROWS = """\
100:00:00.0 +40:00:00 99:58:20.0 +40:03:20
200:00:00.0 +50:00:00 199:58:20.0 +50:03:20
* 300:00:00.0 +60:00:00 298:00:00.0 +61:00:00
010:00:00.0 -00:30:00.0 009:58:20.0 -00:26:40.0
"""


@pytest.mark.parametrize("rows", [DECIMAL_ROWS, SPACED_ROWS, COLON_ROWS])
def test_dialects_of_one_night(tmp_path: Path, rows: str) -> None:
    points = read(tmp_path, INDEXED.format(rows=rows))
    accepted = points.accepted()
    np.testing.assert_allclose(accepted.err1_deg * 3600.0, 100.0, atol=1e-6)
    np.testing.assert_allclose(accepted.err2_deg * 3600.0, -200.0, atol=1e-6)
    assert (points.count("accepted"), points.count("rejected")) == (3, 1)
    assert points.warnings == (f"{tmp_path / 'run.dat'}: 3 observations used, 1 masked",)


@pytest.mark.parametrize(
    ("rows", "complaint"),
    [
        (
            "085 40.04 +54 29.42 085 38.37 +54 32.75\n",
            r"dat:4: columns of whole degrees and minutes are not read",
        ),
        (
            "085 40 62.2 +54 29 25.1 085 38 22.2 +54 32 45.1\n",
            r"dat:4: .* minutes and seconds below 60",
        ),
        (
            "05 42 40.1 +54 29 25.1 085 38 22.2 +54 32 45.1\n",
            r"dat:4: read as degrees minutes seconds the encoders are 80 deg from the true place",
        ),
        (
            "85:40:02 54:29:61 85:38:22 54:32:45\n",
            r"dat:4: minutes or seconds are not below 60",
        ),
        (
            "85:40:02 54:60:00 85:38:22 54:32:45\n",
            r"dat:4: minutes or seconds are not below 60",
        ),
        ("85:40:02 54:29:25 85:38:22\n", r"dat:4: 3 angles where an observation has four"),
        ("85:40:02 54:29:25 85:38:22 x\n", r"dat:4: 'x' \(number 4 of the line\) is not"),
        (
            "85 40 2 54 29 25 85 38 22 54 32 45\n85.1 54.5 85.0 54.6\n",
            r"dat:5: this observation is in decimal degrees, those above in degrees minutes",
        ),
        (
            "1.4952 0.9510 1.4947 0.9520\n2.3246 0.9979 2.3241 0.9988\n"
            "3.9316 0.5750 3.9311 0.5759\n",
            r"run\.dat: .* this looks like radians; convert the angles to degrees",
        ),
    ],
)
def test_layouts_that_are_not_read_are_named(tmp_path: Path, rows: str, complaint: str) -> None:
    with pytest.raises(InputFileError, match=complaint):
        read(tmp_path, INDEXED.format(rows=rows))


def test_files_that_are_no_tpoint_file(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="is empty"):
        read(tmp_path, "\n")
    with pytest.raises(InputFileError, match="no latitude line"):
        read(tmp_path, "caption\n: ALTAZ\nEND\n")
    with pytest.raises(InputFileError, match="is missing: no such file"):
        read_tpoint(tmp_path / "none.dat")


def test_a_file_without_its_end_is_read_with_a_warning(tmp_path: Path) -> None:
    points = read(tmp_path, SMALL.partition("END")[0])
    assert len(points) == 4
    assert "no END line" in points.warnings[-1]


def test_options_fill_what_the_format_cannot_hold(tmp_path: Path) -> None:
    points = read(tmp_path, SMALL, longitude_deg=-70.8, unit="AuxTel", geometry="azel")
    assert (points.longitude_deg, points.unit) == (-70.8, "AuxTel")
    with pytest.raises(ConfigurationError, match="of geometry azel, not polar"):
        read(tmp_path, SMALL, geometry="polar")


def test_written_files_are_plain_tpoint(tmp_path: Path) -> None:
    path = tmp_path / "out.dat"
    points = table(
        2,
        status=("accepted", "rejected"),
        ax1_deg=np.array([170.0, -90.0]),
        ax2_deg=np.array([45.0, 60.0]),
        err1_deg=np.array([0.25, -0.5]),
        err2_deg=np.array([0.125, 0.0]),
    )
    write_tpoint(points, path)
    assert path.read_text().splitlines() == [
        "tower 3: points from solarcal",
        "! lon_deg=-106.48",
        "! elevation_m=1830.0",
        "! unit=tower 3",
        "! ax1_centre_deg=0.0",
        "! ideal=apparent",
        ": ALTAZ",
        "+35 03 0",
        "010.0000000000 45.0000000000 009.7500000000 44.8750000000",
        "! 270.0000000000 30.0000000000 270.5000000000 30.0000000000",
        "END",
    ]


def test_other_geometries_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="for azel only, not for polar"):
        write_tpoint(table(geometry="polar"), tmp_path / "out.dat")
    with pytest.raises(ConfigurationError, match="needs the latitude"):
        write_tpoint(table(latitude_deg=None), tmp_path / "out.dat")
    assert list(tmp_path.iterdir()) == []


def test_attempts_without_angles_are_left_out(tmp_path: Path) -> None:
    nothing = np.array([np.nan, 1.0])
    points = table(2, status=("aborted", "accepted"), ax1_deg=nothing, err1_deg=nothing)
    write_tpoint(points, tmp_path / "out.dat")
    assert len(read_tpoint(tmp_path / "out.dat")) == 1


angle = st.floats(-180.0, 180.0, exclude_min=True)


@st.composite
def tables(draw: st.DrawFn) -> PointTable:
    n = draw(st.integers(0, 5))

    def column(values: st.SearchStrategy[float]) -> np.ndarray[Any, Any]:
        return np.array(draw(st.lists(values, min_size=n, max_size=n)), dtype=np.float64)

    centre = draw(st.sampled_from([0.0, 180.0, 20.0]))
    return table(
        n,
        latitude_deg=draw(st.floats(-90.0, 90.0)),
        longitude_deg=draw(st.none() | st.floats(-180.0, 180.0)),
        unit=draw(st.sampled_from(["", "tower 3", "a=b"])),
        ax1_centre_deg=centre,
        ax1_deg=wrap_deg(column(angle), centre),
        ax2_deg=column(st.floats(0.0, 180.0)),
        err1_deg=column(st.floats(-179.0, 179.0)),
        err2_deg=column(st.floats(-180.0, 180.0)),
        status=tuple(
            draw(st.lists(st.sampled_from(["accepted", "rejected"]), min_size=n, max_size=n))
        ),
    )


@settings(derandomize=True, max_examples=150, deadline=None)
@given(points=tables())
def test_tpoint_round_trips_to_the_printed_digits(
    points: PointTable, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "round.dat"
    write_tpoint(points, path)
    again = read_tpoint(path)
    assert np.all(np.abs(wrap_deg(again.ax1_deg - points.ax1_deg)) <= 2e-10)
    np.testing.assert_allclose(again.ax2_deg, points.ax2_deg, rtol=0, atol=2e-10)
    np.testing.assert_allclose(again.err1_deg, points.err1_deg, rtol=0, atol=2e-10)
    np.testing.assert_allclose(again.err2_deg, points.err2_deg, rtol=0, atol=2e-10)
    for name in ("latitude_deg", "longitude_deg", "elevation_m", "unit", "ax1_centre_deg",
                 "status"):  # fmt: skip
        assert getattr(again, name) == getattr(points, name), name
    first = path.read_bytes()
    write_tpoint(again, path)
    assert path.read_bytes() == first


@settings(derandomize=True, max_examples=250, deadline=None)
@given(
    at=st.integers(0, len(SMALL) - 1),
    length=st.integers(0, 20),
    patch=st.binary(max_size=5)
    | st.sampled_from([b"1e99", b"\0", b"!", b"*", b":", b"END", b"9" * 500, b"-", b"1e999999"]),
)
def test_damaged_files_are_read_or_refused(
    at: int, length: int, patch: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "fuzz.dat"
    whole = SMALL.encode()
    path.write_bytes(whole[:at] + patch + whole[at + length :])
    try:
        points = read_tpoint(path)
    except SolarcalError as error:
        refusal = str(error)
    else:
        refusal = ""
        assert np.isfinite(points.ax1_deg + points.ax2_deg).all()
        assert np.isfinite(points.err1_deg + points.err2_deg).all()
    assert "\n" not in refusal


@pytest.mark.parametrize(
    ("name", "observations"),
    [("auxtel-2020-Jan-26-UTC-1-47-15.dat", 17), ("auxtel-2020-Mar-15-UTC-2-27-13.dat", 44)],
)
def test_the_real_files_survive_being_written(tmp_path: Path, name: str, observations: int) -> None:
    if not (REFERENCE / name).exists():
        pytest.skip("reference data (shared/data/tpoint) is not here")
    points = read_tpoint(REFERENCE / name)
    assert (len(points), points.count("accepted")) == (observations, observations)
    assert points.latitude_deg == -30.2445
    write_tpoint(points, tmp_path / "copy.dat")
    again = read_tpoint(tmp_path / "copy.dat")
    np.testing.assert_allclose(again.ax1_deg, points.ax1_deg, rtol=0, atol=1e-12)
    np.testing.assert_allclose(again.err1_deg, points.err1_deg, rtol=0, atol=1e-12)
    np.testing.assert_allclose(again.err2_deg, points.err2_deg, rtol=0, atol=1e-12)


# -- many rows at once ----------------------------------------------------------------------------

DECIMALS = ["210.5 41.25 210.6 41.5", "-0.5 -1 +359.75 .5", "10. 20 11 21"]
SPACED_ROWS = ["210 30 00.0 41 15 00 210 36 0 41 30 00.00", "-0 30 00 -0 00 30.5 359 30 0 0 00 30"]
COLON_ROWS = ["210:30:00.0 41:15:00 210:36:0 41:30:00", "-0:30:00 -0:00:30.5 0:30:00 -0:00:30"]


def test_the_target_of_a_heliostat_comes_back(tmp_path: Path) -> None:
    """Without it the normals of a mirror would be taken for places of the Sun."""
    mirror = Heliostat(Target(176.0, 78.0, 120.0), MirrorOffset(0.12, 0.0, 0.35))
    write_tpoint(table(heliostat=mirror), tmp_path / "h.dat")
    read = read_tpoint(tmp_path / "h.dat").heliostat
    assert read is not None
    assert read.target == mirror.target
    for name in ("AzimPivot_R", "PivotRefl_R", "PivotRefl_Z"):
        assert getattr(read.offset, name) == pytest.approx(getattr(mirror.offset, name), abs=1e-6)
    write_tpoint(table(), tmp_path / "plain.dat")
    assert read_tpoint(tmp_path / "plain.dat").heliostat is None


def test_degrees_and_minutes_without_seconds_keep_the_sign_of_the_degrees() -> None:
    cells = ["-10:30", "20:15", "-0:45", "-5:06:36"]
    with pytest.raises(InputFileError, match="25 deg from the true place"):
        sexagesimal_row(cells, COLONS, "")
    cells[3] = "19:54"
    row = sexagesimal_row(cells, COLONS, "")
    assert row == pytest.approx((-10.5, 20.25, -0.75, 19.9), abs=1e-12)


@pytest.mark.parametrize(
    ("layout", "rows"), [(DECIMAL, DECIMALS), (SPACED, SPACED_ROWS), (COLONS, COLON_ROWS)]
)
def test_many_rows_give_the_angles_of_each_alone_to_the_last_bit(
    layout: str, rows: list[str]
) -> None:
    alone = [
        tuple(map(float, row.split()))
        if layout == DECIMAL
        else sexagesimal_row(row.split(), layout, "")
        for row in rows
    ]
    together = many_rows(rows, layout)
    assert together is not None
    assert together.tolist() == [list(row) for row in alone]


@pytest.mark.parametrize(
    ("layout", "row"),
    [
        (DECIMAL, "1 2 3"), (DECIMAL, "1 2 3 4 5 6 7 8"), (DECIMAL, "1 2 3 4e0"),
        (DECIMAL, "1_0 2 3 4"), (DECIMAL, "1 2 3 nan"), (DECIMAL, "1 2 3 -"),
        (DECIMAL, "1 91 3 4"), (DECIMAL, "1 2 3 \N{ARABIC-INDIC DIGIT FOUR}"),
        (DECIMAL, "1 2 3 " + "0" * 31 + "4"), (SPACED, "10 60 0 10 0 0 10 0 0 10 0 0"),
        (SPACED, "10 0 0 10 0 0 50 0 0 10 0 0"), (COLONS, "10:0:0 10:0:0 10:0:0"),
        (COLONS, "10:0:0 10:0 10:0:0 10:0:0"),
    ],
)  # fmt: skip
def test_a_row_that_is_not_certainly_right_is_left_to_be_looked_at_alone(
    layout: str, row: str
) -> None:
    good = {DECIMAL: DECIMALS, SPACED: SPACED_ROWS, COLONS: COLON_ROWS}[layout]
    assert many_rows(good[:1], layout) is not None
    assert many_rows([*good[:1], row], layout) is None


def test_a_slip_far_down_a_long_file_is_named_by_its_line(tmp_path: Path) -> None:
    rows = ["210.5 41.25 210.6 41.5"] * 500
    path = tmp_path / "long.dat"
    for slip, words in (("210.5 41.25 210.6 4l.5", "'4l.5'"), ("210.5 95 210.6 41", "-90..90")):
        path.write_text("\n".join(["caption", ": ALTAZ", "35", *rows, slip, *rows, "END"]))
        with pytest.raises(InputFileError, match=rf"long\.dat:504: .*{words}"):
            read_tpoint(path)


def test_masked_rows_keep_their_place_among_many(tmp_path: Path) -> None:
    rows = [f"{200 + i} 41 {200 + i}.25 41" for i in range(9)]
    rows[4] = "; " + rows[4]
    rows[6] = "* " + rows[6] + " ! cloud"
    path = tmp_path / "masked.dat"
    path.write_text("\n".join(["caption", ": ALTAZ", "35", *rows, "END"]))
    table = read_tpoint(path)
    assert (180.0 - table.ax1_deg).tolist() == [200.0 + i for i in range(9)]
    assert table.err1_deg.tolist() == [-0.25] * 9
    assert [i for i, status in enumerate(table.status) if status == "rejected"] == [4, 6]
    assert table.labels == tuple(range(4, 13))


@pytest.mark.parametrize(("column", "angle"), [(0, 6.6), (1, 1.8), (2, 6.6), (3, -1.8)])
def test_low_observations_near_north_are_no_radians(column: int, angle: float) -> None:
    """Radians go once round, and none is above pi/2: a single one beyond says degrees."""
    azimuth, elevation = np.linspace(0.5, 6.0, 30), np.linspace(0.2, 1.5, 30)
    rows = np.column_stack((azimuth, elevation, azimuth, elevation))
    with pytest.raises(InputFileError, match="looks like radians"):
        refuse_radians(rows, "run.dat")
    rows[4, column] = angle
    refuse_radians(rows, "run.dat")
