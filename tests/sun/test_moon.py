"""The Moon: Meeus' worked example, its parallax, and when it can be followed."""

import numpy as np
import pytest

from solarcal.site import Site
from solarcal.sun.moon import geocentric_moon, moon_position
from solarcal.sun.position import sun_position
from solarcal.timescale import parse_utc

# Astronomical Algorithms, examples 47.a and 48.a: 1992 April 12, 0h TD (58.184 s after UTC).
EXAMPLE_UTC_S = parse_utc("1992-04-12") - 58.184


def test_the_place_is_that_of_the_worked_example() -> None:
    moon = geocentric_moon(np.array(EXAMPLE_UTC_S))
    x, y, z = moon.direction
    assert np.degrees(np.arctan2(y, x)) == pytest.approx(134.688470, abs=20.0 / 3600.0)
    assert np.degrees(np.arcsin(z)) == pytest.approx(13.768368, abs=10.0 / 3600.0)
    assert float(moon.distance_au) * 149597870.7 == pytest.approx(368409.7, abs=30.0)


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
