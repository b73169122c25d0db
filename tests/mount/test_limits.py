"""How far the axes may go, and how near they are."""

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import AxisLimits, Limits

LIMITS = Limits(AxisLimits(-120.0, 150.0), AxisLimits(5.0, 88.0))


def test_distance_is_to_the_nearer_end_and_negative_outside():
    axis = AxisLimits(-120.0, 150.0)
    assert axis.distance_deg(140.0) == 10.0
    assert axis.distance_deg(-119.0) == 1.0
    assert axis.distance_deg(151.5) == -1.5
    assert type(axis.distance_deg(140.0)) is float
    np.testing.assert_allclose(axis.distance_deg(np.array([140.0, -121.0])), [10.0, -1.0])


def test_distance_of_a_mount_is_that_of_its_nearer_axis():
    assert LIMITS.distance_deg(0.0, 80.0) == 8.0
    assert LIMITS.distance_deg(149.0, 80.0) == 1.0
    np.testing.assert_allclose(
        LIMITS.distance_deg(np.array([0.0, 155.0]), np.array([90.0, 40.0])), [-2.0, -5.0]
    )


@pytest.mark.parametrize(("low", "high"), [(10.0, 10.0), (20.0, -20.0), (float("nan"), 5.0)])
def test_limits_without_room_are_refused(low, high):
    with pytest.raises(ConfigurationError, match="leave the axis no range"):
        AxisLimits(low, high)
