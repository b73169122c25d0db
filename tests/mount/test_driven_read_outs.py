"""What any controller computes: ideal + E + O, within limits, rounded as it stores them."""

import numpy as np
import pytest

from solarcal.mount.controller import (
    ControllerModel,
    commanded_error_deg,
    ideal_and_elevation_deg,
    ideal_axes_deg,
)
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.site import Site
from solarcal.timescale import parse_utc

SITE = Site(35.05, -106.48, 1830.0)
GEOMETRY = MountGeometry("azel", SITE.latitude_deg)
NOON = parse_utc("2026-06-03T19:00:00Z")
LIMITS = Limits(AxisLimits(-130.0, 130.0), AxisLimits(3.0, 88.0))
P = Coefficients(0.31234567, -0.36, 0.1, 0.05, 0.00041234567, -0.0006)
MODEL = ControllerModel(LIMITS, coefficients=P, offsets=Offsets(0.2, -0.1))


def test_the_target_is_ideal_plus_e_plus_o():
    e1, e2 = correction_deg(P, 20.0, 40.0)
    assert MODEL.target_deg(20.0, 40.0) == (20.0 + e1 + 0.2, 40.0 + e2 - 0.1)
    assert commanded_error_deg(P, MODEL.offsets, 20.0, 40.0) == (e1 + 0.2, e2 - 0.1)


def test_set_sun_offset_makes_the_read_outs_the_target():
    offsets = MODEL.offsets_at(20.0, 40.0, 21.5, 39.25)
    held = ControllerModel(LIMITS, coefficients=P, offsets=offsets)
    assert held.target_deg(20.0, 40.0) == pytest.approx((21.5, 39.25), abs=1e-12)


def test_arrays_and_floats_give_the_same_targets():
    ideal1, ideal2 = np.linspace(-90.0, 90.0, 7), np.linspace(20.0, 80.0, 7)
    both = np.stack(MODEL.target_deg(ideal1, ideal2))
    one = np.array(
        [MODEL.target_deg(float(a), float(b)) for a, b in zip(ideal1, ideal2, strict=True)]
    ).T
    np.testing.assert_allclose(both, one, atol=1e-12)


def test_it_holds_p_and_o_with_its_own_decimals_and_no_negative_zero():
    held = ControllerModel(LIMITS, 3, 5).holding(P, Offsets(0.12345, -0.00001))
    assert held.coefficients == Coefficients(0.312, -0.36, 0.1, 0.05, 0.00041, -0.0006)
    assert str(held.offsets.O2) == "0.0"
    assert held.holding(offsets=Offsets(1.0, 2.0)).coefficients == held.coefficients


def test_ideal_angles_and_elevation_are_of_the_same_sun():
    ax1, ax2, elevation = ideal_and_elevation_deg(GEOMETRY, SITE, np.array([NOON, NOON + 60.0]))
    assert ideal_axes_deg(GEOMETRY, SITE, NOON) == pytest.approx((ax1[0], ax2[0]), abs=1e-9)
    np.testing.assert_allclose(90.0 - ax2, elevation, atol=1e-9)


def test_limits_name_the_axis_that_is_beyond_and_clamp():
    assert LIMITS.beyond(20.0, 40.0) == ""
    assert LIMITS.beyond(140.0, 40.0) == "axis 1: 140.000 is beyond -130..130"
    assert LIMITS.beyond(0.0, 1.0) == "axis 2: 1.000 is beyond 3..88"
    assert [LIMITS.axis2.clamped_deg(a) for a in (1.0, 50.0, 99.0)] == [3.0, 50.0, 88.0]
