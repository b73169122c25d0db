"""Azimuth and elevation as native axes, on whatever turn the rotator has."""

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import AxisLimits, MountGeometry
from solarcal.station.software_controller.controller_model import AzElAxes

UPPER = AxisLimits(0.0, 90.0)


def axes(low, high, centre=0.0, elevation=UPPER):
    return AzElAxes("azel", centre, AxisLimits(low, high), elevation)


@pytest.mark.parametrize("centre", [0.0, 180.0])
@pytest.mark.parametrize("turn", [(0.0, 360.0), (-180.0, 180.0), (-180.0, 540.0), (0.0, 450.0)])
def test_directions_are_those_of_the_native_frame_and_come_back(turn, centre):
    here = axes(*turn, centre)
    geometry = MountGeometry("azel", 35.0, centre)
    for ax1 in np.arange(centre - 179.5, centre + 180.0, 7.25):
        azimuth, elevation = here.direction_deg(float(ax1), 35.5)
        assert turn[0] <= azimuth <= turn[1]
        expected1, expected2 = geometry.axes_from_horizontal(azimuth, 90.0 - elevation)
        assert (float(expected1), float(expected2)) == pytest.approx((float(ax1), 35.5), abs=1e-9)
        assert here.reading_deg((azimuth, elevation)) == pytest.approx((float(ax1), 35.5), abs=1e-9)


def test_east_south_west_of_a_plain_rotator():
    here = axes(0.0, 360.0)
    assert here.direction_deg(90.0, 60.0) == (90.0, 30.0)
    assert here.direction_deg(0.0, 60.0) == (180.0, 30.0)
    assert here.direction_deg(-90.0, 60.0) == (270.0, 30.0)


def test_a_turn_with_overlap_prefers_the_plain_azimuth():
    assert axes(0.0, 450.0).direction_deg(120.0, 45.0) == (60.0, 45.0)
    assert axes(0.0, 450.0).reading_deg((420.0, 45.0)) == (120.0, 45.0)


@pytest.mark.parametrize(
    ("turn", "centre", "limits"),
    [
        ((0.0, 360.0), 0.0, (-180.0, 180.0)),
        ((-180.0, 540.0), 0.0, (-180.0, 180.0)),
        # In the South the Sun passes North: a stop there parts the day, but both halves are there.
        ((0.0, 360.0), 180.0, (0.0, 360.0)),
        ((-180.0, 180.0), 180.0, (0.0, 360.0)),
        ((90.0, 270.0), 0.0, (-90.0, 90.0)),
        ((-90.0, 90.0), 180.0, (90.0, 270.0)),
        # An overlap alone: from 370 to 400 deg is from 10 to 40.
        ((370.0, 400.0), 0.0, (140.0, 170.0)),
        # A gap in the branch: the longer part.
        ((30.0, 320.0), 180.0, (0.0, 150.0)),
    ],
)
def test_limits_are_what_the_rotator_reaches_of_the_branch(turn, centre, limits):
    reach = axes(*turn, centre).limits.axis1
    assert (reach.low_deg, reach.high_deg) == pytest.approx(limits, abs=1e-5)


def test_it_is_never_sent_over_the_zenith_or_beyond_its_range():
    here = axes(0.0, 360.0, elevation=AxisLimits(-10.0, 180.0))
    assert here.limits.axis2 == AxisLimits(0.0, 100.0)
    assert axes(0.0, 360.0).direction_deg(-180.0 - 5e-7, -5e-7) == (360.0, 90.0)


def test_other_mounts_and_a_rotator_without_room_are_refused():
    with pytest.raises(ConfigurationError, match="a tiltroll-ew mount cannot be driven"):
        AzElAxes("tiltroll-ew", 0.0, AxisLimits(0.0, 360.0), UPPER)
    with pytest.raises(ConfigurationError, match="give axis 2 no range"):
        axes(0.0, 360.0, elevation=AxisLimits(91.0, 170.0))
    with pytest.raises(ConfigurationError, match="are not a valid range"):
        axes(2000.0, 2100.0)
