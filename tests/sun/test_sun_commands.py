"""`solarcal sun` and `solarcal day`: their JSON is a contract, their refusals one line."""

import json
import subprocess
import sys

import pytest

from solarcal.cli import run_command
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc

TIJERAS = ["--lat", "35.05", "--lon", "-106.48", "--elevation", "1830"]
JUNE = ["--at", "2026-06-21T08:30:00-07:00"]


def document(capsys: pytest.CaptureFixture[str], *argv: str):
    assert run_command(argv) == 0
    return json.loads(capsys.readouterr().out)


def test_sun_prints_exactly_the_keys_of_the_contract(capsys: pytest.CaptureFixture[str]) -> None:
    found = document(capsys, "sun", *TIJERAS, *JUNE, "--json")
    assert list(found) == [
        "utc",
        "model",
        "azimuth_deg",
        "zenith_deg",
        "elevation_deg",
        "declination_deg",
        "equation_of_time_min",
        "solar_time",
        "geometry",
        "ax1_deg",
        "ax2_deg",
    ]
    sun = sun_position("precise", parse_utc("2026-06-21T15:30:00Z"), Site(35.05, -106.48, 1830.0))
    assert found["utc"] == "2026-06-21T15:30:00.000Z"
    assert (found["model"], found["geometry"]) == ("precise", "azel")
    assert found["azimuth_deg"] == sun.azimuth_deg
    assert found["zenith_deg"] == sun.zenith_deg
    assert found["ax2_deg"] == pytest.approx(sun.zenith_deg, abs=1e-9)
    assert found["ax1_deg"] == pytest.approx(180.0 - sun.azimuth_deg, abs=1e-9)
    assert found["solar_time"] == "08:22:14"


@pytest.mark.parametrize(
    ("options", "ax1_deg"), [([], 175.048), (["--ax1-centre", "200"], 175.048)]
)
def test_south_of_the_equator_an_azel_mount_counts_around_north(
    capsys: pytest.CaptureFixture[str], options: list[str], ax1_deg: float
) -> None:
    cape = ["--lat", "-33.9", "--lon", "18.4"]
    morning = document(capsys, "sun", *cape, "--at", "2026-06-21T10:30Z", *options, "--json")
    assert morning["ax1_deg"] == pytest.approx(ax1_deg, abs=0.001)
    afternoon = document(capsys, "sun", *cape, "--at", "2026-06-21T12:30Z", *options, "--json")
    assert afternoon["ax1_deg"] > 180.0


@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
@pytest.mark.parametrize("model", ["solartrak", "solartrak+", "noaa", "precise"])
def test_every_model_answers_for_every_mount(
    capsys: pytest.CaptureFixture[str], model: str, geometry: str
) -> None:
    argv = ["sun", *TIJERAS, *JUNE, "--model", model, "--geometry", geometry]
    found = document(capsys, *argv, "--json")
    assert (found["model"], found["geometry"]) == (model, geometry)
    assert run_command(argv) == 0
    assert f"AX1 ({geometry})" in capsys.readouterr().out


def test_refraction_uses_the_station_pressure(capsys: pytest.CaptureFixture[str]) -> None:
    seen = [
        document(capsys, "sun", *TIJERAS, *JUNE, "--json", "--refraction", "hughes", *air)
        for air in ([], ["--pressure", "812.5"], ["--pressure", "1013", "--temperature", "-20"])
    ]
    zeniths = [found["zenith_deg"] for found in seen]
    assert zeniths[0] == pytest.approx(zeniths[1], abs=2e-5)
    assert zeniths[0] - zeniths[2] > 0.005
    assert seen[2]["ax2_deg"] == pytest.approx(zeniths[2], abs=1e-9)


@pytest.mark.parametrize("method", ["precise", "noaa"])
def test_day_tells_the_events_of_the_nearest_transit(
    capsys: pytest.CaptureFixture[str], method: str
) -> None:
    argv = ["day", *TIJERAS, *JUNE, "--method", method]
    found = document(capsys, *argv, "--json")
    assert list(found) == [
        "utc",
        "method",
        "altitude_deg",
        "sunrise_utc",
        "transit_utc",
        "sunset_utc",
        "transit_elevation_deg",
        "daylight_h",
        "polar",
        "solar_time",
        "equation_of_time_min",
    ]
    assert found["transit_utc"].startswith("2026-06-21T19:0")
    span_s = parse_utc(found["sunset_utc"]) - parse_utc(found["sunrise_utc"])
    assert span_s / 3600.0 == pytest.approx(found["daylight_h"], abs=1e-5)
    assert found["daylight_h"] == pytest.approx(14.5, abs=0.1)
    assert found["polar"] is None
    assert run_command(argv) == 0
    assert "above -0.833 deg" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("date", "polar", "words"),
    [("2026-06-21", "day", "polar day"), ("2026-12-21", "night", "polar night")],
)
def test_day_says_polar_day_and_night(
    capsys: pytest.CaptureFixture[str], date: str, polar: str, words: str
) -> None:
    argv = ["day", "--lat", "80", "--lon", "15", "--at", f"{date}T11:00Z"]
    found = document(capsys, *argv, "--json")
    assert (found["polar"], found["sunrise_utc"], found["sunset_utc"]) == (polar, None, None)
    assert run_command(argv) == 0
    assert words in capsys.readouterr().out


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["sun", "--lat", "95", "--lon", "0", *JUNE], "--lat: 95 is not between"),
        (["day", "--lat", "95", "--lon", "0", *JUNE], "--lat: 95 is not between"),
        (["sun", "--lat", "nan", "--lon", "0", *JUNE], "--lat: 'nan' is not a number"),
        (["sun", *TIJERAS, "--at", "noon"], "'noon' is not a date and time"),
        (["day", *TIJERAS, "--at", "2026-02-30"], "'2026-02-30' is not a date and time"),
        (["sun", *TIJERAS, "--at", "2126-01-01"], "no Sun for 2126-01-01"),
        (["sun", *TIJERAS, *JUNE, "--model", "spa"], "--model: 'spa' is none of"),
        (["sun", *TIJERAS, *JUNE, "--geometry", "dish"], "--geometry: 'dish' is none of"),
        (["sun", *TIJERAS, *JUNE, "--refraction", "bennett"], "--refraction: 'bennett' is none of"),
        (["sun", *TIJERAS, *JUNE, "--pressure", "30"], "pressure 30 hPa"),
        (["sun", *TIJERAS, *JUNE, "--dut1", "37"], "--dut1: 37 is not between -1 and 1"),
        (["day", *TIJERAS, *JUNE, "--altitude", "100"], "--altitude: 100 is not between"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(
    capsys: pytest.CaptureFixture[str], argv: list[str], words: str
) -> None:
    assert run_command(argv) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert words in printed.err


def test_the_door_and_the_controllers_sun_do_not_load_what_is_heavy() -> None:
    program = (
        "import sys, solarcal.sun.appendix_a, solarcal.sun.day;"
        "print([name for name in ('erfa', 'scipy', 'pandas') if name in sys.modules])"
    )
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert answer.stdout.decode().strip() == "[]"
