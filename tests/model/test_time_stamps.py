"""Stamps and ideal angles say the same thing twice: the simplest wrong one is named with its size.

From every door: a points file, its import, a merged pair, a report, a replay.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from solarcal.cli import run_command
from solarcal.model.analysis import findings_of
from solarcal.model.evidence.angle_conventions import _MEANINGS, other_conventions
from solarcal.model.evidence.direct import Evidence
from solarcal.model.evidence.stamp_search import day_and_month_exchanged_s
from solarcal.model.evidence.sun_path import _thinned, stamp_evidence
from solarcal.model.finding import Finding
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.session.interchange import imported_header, session_from_table, write_table
from solarcal.session.points import PointTable
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.station.analysing import stamp_findings
from solarcal.station.fitting import sky_context, solve_table
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc

SITE = Site(35.05, -106.48, 1830.0)
TRACKER = Mechanism(P1=0.3, P2=-0.36, P3=0.1, P4=0.25, P5=0.0, P6=0.0)


def day(ideal: str = "apparent", geometry: str = "azel", n: int = 10) -> PointTable:
    """Honest points of a June day."""
    return sun_at(parse_utc("2026-06-21T16:20:55Z") + 2700.0 * np.arange(n), ideal, geometry)


def sun_at(utc_s: np.ndarray, ideal: str = "apparent", geometry: str = "azel") -> PointTable:
    """Angles of the Sun at these instants, errors of a mechanism."""
    n = len(utc_s)
    if ideal == "solartrak":
        sun = sun_position("solartrak", utc_s, SITE)
    elif ideal == "airless":
        sun = sun_position("precise", utc_s, SITE)
    else:
        air = Weather(pressure_hpa=standard_pressure_hpa(SITE.elevation_m))
        sun = sun_position("precise", utc_s, SITE, refraction="hughes", weather=air)
    mount = MountGeometry(geometry, SITE.latitude_deg)
    ax1, ax2 = mount.axes_from_horizontal(sun.azimuth_deg, sun.zenith_deg)
    err1, err2 = TRACKER.errors_deg(mount, ax1, ax2)
    noise = np.random.default_rng(5).normal(0.0, 0.01, (2, n))
    return PointTable(
        geometry=geometry, latitude_deg=SITE.latitude_deg, longitude_deg=SITE.longitude_deg,
        elevation_m=SITE.elevation_m, unit="T", ax1_centre_deg=0.0, ideal=ideal, utc_s=utc_s,
        ax1_deg=ax1, ax2_deg=ax2, err1_deg=err1 + noise[0], err2_deg=err2 + noise[1],
        sigma_deg=None, status=("accepted",) * n, approach=((0, 0),) * n, note=("",) * n,
        labels=tuple(range(1, n + 1)), sources=("day.csv",) * n,
    )  # fmt: skip


def late(seconds: float | np.ndarray) -> PointTable:
    return replace(day(), utc_s=day().utc_s + seconds)


@pytest.mark.parametrize("ideal", ["apparent", "airless", "solartrak"])
@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
def test_honest_points_have_no_finding(ideal: str, geometry: str) -> None:
    assert stamp_findings(day(ideal, geometry)) == ()


@pytest.mark.parametrize(
    ("points", "kind", "number", "words"),
    [
        (late(3600.0), "time_stamps", 3600.0, "3600 s late (1 h: daylight-saving time"),
        (late(-7200.0), "time_stamps", -7200.0, "7200 s early (2 h"),
        (late(19800.0), "time_stamps", 19800.0, "19800 s late (5.5 h"),
        (late(40.0), "time_stamps", 40.0, "40 s late"),
        (late(86400.0 * 1.0), "time_stamps", 86400.0, "(a day: the date)"),
        (
            replace(day(), longitude_deg=106.48),
            "site",
            212.96,
            "wrong sign (+106.4800 for -106.4800",
        ),
        (
            replace(day(), latitude_deg=-35.05),
            "site",
            -70.1,
            "wrong sign (-35.0500 for +35.0500 deg)",
        ),
        (replace(day(), latitude_deg=45.05), "site", 10.0, "latitude is +10.000 deg off"),
        (replace(day(), latitude_deg=42.0, longitude_deg=-80.0), "site", 27.38, "another site"),
        (replace(day(), latitude_deg=-106.48 + 30, longitude_deg=35.05), "site", None, "site"),
        (replace(day(), geometry="tiltroll-ew"), "geometry", None, "those of a azel mount"),
        (replace(day("airless"), ideal="apparent"), "ideal_kind", None, "--ideal airless"),
        (
            replace(
                day(),
                ax1_deg=day().ax1_deg + day().err1_deg,
                ax2_deg=day().ax2_deg + day().err2_deg,
            ),
            "ideal_kind",
            None,
            "the angles are the axes' read-outs, not ideal angles",
        ),
        (replace(day("solartrak"), ideal="apparent"), "ideal_kind", None, "--ideal solartrak"),
        (replace(day("apparent"), ideal="airless"), "ideal_kind", None, "--ideal apparent"),
    ],
)
def test_the_simplest_explanation_is_named_with_its_size(
    points: PointTable, kind: str, number: float | None, words: str
) -> None:
    (found,) = stamp_findings(points)
    assert found.kind == kind
    assert found.direct
    assert words in found.sentence
    if number is not None:
        assert found.number == pytest.approx(number, abs=0.01 * abs(number))
    assert found.labels == points.labels


def from_north(t: PointTable) -> dict[str, np.ndarray]:
    return {"ax1_deg": 180.0 - t.ax1_deg}


def elevation(t: PointTable) -> dict[str, np.ndarray]:
    return {"ax2_deg": 90.0 - t.ax2_deg}


CONVENTIONS = {
    "azel": {
        "azimuth from North, positive East": from_north,
        "azimuth from South, positive West": lambda t: {"ax1_deg": -t.ax1_deg},
        "of axis 2 are 90 deg - AX2 (elevation)": elevation,
        "positive East) and of axis 2 are 90 deg - AX2 (elevation)": (
            lambda t: from_north(t) | elevation(t)
        ),
    },
    "tiltroll-ew": {
        "of axis 1 are -AX1 (tilt positive North):": lambda t: {"ax1_deg": -t.ax1_deg},
        "roll from due West": lambda t: {"ax2_deg": 180.0 - t.ax2_deg},
    },
    "tiltroll-ns": {"of axis 1 are -AX1 (tilt positive West):": lambda t: {"ax1_deg": -t.ax1_deg}},
    "polar": {
        "hour angle positive in the afternoon": lambda t: {"ax1_deg": -t.ax1_deg},
        "(declination)": elevation,
    },
}


@pytest.mark.parametrize(
    ("geometry", "words"), [(name, words) for name in CONVENTIONS for words in CONVENTIONS[name]]
)
def test_angles_counted_otherwise_are_named_and_no_cause_is_looked_for_beside(geometry, words):
    table = day(geometry=geometry)
    table = replace(table, **CONVENTIONS[geometry][words](table))
    (stamps, residuals) = analyse_table(table)
    assert stamps.kind == "geometry"
    assert words in stamps.sentence
    assert residuals.certainty == "not_determinable"


def test_every_convention_that_has_a_name_is_looked_for():
    for (geometry, *_), name in _MEANINGS.items():
        assert any(f"({name})" in way.words(geometry) for way in other_conventions()), name
    # Zeros are where the axes of a mount and the directions of the compass are.
    assert {zero % 90 for way in other_conventions() for _, zero in way.axes} == {0}
    assert len(set(other_conventions())) == 8 * 4 - 1


def analyse_table(table: PointTable) -> tuple[Finding, ...]:
    return findings_of(solve_table(table), sky_context(table), Evidence(table))


@pytest.mark.parametrize("bad", [4, 6])
def test_of_stamps_that_nothing_explains_a_few_are_named_or_the_whole_file(bad: int) -> None:
    table = day()
    off_deg = (
        20.0 * np.random.default_rng(3).standard_normal(len(table)) * (np.arange(len(table)) < bad)
    )
    (found,) = stamp_findings(replace(table, ax1_deg=table.ax1_deg + off_deg))
    assert "no single time shift" in found.sentence
    assert found.labels == (table.labels if bad > 5 else table.labels[:bad])


def test_day_and_month_exchanged_are_named_and_the_fit_is_still_tested() -> None:
    shift_s = parse_utc("2026-06-04T16:00:00Z") - parse_utc("2026-06-21T16:00:00Z")
    utc_s = day().utc_s + shift_s
    exchanged_s = utc_s + parse_utc("2026-04-06T00:00:00Z") - parse_utc("2026-06-04T00:00:00Z")
    assert day_and_month_exchanged_s(exchanged_s) == pytest.approx(utc_s)
    table = replace(sun_at(utc_s), utc_s=exchanged_s)
    first, *others = analyse_table(table)
    assert (first.kind, first.unit) == ("time_stamps", "s")
    assert first.sentence.startswith("day and month of the time stamps are exchanged:")
    assert "sag" in {finding.kind for finding in others}


def test_a_shift_that_a_longitude_would_explain_as_well_names_both() -> None:
    (found,) = stamp_findings(late(40.0))
    assert "or the longitude is +0.167 deg off (-106.4800, the angles are of -106.647" in (
        found.sentence
    )
    (found,) = stamp_findings(replace(day(), longitude_deg=-100.0))
    assert "1555 s late, or the longitude is +6.480 deg off (-100.0000, the angles are of " in (
        found.sentence
    )


def test_one_row_among_many_is_named_alone() -> None:
    times = day().utc_s.copy()
    times[3] += 3600.0
    (found,) = stamp_findings(replace(day(), utc_s=times))
    assert found.labels == (4,)
    assert "3600 s late" in found.sentence


@pytest.mark.parametrize("off_s", [-25200.0, 43200.0])
def test_a_stamp_at_which_the_sun_is_too_low_is_not_passed_over(
    off_s: float, tmp_path, capsys
) -> None:
    """Its point is left out of the fit because of the stamp that is wrong."""
    table = day("solartrak")
    times = table.utc_s.copy()
    times[3] += off_s
    write_table(replace(table, utc_s=times), tmp_path / "night.csv")
    _, document = documents(capsys, "fit", str(tmp_path / "night.csv"))
    assert document["points"]["used"] == 9
    assert document["verdict"]["state"] == "does_not_fit"
    assert f"{abs(off_s):.0f} s" in document["verdict"]["reasons"][0]


def test_points_that_are_low_by_stamp_and_angles_are_not_compared() -> None:
    """No fit uses them, and there the air decides where the Sun is seen."""
    dawn = np.append(day().utc_s, parse_utc("2026-06-21T12:10:00Z"))
    table = day(n=11)
    low = sun_position("precise", dawn[-1:], SITE)
    ax1, ax2 = MountGeometry("azel", SITE.latitude_deg).axes_from_horizontal(
        low.azimuth_deg, low.zenith_deg - 0.3
    )
    assert 0.0 < low.elevation_deg[0] < 4.5
    table = replace(
        table,
        utc_s=dawn,
        ax1_deg=np.append(day().ax1_deg, ax1),
        ax2_deg=np.append(day().ax2_deg, ax2),
    )
    assert stamp_findings(table) == ()


def test_a_clock_that_was_set_within_the_file_is_named_with_the_points_after_it() -> None:
    (found,) = stamp_findings(late(np.where(np.arange(10) < 3, 0.0, 3600.0)))
    assert found.labels == (4, 5, 6, 7, 8, 9, 10)
    assert "one explanation: the time stamps are 3600 s late (1 h" in found.sentence


def test_stamps_that_nothing_single_explains_are_still_a_finding() -> None:
    scrambled = np.random.default_rng(3).permutation(day().utc_s)
    (found,) = stamp_findings(replace(day(), utc_s=scrambled))
    assert found.kind == "time_stamps"
    assert "no single time shift" in found.sentence


def test_without_stamps_or_a_site_nothing_is_compared() -> None:
    assert stamp_findings(replace(day(), utc_s=np.full(10, np.nan))) == ()
    assert stamp_findings(replace(day(), longitude_deg=None)) == ()
    struck = replace(late(3600.0), status=("rejected",) * 10)
    assert stamp_findings(struck) == ()


@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
@pytest.mark.parametrize(("light", "latitude", "told"), [
    ("sun", 35.05, ""), ("sun", -35.05, "reach a declination of"), ("", -35.05, ""),
    # The Moon, and a site that is not well known, go further than the Sun.
    ("sun", 32.0, ""),
])  # fmt: skip
def test_without_stamps_no_angles_are_the_suns_at_any_declination(
    geometry: str, light: str, latitude: float, told: str
) -> None:
    nothing = np.full(10, np.nan)
    if geometry != "azel" and latitude < 0:
        # About the pole of the other hemisphere a direction of its axes is another one.
        latitude = 75.0
    points = replace(day(geometry=geometry), utc_s=nothing, light=light, latitude_deg=latitude)
    if geometry == "polar" and told:
        # The axis is the pole's wherever it stands: axis 2 is the polar distance.
        told = ""
    found = stamp_findings(points)
    assert (told in found[0].sentence and found[0].kind == "site") if told else found == ()


def test_angles_noted_to_a_tenth_are_not_held_against_stamps_to_the_second() -> None:
    exact = day()
    coarse = replace(exact, ax1_deg=np.round(exact.ax1_deg, 1), ax2_deg=np.round(exact.ax2_deg, 1))
    limit_deg = 0.04
    assert stamp_evidence(coarse, sky_context(coarse), limit_deg) == ()
    (finding,) = stamp_findings(replace(coarse, utc_s=coarse.utc_s + 120.0))
    assert finding.kind == "time_stamps"
    assert finding.number == pytest.approx(120.0, abs=15.0)


def test_another_kind_is_named_where_only_the_lowest_points_show_it() -> None:
    """Refraction is beyond the limit at one point in the morning only."""
    points = replace(day("airless"), ideal="apparent")
    context = sky_context(points)
    worst = next(f.number for f in stamp_evidence(points, context, 0.02))
    (finding,) = stamp_evidence(points, context, 1.9 * worst)
    assert finding.kind == "ideal_kind"
    assert "give ideal=airless" in finding.sentence


def test_what_a_few_points_are_off_has_one_explanation_of_many() -> None:
    slip = day()
    slip.utc_s[3] += 90.0
    (finding,) = stamp_findings(slip)
    assert finding.labels == (4,)
    assert "at 1 of 10 points (point 4); one explanation: the time stamp" in finding.sentence


def test_half_the_tolerance_is_allowed() -> None:
    table = late(8.0)  # 0.03 deg of Sun
    context = sky_context(table)
    assert stamp_evidence(table, context, 0.1) == ()
    assert stamp_evidence(table, context, 0.02)[0].kind == "time_stamps"


def test_a_part_of_a_second_is_early_or_late_too() -> None:
    for seconds, sense in ((-0.7, "1 s early"), (0.7, "1 s late")):
        table = late(seconds)
        (found,) = stamp_evidence(table, sky_context(table), 0.004)
        assert f"the time stamps are {sense}" in found.sentence


def test_of_stamps_that_are_not_equally_late_the_mean_is_reported() -> None:
    """That of least squares: the Sun covers as many degrees in every second of the day."""
    seconds = np.full(10, 40.0)
    seconds[2] = 60.0
    table = late(seconds)
    (found,) = stamp_evidence(table, sky_context(table), 0.3)
    assert found.number == pytest.approx(42.0, abs=0.1)


def test_the_wrong_site_of_a_unit_is_no_matter_of_clocks() -> None:
    table = replace(day(), longitude_deg=106.48)
    (found,) = stamp_evidence(table, sky_context(table), 0.1, kind_claimed=False)
    assert found.sentence.endswith("; correct the site")
    table = late(3600.0)
    (found,) = stamp_evidence(table, sky_context(table), 0.1, kind_claimed=False)
    assert "; compare the clocks of unit and laptop" in found.sentence


@pytest.mark.parametrize("date", ["1960-01-02", "1960-01-04", "2100-02-25", "2100-02-27"])
def test_at_either_end_of_the_sun_models_wrong_stamps_are_no_error(date: str) -> None:
    """The search for what is wrong with them looks at other days too."""
    table = replace(day(), utc_s=parse_utc(f"{date}T06:00:00Z") + 2700.0 * np.arange(10))
    assert stamp_evidence(table, sky_context(table), 0.1)


# -- from every door -------------------------------------------------------------------------------


def documents(capsys: pytest.CaptureFixture[str], *command: str) -> tuple[int, dict]:
    code = run_command([*command, "--json"])
    return code, json.loads(capsys.readouterr().out)


@pytest.fixture
def doors(tmp_path: Path) -> dict[str, list[str]]:
    """The same points, stamps an hour late: as a CSV, imported, and as two merged halves."""
    table = late(3600.0)
    write_table(table, tmp_path / "late.csv")
    session_from_table(table, tmp_path / "late.jsonl", utc_s=parse_utc("2026-07-01"))
    write_table(table.rows(range(5)), tmp_path / "one.csv")
    write_table(table.rows(range(5, 10)), tmp_path / "two.csv")
    write_table(day(), tmp_path / "good.csv")
    names = {"csv": ["late.csv"], "import": ["late.jsonl"], "merged": ["one.csv", "two.csv"]}
    found = {door: [str(tmp_path / name) for name in files] for door, files in names.items()}
    return {**found, "good": [str(tmp_path / "good.csv")]}


@pytest.mark.parametrize("door", ["csv", "import", "merged"])
def test_from_every_door_it_is_found_shown_and_not_done(doors, door, capsys) -> None:
    code, document = documents(capsys, "fit", *doors[door], "--require", "done")
    assert code == 1
    assert document["coefficients"]["P2"]["value"] == pytest.approx(-0.36, abs=0.05)
    assert document["verdict"]["state"] == "does_not_fit"
    first = document["findings"][0]
    assert (first["kind"], first["certainty"], first["unit"]) == ("time_stamps", "found", "s")
    assert first["number"] == 3600.0
    assert len(first["points"]) == 10
    assert document["verdict"]["reasons"][0] == first["sentence"]


def test_the_report_and_the_replay_of_an_import_say_it_too(doors, capsys, tmp_path) -> None:
    (session,) = doors["import"]
    _, document = documents(capsys, "replay", session)
    assert document["findings"][0]["number"] == 3600.0
    assert document["verdict"]["state"] == "does_not_fit"
    assert run_command(["replay", session, "--headless"]) == 0
    assert "3600 s late" in " ".join(capsys.readouterr().out.split())
    run_command(["report", session, "-o", str(tmp_path / "out.txt")])
    assert "3600 s late" in " ".join((tmp_path / "out.txt").read_text().split())


def test_airless_points_high_up_are_fitted_the_same_after_an_import() -> None:
    """The air of an import is that of its elevation, as the file's is."""
    table = day("airless")
    header = imported_header(table, parse_utc("2026-07-01"))
    assert solve_table(table, header=header).values.tolist() == solve_table(table).values.tolist()


def test_importing_says_it_at_once(doors, capsys, tmp_path) -> None:
    _, document = documents(capsys, "import", *doors["csv"], str(tmp_path / "again.jsonl"))
    (warning,) = document["warnings"]
    assert "3600 s late" in warning


def test_with_the_stamps_left_empty_the_same_points_are_a_calibration(doors, capsys) -> None:
    _, document = documents(capsys, "fit", *doors["good"])
    assert [f for f in document["findings"] if f["kind"] == "time_stamps"] == []
    assert document["verdict"]["state"] != "does_not_fit"


def test_ideal_by_option_is_the_cure_that_was_named(tmp_path, capsys) -> None:
    table = replace(day("solartrak"), ideal="apparent")
    path = tmp_path / "controller.csv"
    write_table(table, path)
    path.write_text(path.read_text().replace("# ideal=apparent\n", ""))
    _, taken_as_apparent = documents(capsys, "fit", str(path))
    assert taken_as_apparent["findings"][0]["kind"] == "ideal_kind"
    assert taken_as_apparent["verdict"]["state"] == "does_not_fit"
    _, told = documents(capsys, "fit", str(path), "--ideal", "solartrak")
    assert [f for f in told["findings"] if f["kind"] == "ideal_kind"] == []


def of_another_century(folder: Path, date: str, ideal: str = "apparent") -> Path:
    """The honest day, dated so that the Sun models know nothing of it."""
    table = day(ideal)
    path = folder / "old.csv"
    write_table(replace(table, utc_s=table.utc_s - table.utc_s[0] + parse_utc(date)), path)
    return path


@pytest.mark.parametrize(
    ("date", "year"), [("1900-01-01T00:00:00Z", "1961"), ("2200-12-31T10:00:00Z", "2099")]
)
def test_dates_beyond_the_sun_models_are_fitted_and_not_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], date: str, year: str
) -> None:
    path = of_another_century(tmp_path, date)
    assert run_command(["fit", "--json", str(path)]) == 0
    fitted = json.loads(capsys.readouterr().out)
    assert fitted["coefficients"]["P1"]["value"] == pytest.approx(0.3, abs=0.05)
    assert fitted["verdict"]["state"] == "done"
    (said,) = [f for f in fitted["findings"] if f["kind"] == "time_stamps"]
    assert said["certainty"] == "not_determinable"
    assert said["sentence"].startswith("the Sun models hold for 1960-01-01 to 2100-02-28: ")
    assert said["sentence"].endswith(f"and the forecast is for {year}")
    assert run_command(["forecast", "--json", str(path)]) == 0
    assert json.loads(capsys.readouterr().out)["forecast"]["year_p95_deg"] < 0.1


def test_a_plan_for_such_points_asks_for_its_instant(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(of_another_century(tmp_path, "1900-01-01T00:00:00Z"))
    assert run_command(["plan", path]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "2100-02-28); give --at, the instant to plan from" in line
    assert run_command(["plan", path, "--at", "2026-06-21T15:00:00Z"]) == 0
    assert "Planned from 2026-06-21 15:00 UTC" in capsys.readouterr().out
    assert run_command(["plan", path, "--at", "1900-01-01T00:00:00Z"]) == 2
    assert "give an instant within these years" in capsys.readouterr().err


def test_angles_that_need_the_sun_of_such_a_date_are_refused_with_the_way_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = of_another_century(tmp_path, "2200-12-31T10:00:00Z", "solartrak")
    assert run_command(["fit", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is dated outside 1960-01-01 to 2100-02-28" in line
    assert line.endswith("correct utc or give ideal=airless")


@pytest.mark.parametrize(("rows", "kept"), [(5, 5), (24, 24), (100, 24)])
def test_of_many_rows_some_are_searched_from_the_first_to_the_last(rows: int, kept: int) -> None:
    places = _thinned(np.arange(10, 10 + rows))
    assert (places[0], places[-1]) == (10, 9 + rows)
    assert len(set(places)) == kept
