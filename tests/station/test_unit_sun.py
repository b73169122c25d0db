"""A unit that believes in another Sun is told what it has wrong."""

import msgspec
import numpy as np
import pytest

from solarcal.model.evidence.unit_state import check_unit_settings, check_unit_sun
from solarcal.mount.controller import ideal_axes_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.site import Site
from solarcal.station.sun_path import solar_time_from_direction_h
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import UnitSite

SITE = Site(35.05, -106.48, 1830.0)
UNIT = UnitSite(SITE, 7.0, "azel")
NOW = parse_utc("2026-06-21T16:00:00Z")


def shown_by(site: Site, computed_for_utc_s: float) -> tuple[float, float]:
    return ideal_axes_deg(MountGeometry("azel", site.latitude_deg), site, computed_for_utc_s)


def test_a_right_unit_agrees():
    assert check_unit_sun(UNIT, SITE, NOW, shown_by(SITE, NOW), NOW).agrees


@pytest.mark.parametrize(
    ("site", "utc_s", "words"),
    [
        (SITE, NOW + 3600.0, "wrong by +1 h"),
        (SITE, NOW - 7200.0, "wrong by -2 h"),
        (SITE, NOW + 86400.0, "its date is wrong by +1 day"),
        (SITE, NOW - 86400.0, "its date is wrong by -1 day"),
        # Morning for afternoon: half a day either way.
        (SITE, NOW + 12 * 3600.0, "wrong by +12 h"),
        (SITE, NOW - 12 * 3600.0, "wrong by -12 h"),
        (Site(-35.05, -106.48), NOW, "other hemisphere"),
        (Site(35.05, 106.48), NOW, "wrong sign"),
        (SITE, NOW + 7 * 86400.0 + 1234.0, "no single wrong"),
    ],
)
def test_what_is_wrong_is_named(site, utc_s, words):
    check = check_unit_sun(UNIT, SITE, NOW, shown_by(site, utc_s), NOW)
    assert not check.agrees
    assert words in check.explanation


def test_a_longitude_counted_to_360_is_the_same_place():
    told = msgspec.structs.replace(UNIT, site=Site(35.05, 253.52, 1830.0))
    assert check_unit_settings(told, SITE, 0.0) == ()
    wrong = check_unit_sun(told, SITE, NOW, shown_by(Site(35.05, 106.48), NOW), NOW)
    assert "wrong sign" in wrong.explanation


def test_settings_that_are_not_ours_are_said_with_their_size():
    told = msgspec.structs.replace(UNIT, site=Site(-35.05, -106.0))
    said = check_unit_settings(told, SITE, 3600.5)
    assert len(said) == 3
    assert "other hemisphere" in said[0]
    assert "-106.0000" in said[1]
    assert "+1 h" in said[2]
    assert check_unit_settings(UNIT, SITE, 0.2) == ()
    assert "0.100 deg of Sun" in check_unit_settings(UNIT, SITE, 24.0)[0]


@pytest.mark.parametrize(
    ("zone_west_h", "longitude_deg", "contradicts"),
    [
        (7.0, 106.48, True), (-7.0, -106.48, True), (7.0, -106.48, False), (6.0, 253.52, False),
        # Kashgar keeps Beijing's time, Kiritimati that of the day before; a clock in UTC none.
        (-8.0, 76.0, False), (-14.0, -157.4, False), (0.0, 106.48, False),
    ],
)  # fmt: skip
def test_a_zone_that_is_not_of_the_longitude_is_said(zone_west_h, longitude_deg, contradicts):
    site = Site(35.05, longitude_deg)
    said = check_unit_settings(UnitSite(site, zone_west_h, "azel"), site, 0.0)
    assert len(said) == contradicts
    if contradicts:
        assert f"zone ({zone_west_h:g} h west)" in said[0]
        assert "contradict each other by 9.9 h" in said[0]


@pytest.mark.parametrize(
    ("azimuth_deg", "elevation_deg", "latitude_deg", "solar_h"),
    [
        # At the equator at an equinox the Sun goes straight over: 15 deg an hour.
        (270.0, 45.0, 0.0, 15.0), (90.0, 60.0, 0.0, 10.0), (270.0, 89.0, 0.0, 12.0 + 1.0 / 15.0),
        (180.0, 50.0, 40.0, 12.0), (0.0, 50.0, -40.0, 12.0), (0.0, 10.0, 75.0, 0.0),
    ],
)  # fmt: skip
def test_solar_time_follows_from_where_the_sun_stands(
    azimuth_deg, elevation_deg, latitude_deg, solar_h
):
    found = solar_time_from_direction_h(
        np.array([azimuth_deg]), np.array([elevation_deg]), latitude_deg
    )
    assert (float(found[0]) - solar_h + 12.0) % 24.0 - 12.0 == pytest.approx(0.0, abs=1e-9)
