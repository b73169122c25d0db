"""Two models of the Sun over thirty years, as the spectrometer tracker's paper compared them."""

import json

import pytest

from solarcal.cli import run_command
from solarcal.errors import ConfigurationError
from solarcal.site import Site
from solarcal.sun.position import compare_models


def test_noaas_series_are_half_a_degree_off_at_worst() -> None:
    # The published figure says within 0.5 deg.
    found = compare_models("noaa", "precise", Site(50.8, 4.36, 100.0), 1990, 2020).summary()
    assert found["altitude_worst_deg"] == pytest.approx(0.52, abs=0.006)
    assert found["azimuth_worst_deg"] == pytest.approx(0.46, abs=0.006)
    assert found["altitude_rms_deg"] < 0.25


def test_a_model_does_not_differ_from_itself() -> None:
    found = compare_models("precise", "precise", Site(35.0, -106.0, 0.0), 2026, 2026).summary()
    assert found["altitude_worst_deg"] == found["azimuth_worst_deg"] == 0.0


def test_years_are_in_order() -> None:
    with pytest.raises(ConfigurationError, match="the years 2020 to 1990"):
        compare_models("noaa", "precise", Site(0.0, 0.0, 0.0), 2020, 1990)


def test_the_command_prints_worst_and_rms(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sun", "compare", "--models", "noaa,precise", "--lat", "50.8", "--lon", "4.36",
             "--from", "2010", "--to", "2012"]  # fmt: skip
    assert run_command([*words, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["models"] == ["noaa", "precise"]
    assert 0.3 < document["altitude_worst_deg"] < 0.6
    assert [row["year"] for row in document["years"]] == [2010, 2011, 2012]
    assert run_command(words) == 0
    assert "altitude" in capsys.readouterr().out


def test_the_sun_command_is_still_the_position(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command(["sun", "--lat", "35", "--lon", "-106", "--at", "2026-06-21T19:00Z"]) == 0
    assert "Sun by precise" in capsys.readouterr().out
