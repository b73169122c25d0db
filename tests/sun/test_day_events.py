"""Sunrise, transit, sunset; polar seasons; the hours above an elevation."""

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.day import DayEvents, day_events, daylight, noaa_day_events
from solarcal.timescale import format_utc, parse_utc

HALF_DAY_S = 43200.0


def elevation_deg(at_s: float, site: Site) -> float:
    return sun_position("precise", at_s, site).elevation_deg


@pytest.mark.parametrize("method", [day_events, noaa_day_events])
def test_polar_day_and_night_at_latitude_80_are_said_plainly(method) -> None:
    svalbard = Site(80.0, 15.0)
    summer: DayEvents = method(parse_utc("2026-06-21T12:00Z"), svalbard)
    winter: DayEvents = method(parse_utc("2026-12-21T12:00Z"), svalbard)
    spring: DayEvents = method(parse_utc("2026-03-20T12:00Z"), svalbard)
    assert (summer.polar, summer.sunrise_utc_s, summer.sunset_utc_s) == ("day", None, None)
    assert (winter.polar, winter.sunrise_utc_s, winter.sunset_utc_s) == ("night", None, None)
    assert summer.daylight_s == 86400.0
    assert winter.daylight_s == 0.0
    assert spring.polar is None
    assert spring.sunrise_utc_s is not None
    assert summer.transit_elevation_deg == pytest.approx(33.44, abs=0.05)
    assert winter.transit_elevation_deg == pytest.approx(-13.44, abs=0.05)


@pytest.mark.parametrize("method", [day_events, noaa_day_events])
def test_in_the_south_the_seasons_are_the_other_way_round(method) -> None:
    antarctica = Site(-80.0, 15.0)
    assert method(parse_utc("2026-06-21T12:00Z"), antarctica).polar == "night"
    assert method(parse_utc("2026-12-21T12:00Z"), antarctica).polar == "day"
    cape = Site(-33.9, 18.4)
    june = method(parse_utc("2026-06-21T12:00Z"), cape)
    december = method(parse_utc("2026-12-21T12:00Z"), cape)
    assert december.daylight_s > june.daylight_s + 4 * 3600


@pytest.mark.parametrize("method", [day_events, noaa_day_events])
def test_in_the_tropics_the_sun_passes_overhead_and_days_are_twelve_hours(method) -> None:
    noon = method(parse_utc("2026-05-01T18:00Z"), Site(15.1, -90.0))
    assert noon.transit_elevation_deg > 89.5
    assert method(parse_utc("2026-05-01"), Site(0.0, 10.0)).daylight_s == pytest.approx(
        12 * 3600 + 7 * 60, abs=90
    )


@pytest.mark.parametrize("longitude_deg", [-179.9, -106.48, 0.0, 151.0, 180.0, 253.52])
def test_the_events_are_those_around_the_nearest_transit(longitude_deg: float) -> None:
    site = Site(35.0, longitude_deg)
    for hour in range(0, 24, 3):
        asked_s = parse_utc("2026-09-10") + 3600.0 * hour
        for events in (day_events(asked_s, site), noaa_day_events(asked_s, site)):
            assert events.sunrise_utc_s is not None
            assert events.sunset_utc_s is not None
            assert abs(events.transit_utc_s - asked_s) < HALF_DAY_S + 60.0
            assert events.sunrise_utc_s < events.transit_utc_s < events.sunset_utc_s


@pytest.mark.parametrize("latitude_deg", [-60.0, -20.0, 0.0, 35.0, 65.0])
def test_the_roots_are_roots_of_the_precise_sun(latitude_deg: float) -> None:
    site = Site(latitude_deg, 30.0, 500.0)
    events = day_events(parse_utc("2026-06-21T10:00Z"), site)
    assert events.sunrise_utc_s is not None
    assert events.sunset_utc_s is not None
    for at_s in (events.sunrise_utc_s, events.sunset_utc_s):
        assert elevation_deg(at_s, site) == pytest.approx(-50.0 / 60.0, abs=2e-5)
    assert sun_position("precise", events.transit_utc_s, site).solar_time_h == pytest.approx(
        12.0, abs=1e-6
    )


def test_the_days_at_the_edge_of_polar_day_follow_each_other_without_a_gap() -> None:
    site = Site(78.22, 15.65)
    states = []
    for day in range(40):
        events = day_events(parse_utc("2026-04-05T11:00Z") + 86400.0 * day, site)
        states.append(events.polar)
        if events.polar is None:
            for at_s in (events.sunrise_utc_s, events.sunset_utc_s):
                assert at_s is None or abs(elevation_deg(at_s, site) + 50.0 / 60.0) < 2e-5
    first = states.index("day")
    assert states == [None] * first + ["day"] * (40 - first)
    assert 5 < first < 25


def test_at_the_pole_the_sun_rises_once_in_spring() -> None:
    pole = Site(90.0, 0.0)
    seen = [day_events(parse_utc("2026-03-10T12:00Z") + 86400.0 * day, pole) for day in range(20)]
    assert seen[0].polar == "night"
    assert seen[-1].polar == "day"
    rising = [events for events in seen if events.polar is None]
    assert len(rising) == 1
    assert rising[0].sunrise_utc_s is not None
    assert rising[0].sunset_utc_s is None
    assert format_utc(rising[0].sunrise_utc_s, 0).startswith("2026-03-18")


def test_daylight_is_where_the_sun_is_above_the_elevation() -> None:
    site = Site(35.05, -106.48, 1830.0)
    span = daylight(site, parse_utc("2026-12-21T19:00Z"), 10.0)
    assert span is not None
    for at_s in span:
        assert elevation_deg(at_s, site) == pytest.approx(10.0, abs=2e-5)
    inside = np.linspace(span[0] + 1.0, span[1] - 1.0, 50)
    assert (sun_position("precise", inside, site).elevation_deg > 10.0).all()


def test_daylight_is_nothing_where_the_sun_stays_lower_and_a_day_where_it_stays_higher() -> None:
    assert daylight(Site(35.0, 0.0), parse_utc("2026-12-21T12:00Z"), 40.0) is None
    span = daylight(Site(80.0, 0.0), parse_utc("2026-06-21T12:00Z"), 10.0)
    assert span is not None
    assert span[1] - span[0] == 86400.0


@pytest.mark.parametrize("method", [day_events, noaa_day_events])
def test_a_year_without_a_sun_is_refused(method) -> None:
    with pytest.raises(ConfigurationError, match="no Sun for 2500"):
        method(parse_utc("2500-01-01"), Site(35.0, 0.0))
