"""The Moon: Meeus' worked example, its parallax, and when it can be followed."""

import json
import math

import numpy as np
import pytest

from solarcal.cli import run_command
from solarcal.site import Site
from solarcal.sun.moon import MoonLight, geocentric_au, moon_day, moon_position
from solarcal.sun.position import sun_position
from solarcal.sun.precise import EarthMotion, Frame, Instants
from solarcal.timescale import parse_utc

# Astronomical Algorithms, examples 47.a and 48.a: 1992 April 12, 0h TD (58.184 s after UTC).
EXAMPLE_UTC_S = parse_utc("1992-04-12") - 58.184


def test_the_place_is_that_of_the_worked_example() -> None:
    instants = Instants.of_utc(np.array(EXAMPLE_UTC_S))
    place_au = geocentric_au(instants, Frame.of(instants, EarthMotion.at(instants)))
    distance_au = np.linalg.norm(place_au)
    x, y, z = place_au / distance_au
    assert np.degrees(np.arctan2(y, x)) == pytest.approx(134.688470, abs=20.0 / 3600.0)
    assert np.degrees(np.arcsin(z)) == pytest.approx(13.768368, abs=10.0 / 3600.0)
    assert float(distance_au) * 149597870.7 == pytest.approx(368409.7, abs=30.0)


def test_the_phase_is_that_of_the_worked_example() -> None:
    # From the Earth's centre the example has i = 69.0756 and k = 0.6786; from a site the Moon is
    # displaced by its parallax, a degree at most.
    moon = moon_position(EXAMPLE_UTC_S, Site(0.0, 0.0, 0.0))
    assert float(moon.illuminated) == pytest.approx(0.6786, abs=0.012)
    assert float(moon.phase_deg) == pytest.approx(69.0756, abs=1.0)
    assert bool(moon.waxing)


def test_in_a_total_eclipse_the_moon_stands_before_the_sun() -> None:
    # 8 April 2024, middle of totality near Mazatlan at 18:09:35 UTC.
    utc_s, site = parse_utc("2024-04-08T18:09:35"), Site(23.24, -106.41, 10.0)
    moon, sun = moon_position(utc_s, site), sun_position("precise", utc_s, site)
    assert float(moon.azimuth_deg) == pytest.approx(float(sun.azimuth_deg), abs=0.05)
    assert float(moon.zenith_deg) == pytest.approx(float(sun.zenith_deg), abs=0.02)
    # Total: its disc is the larger one.
    assert float(moon.semidiameter_deg) > 0.2666
    assert float(moon.illuminated) < 1e-4
    assert not moon.usable


def test_full_moon_rises_as_the_sun_sets() -> None:
    # Full on 2026 June 29 at 23:57 UTC.
    moon = moon_position(parse_utc("2026-06-29T23:57:00"), Site(0.0, 0.0, 0.0))
    assert float(moon.illuminated) > 0.99
    assert bool(moon.usable)


def test_many_instants_are_each_alone() -> None:
    site = Site(35.05, -106.48, 1830.0)
    times = parse_utc("2026-06-01") + np.arange(5) * 86400.0 * 5.3
    together = moon_position(times, site)
    for at, utc_s in enumerate(times):
        alone = moon_position(utc_s, site)
        assert together.azimuth_deg[at] == pytest.approx(float(alone.azimuth_deg), abs=1e-9)
        assert together.illuminated[at] == pytest.approx(float(alone.illuminated), abs=1e-12)


# The upper edge at -34' and the transit by XEphem's library (pyephem 4.2.1).
PASSAGES = [
    (
        (51.4769, 0.0, 46.0), "2026-01-03T22:00",
        ("2026-01-03T15:47:37", "2026-01-04T00:43:32", "2026-01-04T09:19:58"), 63.4572, 0.99355,
    ),
    (
        (35.0, -106.0, 1900.0), "2026-08-28T08:00",
        ("2026-08-28T01:28:25", "2026-08-28T07:09:42", "2026-08-28T12:59:12"), 45.7580, 0.99982,
    ),
    (
        (-21.1, 55.4, 2160.0), "2026-09-25T20:00",
        ("2026-09-25T13:10:43", "2026-09-25T19:26:13", "2026-09-26T01:36:36"), 70.0779, 0.99045,
    ),
]  # fmt: skip


@pytest.mark.parametrize(("place", "at", "events", "elevation", "lit"), PASSAGES)
def test_a_passage_is_that_of_an_independent_program(
    place: tuple[float, float, float],
    at: str,
    events: tuple[str, str, str],
    elevation: float,
    lit: float,
) -> None:
    day = moon_day(parse_utc(at), Site(*place))
    found = (day.rise_utc_s, day.transit_utc_s, day.set_utc_s)
    assert found == pytest.approx([parse_utc(event) for event in events], abs=5.0)
    assert float(day.at_transit.elevation_deg) == pytest.approx(elevation, abs=0.001)
    assert float(day.at_transit.illuminated) == pytest.approx(lit, abs=0.001)
    assert day.usable_utc_s is not None
    heights = moon_position(np.array(day.usable_utc_s), Site(*place)).elevation_deg
    np.testing.assert_allclose(heights, 10.0, atol=1e-4)


def test_a_thin_moon_is_not_usable_and_one_that_stays_up_does_not_rise() -> None:
    assert moon_day(parse_utc("2026-01-17T12:00"), Site(51.5, 0.0)).usable_utc_s is None
    # Near its northern standstill at 75 N the Moon circles above the horizon.
    polar = moon_day(parse_utc("2025-12-05T00:00"), Site(75.0, 0.0))
    assert (polar.rise_utc_s, polar.set_utc_s) == (None, None)
    assert polar.usable_utc_s is not None


def test_the_middle_of_the_light_is_that_of_the_lit_part_of_the_disc() -> None:
    """Against the mean of a grid of points of the disc whose sphere the Sun reaches."""
    site, utc_s = Site(35.0, -106.0), parse_utc("2026-08-22T02:00")
    moon = moon_position(utc_s, site)
    phase = math.radians(float(moon.phase_deg))
    assert 60.0 < math.degrees(phase) < 100.0
    x, y = np.meshgrid(*[np.linspace(-1.0, 1.0, 801)] * 2)
    z2 = 1.0 - x**2 - y**2
    lit = (z2 >= 0.0) & (x * math.sin(phase) + np.sqrt(np.maximum(z2, 0.0)) * math.cos(phase) > 0.0)
    expected = float(x[lit].mean()) * float(moon.semidiameter_deg)
    azimuth, zenith = MoonLight(site, utc_s - 7200.0, utc_s + 7200.0).horizontal_deg(utc_s)
    across = (azimuth - float(moon.azimuth_deg)) * math.sin(math.radians(zenith))
    up = float(moon.zenith_deg) - zenith
    assert math.hypot(across, up) == pytest.approx(expected, rel=0.01)
    # Towards the Sun, which has set in the west: the Moon waxes in the south.
    assert across > 0.0
    sun = sun_position("precise", utc_s, site)
    assert float(sun.azimuth_deg) > float(moon.azimuth_deg)


def test_the_day_of_the_moon_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["day", "--target", "moon", "--lat", "51.4769", "--lon", "0", "--elevation", "46"]
    assert run_command([*words, "--at", "2026-01-03T22:00", "--table", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["moonrise_utc"].startswith("2026-01-03T15:47:3")
    assert document["usable_utc"][0].startswith("2026-01-03T17:20:0")
    assert all(row["elevation_deg"] >= 0.0 for row in document["table"])
    assert len(document["table"]) == 35
    assert run_command([*words, "--at", "2026-01-17T12:00"]) == 0
    assert "not usable: less than 40% lit" in capsys.readouterr().out
    assert run_command([*words, "--method", "noaa"]) == 2
    assert "leave it out for the Moon" in capsys.readouterr().err
