"""Collector energy in the manner of SUNCALC: the numbers of 10-physics.md section 4, and sense."""

import math

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.sun.circular_orbit import CircularDay, days_after_march_equinox
from solarcal.sun.energy import (
    SUN_RADIUS_DEG,
    FixedCollector,
    OneAxisCollector,
    TrackingCollector,
    day_percent,
    disc_percent,
    moment_percent,
    pointing_loss,
    suncalc_day_percent,
    year_percent,
)
from solarcal.timescale import parse_utc

LEVEL = FixedCollector()
DEFAULT = CircularDay(42.0, 91.0)
"""Section 4: latitude 42, 91 days after the March equinox."""

DIGITS = 5.1e-7
"""Half a unit of the sixth decimal, as printed."""


def test_section_4_where_the_sun_stands_at_noon() -> None:
    north, east, up = DEFAULT.direction_neu(12.0).tolist()
    assert north == pytest.approx(-0.318138, abs=DIGITS)
    assert east == 0.0
    assert up == pytest.approx(0.948044, abs=DIGITS)
    assert DEFAULT.elevation_deg(12.0) == pytest.approx(71.449641, abs=DIGITS)
    assert DEFAULT.high_sun_deg == pytest.approx(71.449641, abs=DIGITS)


def test_section_4_daylight_and_sunrise_bearing() -> None:
    assert DEFAULT.daylight_h == pytest.approx(15.065298, abs=DIGITS)
    assert DEFAULT.dawn_h == pytest.approx(4.467351, abs=DIGITS)
    assert DEFAULT.dusk_h == pytest.approx(19.532649, abs=DIGITS)
    assert DEFAULT.sunrise_bearing_deg == pytest.approx(32.376807, abs=DIGITS)


def test_section_4_energy_at_the_moment_and_over_the_day() -> None:
    assert moment_percent(LEVEL, DEFAULT, 12.0) == pytest.approx(94.804440, abs=DIGITS)
    assert suncalc_day_percent(LEVEL, DEFAULT) == pytest.approx(36.694840, abs=DIGITS)


@pytest.mark.parametrize(("day", "percent"), [(0, 23.647252), (91, 36.694840), (273, 10.066100)])
def test_section_4_energy_at_equinox_june_and_december_solstice(day: int, percent: float) -> None:
    found = suncalc_day_percent(LEVEL, CircularDay(42.0, day))
    assert found == pytest.approx(percent, abs=DIGITS)


@pytest.mark.parametrize("day", [0.0, 45.5, 91.0, 182.0, 273.0])
@pytest.mark.parametrize("latitude_deg", [-60.0, -10.0, 0.0, 42.0, 66.0])
def test_the_integral_is_the_closed_form_of_a_level_collector(
    latitude_deg: float, day: float
) -> None:
    one = CircularDay(latitude_deg, day)
    half_rad = one.daylight_h * math.pi / 24.0
    latitude, declination = math.radians(latitude_deg), math.radians(one.declination_deg)
    closed = (
        half_rad * math.sin(latitude) * math.sin(declination)
        + math.cos(latitude) * math.cos(declination) * math.sin(half_rad)
    ) / math.pi
    assert day_percent(LEVEL, one) == pytest.approx(100.0 * closed, abs=1e-4)
    assert suncalc_day_percent(LEVEL, one) == pytest.approx(100.0 * closed, abs=0.03)


def test_events_are_where_the_direction_says_they_are() -> None:
    for latitude_deg in (-50.0, 30.0, 42.0):
        for day in (10.0, 91.0, 200.0, 300.0):
            one = CircularDay(latitude_deg, day)
            assert one.dawn_h is not None
            assert one.due_east_h is not None
            assert one.due_west_h is not None
            assert one.sunrise_bearing_deg is not None
            north, east, up = one.direction_neu(one.dawn_h).tolist()
            assert up == pytest.approx(0.0, abs=1e-12)
            bearing = math.degrees(math.atan2(north, east))
            assert bearing == pytest.approx(one.sunrise_bearing_deg, abs=1e-9)
            for hour, sign in ((one.due_east_h, 1.0), (one.due_west_h, -1.0)):
                north, east, _ = one.direction_neu(hour).tolist()
                assert north == pytest.approx(0.0, abs=1e-12)
                assert math.copysign(1.0, east) == sign


def test_between_equator_and_sun_it_is_never_due_east() -> None:
    assert CircularDay(5.0, 91.0).due_east_h is None
    assert CircularDay(5.0, 91.0).due_west_h is None
    assert CircularDay(0.0, 0.0).due_east_h == 6.0


def test_days_with_the_sun_shining_or_hidden_throughout_are_said_so() -> None:
    summer, winter = CircularDay(80.0, 91.0), CircularDay(80.0, 273.0)
    assert (summer.never_sets, summer.daylight_h, summer.dawn_h) == ("day", 24.0, None)
    assert (winter.never_sets, winter.daylight_h, winter.dusk_h) == ("night", 0.0, None)
    assert summer.sunrise_bearing_deg is None
    assert summer.low_sun_deg == pytest.approx(13.4496, abs=1e-4)
    assert day_percent(TrackingCollector(), summer) == pytest.approx(100.0)
    assert day_percent(TrackingCollector(), winter) == 0.0
    assert suncalc_day_percent(LEVEL, winter) == 0.0
    assert CircularDay(90.0, 91.0).never_sets == "day"
    assert CircularDay(-90.0, 91.0).never_sets == "night"


def test_tracking_catches_all_daylight_and_one_axis_lies_between() -> None:
    tracking = day_percent(TrackingCollector(), DEFAULT)
    assert tracking == pytest.approx(100.0 * DEFAULT.daylight_h / 24.0)
    latitude = math.radians(42.0)
    polar = OneAxisCollector((math.cos(latitude), 0.0, math.sin(latitude)))
    # About the pole the Sun is only missed by its declination.
    declination = math.radians(DEFAULT.declination_deg)
    assert day_percent(polar, DEFAULT) == pytest.approx(tracking * math.cos(declination))
    trough = day_percent(OneAxisCollector((2.0, 0.0, 0.0)), DEFAULT)
    assert day_percent(LEVEL, DEFAULT) < trough < tracking
    assert year_percent(TrackingCollector(), 42.0) == pytest.approx(50.0, abs=0.01)


def test_a_collector_sees_nothing_on_its_back_or_below_the_horizon() -> None:
    north_wall = FixedCollector((1.0, 0.0, 0.0))
    assert moment_percent(north_wall, DEFAULT, 12.0) == 0.0
    assert moment_percent(north_wall, DEFAULT, 5.5) > 0.0
    assert moment_percent(TrackingCollector(), DEFAULT, 4.0) == 0.0
    assert moment_percent(TrackingCollector(), DEFAULT, 5.0) == 100.0


def test_length_of_the_normal_does_not_matter() -> None:
    once, tenfold = FixedCollector((-0.5, 0.2, 0.8)), FixedCollector((-5.0, 2.0, 8.0))
    assert day_percent(once, DEFAULT) == pytest.approx(day_percent(tenfold, DEFAULT))


def test_a_tilted_collector_gains_over_the_year() -> None:
    tilted = FixedCollector((-math.sin(math.radians(37.0)), 0.0, math.cos(math.radians(37.0))))
    assert year_percent(tilted, 42.0) > 1.2 * year_percent(LEVEL, 42.0)


def test_a_pointing_error_costs_a_tracker_its_cosine() -> None:
    loss = pointing_loss(TrackingCollector(), DEFAULT, 1.0)
    assert loss.lost_percent == pytest.approx(100.0 * (1.0 - math.cos(math.radians(1.0))))
    assert loss.worst_bearing_deg is None
    assert pointing_loss(TrackingCollector(), DEFAULT, 0.0).lost_percent == 0.0


def test_a_fixed_collector_loses_most_when_tipped_away_from_the_sun() -> None:
    winter = CircularDay(42.0, 273.0)
    loss = pointing_loss(LEVEL, winter, 1.0)
    assert loss.worst_bearing_deg == pytest.approx(0.0)
    tipped = FixedCollector((math.sin(math.radians(1.0)), 0.0, math.cos(math.radians(1.0))))
    assert loss.worst_percent == pytest.approx(day_percent(tipped, winter))
    # By hand: the mean southward part of the Sun that day is 0.28997 of full Sun.
    lost = 28.997 * math.sin(math.radians(1.0)) / 10.06642
    assert loss.lost_percent == pytest.approx(100.0 * lost, abs=0.02)
    hidden = pointing_loss(LEVEL, CircularDay(80.0, 273.0), 1.0)
    assert hidden.lost_percent == 0.0


def test_a_concentrator_loses_the_part_of_the_disc_it_does_not_accept() -> None:
    assert disc_percent(0.5, 0.0) == 100.0
    assert disc_percent(0.5, 0.5 - SUN_RADIUS_DEG) == 100.0
    assert disc_percent(0.5, 0.5 + SUN_RADIUS_DEG) == 0.0
    assert disc_percent(SUN_RADIUS_DEG / 2.0, 0.0) == pytest.approx(25.0)
    # Two equal circles whose edges pass through each other's centres.
    lens = 2.0 / 3.0 - math.sqrt(3.0) / (2.0 * math.pi)
    assert disc_percent(SUN_RADIUS_DEG, SUN_RADIUS_DEG) == pytest.approx(100.0 * lens)
    errors = np.linspace(0.0, 0.9, 40)
    shares = [disc_percent(0.5, float(error)) for error in errors]
    assert shares == sorted(shares, reverse=True)


def test_days_are_counted_from_the_precise_march_equinox() -> None:
    # 2026-03-20 14:46 UTC and the solstice of 2026-06-21 08:24 UTC (almanac, to the minute).
    equinox_s = parse_utc("2026-03-20T14:46:00Z")
    assert days_after_march_equinox(equinox_s + 120.0) == pytest.approx(2 / 1440, abs=1.5 / 1440)
    assert days_after_march_equinox(parse_utc("2026-06-21T08:24:00Z")) == pytest.approx(
        92.735, abs=0.002
    )
    assert 364.0 < days_after_march_equinox(equinox_s - 86400.0) < 365.0


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: FixedCollector((0.0, 0.0, 0.0)), "normal is zero"),
        (lambda: FixedCollector((math.inf, 0.0, 0.0)), "three finite numbers"),
        (lambda: OneAxisCollector((0.0, 0.0, 0.0)), "axis is zero"),
        (lambda: moment_percent(LEVEL, DEFAULT, 24.5), "solar time 24.5 h"),
        (lambda: pointing_loss(LEVEL, DEFAULT, 90.0), "pointing error 90 deg"),
        (lambda: disc_percent(0.0, 0.1), "acceptance half angle 0 deg"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(make, says: str) -> None:
    with pytest.raises(ConfigurationError, match=says) as refused:
        make()
    assert "\n" not in str(refused.value)
