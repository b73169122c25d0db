"""`solarcal day`, `year` and `energy` as a technician meets them."""

import json
from typing import Any

import pytest

from solarcal.cli import run_command
from solarcal.sun.circular_orbit import CircularDay, days_after_march_equinox
from solarcal.sun.energy import TrackingCollector, day_percent
from solarcal.timescale import parse_utc

TIJERAS = ("--lat", "35.05", "--lon", "-106.48", "--elevation", "1830")
JUNE = ("--at", "2026-06-21T18:00:00Z")
SWING = ("--geometry", "polar", "--limits1", "-60", "60")


def document(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    assert run_command([*argv, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def text(capsys: pytest.CaptureFixture[str], *argv: str) -> str:
    assert run_command(argv) == 0
    return capsys.readouterr().out


def test_energy_without_options_answers_suncalcs_own_question(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = document(capsys, "energy")
    assert (found["latitude_deg"], found["day"], found["solar_time_h"]) == (42.0, 91.0, 12.0)
    # The numbers of 10-physics.md section 4.
    for value, reference in (
        (found["sun"]["north"], -0.318138),
        (found["sun"]["up"], 0.948044),
        (found["sun"]["elevation_deg"], 71.449641),
        (found["sun"]["high_sun_deg"], 71.449641),
        (found["sun"]["sunrise_bearing_deg"], 32.376807),
        (found["daylight_h"], 15.065298),
        (found["dawn_h"], 4.467351),
        (found["dusk_h"], 19.532649),
        (found["percent"]["moment"], 94.804440),
        (found["percent"]["day"], 36.694840),
        (found["percent"]["seasons"]["0"], 23.647252),
        (found["percent"]["seasons"]["91"], 36.694840),
        (found["percent"]["seasons"]["273"], 10.066100),
    ):
        assert value == pytest.approx(reference, abs=5.1e-7)
    assert found["pointing"] is None
    said = text(capsys, "energy")
    for number in ("94.804440", "36.694840", "15.065298", "4.467351", "32.376807", "10.066100"):
        assert number in said
    assert "N -0.318138  E +0.000000  U +0.948044" in said


@pytest.mark.parametrize("longitude", ["-170", "-106.48", "0", "174"])
def test_a_date_alone_is_the_sites_own_day(
    capsys: pytest.CaptureFixture[str], longitude: str
) -> None:
    found = document(capsys, "day", "--lat", "35", "--lon", longitude, "--at", "2026-06-21")
    # The site's own noon: a sixth of an hour a degree before or after that of Greenwich.
    noon_s = parse_utc("2026-06-21T12:00Z") - 240.0 * float(longitude)
    assert abs(parse_utc(found["transit_utc"]) - noon_s) < 1000.0


def test_every_line_fits_80_columns(capsys: pytest.CaptureFixture[str]) -> None:
    for argv in (
        ("energy", "--pointing-error", "0.3", "--acceptance", "0.5"),
        ("day", *TIJERAS, *JUNE, *SWING, "--table"),
        ("year", *TIJERAS, "--year", "2026", *SWING, "--normal", "-0.5", "0", "0.8"),
    ):
        assert max(map(len, text(capsys, *argv).splitlines())) <= 80


def test_energy_of_tracking_tilted_and_turning_collectors(
    capsys: pytest.CaptureFixture[str],
) -> None:
    level = document(capsys, "energy", "--day", "273")
    tilted = document(capsys, "energy", "--day", "273", "--tilt", "65")
    turning = document(capsys, "energy", "--day", "273", "--axis", "0", "0", "1")
    tracking = document(capsys, "energy", "--day", "273", "--tracking")
    caught = [each["percent"]["day_integrated"] for each in (level, tilted, turning, tracking)]
    assert caught == sorted(caught)
    assert tilted["collector"]["normal_neu"][0] == pytest.approx(-0.9063, abs=1e-4)
    assert tracking["percent"]["day_integrated"] == pytest.approx(
        100.0 * tracking["daylight_h"] / 24.0
    )
    south = document(capsys, "energy", "--lat", "-30", "--tilt", "30")
    assert south["collector"]["normal_neu"][0] > 0.0


def test_energy_lost_by_a_pointing_error(capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--tracking", "--pointing-error", "0.3", "--acceptance", "0.4")
    found = document(capsys, "energy", *options)["pointing"]
    assert found["lost_percent"] == pytest.approx(0.0013708, abs=1e-6)
    assert found["disc_percent"] == pytest.approx(66.24, abs=0.01)
    assert "of the Sun's disc" in text(capsys, "energy", *options)


def test_days_without_sunrise_are_said_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert "shines all day" in text(capsys, "energy", "--lat", "80")
    assert "hidden all day" in text(capsys, "energy", "--lat", "-80")
    assert "never: the Sun stays in the North" in text(capsys, "energy", "--lat", "5")
    assert "below the horizon" in text(capsys, "energy", "--day", "273")
    assert document(capsys, "energy", "--lat", "80")["sun"]["never_sets"] == "day"


def test_energy_of_a_date(capsys: pytest.CaptureFixture[str]) -> None:
    found = document(capsys, "energy", "--date", "2026-06-21")
    assert found["day"] == pytest.approx(92.885, abs=0.01)


def test_day_tells_solar_time(capsys: pytest.CaptureFixture[str]) -> None:
    found = document(capsys, "day", *TIJERAS, *JUNE)
    assert found["solar_time"] == "10:52:12"
    assert found["equation_of_time_min"] == pytest.approx(-1.872, abs=0.01)
    assert "within_limits" not in found
    assert "table" not in found


def test_120_deg_of_swing_is_about_8_hours_in_summer(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = document(capsys, "day", *TIJERAS, *JUNE, *SWING)["within_limits"]
    assert found["hours"] == pytest.approx(8.0, abs=0.01)
    ((first, last),) = found["spans_utc"]
    assert parse_utc(last) - parse_utc(first) == pytest.approx(3600.0 * found["hours"], abs=0.01)
    assert "polar: 8.001 h within limits" in text(capsys, "day", *TIJERAS, *JUNE, *SWING)


def test_day_says_where_one_range_cannot_hold_the_path(
    capsys: pytest.CaptureFixture[str],
) -> None:
    kourou = ("--lat", "5.2", "--lon", "-52.7", "--at", "2026-06-10T15:00Z")
    said = text(capsys, "day", *kourou, "--limits2", "2", "88")
    assert "one range cannot cover this day" in said


def test_day_table_runs_from_sunrise_to_sunset(capsys: pytest.CaptureFixture[str]) -> None:
    found = document(capsys, "day", *TIJERAS, *JUNE, *SWING, "--table", "--every", "60")
    rows = found["table"]
    assert rows[0]["utc"] == "2026-06-21T12:00:00.000Z"
    assert rows[-1]["utc"] == "2026-06-22T02:00:00.000Z"
    assert len(rows) == 15
    within = [row["utc"][11:13] for row in rows if row["within_limits"]]
    assert within == ["16", "17", "18", "19", "20", "21", "22", "23"]
    sun = document(capsys, "sun", *TIJERAS, "--at", rows[6]["utc"], "--geometry", "polar")
    for name in ("azimuth_deg", "elevation_deg", "ax1_deg", "ax2_deg"):
        assert rows[6][name] == pytest.approx(sun[name], abs=1e-4)
    assert rows[6]["solar_time"] == sun["solar_time"]
    assert "beyond" in text(capsys, "day", *TIJERAS, *JUNE, *SWING, "--table")


def test_day_chart_draws_elevation_and_azimuth(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("LINES", "24")
    said = text(capsys, "day", *TIJERAS, *JUNE, *SWING, "--chart").splitlines()
    chart = said[-22:]
    assert chart[0].startswith("elevation, deg")
    assert ": beyond limits" in chart[0]
    assert chart[11] == "azimuth"
    assert max(map(len, chart)) <= 80
    # Highest in the middle of the upper chart, East on the left of the lower one.
    assert "●" in chart[2][30:50]
    assert "●" not in chart[2][:25]
    east = next(line for line in chart[12:] if line.startswith(" E┤"))
    assert "●" in east[:40]
    assert "●" not in east[40:]


def test_day_in_the_polar_night_has_neither_table_nor_dots(
    capsys: pytest.CaptureFixture[str],
) -> None:
    night = ("--lat", "80", "--lon", "15", "--at", "2026-12-21T11:00Z")
    said = text(capsys, "day", *night, "--table", "--chart", "--limits2", "2", "88")
    assert "The Sun is not up that day" in said
    assert "The Sun stays below the horizon all day." in said
    assert "never within the limits" in said
    assert document(capsys, "day", *night, "--table")["table"] == []


def test_year_goes_month_by_month(capsys: pytest.CaptureFixture[str]) -> None:
    found = document(capsys, "year", *TIJERAS, "--year", "2026", *SWING, "--tracking")
    assert [month["date"] for month in found["months"]] == [
        f"2026-{month:02d}-21" for month in range(1, 13)
    ]
    june = found["months"][5]
    day = document(capsys, "day", *TIJERAS, *JUNE)
    for name in ("sunrise_utc", "transit_utc", "sunset_utc", "daylight_h"):
        assert june[name] == day[name]
    assert june["within_limits_h"] == pytest.approx(8.0, abs=0.01)
    noon_s = parse_utc("2026-06-21T12:00:00Z") + 240.0 * 106.48
    circular = CircularDay(35.05, days_after_march_equinox(noon_s))
    assert june["energy_percent"] == day_percent(TrackingCollector(), circular)
    assert found["whole_year"]["within_limits_h"] == pytest.approx(8.0 * 365.0, rel=0.01)
    assert found["whole_year"]["daylight_h"] == pytest.approx(4449.0, rel=0.01)
    assert found["whole_year"]["energy_percent"] == pytest.approx(50.0, abs=0.01)


def test_year_without_limits_and_beyond_the_polar_circle(
    capsys: pytest.CaptureFixture[str],
) -> None:
    argv = ("year", "--lat", "80", "--lon", "15", "--year", "2026")
    found = document(capsys, *argv)
    assert [month["polar"] for month in found["months"]].count("day") == 5
    assert found["months"][11]["polar"] == "night"
    assert found["months"][11]["sunrise_utc"] is None
    assert found["whole_year"]["within_limits_h"] is None
    assert "night" in text(capsys, *argv)


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (("energy", "--lat", "95"), "--lat: 95 is not between -90 and 90"),
        (("energy", "--day", "400"), "--day: 400 is not between 0 and 366"),
        (("energy", "--normal", "0", "0", "0"), "normal is zero"),
        (("energy", "--tilt", "200"), "--tilt: 200 is not between 0 and 180"),
        (("energy", "--facing", "90"), "--facing: says where a --tilt leans to"),
        (("energy", "--acceptance", "0.5"), "give --pointing-error too"),
        (("energy", "--date", "the 1st"), "is not a date and time"),
        (("year", *TIJERAS, "--year", "1800"), "--year: 1800 is not"),
        (("day", "--lat", "95", "--lon", "0"), "--lat: 95 is not between -90 and 90"),
        (("day", *TIJERAS, "--limits1", "60", "-60"), "leave the axis no range"),
        (("day", *TIJERAS, "--every", "0"), "--every: 0 is not"),
        (("day", *TIJERAS, "--lowest", "90"), "--lowest: 90 is not"),
        (("day", *TIJERAS, "--geometry", "boat"), "--geometry: 'boat' is none of azel"),
    ],
)
def test_bad_input_is_answered_in_one_clear_line(
    capsys: pytest.CaptureFixture[str], argv: tuple[str, ...], says: str
) -> None:
    assert run_command(argv) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert says in captured.err
    assert captured.err.count("\n") == 1
