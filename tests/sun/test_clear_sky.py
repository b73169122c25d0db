"""Clear-sky estimate: published air masses and the beam of pvlib's Ineichen model."""

import numpy as np
import pytest

from solarcal.sun.circular_orbit import CircularDay
from solarcal.sun.energy import (
    FixedCollector,
    TrackingCollector,
    air_mass,
    day_kwh_m2,
    direct_w_m2,
    moment_w_m2,
)


@pytest.mark.parametrize(
    # Kasten and Young: elevation and relative optical air mass.
    ("elevation_deg", "mass"),
    [(90, 0.9997), (30, 1.9939), (10, 5.5841), (5, 10.31), (0, 37.9196)],
)
def test_air_masses_are_the_published_ones(elevation_deg: float, mass: float) -> None:
    assert air_mass(np.array(90.0 - elevation_deg)) == pytest.approx(mass, rel=1e-3)


def test_the_beam_falls_with_air_mass_turbidity_and_nightfall() -> None:
    zenith = np.array([0.0, 60.0, 80.0, 91.0])
    clean, hazy = direct_w_m2(zenith, 3.0), direct_w_m2(zenith, 6.0)
    # 0.827 x 1361 x exp(-0.09 x 2 x air mass) at sea level.
    assert clean[0] == pytest.approx(0.827 * 1361.0 * np.exp(-0.18 * 0.9997), rel=1e-3)
    assert np.all(np.diff(clean) < 0.0)
    assert np.all(hazy[:3] < clean[:3])
    assert clean[3] == 0.0
    assert direct_w_m2(np.array(30.0), 3.0, 2000.0) > direct_w_m2(np.array(30.0), 3.0)


def test_a_level_collector_gets_the_cosine_of_the_beam() -> None:
    day = CircularDay(42.0, 91.0)
    level, tracking = FixedCollector(), TrackingCollector()
    share = moment_w_m2(level, day, 12.0) / moment_w_m2(tracking, day, 12.0)
    assert share == pytest.approx(0.94804440, abs=1e-6)
    # A clear June day at 42 N: between 6 and 9 kWh on the level, a third more when tracking.
    assert 6.0 < day_kwh_m2(level, day) < 9.0
    assert 1.2 < day_kwh_m2(tracking, day) / day_kwh_m2(level, day) < 1.7
