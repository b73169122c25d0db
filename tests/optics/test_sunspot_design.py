"""Designing a sunspot device, and finding out what it adds of its own."""

import math

import pytest

from solarcal.errors import ConfigurationError
from solarcal.optics.sunspot import (
    design_for,
    design_from_size,
    spot_error_deg,
    two_position_check,
)


def test_a_device_shows_what_its_design_promises():
    """At the largest error the spot's far edge lies on the plate's rim (10-physics, 5)."""
    device = design_from_size(500.0, 4.0, 120.0, 0.5)
    # F = 2H = 1000 mm, the Sun 9.3 mrad across.
    assert device.spot == pytest.approx(4.0 + 9.306, abs=0.01)
    assert device.even_rim == pytest.approx(0.5 * 9.306, abs=0.01)
    edge = 0.5 * (device.plate - device.hole)
    seen = spot_error_deg(500.0, 4.0, device.spot, edge)
    assert seen == pytest.approx(device.range_deg)
    nudged = spot_error_deg(500.0, 4.0, device.spot, device.even_rim + 0.5)
    assert nudged == pytest.approx(device.resolution_deg)


def test_the_device_for_a_wish_fulfils_it():
    device = design_for(0.02, 1.5, 4.0, 0.5)
    assert device.resolution_deg == pytest.approx(0.02)
    assert device.range_deg == pytest.approx(1.5)
    assert device.height == pytest.approx(0.5 * 0.5 / math.tan(math.radians(0.02)))


def test_the_range_ends_at_small_angles():
    assert design_from_size(10.0, 1.0, 100.0, 0.5).range_deg == pytest.approx(math.degrees(0.1))


def test_turning_the_device_tells_its_error_from_the_trackers():
    """Device 0.03 deg off, tracker -0.1 deg: the marks read -0.07, and 0.13 turned by 180 deg."""
    found = two_position_check(-0.1 + 0.03, 0.1 + 0.03)
    assert found == pytest.approx((0.03, -0.1))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (lambda: design_from_size(0.0, 4.0, 120.0, 0.5), "height H"),
        (lambda: design_from_size(500.0, 4.0, 12.0, 0.5), "too small"),
        (lambda: design_for(0.0, 1.0, 4.0, 0.5), "resolution"),
        (lambda: design_for(0.02, 8.0, 4.0, 0.5), "5.7 deg"),
        (lambda: design_for(2.0, 1.0, 4.0, 0.5), "coarser"),
        (lambda: design_for(0.02, 1.0, -4.0, 0.5), "hole"),
    ],
)
def test_a_device_that_cannot_be_is_answered_in_one_line(asked, said):
    with pytest.raises(ConfigurationError, match=said):
        asked()
