"""Points CSV: what is read, what is refused and where, and exact round trips."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from session_samples import assert_same_points, table

from solarcal.errors import ConfigurationError, InputFileError, SolarcalError, harmless
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.session.points import PointTable
from solarcal.timescale import parse_utc
from solarcal.units import wrap_deg

FULL = """\
# geometry=azel
# lat_deg=35.05
# lon_deg=-106.48
# elevation_m=1830
# unit=tower 3
# taken by Ada, in wind
utc,ax1_deg,ax2_deg,err1_deg,err2_deg,sigma_deg,status,approach1,approach2,note
2026-06-21T15:30:00Z,61.5,54.25,0.25,-0.125,0.02,accepted,1,-1,"good, ""calm"", dry"
2026-06-21T16:00:00Z,55.5,48,0.26,-0.126,0.02,,+,-,
,,,,,,aborted,,,clouds
2026-06-21T16:30:00Z,45,40,0.27,-0.127,0.03,Rejected,0,.,bird
"""
PLAIN = "utc,ax1_deg,ax2_deg,err1_deg,err2_deg\n"


def read(tmp_path: Path, text: str | bytes, **options: Any) -> PointTable:
    path = tmp_path / "points.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_points_csv(path, **options)


def test_everything_a_file_can_say(tmp_path: Path) -> None:
    points = read(tmp_path, FULL)
    assert (points.geometry, points.unit, points.ideal) == ("azel", "tower 3", "apparent")
    assert (points.latitude_deg, points.longitude_deg, points.elevation_m) == (
        35.05, -106.48, 1830.0,
    )  # fmt: skip
    assert points.ax1_centre_deg == 0.0
    assert points.utc_s[0] == parse_utc("2026-06-21T15:30:00Z")
    assert points.ax1_deg[[0, 1, 3]].tolist() == [61.5, 55.5, 45.0]
    assert np.isnan([points.utc_s[2], points.ax1_deg[2], points.err2_deg[2]]).all()
    assert points.err2_deg[1] == -0.126
    assert points.sigma_deg is not None
    assert points.sigma_deg[3] == 0.03
    assert points.status == ("accepted", "accepted", "aborted", "rejected")
    assert points.approach == ((1, -1), (1, -1), (0, 0), (0, 0))
    assert points.note == ('good, "calm", dry', "", "clouds", "bird")
    assert points.labels == (8, 9, 10, 11)
    assert points.accepted().labels == (8, 9)
    assert points.warnings == ()


@pytest.mark.parametrize(
    "text",
    [
        FULL.replace("\n", "\r\n"),
        "\ufeff" + FULL,
        FULL.rstrip("\n"),
        FULL + "\n\n",
        FULL + "   \n\t\n , ,,,,,,,\n",
        FULL.replace("utc,ax1", " UTC , ax1"),
        FULL.replace("# geometry=azel", "#geometry = azel ,,,,"),
        FULL.replace(",note\n", ",note,operator\n").replace("clouds", "clouds,Ada").replace(
            "bird", "bird,Ada").replace('dry"', 'dry",').replace("+,-,", "+,-,,"),
    ],
    ids=["CR LF", "BOM", "no last newline", "blank lines", "blanks", "spaces", "spreadsheet commas",
         "unknown column"],
)  # fmt: skip
def test_what_spreadsheets_and_editors_do_is_read(tmp_path: Path, text: str) -> None:
    assert_same_points(read(tmp_path, text), read(tmp_path, FULL))


def test_columns_may_come_in_any_order(tmp_path: Path) -> None:
    points = read(tmp_path, "err2_deg,note,ax2_deg,ax1_deg,err1_deg,utc\n4,a,2,1,3,\n",
                  geometry="azel")  # fmt: skip
    row = (points.ax1_deg, points.ax2_deg, points.err1_deg, points.err2_deg)
    assert [column[0] for column in row] == [1, 2, 3, 4]


def test_rows_commented_out_are_ignored_and_a_note_may_have_lines(tmp_path: Path) -> None:
    rows = ',1,20,0,0,"one\n# two\nthree"\n#,1,2,3,4,\n,5,60,0,0,x\n'
    text = PLAIN.replace("\n", ",note\n") + rows
    points = read(tmp_path, text, geometry="azel")
    assert points.note == ("one\n# two\nthree", "x")
    assert points.labels == (2, 6)


def test_options_fill_what_is_missing_and_never_overrule_the_file(tmp_path: Path) -> None:
    options = {"geometry": "polar", "latitude_deg": -20.0, "longitude_deg": 55.0,
               "elevation_m": 10.0, "unit": "B"}  # fmt: skip
    filled = read(tmp_path, PLAIN, **options)
    assert (filled.geometry, filled.latitude_deg, filled.longitude_deg) == ("polar", -20.0, 55.0)
    assert (filled.elevation_m, filled.unit) == (10.0, "B")
    own = read(tmp_path, FULL, **options)
    assert (own.geometry, own.latitude_deg, own.unit) == ("azel", 35.05, "tower 3")
    assert len(own.warnings) == 5
    assert any("its own unit tower 3 was used, not the option's B" in w for w in own.warnings)
    assert read(tmp_path, FULL, geometry="azel", latitude_deg=35.05).warnings == ()


def test_the_geometry_must_be_known(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"does not say its geometry; add --geometry"):
        read(tmp_path, PLAIN)
    with pytest.raises(ConfigurationError, match=r"'altaz' is none of azel"):
        read(tmp_path, PLAIN, geometry="altaz")
    assert read(tmp_path, PLAIN, geometry="azel").site is None


def test_ax1_is_brought_onto_the_branch(tmp_path: Path) -> None:
    text = "# geometry=azel\n# lat_deg=-33.9\n" + PLAIN + ",-170,50,0,0\n,190,50,0,0\n,360,50,0,0\n"
    southern = read(tmp_path, text)
    assert southern.ax1_centre_deg == 180.0
    assert southern.ax1_deg.tolist() == [190.0, 190.0, 360.0]
    tropical = read(tmp_path, "# ax1_centre_deg=0\n" + text)
    assert tropical.ax1_deg.tolist() == [-170.0, -170.0, 0.0]
    assert read(tmp_path, text.replace("azel", "polar")).ax1_centre_deg == 0.0


BAD_CELLS = [
    ("15:30:00Z,61.5", "15:30:00Z,6l.5", r"csv:8: column ax1_deg: '6l\.5' is not a number"),
    ("54.25", "nan", r"csv:8: column ax2_deg: 'nan' is not a number"),
    ("54.25", "-inf", r"csv:8: column ax2_deg: '-inf' is not a number"),
    ("54.25", "181", r"csv:8: column ax2_deg: '181' is not between 0 and 180"),
    ("54.25", "1_0", r"csv:8: column ax2_deg: '1_0' is not a number"),
    ("54.25", "٣", r"csv:8: column ax2_deg: '٣' is not a number"),
    ("48,0.26", "48,", r"csv:9: column err1_deg: is empty"),
    ("-0.126", "900", r"csv:9: column err2_deg: '900' is not between -180 and 180"),
    (",0.02,,", ",0,,", r"csv:9: column sigma_deg: '0' is not between"),
    (",0.02,,", ",,,", r"csv:9: column sigma_deg: is empty, but other rows have one"),
    ("Rejected", "maybe", r"csv:11: column status: 'maybe' is none of accepted, aborted"),
    (",+,-,", ",up,-,", r"csv:9: column approach1: 'up' is none of 1, -1, 0"),
    ("2026-06-21T16:30:00Z", "noon", r"csv:11: column utc: 'noon' is not a date and time"),
    ("2026-06-21T16:30:00Z", "0001-01-01", r"csv:11: column utc: '0001-01-01' is not between"),
    ("clouds\n", "clouds,1\n", r"csv:10: 11 cells where the header has 10 \(column number 11\)"),
    (",0.27,-0.127,0.03,Rejected,0,.,bird", "", r"csv:11: 3 cells .* \(column err1_deg\)"),
    ('"good', '"go"od', r"csv:8: not readable as CSV"),
    ("bird", '"bird', r"csv:11: not readable as CSV"),
    ("lat_deg=35.05", "lat_deg=high", r"csv:2: lat_deg='high' is not a number"),
    ("lat_deg=35.05", "lat_deg=95", r"csv: latitude 95 is not between -90 and 90"),
    ("geometry=azel", "geometry=altaz", r"csv:1: geometry='altaz' is none of azel"),
    ("# unit=tower 3", "# ideal=real", r"csv:5: ideal='real' is none of apparent, airless"),
    ("# unit=tower 3", "# lat_deg=35", r"csv:5: lat_deg is given twice"),
    ("# unit=tower 3", "# ax1_centre_deg=900", r"csv:5: ax1_centre_deg=900 is not within 360"),
    ("err1_deg,err2_deg", "err1_deg,error2", r"csv:7: the header line has no column err2_deg"),
    ("approach1,approach2", "approach1,status", r"csv:7: the header line has the column status tw"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "complaint"), BAD_CELLS)
def test_a_bad_cell_is_named_by_line_and_column(
    tmp_path: Path, old: str, new: str, complaint: str
) -> None:
    assert FULL.count(old) >= 1
    with pytest.raises(InputFileError, match=complaint) as refusal:
        read(tmp_path, FULL.replace(old, new, 1))
    assert "\n" not in str(refusal.value)


def test_the_first_bad_cell_of_a_long_column_is_the_one_named(tmp_path: Path) -> None:
    rows = [f",{i % 90},40,0.1,0.1" for i in range(5000)]
    rows[4000] = ",x,40,0.1,0.1"
    rows[4500] = ",y,40,0.1,0.1"
    with pytest.raises(InputFileError, match=r"csv:4002: column ax1_deg: 'x'"):
        read(tmp_path, PLAIN + "\n".join(rows), geometry="azel")


@pytest.mark.parametrize("cell", ["1_0", "٣"])
def test_a_column_without_gaps_holds_plain_digits_only(tmp_path: Path, cell: str) -> None:
    with pytest.raises(InputFileError, match=rf"csv:3: column ax2_deg: '{cell}' is not a number"):
        read(tmp_path, f"{PLAIN},1,50,0,0\n,2,{cell},0,0\n", geometry="azel")


@pytest.mark.parametrize("date", ["1900-01-01T00:00:00", "2200-12-31T23:59:59"])
def test_dates_of_three_centuries_are_read(tmp_path: Path, date: str) -> None:
    points = read(tmp_path, f"{PLAIN}{date}Z,1,50,0,0\n", geometry="azel")
    assert points.utc_s[0] == parse_utc(date)


@pytest.mark.parametrize("date", ["1899-12-31T23:59:59Z", "2201-01-01T00:00:00Z"])
@pytest.mark.parametrize(
    ("ideal", "cure"), [("apparent", "correct it, or leave it empty"), ("airless", "correct it")]
)
def test_other_dates_are_refused_with_the_way_out(
    tmp_path: Path, date: str, ideal: str, cure: str
) -> None:
    text = f"# ideal={ideal}\n{PLAIN}{date},1,50,0,0\n"
    with pytest.raises(InputFileError) as refusal:
        read(tmp_path, text, geometry="azel")
    assert str(refusal.value).endswith(
        f"csv:3: column utc: {date!r} is not between 1900-01-01 and 2200-12-31; {cure}"
    )


@pytest.mark.parametrize("ideal", ["airless", "solartrak"])
def test_only_apparent_angles_do_without_a_time(tmp_path: Path, ideal: str) -> None:
    text = f"# ideal={ideal}\n{PLAIN},1,50,0,0\n"
    with pytest.raises(InputFileError, match=r"csv:3: column utc: is empty; only rows of ideal=ap"):
        read(tmp_path, text, geometry="azel")
    assert len(read(tmp_path, text.replace(ideal, "apparent"), geometry="azel")) == 1


def test_files_that_are_no_points_file(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="is empty"):
        read(tmp_path, "", geometry="azel")
    with pytest.raises(InputFileError, match="is empty"):
        read(tmp_path, "# geometry=azel\n\n")
    with pytest.raises(InputFileError, match="is empty"):
        read(tmp_path, "\n \n")
    with pytest.raises(InputFileError, match=r"csv:1: the header line .* by semicolons; save .*"):
        read(tmp_path, PLAIN.replace(",", ";"), geometry="azel")
    with pytest.raises(InputFileError, match=r"csv:1: the header line .* by tabs; save .*"):
        read(tmp_path, PLAIN.replace(",", "\t"), geometry="azel")
    with pytest.raises(InputFileError, match=r"csv:2: not UTF-8 text \(byte 0xff\)"):
        read(tmp_path, PLAIN.encode() + b"\xff", geometry="azel")
    with pytest.raises(InputFileError, match="is missing: no such file"):
        read_points_csv(tmp_path / "none.csv")


def test_twenty_thousand_rows_come_back(tmp_path: Path) -> None:
    n = 20_000
    many = table(n, utc_s=1782055800.0 + np.arange(n) / 8.0, sigma_deg=np.full(n, 0.02))
    path = tmp_path / "many.csv"
    write_points_csv(many, path)
    assert_same_points(read_points_csv(path), many)


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    for target in (tmp_path / "no" / "such.csv", tmp_path, "a\0.csv"):
        with pytest.raises(ConfigurationError, match="cannot be written"):
            write_points_csv(table(), target)
    assert [p.name for p in tmp_path.iterdir()] == []


def test_what_a_terminal_would_obey_is_written_out(tmp_path: Path) -> None:
    target = tmp_path / "a.csv"
    write_points_csv(table(note=("\udcff", "\x1b[2J\x07", "\u202egnorw")), target)
    said = (r"\udcff", r"\x1b[2J\x07", r"\u202egnorw")
    assert read_points_csv(target).note == said
    target.write_text(target.read_text().replace(r"\x1b", "\x1b"), encoding="utf-8")
    assert read_points_csv(target).note == said


# -- round trips and arbitrary content ---------------------------------------------------------

# Adding zero leaves no negative zero, whose sign the branch does not keep.
angle = st.floats(-180.0, 180.0, exclude_min=True).map(lambda a: a + 0.0)
instants = st.integers(-(2 * 10**15), 7 * 10**15).map(lambda micros: micros / 1e6)
notes = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
names = st.text(st.characters(exclude_categories=["Cs", "Cc", "Z"]), max_size=12).map(
    lambda name: name.rstrip(",")
)


@st.composite
def tables(draw: st.DrawFn) -> PointTable:
    n = draw(st.integers(0, 6))

    def column(values: st.SearchStrategy[float]) -> np.ndarray[Any, Any]:
        return np.array(draw(st.lists(values, min_size=n, max_size=n)), dtype=np.float64)

    def several(values: st.SearchStrategy[Any]) -> tuple[Any, ...]:
        return tuple(draw(st.lists(values, min_size=n, max_size=n)))

    centre = draw(st.sampled_from([0.0, 180.0, -37.5]))
    made = table(
        n,
        geometry=draw(st.sampled_from(["azel", "polar", "tiltroll-ew", "tiltroll-ns"])),
        latitude_deg=draw(st.none() | st.floats(-90.0, 90.0)),
        longitude_deg=draw(st.none() | st.floats(-180.0, 180.0)),
        elevation_m=draw(st.floats(-100.0, 6000.0)),
        unit=draw(names),
        ax1_centre_deg=centre,
        ideal=draw(st.sampled_from(["apparent", "airless", "solartrak"])),
        utc_s=column(instants),
        ax1_deg=wrap_deg(column(angle), centre),
        ax2_deg=column(st.floats(0.0, 180.0)),
        err1_deg=column(angle),
        err2_deg=column(angle),
        sigma_deg=draw(st.sampled_from([None, np.full(n, 0.1 + 0.2) if n else None])),
        status=several(st.sampled_from(["accepted", "aborted", "rejected"])),
        approach=several(st.tuples(st.integers(-1, 1), st.integers(-1, 1))),
        note=several(notes),
    )
    for i, status in enumerate(made.status):
        if status != "accepted" and draw(st.booleans()):
            for name in ("utc_s", "ax1_deg", "err2_deg"):
                getattr(made, name)[i] = np.nan
    return made


@settings(derandomize=True, max_examples=150, deadline=None)
@given(points=tables())
def test_csv_round_trips_to_the_last_bit(
    points: PointTable, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "round.csv"
    write_points_csv(points, path)
    again = read_points_csv(path)
    # What a terminal would obey is written out; all else is the same.
    note = tuple(map(harmless, points.note))
    assert_same_points(again, dataclasses.replace(points, note=note, unit=harmless(points.unit)))
    first = path.read_bytes()
    write_points_csv(again, path)
    assert path.read_bytes() == first


@settings(derandomize=True, max_examples=250, deadline=None)
@given(
    at=st.integers(0, len(FULL.encode()) - 1),
    length=st.integers(0, 20),
    patch=st.binary(max_size=5) | st.sampled_from([b'"', b",", b"\r", b"\0", b"1e999", b"\n\n"]),
)
def test_damaged_files_are_read_or_refused(
    at: int, length: int, patch: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "fuzz.csv"
    whole = FULL.encode()
    path.write_bytes(whole[:at] + patch + whole[at + length :])
    try:
        points = read_points_csv(path, geometry="azel")
    except SolarcalError as error:
        refusal = str(error)
    else:
        refusal = ""
        used = points.accepted()
        assert np.isfinite(used.ax1_deg + used.ax2_deg + used.err1_deg + used.err2_deg).all()
    assert "\n" not in refusal
