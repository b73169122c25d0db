"""Rows of the seed documents, asked of the program itself."""

import json
from pathlib import Path

import pytest

from solarcal.cli import run_command

SIGNALS = ["--signals", "1.1", "1", "1", "1"]


def answered(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert run_command(list(words)) == 0
    return capsys.readouterr().out


def test_heliostat_circle_prints_the_published_bisection(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ("heliostat", "circle", "--angle", "22.5", "--distance", "5")
    text = answered(capsys, *words, "--steps")
    assert "12.489481 after 17 steps; the root finder above gives 12.489466" in text
    assert "10.232005 after 18 steps; the root finder above gives 10.232014" in text
    assert "bisection" not in answered(capsys, *words)


def test_the_moon_is_a_target_with_its_phase(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("sun", "--target", "moon", "--lat", "35", "--lon", "-106")
    full = json.loads(answered(capsys, *words, "--at", "2026-06-29T05:00Z", "--json"))
    assert full["illuminated"] > 0.98
    assert full["usable"]
    assert full["ax2_deg"] == pytest.approx(full["zenith_deg"])
    text = answered(capsys, *words, "--at", "2026-06-15T18:00Z")
    assert "not usable: less than 40% lit" in text


def test_percent_becomes_watts_and_kilowatt_hours(capsys: pytest.CaptureFixture[str]) -> None:
    text = answered(capsys, "energy")
    # 94.804440 % of SUNCALC's 1.40 kW/m2, and 36.692442 % of it over 24 h.
    assert "1327 W/m2 of 1.40 kW/m2 now, 12.33 kWh/m2 a day" in text
    assert "look towards bearing 180.000, 71.450 deg up" in text
    found = json.loads(answered(capsys, "energy", "--turbidity", "5", "--json"))["irradiance"]
    clean = json.loads(answered(capsys, "energy", "--json"))["irradiance"]
    assert 0.0 < found["clear_sky_w_m2"] < clean["clear_sky_w_m2"] < 1327.0


@pytest.mark.parametrize(
    ("t2", "warned"), [("0.5", True), ("2.9", True), ("3.5", False), ("45", False)]
)
def test_a_trace_near_the_zenith_warns_of_the_singularity(
    capsys: pytest.CaptureFixture[str], t2: str, warned: bool
) -> None:
    text = answered(capsys, "two-mirror", "trace", *SIGNALS, "--t1", "10", "--t2", t2)
    assert ("near its singularity" in text) == warned


@pytest.mark.parametrize("method", ["linear", "robust"])
def test_parameters_of_a_unit_forty_degrees_off_are_unrealistic(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], method: str
) -> None:
    rows = "".join(
        f",{ax1},{ax2},{40.0 + 0.01 * n},0.2\n"
        for n, (ax1, ax2) in enumerate(((-60, 60), (-30, 40), (0, 30), (30, 40), (60, 60)))
    )
    path = tmp_path / "wrong.csv"
    head = "# geometry=azel\n# lat_deg=35\n# lon_deg=-106\n"
    path.write_text(head + "utc,ax1_deg,ax2_deg,err1_deg,err2_deg\n" + rows)
    assert "*** Parameters still unrealistic ***" in answered(
        capsys, "fit", str(path), "--method", method
    )
    document = json.loads(answered(capsys, "fit", str(path), "--method", method, "--json"))
    assert document["message"] == "Parameters still unrealistic"
