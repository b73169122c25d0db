"""Against the JPL ephemeris: 400 airless topocentric positions, 1990-2060."""

import csv
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from solarcal.site import Site, Weather
from solarcal.sun import apparent_zenith_deg, sun_position
from solarcal.sun.day import day_events, noaa_day_events
from solarcal.timescale import parse_utc
from solarcal.units import wrap_deg

REFERENCE = Path(__file__).parents[2].parent / "shared" / "data" / "sun_reference.csv"

pytestmark = pytest.mark.skipif(
    not REFERENCE.is_file(), reason="the reference data lie beside the project and are not here"
)


@cache
def rows() -> list[dict[str, str]]:
    with REFERENCE.open(newline="") as file:
        return list(csv.DictReader(file))


def site_of(row: dict[str, str]) -> Site:
    return Site(float(row["lat_deg"]), float(row["lon_east_deg"]), float(row["elevation_m"]))


def worst_separation_deg(model: str) -> float:
    worst = 0.0
    for row in rows():
        dut1_s = float(row["dut1_s"]) if model == "precise" else 0.0
        sun = sun_position(model, parse_utc(row["utc_iso"]), site_of(row), dut1_s=dut1_s)
        zenith_deg = float(row["zenith_true_deg"])
        turned = wrap_deg(sun.azimuth_deg - float(row["azimuth_north_east_deg"]))
        across = turned * np.sin(np.radians(zenith_deg))
        worst = max(worst, float(np.hypot(across, sun.zenith_deg - zenith_deg)))
    return worst


def test_the_reference_is_whole() -> None:
    assert len(rows()) == 400


@pytest.mark.parametrize(
    ("model", "limit_deg"),
    [("precise", 0.05 / 3600.0), ("solartrak", 0.015), ("solartrak+", 0.005), ("noaa", 0.63)],
)
def test_each_model_keeps_its_claim_on_all_rows(model: str, limit_deg: float) -> None:
    assert worst_separation_deg(model) < limit_deg


@pytest.mark.parametrize("refraction", ["hughes", "saemundsson"])
def test_refraction_agrees_within_a_tenth_of_an_arcsecond(refraction: str) -> None:
    for row in rows():
        air = Weather(float(row["pressure_hpa"]), float(row["temperature_c"]))
        seen = apparent_zenith_deg(float(row["zenith_true_deg"]), refraction, air)
        off_deg = seen - float(row[f"zenith_apparent_{refraction}_deg"])
        assert abs(off_deg) < 0.1 / 3600.0, row["utc_iso"]


# Every fourth row: root finding is the slow part of this file.
@pytest.mark.parametrize("first", range(4))
def test_day_events_agree_within_a_second(first: int) -> None:
    for row in rows()[first::4]:
        events = day_events(parse_utc(row["utc_iso"]), site_of(row), dut1_s=float(row["dut1_s"]))
        found = (events.sunrise_utc_s, events.transit_utc_s, events.sunset_utc_s)
        for at_s, name in zip(found, ("sunrise", "transit", "sunset"), strict=True):
            assert at_s == pytest.approx(parse_utc(row[f"{name}_utc"]), abs=1.0), row["utc_iso"]


def test_noaa_events_are_good_to_minutes_below_the_polar_circles() -> None:
    for row in rows():
        if abs(float(row["lat_deg"])) > 60.0:
            continue
        events = noaa_day_events(parse_utc(row["utc_iso"]), site_of(row))
        found = (events.sunrise_utc_s, events.transit_utc_s, events.sunset_utc_s)
        for at_s, name in zip(found, ("sunrise", "transit", "sunset"), strict=True):
            assert at_s == pytest.approx(parse_utc(row[f"{name}_utc"]), abs=300.0)
