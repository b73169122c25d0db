"""Mirrors and heliostats: the plane of reflection, aiming, targeting (10-physics, section 6)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solarcal.errors import ConfigurationError
from solarcal.optics.mirror_roots import exact_roots
from solarcal.optics.offset_mirror import MirrorOffset
from solarcal.optics.reflection import (
    Target,
    angle_deg,
    bisector,
    direction_enu,
    horizontal_deg,
    reflected,
    targeting,
    translation_deg,
)

azimuths = st.floats(0.0, 359.99)
sun_zeniths = st.floats(0.1, 89.0)
target_zeniths = st.floats(20.0, 120.0)


def angle_sun_target_deg(sun_a, sun_z, target_a, target_z):
    """gamma of cos(gamma) = cos a_z cos b_z + sin a_z sin b_z cos(a_a - b_a)  (section 6)."""
    sun, target = math.radians(sun_z), math.radians(target_z)
    turn = math.radians(sun_a - target_a)
    return math.degrees(
        math.acos(
            math.cos(sun) * math.cos(target) + math.sin(sun) * math.sin(target) * math.cos(turn)
        )
    )


def aim(sun_a, sun_z, target_a, target_z):
    """The normal of a mirror without offsets."""
    return exact_roots(sun_a, sun_z, Target(target_a, target_z, 1.0), MirrorOffset())[0]


@settings(derandomize=True, max_examples=200)
@given(azimuths, sun_zeniths, azimuths, target_zeniths)
def test_the_normal_stands_half_way_in_the_plane_of_reflection(sun_a, sun_z, target_a, target_z):
    """Section 6: cos gamma = ..., the normal gamma/2 from the target in the plane of reflection."""
    gamma = angle_sun_target_deg(sun_a, sun_z, target_a, target_z)
    if not 0.1 < gamma < 179.0:
        return
    found = aim(sun_a, sun_z, target_a, target_z)
    normal = direction_enu(found.azimuth_deg, found.zenith_deg)
    sun, target = direction_enu(sun_a, sun_z), direction_enu(target_a, target_z)
    assert found.incidence_deg == pytest.approx(gamma / 2.0, abs=1e-6)
    assert float(angle_deg(normal, target)) == pytest.approx(gamma / 2.0, abs=1e-6)
    assert abs(float(np.dot(np.cross(sun, target), normal))) < 1e-12
    assert float(angle_deg(reflected(sun, normal), target)) < 1e-9


def test_the_trigonometric_form_agrees_but_for_the_quadrant_asin_loses():
    """Section 6: 'the printed asin forms lose the quadrant'. The normal's azimuth from the target,
    by the law of sines: right while it is below 90 deg, folded back beyond."""

    def asin_azimuth_deg(sun_a, sun_z, target_a, target_z):
        gamma = math.radians(angle_sun_target_deg(sun_a, sun_z, target_a, target_z))
        zenith = math.radians(aim(sun_a, sun_z, target_a, target_z).zenith_deg)
        # Angle at the target between the zenith and the Sun.
        sine = math.sin(math.radians(sun_z)) * math.sin(math.radians(sun_a - target_a))
        at_target = sine / math.sin(gamma)
        turn = math.asin(math.sin(gamma / 2.0) * at_target / math.sin(zenith))
        return target_a + math.degrees(turn)

    assert asin_azimuth_deg(150.0, 40.0, 180.0, 80.0) == pytest.approx(
        aim(150.0, 40.0, 180.0, 80.0).azimuth_deg, abs=1e-9
    )
    beyond = aim(20.0, 70.0, 180.0, 50.0).azimuth_deg
    folded = asin_azimuth_deg(20.0, 70.0, 180.0, 50.0)
    assert abs(beyond - folded) > 10.0
    assert (beyond - 180.0) + (folded - 180.0) == pytest.approx(-180.0)


@settings(derandomize=True, max_examples=100)
@given(azimuths, sun_zeniths, azimuths, target_zeniths)
def test_targeting_undoes_aiming(sun_a, sun_z, target_a, target_z):
    """Section 6: target = reflection of the Sun in the known normal."""
    if angle_sun_target_deg(sun_a, sun_z, target_a, target_z) > 178.0:
        return
    found = aim(sun_a, sun_z, target_a, target_z)
    back = targeting(
        np.array([sun_a]),
        np.array([sun_z]),
        np.array([found.azimuth_deg]),
        np.array([found.zenith_deg]),
    )
    there = direction_enu(back.azimuth_deg, back.zenith_deg)
    assert float(angle_deg(there, direction_enu(target_a, target_z))) < 1e-9
    assert back.sigma_deg is None


def test_several_observations_are_averaged_and_say_how_well_they_agree():
    rng = np.random.default_rng(7)
    n = 400
    sun_a, sun_z = rng.uniform(90.0, 270.0, n), rng.uniform(20.0, 70.0, n)
    exact = bisector(direction_enu(sun_a, sun_z), direction_enu(200.0, 84.0))
    # 0.02 deg of the normal per component is 0.04 deg of the beam, in the plane of reflection.
    noisy = exact + np.radians(0.02) * rng.standard_normal((n, 3))
    found = targeting(sun_a, sun_z, *horizontal_deg(noisy))
    away = float(
        angle_deg(direction_enu(found.azimuth_deg, found.zenith_deg), direction_enu(200.0, 84.0))
    )
    assert found.rms_deg is not None
    assert found.sigma_deg is not None
    assert 0.02 < found.rms_deg < 0.045
    assert found.sigma_deg == pytest.approx(found.rms_deg / 20.0)
    assert away < 4.0 * found.sigma_deg
    assert len(found.residual_deg) == n


def test_three_feet_at_eight_hundred_turn_the_target():
    """Section 6: a 3 ft translation at 800 ft is 0.215 deg."""
    assert round(translation_deg(3.0, 800.0), 3) == 0.215


def test_a_mirror_facing_the_sun_sends_it_back():
    found = aim(135.0, 30.0, 135.0, 30.0)
    assert (found.azimuth_deg, found.zenith_deg) == pytest.approx((135.0, 30.0))
    assert found.incidence_deg == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (lambda: aim(90.0, 95.0, 180.0, 80.0), "5.00 deg below the horizon"),
        (lambda: aim(90.0, math.nan, 180.0, 80.0), "cannot be"),
        (lambda: aim(0.0, 60.0, 180.0, 120.0), "opposite"),
        (lambda: aim(0.0, 60.0, 180.0, 181.0), "target zenith"),
        (lambda: Target(500.0, 80.0, 1.0), "target azimuth"),
        (lambda: Target(180.0, 80.0, 0.0), "distance of the target"),
        (lambda: translation_deg(3.0, 0.0), "greater than zero"),
        (
            lambda: targeting(*(np.array([v]) for v in (90.0, 60.0, 270.0, 60.0))),
            "observation 1: the Sun is behind the mirror",
        ),
        (lambda: targeting(*(np.empty(0),) * 4), "at least one"),
        (
            lambda: targeting(
                np.array([90.0, 90.0]),
                np.array([45.0, 45.0]),
                np.array([90.0, 90.0]),
                np.array([1.0, 89.0]),
            ),
            "not of one target",
        ),
    ],
)
def test_what_no_mirror_can_do_is_answered_in_one_line(asked, said):
    with pytest.raises(ConfigurationError, match=said) as refusal:
        asked()
    assert "\n" not in str(refusal.value)
