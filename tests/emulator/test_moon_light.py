"""The Moon as the light of an emulated tracker: where it shines, and when it does not."""

import math

import numpy as np
import pytest

from solarcal.emulator.scenario import load_scenario
from solarcal.errors import ConfigurationError
from solarcal.sun.moon import moon_position

EXACT = ("truth.noise_deg=0", "truth.switch_sigma_counts=0", "truth.light=moon")


def topocentric_deg(ra_deg, dec_deg, distance_km, gast_deg, latitude_deg, longitude_deg):
    """Azimuth from the South towards East and zenith angle, from the Earth's centre to a site."""
    earth = 6378.137
    latitude = math.radians(latitude_deg)
    # On the ellipsoid, at sea level.
    flat = 1.0 / 298.257223563
    u = math.atan((1.0 - flat) * math.tan(latitude))
    across, along = earth * math.cos(u), earth * (1.0 - flat) * math.sin(u)
    local = math.radians(gast_deg + longitude_deg)
    ra, dec = math.radians(ra_deg), math.radians(dec_deg)
    moon = distance_km * np.array(
        (math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra), math.sin(dec))
    )
    seen = moon - np.array((across * math.cos(local), across * math.sin(local), along))
    seen /= np.linalg.norm(seen)
    up = np.array((math.cos(latitude) * math.cos(local), math.cos(latitude) * math.sin(local),
                   math.sin(latitude)))  # fmt: skip
    east = np.array((-math.sin(local), math.cos(local), 0.0))
    south = np.cross(east, up)
    return (
        math.degrees(math.atan2(seen @ east, seen @ south)),
        math.degrees(math.acos(float(seen @ up))),
    )


def test_it_shines_from_where_meeus_has_the_moon(rig):
    """Astronomical Algorithms, examples 47.a and 48.a, and 12.4 for the sidereal time.

    A diode sees the middle of the light: 4 r (1 - cos i)/(3 pi) from the disc's, i 69.08 deg.
    """
    # 0h TD is 58.184 s after 0h UTC's instant; nutation in longitude 0.004610 deg of the example.
    days = 2448724.5 - 58.184 / 86400.0 - 2451545.0
    gast_deg = 280.46061837 + 360.98564736629 * days + 0.004610 * math.cos(math.radians(23.4406))
    tracker = rig(
        "tijeras-azel", *EXACT, "truth.refraction=none", "site.latitude_deg=20",
        "site.longitude_deg=-60", "site.elevation_m=0", "start=1992-04-11T23:59:01.816Z",
    )  # fmt: skip
    world = tracker.emulator.world
    light = world.sky.light_now_deg(world.start_utc_s)
    disc = topocentric_deg(134.688470, 13.768368, 368409.7, gast_deg, 20.0, -60.0)
    assert disc[1] < 40.0
    away = float(world.geometry.sky_separation_deg(*light, *disc))
    radius_deg = math.degrees(math.asin(1737.4 / 368409.7))
    shift = 4.0 / (3.0 * math.pi) * radius_deg * (1.0 - math.cos(math.radians(69.0756)))
    assert shift == pytest.approx(0.0737, abs=0.0002)
    assert away == pytest.approx(shift, abs=0.012)


def test_at_the_readings_of_the_moon_the_spot_is_centred_and_the_units_sun_is_elsewhere(rig):
    tracker = rig("tijeras-azel", *EXACT, "start=2026-06-29T22:00:00Z", referenced=True)
    tracker.advance(8 * 3600.0)
    world = tracker.emulator.world
    light = world.sky.light_now_deg(world.true_utc_s(tracker.emulator.now_s()))
    wanted = world.mechanism.readings_deg(world.geometry, *light)
    tracker.drive_to(float(wanted[0]), float(wanted[1]))
    spot, status = tracker.spot(), tracker.status()
    assert spot.visible
    # What it moved while the axes were on their way.
    assert math.hypot(spot.error1_deg, spot.error2_deg) < 1.0
    assert status.ideal2_deg > 90.0
    assert not rig("tijeras-azel", *EXACT, "start=2026-06-29T22:00:00Z").spot().visible


def test_a_thin_moon_gives_no_spot(rig):
    tracker = rig("tijeras-azel", *EXACT, "start=2026-06-15T18:00:00Z")
    world = tracker.emulator.world
    assert float(moon_position(world.start_utc_s, world.site).elevation_deg) > 30.0
    assert world.sky.light_now_deg(world.start_utc_s) is None


def test_a_date_begins_as_the_moon_has_risen():
    scenario = load_scenario("tijeras-azel", ["truth.light=moon", "start=2026-06-29"])
    site = scenario.site.place()
    start = scenario.start_utc_s()
    assert float(moon_position(start, site).elevation_deg) == pytest.approx(12.0, abs=0.25)
    assert float(moon_position(start + 600.0, site).elevation_deg) > 12.0
    with pytest.raises(ConfigurationError, match="the Moon does not rise through 12 deg"):
        load_scenario(
            "tijeras-azel", ["truth.light=moon", "start=2026-06-29", "site.latitude_deg=75"]
        ).start_utc_s()


def test_another_light_is_refused():
    with pytest.raises(ConfigurationError, match=r"truth\.light: 'mars' is not one of sun, moon"):
        load_scenario("tijeras-azel", ["truth.light=mars"])
