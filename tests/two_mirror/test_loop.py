"""Steps, PID, the watch over the signs, the spiral, and the way past the zenith."""

import math

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.two_mirror.control import (
    GrowthWatch,
    Pid,
    PidGains,
    ZenithPassage,
    beside,
    sense_of_turn,
    spiral_deg,
    step_rate_deg_s,
    ziegler_nichols,
)
from solarcal.two_mirror.mirrors import direction_components

SUN_DEG_S = 15.0 / 3600.0


def test_a_step_is_the_sign_of_the_error_times_k() -> None:
    """Section 6: 'control by fixed steps sgn(.)k'."""
    assert step_rate_deg_s(0.3, 0.01, SUN_DEG_S, 2.0) == 0.005
    assert step_rate_deg_s(-1e-5, 0.01, SUN_DEG_S, 2.0) == -0.005
    assert step_rate_deg_s(0.0, 0.01, SUN_DEG_S, 2.0) == 0.0


def test_a_step_must_keep_up_with_the_sun() -> None:
    """'step at least the Sun's rate times the update period'."""
    assert step_rate_deg_s(1.0, SUN_DEG_S * 2.0, SUN_DEG_S, 2.0) == pytest.approx(SUN_DEG_S)
    with pytest.raises(ConfigurationError, match="less than the Sun moves"):
        step_rate_deg_s(1.0, SUN_DEG_S * 1.99, SUN_DEG_S, 2.0)


def test_ziegler_nichols_gains_of_section_6() -> None:
    """Kp = 0.6 Kc, Ki = 2 Kp/Tc, Kd = Kp Tc/8."""
    gains = ziegler_nichols(2.0, 4.0)
    assert gains.kp == pytest.approx(1.2)
    assert gains.ki == pytest.approx(0.6)
    assert gains.kd == pytest.approx(0.6)


def test_pid_holds_a_moving_sun_without_lag() -> None:
    """The integral takes over the Sun's rate; proportional control alone stays behind by
    rate/Kp."""

    def left_deg(gains: PidGains) -> float:
        pid, axis, sun = Pid(gains, 1.0, 1.0), 0.0, 0.0
        for _ in range(400):
            rate = pid.rate_deg_s(sun - axis)
            axis += rate
            sun += SUN_DEG_S
        return abs(sun - axis)

    assert left_deg(PidGains(0.5)) == pytest.approx(SUN_DEG_S / 0.5)
    assert left_deg(PidGains(0.5, 0.1, 0.1)) < 1e-6


def test_pid_takes_over_a_moving_axis_without_a_jump() -> None:
    pid = Pid(PidGains(0.5, 0.1, 0.3), 1.0, 1.0)
    pid.begin(SUN_DEG_S)
    assert pid.rate_deg_s(0.0) == SUN_DEG_S


def test_the_integral_stands_while_the_axis_can_do_no_more() -> None:
    """After a minute at its limit the axis stops as soon as it is there."""
    pid = Pid(PidGains(0.5, 0.2), 1.0, 0.1)
    for _ in range(60):
        assert pid.rate_deg_s(10.0) == 0.1
    assert pid.rate_deg_s(0.0) == 0.0


def test_an_error_that_grows_over_five_steps_is_noticed() -> None:
    watch = GrowthWatch()
    grown = [0.1 * 1.6**n for n in range(8)]
    assert [watch.growing(error) for error in grown] == [False] * 5 + [True] * 3
    assert "sign" in watch.sentence()


def test_noise_and_a_single_setback_are_not() -> None:
    watch = GrowthWatch()
    errors = np.abs(np.random.default_rng(3).standard_normal(5000)) * 0.1
    assert not any(watch.growing(error) for error in errors)
    watch.forget()
    assert not any(watch.growing(e) for e in (1.0, 1.5, 2.0, 2.5, 3.0, 2.9, 3.4, 3.9, 4.4, 4.9))


def test_the_spiral_leaves_no_gap() -> None:
    """Every direction within the limit comes into the field of some look."""
    field, limit = 0.573, 6.0
    looks = np.array(list(spiral_deg(field, limit)))
    rng = np.random.default_rng(5)
    radius, turn = limit * np.sqrt(rng.random(4000)), rng.random(4000) * 2.0 * math.pi
    places = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)
    nearest = np.linalg.norm(places[:, None, :] - looks[None, :, :], axis=2).min(axis=1)
    assert nearest.max() < field


def test_the_spiral_grows_from_the_centre_and_ends() -> None:
    radii = [math.hypot(x, y) for x, y in spiral_deg(0.5, 3.0)]
    assert radii == sorted(radii)
    assert radii[0] == 0.0
    assert 3.0 < radii[-1] < 3.6


@pytest.mark.parametrize("t2", [0.5, 30.0, 85.0])
def test_a_look_is_as_far_off_as_asked_for_whatever_the_zenith_angle(t2: float) -> None:
    centre = direction_components(50.0, t2)
    for x, y in ((2.0, 0.0), (0.0, -2.0), (1.2, 1.6), (0.0, 0.0)):
        look = beside(50.0, t2, x, y)
        apart = math.degrees(math.acos(min(1.0, float(np.dot(centre, look)))))
        assert apart == pytest.approx(math.hypot(x, y), abs=1e-6)
    farther = beside(50.0, t2, 1.0, 0.0)
    assert farther == pytest.approx(direction_components(50.0, t2 + 1.0))


def test_the_sense_of_turn_crosses_the_branch() -> None:
    assert sense_of_turn([170.0, 178.0, -175.0, -160.0]) == 1
    assert sense_of_turn([-170.0, -178.0, 175.0, 160.0]) == -1


def test_the_passage_never_turns_back() -> None:
    """Neither where the calculation wavers nor where the axis is ahead at the entry."""
    path = [100.0, 120.0, 160.0, -150.0, -110.0, -95.0]
    passage = ZenithPassage(101.0, path)
    asked = [passage.azimuth_deg(a) for a in (100.0, 120.0, 119.0, 160.0, -150.0, -151.0, -95.0)]
    assert asked == [101.0, 120.0, 120.0, 160.0, 210.0, 210.0, 265.0]
    assert passage.rate_deg_s(215.0, 210.0, 1.0) == 0.0
    assert passage.rate_deg_s(200.0, 210.0, 2.0) == 5.0
