"""Many positions at one site: as precise as the precise Sun, within half an arcsecond."""

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.timescale import parse_utc
from solarcal.units import FloatArray, wrap_deg

DAY_S = 86400.0


def separation_arcsec(site: Site, times: FloatArray, ephemeris: SiteEphemeris, dut1_s: float):
    azimuth, zenith = ephemeris.horizontal_deg(times)
    true = sun_position("precise", times, site, dut1_s=dut1_s)
    across = wrap_deg(azimuth - true.azimuth_deg) * np.sin(np.radians(true.zenith_deg))
    return 3600.0 * np.hypot(across, zenith - true.zenith_deg)


@pytest.mark.parametrize(
    ("site", "start", "days", "dut1_s"),
    [
        (Site(35.05, -106.48, 1830.0), "2026-01-01", 365.0, 0.0),
        (Site(-33.9, 18.4, 40.0), "2024-02-28T13:00", 366.0, -0.4),
        (Site(-66.0, 359.0, 2900.0), "2016-07-01", 365.0, 0.3),  # holds a leap second
        (Site(0.0, -180.0), "1990-06-10", 1.0, 0.0),
        (Site(23.44, 77.0, 500.0), "2060-06-21", 0.01, 0.0),
        (Site(90.0, 0.0, 2800.0), "2026-03-01", 60.0, 0.1),
        (Site(35.05, -106.48, 1830.0), "2090-01-01", 2000.0, 0.0),
    ],
)
def test_it_follows_the_precise_sun(site: Site, start: str, days: float, dut1_s: float) -> None:
    start_s = parse_utc(start)
    end_s = start_s + days * DAY_S
    ephemeris = SiteEphemeris(site, start_s, end_s, dut1_s)
    times = np.random.default_rng(7).uniform(start_s, end_s, 3000)
    times[:2] = start_s, end_s
    assert separation_arcsec(site, times, ephemeris, dut1_s).max() < 0.1


def test_one_position_is_the_same_as_many() -> None:
    site, start_s = Site(-12.0, -77.0, 150.0), parse_utc("2026-02-01")
    ephemeris = SiteEphemeris(site, start_s, start_s + 30 * DAY_S)
    times = start_s + np.random.default_rng(8).uniform(0.0, 30 * DAY_S, (30, 40))
    azimuth, zenith = ephemeris.horizontal_deg(times)
    assert azimuth.shape == zenith.shape == (30, 40)
    for index, at_s in np.ndenumerate(times):
        one = ephemeris.horizontal_deg(float(at_s))
        assert type(one[0]) is float
        assert one == pytest.approx((azimuth[index], zenith[index]), abs=1e-9)


def test_order_and_block_size_do_not_matter() -> None:
    site, start_s = Site(35.05, -106.48), parse_utc("2026-01-01")
    ephemeris = SiteEphemeris(site, start_s, start_s + 365 * DAY_S)
    times = start_s + np.linspace(0.0, 365 * DAY_S, 40_000)
    shuffle = np.random.default_rng(9).permutation(times.size)
    straight = ephemeris.horizontal_deg(times)
    shuffled = ephemeris.horizontal_deg(times[shuffle])
    for ordered, mixed in zip(straight, shuffled, strict=True):
        assert np.abs(ordered[shuffle] - mixed).max() < 1e-9


def test_nothing_asked_nothing_answered() -> None:
    ephemeris = SiteEphemeris(Site(35.0, 0.0), 1.7e9, 1.7e9)
    azimuth, zenith = ephemeris.horizontal_deg(np.empty(0))
    assert azimuth.size == zenith.size == 0
    assert ephemeris.horizontal_deg(1.7e9)[1] > 0.0


@pytest.mark.parametrize("outside_s", [-1.0, DAY_S + 1.0, float("nan")])
def test_times_outside_the_interval_are_refused(outside_s: float) -> None:
    ephemeris = SiteEphemeris(Site(35.0, 0.0), 1.7e9, 1.7e9 + DAY_S)
    for asked in (1.7e9 + outside_s, np.array([1.7e9, 1.7e9 + outside_s])):
        with pytest.raises(ConfigurationError, match="prepared from 2023-11-14T22:13:20Z"):
            ephemeris.horizontal_deg(asked)


def test_an_interval_that_ends_before_it_begins_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="before it begins"):
        SiteEphemeris(Site(35.0, 0.0), 1.7e9, 1.6e9)
