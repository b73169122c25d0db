"""Two 45-degree mirrors: 10-physics.md section 6, 'Two 45-degree mirrors, altazimuth'."""

import math

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import maths_for, unit_vector
from solarcal.two_mirror.mirrors import (
    MOVING_MIRROR,
    EulerBase,
    axes_of,
    direction,
    direction_components,
    fixed_mirrors_matrix,
    mirror_matrix,
    ray_from_sky,
    ray_to_sky,
    sun_axes_deg,
    tracker_matrix,
)

EVERYWHERE = [(t1, t2) for t1 in (-170.0, -60.0, 0.0, 25.0, 140.0) for t2 in (0.0, 3.0, 50.0, 89.0)]


def test_the_moving_mirrors_have_the_normal_of_section_6() -> None:
    """M_R = I - 2nn^T, n = (0, 1, -1)/sqrt 2."""
    n = np.array([0.0, 1.0, -1.0]) / math.sqrt(2.0)
    np.testing.assert_allclose(MOVING_MIRROR, np.eye(3) - 2.0 * np.outer(n, n), atol=1e-15)


def test_at_the_zenith_nothing_is_turned() -> None:
    """'checked: M(0,0) = I'."""
    np.testing.assert_allclose(tracker_matrix(0.0, 0.0), np.eye(3), atol=1e-15)


@pytest.mark.parametrize(("t1", "t2"), EVERYWHERE)
def test_the_third_column_is_the_pointing_direction(t1: float, t2: float) -> None:
    """'third column = pointing direction', in the native azel frame of mount.geometry."""
    native = unit_vector(maths_for(t1, t2), np.radians(t1), np.radians(t2))
    np.testing.assert_allclose(tracker_matrix(t1, t2)[:, 2], native, atol=1e-14)


@pytest.mark.parametrize(("t1", "t2"), EVERYWHERE)
def test_two_reflections_are_a_rotation(t1: float, t2: float) -> None:
    matrix = tracker_matrix(t1, t2)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(matrix) == pytest.approx(1.0)


@pytest.mark.parametrize(("t1", "t2"), EVERYWHERE)
def test_each_reflection_is_one_in_a_real_mirror(t1: float, t2: float) -> None:
    """A ray traced mirror by mirror: the first turns with t1, the second with t1 and t2."""
    about_z = np.array(
        [
            [math.cos(math.radians(t1)), -math.sin(math.radians(t1)), 0.0],
            [math.sin(math.radians(t1)), math.cos(math.radians(t1)), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    about_y = np.array(
        [
            [math.cos(math.radians(t2)), 0.0, math.sin(math.radians(t2))],
            [0.0, 1.0, 0.0],
            [-math.sin(math.radians(t2)), 0.0, math.cos(math.radians(t2))],
        ]
    )
    first = about_z @ np.array([0.0, 1.0, -1.0])
    second = about_z @ about_y @ np.array([0.0, 1.0, -1.0])
    for ray in np.eye(3):
        between = ray - 2.0 * first * (first @ ray) / 2.0
        out = between - 2.0 * second * (second @ between) / 2.0
        np.testing.assert_allclose(tracker_matrix(t1, t2) @ ray, out, atol=1e-14)


@pytest.mark.parametrize(("t1", "t2"), EVERYWHERE)
def test_the_loops_plain_floats_are_the_matrix(t1: float, t2: float) -> None:
    ray = (0.003, -0.004, 1.0)
    out = ray_to_sky(ray, t1, t2)
    np.testing.assert_allclose(out, tracker_matrix(t1, t2) @ ray, atol=1e-14)
    np.testing.assert_allclose(ray_from_sky(out, t1, t2), ray, atol=1e-14)


def test_small_euler_angles_are_p1_p2_p3() -> None:
    """'to first order gamma = P3, beta = P1, alpha = P2', s_tracker = M s."""
    small = 1e-4
    for angles, p in (
        (EulerBase(small, 0.0, 0.0), Coefficients(P2=small)),
        (EulerBase(0.0, small, 0.0), Coefficients(P1=small)),
        (EulerBase(0.0, 0.0, small), Coefficients(P3=small)),
    ):
        for ax1, ax2 in ((20.0, 35.0), (110.0, 60.0), (-75.0, 80.0)):
            t1, t2 = angles.axes_deg(ax1, ax2)
            e1, e2 = correction_deg(p, ax1, ax2)
            assert t1 - ax1 == pytest.approx(e1, abs=1e-8)
            assert t2 - ax2 == pytest.approx(e2, abs=1e-8)


def test_the_base_is_rx_ry_rz_and_its_angles_come_back() -> None:
    """M = Rx(gamma) Ry(beta) Rz(alpha); and the axis angles of the floats are those of M."""
    base = EulerBase(9.96, 0.888, 0.174)
    back = EulerBase.of_matrix(base.matrix())
    assert (back.alpha_deg, back.beta_deg, back.gamma_deg) == pytest.approx((9.96, 0.888, 0.174))
    seen = base.matrix() @ direction(40.0, 55.0)
    assert base.axes_deg(40.0, 55.0) == pytest.approx(axes_of((seen[0], seen[1], seen[2])))


def test_the_sun_in_the_frame_south_east_up() -> None:
    """Azimuth 90 (East) is AX1 = 90; the North is AX1 = 180; t2 is the zenith angle."""
    assert sun_axes_deg(90.0, 30.0) == (90.0, 30.0)
    np.testing.assert_allclose(
        direction_components(*sun_axes_deg(0.0, 90.0)), (-1.0, 0.0, 0.0), atol=1e-15
    )


def test_fixed_mirrors_multiply_in_the_order_of_the_ray() -> None:
    first, second = (1.0, 0.0, -1.0), (0.0, 2.0, 1.0)
    np.testing.assert_allclose(
        fixed_mirrors_matrix([first, second]), mirror_matrix(first) @ mirror_matrix(second)
    )
    np.testing.assert_array_equal(fixed_mirrors_matrix([]), np.eye(3))


def test_bad_input_is_answered_in_one_line() -> None:
    for wrong, said in (
        (lambda: mirror_matrix((0.0, 0.0, 0.0)), "zero length"),
        (lambda: mirror_matrix((0.0, 1.0)), "three numbers"),
        (lambda: axes_of((0.0, 0.0, 0.0)), "zero length"),
        (lambda: sun_axes_deg(10.0, 90.5), "below the horizon"),
        (lambda: sun_axes_deg(math.nan, 10.0), "must be numbers"),
    ):
        with pytest.raises(ConfigurationError, match=said) as told:
            wrong()
        assert "\n" not in str(told.value)
