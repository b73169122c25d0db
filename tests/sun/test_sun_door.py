"""The front door: one kind of answer from every model, and plain refusals."""

import warnings

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.site import Site, Weather
from solarcal.sun import REFRACTIONS, SUN_MODELS, SunPosition, apparent_zenith_deg, sun_position
from solarcal.sun.precise import Instants
from solarcal.timescale import parse_utc
from solarcal.units import wrap_deg

TIJERAS = Site(35.05, -106.48, 1830.0)
JUNE_S = parse_utc("2026-06-21T15:30:00Z")
FIELDS = SunPosition.__slots__


@pytest.mark.parametrize("model", SUN_MODELS)
def test_a_float_gives_floats_and_an_array_gives_arrays_of_its_shape(model: str) -> None:
    one = sun_position(model, JUNE_S, TIJERAS)
    times = JUNE_S + 600.0 * np.arange(12.0).reshape(3, 4)
    many = sun_position(model, times, TIJERAS)
    for name in FIELDS:
        assert type(getattr(one, name)) is float, name
        assert getattr(many, name).shape == (3, 4), name
        assert getattr(many, name)[0, 0] == pytest.approx(getattr(one, name), abs=1e-9)
    assert many.elevation_deg[2, 3] == 90.0 - many.zenith_deg[2, 3]


@pytest.mark.parametrize("year", [1961, 1999, 2026, 2080])
def test_many_precise_positions_are_those_of_single_ones(year: int) -> None:
    """Of many the theory is evaluated at midnights only: within 0.0005 arcsec."""
    begin_s = float(np.datetime64(f"{year}-02-01", "s").astype(int))
    times = begin_s + np.random.default_rng(year).uniform(0.0, 30.0 * 86400.0, (40, 30))
    many = sun_position("precise", times, TIJERAS)
    for place in [(0, 0), (3, 7), (20, 29), (39, 11)]:
        one = sun_position("precise", float(times[place]), TIJERAS)
        across = (many.azimuth_deg[place] - one.azimuth_deg) * np.sin(np.radians(one.zenith_deg))
        along = many.zenith_deg[place] - one.zenith_deg
        assert 3600.0 * np.hypot(across, along) < 5e-4
        assert many.declination_deg[place] == pytest.approx(one.declination_deg, abs=1e-7)


@pytest.mark.parametrize("model", SUN_MODELS)
def test_ranges_hold_around_the_clock_and_the_year(model: str) -> None:
    times = JUNE_S + np.random.default_rng(5).uniform(0.0, 3.2e7, 3000)
    for latitude_deg in (-90.0, -33.9, 0.0, 23.4, 90.0):
        sun = sun_position(model, times, Site(latitude_deg, 170.0))
        assert (sun.azimuth_deg >= 0).all()
        assert (sun.azimuth_deg < 360).all()
        assert (sun.solar_time_h >= 0).all()
        assert (sun.solar_time_h < 24).all()
        assert (np.abs(sun.equation_of_time_min) < 17).all()
        assert (np.abs(sun.declination_deg) < 23.5).all()


@pytest.mark.parametrize("model", SUN_MODELS)
def test_equation_of_time_and_solar_time_are_those_of_the_almanac(model: str) -> None:
    # 3 November: apparent time 16.4 min ahead; 11 February: 14.2 min behind.
    november = sun_position(model, parse_utc("2026-11-03T12:00Z"), Site(50.0, 0.0))
    february = sun_position(model, parse_utc("2026-02-11T12:00Z"), Site(50.0, 0.0))
    assert november.equation_of_time_min == pytest.approx(16.45, abs=0.4)
    assert february.equation_of_time_min == pytest.approx(-14.2, abs=0.4)
    assert november.solar_time_h == pytest.approx(12.0 + november.equation_of_time_min / 60.0)
    east = sun_position(model, parse_utc("2026-11-03T12:00Z"), Site(50.0, 15.0))
    assert east.solar_time_h - november.solar_time_h == pytest.approx(1.0, abs=1e-9)


def test_a_second_of_dut1_turns_the_earth_by_fifteen_arcseconds() -> None:
    equator = Site(0.0, 0.0)
    at_s = parse_utc("2026-03-20T08:00Z")
    early = sun_position("precise", at_s, equator, dut1_s=0.5).zenith_deg
    late = sun_position("precise", at_s, equator, dut1_s=-0.5).zenith_deg
    assert (late - early) * 3600.0 == pytest.approx(15.04, abs=0.05)


def test_a_leap_second_is_known_to_the_precise_sun() -> None:
    # Between these two the Earth turned for one second, and two went by.
    across = np.array([parse_utc("2016-12-31T23:59:59Z"), parse_utc("2017-01-01T00:00:00Z")])
    instants = Instants.of_utc(across)
    for scale, seconds in ((instants.tt, 2.0), (instants.ut1, 1.0)):
        days = np.diff(scale[0]) + np.diff(scale[1])
        assert days[0] * 86400.0 == pytest.approx(seconds, abs=1e-4)


def test_years_without_announced_leap_seconds_raise_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sun_position("precise", parse_utc("2060-06-01T12:00Z"), TIJERAS)
        sun_position("precise", parse_utc("1965-06-01T12:00Z"), TIJERAS)
        sun_position("precise", parse_utc("2100-02-28T12:00Z"), TIJERAS)


def test_refraction_lifts_the_sun_by_the_air_of_the_place() -> None:
    airless = sun_position("precise", JUNE_S, TIJERAS)
    for refraction in REFRACTIONS[1:]:
        seen = sun_position("precise", JUNE_S, TIJERAS, refraction=refraction)
        dense = sun_position(
            "precise", JUNE_S, TIJERAS, refraction=refraction, weather=Weather(1013.25, 15.0)
        )
        lift = airless.zenith_deg - seen.zenith_deg
        # 58 arcsec times the tangent at sea level, four fifths of it at 1830 m.
        assert lift * 3600.0 == pytest.approx(0.8 * 58.0 * np.tan(np.radians(48.3)), rel=0.05)
        assert airless.zenith_deg - dense.zenith_deg > 1.2 * lift
        assert seen.azimuth_deg == airless.azimuth_deg


def test_the_two_refractions_agree_within_nine_arcseconds_above_five_degrees() -> None:
    zenith = np.linspace(0.0, 85.0, 200)
    apart = apparent_zenith_deg(zenith, "hughes") - apparent_zenith_deg(zenith, "saemundsson")
    assert np.abs(apart).max() * 3600.0 < 9.0


@pytest.mark.parametrize("refraction", REFRACTIONS[1:])
def test_refraction_is_finite_and_without_steps_from_zenith_to_nadir(refraction: str) -> None:
    zenith = np.linspace(0.0, 180.0, 200_001)
    lift = zenith - apparent_zenith_deg(zenith, refraction)
    assert np.isfinite(lift).all()
    assert np.abs(np.diff(lift)).max() < 0.005
    # 29 arcmin at the horizon of a standard atmosphere at 10 C, a little more or less by formula.
    assert 60.0 * lift[100_000] == pytest.approx(28.6, abs=0.7)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"model": "spa"}, "unknown Sun model 'spa'"),
        ({"refraction": "bennett"}, "unknown refraction 'bennett'"),
        ({"dut1_s": 37.0}, "DUT1 37 s"),
        ({"dut1_s": float("nan")}, "DUT1 nan s"),
        ({"utc_s": float("nan")}, "no Sun for nan"),
        ({"utc_s": 1e30}, "no Sun for 1e+30 s"),
        ({"utc_s": np.array([0.0, 4107542400.0])}, "no Sun for 2100-03-01"),
        ({"utc_s": parse_utc("1959-12-31")}, "no Sun for 1959-12-31"),
    ],
)
def test_what_cannot_be_answered_is_refused_in_words(
    arguments: dict[str, object], words: str
) -> None:
    asked = {"model": "precise", "utc_s": JUNE_S, "site": TIJERAS} | arguments
    with pytest.raises(ConfigurationError) as refusal:
        sun_position(**asked)  # type: ignore[call-overload]
    assert words in str(refusal.value)


def test_the_precise_sun_agrees_with_an_independent_algorithm() -> None:
    spa = pytest.importorskip("pvlib.spa")
    times = parse_utc("2026-01-01") + np.random.default_rng(6).uniform(0.0, 3e7, 500)
    for site in (TIJERAS, Site(-33.9, 18.4, 40.0), Site(10.0, 151.0)):
        peer = spa.solar_position_numpy(
            times,
            site.latitude_deg,
            site.longitude_deg,
            site.elevation_m,
            0.0,
            10.0,
            69.184,
            0.0,
            1,
        )
        sun = sun_position("precise", times, site)
        across = wrap_deg(peer[4] - sun.azimuth_deg) * np.sin(np.radians(sun.zenith_deg))
        # SPA claims 0.0003 deg.
        assert np.hypot(across, peer[1] - sun.zenith_deg).max() < 0.0003
