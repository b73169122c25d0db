"""Points of sessions as tables, imports, merged files, and the Sun they were taken on."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from session_samples import HEADER, UTC, assert_same_points, note, point, table

from solarcal.errors import InputFileError, SessionFileError
from solarcal.optics.offset_mirror import Heliostat, MirrorOffset, Target
from solarcal.session.interchange import (
    imported_header,
    read_table,
    session_from_table,
    write_table,
)
from solarcal.session.journal import Journal
from solarcal.session.points import (
    PointTable,
    ideal_kind,
    labelled_by_file,
    merge_tables,
)
from solarcal.session.records import Answers, Header, PointRecord, Record, Void
from solarcal.session.view import SessionView, read_session, view_session
from solarcal.site import Site, Weather
from solarcal.stopping_rule import DEFAULT_UNMODELLED
from solarcal.timescale import parse_utc


def session(*records: Record, header: Header = HEADER) -> SessionView:
    return view_session(header, records, "day.jsonl", ("day.jsonl:9: torn",))


ABORTED = PointRecord(
    seq=2, utc=UTC, status="aborted", answers=Answers(ref_check=False), reason="no ref check"
)


def test_a_sessions_points_with_their_statuses() -> None:
    points = session(point(1), ABORTED, note(3), point(4, "rejected")).table
    assert points.labels == (1, 2, 4)
    assert points.status == ("accepted", "aborted", "rejected")
    assert points.note == ("", "no ref check", "")
    assert points.utc_s[0] == parse_utc("2026-06-21T15:29:58.250Z")
    assert (points.ax1_deg[0], points.err1_deg[0]) == (61.123456789, 0.276543211)
    assert np.isnan([points.utc_s[1], points.ax1_deg[1], points.err2_deg[1]]).all()
    assert points.approach == ((1, -1), (0, 0), (1, -1))
    assert points.unit == "SOLARTRAK-EMU 0001"
    assert points.site == Site(35.05, -106.48, 1830.0)
    assert points.ideal == "solartrak"
    assert points.sources == ("day.jsonl",) * 3
    assert points.warnings == ("day.jsonl:9: torn",)
    assert points.sigma_deg is None


def test_voided_points_are_left_out() -> None:
    void = Void(seq=3, utc=UTC, voids=1, reason="bird")
    assert session(point(1), point(2), void).table.labels == (2,)


def test_sigmas_count_only_where_every_accepted_point_has_one() -> None:
    some = session(point(1, sigma_deg=0.02), ABORTED).table
    assert some.sigma_deg is not None
    assert some.accepted().sigma_deg is not None
    assert session(point(1, sigma_deg=0.02), point(2)).table.sigma_deg is None


def test_a_session_without_points_is_an_empty_table() -> None:
    empty = session(note(1)).table
    assert len(empty) == 0
    assert empty.accepted().ax1_deg.shape == (0,)


def sampled() -> PointTable:
    nan = np.nan
    return table(
        4,
        geometry="tiltroll-ew",
        ideal="airless",
        utc_s=np.array([1782055800.123456, 1782055801.0, nan, 1782055803.5]),
        ax2_deg=np.array([50.1, 60.2, nan, 70.3]),
        ax1_deg=np.array([-10.1, 0.1 + 0.2, nan, -1e-9]),
        err1_deg=np.array([1e-17, 2.5, nan, -3.0]),
        err2_deg=np.array([0.1, -1e-5, nan, 3.0]),
        sigma_deg=np.array([0.02, 0.03, nan, 0.02]),
        status=("accepted", "accepted", "aborted", "rejected"),
        approach=((1, -1), (0, 1), (0, 0), (-1, -1)),
        note=("", "a\nb", "cloud", ""),
    )


def test_an_imported_table_comes_back_exactly(tmp_path: Path) -> None:
    path = tmp_path / "new.jsonl"
    made = session_from_table(sampled(), path, utc_s=parse_utc(UTC))
    read = read_session(path)
    assert (read.header, read.records) == (made.header, made.records)
    again = read.table
    assert_same_points(again, sampled())
    assert again.labels == (1, 2, 3, 4)
    assert read.header.unit.model == "imported"
    assert read.header.unknown == ()
    with pytest.raises(SessionFileError, match="exists already"):
        session_from_table(sampled(), path, utc_s=0.0)


@pytest.mark.parametrize("gone", [False, True])
def test_half_an_import_is_removed_and_its_error_is_the_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, gone: bool
) -> None:
    path = tmp_path / "new.jsonl"

    def full(journal: Journal, records: object) -> None:
        if gone:
            path.unlink()
        raise SessionFileError("no space left on device")

    monkeypatch.setattr(Journal, "append_all", full)
    with pytest.raises(SessionFileError, match="no space left"):
        session_from_table(sampled(), path, utc_s=0.0)
    assert not path.exists()


def test_two_files_are_labelled_by_file_and_one_is_not() -> None:
    first, second = sampled(), replace(sampled(), sources=("other.csv",) * 4)
    assert labelled_by_file([first]) == (first,)
    labels = [str(label) for one in labelled_by_file([first, second]) for label in one.labels]
    assert len(set(labels)) == 8
    assert all("other.csv" in label for label in labels[4:])


def test_what_an_import_is_not_told_stays_unknown(tmp_path: Path) -> None:
    bare = table(latitude_deg=None, longitude_deg=None, utc_s=np.full(3, np.nan))
    made = session_from_table(bare, tmp_path / "new.jsonl", utc_s=parse_utc(UTC))
    assert made.header.unknown == ("latitude", "longitude")
    again = made.table
    assert again.site is None
    assert_same_points(again, bare)


@pytest.mark.parametrize("centre_deg", [0.0, 180.0])
def test_an_imported_unit_is_taken_to_reach_every_place_of_its_branch(centre_deg: float) -> None:
    limits = imported_header(table(ax1_centre_deg=centre_deg), 0.0).unit.limits
    assert (limits.axis1.low_deg, limits.axis1.high_deg) == (centre_deg - 180.0, centre_deg + 180.0)
    assert (limits.axis2.low_deg, limits.axis2.high_deg) == (0.0, 180.0)


def test_csv_session_csv_is_the_same_file(tmp_path: Path) -> None:
    write_table(sampled(), tmp_path / "a.csv")
    session_from_table(read_table(tmp_path / "a.csv"), tmp_path / "b.jsonl", utc_s=0.0)
    write_table(read_table(tmp_path / "b.jsonl"), tmp_path / "c.csv")
    assert (tmp_path / "c.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()


# -- several files of one unit -----------------------------------------------------------------


def other(**changes: object) -> PointTable:
    return table(2, **{"sources": ("second.csv",) * 2, **changes})


def test_merged_rows_stay_traceable() -> None:
    merged = merge_tables([table(3), other(note=("x", "y"))])
    assert len(merged) == 5
    assert merged.labels == (2, 3, 4, 2, 3)
    assert merged.sources == ("points.csv",) * 3 + ("second.csv",) * 2
    assert merged.note[3:] == ("x", "y")
    np.testing.assert_array_equal(merged.ax1_deg[3:], other().ax1_deg)


def test_a_single_table_is_its_own_merger() -> None:
    only = table()
    assert merge_tables([only]) is only


def test_the_site_is_taken_from_whoever_knows_it() -> None:
    merged = merge_tables([table(latitude_deg=None, longitude_deg=None), other()])
    assert (merged.latitude_deg, merged.longitude_deg) == (35.05, -106.48)


def test_a_longitude_counted_to_360_is_of_the_same_place() -> None:
    assert len(merge_tables([table(), other(longitude_deg=253.52)])) == 5
    assert len(merge_tables([table(longitude_deg=180.0), other(longitude_deg=-180.0)])) == 5


def test_sigmas_of_some_files_only_are_dropped_and_said() -> None:
    merged = merge_tables([table(), other(sigma_deg=np.array([0.1, 0.2]))])
    assert merged.sigma_deg is None
    assert "only some of the files give sigma_deg" in merged.warnings[0]
    both = merge_tables([table(sigma_deg=np.full(3, 0.3)), other(sigma_deg=np.array([0.1, 0.2]))])
    assert both.sigma_deg is not None
    assert both.sigma_deg.tolist() == [0.3, 0.3, 0.3, 0.1, 0.2]


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"unit": "tower 4"}, "another unit"),
        ({"geometry": "polar"}, "another geometry"),
        ({"ax1_centre_deg": 180.0}, "another AX1 branch centre"),
        ({"ideal": "airless"}, "another kind of ideal angles"),
        ({"latitude_deg": 36.0}, "another latitude"),
        ({"longitude_deg": 106.48}, "another longitude"),
    ],
)
def test_files_that_do_not_belong_together_are_refused(
    changes: dict[str, object], what: str
) -> None:
    with pytest.raises(InputFileError, match=rf"second\.csv is of {what} than points\.csv"):
        merge_tables([table(), other(**changes)])


def test_another_heliostats_target_is_named_in_words() -> None:
    aimed = Heliostat(Target(176.0, 78.0, 120.0), MirrorOffset(PivotRefl_Z=0.35))
    with pytest.raises(InputFileError) as refused:
        merge_tables([table(), other(heliostat=aimed)])
    assert str(refused.value) == (
        "second.csv is of another heliostat's target than points.csv (target 176.00000:78.00000:"
        "120.00000, mirror 0.000000000:0.000000000:0.002916667, not none); only files of one unit "
        "are merged"
    )
    # As points files round them, targets are the same.
    nearly = Heliostat(Target(176.000001, 78.0, 120.0), MirrorOffset(PivotRefl_Z=0.35))
    assert len(merge_tables([table(heliostat=aimed), other(heliostat=nearly)])) == 5


def test_a_file_given_twice_and_no_file_at_all() -> None:
    with pytest.raises(InputFileError, match=r"points\.csv was given twice"):
        merge_tables([table(), table()])
    with pytest.raises(InputFileError, match="no points file"):
        merge_tables([])


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({}, "solartrak"),
        ({"sun_model": "solartrak+"}, "solartrak"),
        ({"sun_model": "noaa"}, "airless"),
        ({"sun_model": "airless"}, "airless"),
        ({"sun_model": "apparent"}, "apparent"),
        ({"sun_model": "precise", "refraction": "bennett"}, "apparent"),
        # An emulated world whose Sun is the controller's own: only the air is between them,
        ({"true_sun": "solartrak"}, "airless"),
        # and where there is none, nothing is.
        ({"true_sun": "solartrak", "weather": Weather(pressure_hpa=0.0)}, "apparent"),
        ({"weather": Weather(pressure_hpa=0.0)}, "solartrak"),
    ],
)
def test_what_the_ideal_angles_of_a_session_leave_out(changes: dict, kind: str) -> None:
    assert ideal_kind(msgspec.structs.replace(HEADER, **changes)) == kind


def test_an_import_is_judged_with_the_widths_of_its_day():
    assert imported_header(table(), 0.0).rule.unmodelled == DEFAULT_UNMODELLED
