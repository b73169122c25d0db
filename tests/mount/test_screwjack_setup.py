"""Setting up a screwjack from tape and inclinometer (10-physics, section 5)."""

import math

import msgspec
import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import ScrewjackDrive
from solarcal.mount.screwjack_setup import (
    Measured,
    dead_points_deg,
    fit_beta,
    measured,
    reach_deg,
    wrong_length,
)

JACK = ScrewjackDrive(R1=30.0, R2=20.0, R3=1.5, beta_deg=90.0, counts_per_length=4000.0)
UNSET = msgspec.structs.replace(JACK, beta_deg=0.0)


def observed(jack: ScrewjackDrive, *angles_deg: float) -> list[Measured]:
    return [Measured(a, jack.length(a)) for a in angles_deg]


def test_the_three_parameters_are_those_of_the_physics():
    """Section 5: SJP3 = R1^2+R2^2-R3^2, SJP2 = -2 R1 R2, and beta = acos((L^2-SJP3)/SJP2) - S."""
    length = 35.0
    setup = fit_beta(UNSET, [Measured(10.0, length)])
    sjp3, sjp2 = 30.0**2 + 20.0**2 - 1.5**2, -2.0 * 30.0 * 20.0
    assert (sjp3, sjp2) == (setup.drive.SJP3, setup.drive.SJP2)
    assert (
        pytest.approx(math.degrees(math.acos((length**2 - sjp3) / sjp2)) - 10.0) == setup.drive.SJP1
    )
    assert setup.consistent is None
    assert setup.beta_sigma_deg is None


@pytest.mark.parametrize("sign", [-1, 1])
def test_two_angles_agree_on_beta(sign):
    jack = msgspec.structs.replace(JACK, sign=sign)
    setup = fit_beta(msgspec.structs.replace(jack, beta_deg=0.0), observed(jack, -40.0, 35.0))
    assert setup.drive.beta_deg == pytest.approx(90.0, abs=1e-9)
    assert setup.spread_deg < 1e-9
    assert setup.consistent


def test_a_length_between_the_pins_is_brought_onto_the_tube():
    """Section 5: L^2 = L1^2 - R3^2."""
    pins = math.hypot(JACK.length(20.0), 1.5)
    assert measured(20.0, pins, 1.5, pin_to_pin=True).length == pytest.approx(JACK.length(20.0))
    assert measured(20.0, pins, 1.5, pin_to_pin=False).length == pins


def test_tape_noise_is_averaged_and_shown():
    rng = np.random.default_rng(3)
    noisy = [
        Measured(one.angle_deg, one.length + 0.02 * float(rng.standard_normal()))
        for one in observed(JACK, *np.linspace(-60.0, 60.0, 9).tolist())
    ]
    setup = fit_beta(UNSET, noisy)
    assert setup.consistent
    assert setup.beta_sigma_deg is not None
    assert 0.005 < setup.beta_sigma_deg < 0.05
    assert abs(setup.drive.beta_deg - 90.0) < 3.0 * setup.beta_sigma_deg
    assert setup.explanations == ()


def test_the_sigma_of_beta_is_that_of_the_mean_of_two_lengths():
    """Off by +e and -e at practically one angle: s = e sqrt(2), of their mean s / sqrt(2) = e."""
    first, second = observed(JACK, 20.0, 20.001)
    off = [first._replace(length=first.length + 0.01), second._replace(length=second.length - 0.01)]
    per_deg = abs(JACK.length(20.5) - JACK.length(19.5))
    assert fit_beta(UNSET, off).beta_sigma_deg == pytest.approx(0.01 / per_deg, rel=1e-3)


def test_a_wrong_length_shows_in_the_betas_and_is_named():
    """R1 measured half an inch short: three observations contradict each other."""
    short = msgspec.structs.replace(UNSET, R1=29.5)
    observations = observed(JACK, -55.0, -10.0, 20.0, 60.0)
    setup = fit_beta(short, observations)
    assert setup.consistent is False
    assert setup.explanations[0].name == "R1"
    assert setup.explanations[0].change == pytest.approx(0.5, abs=1e-3)
    assert setup.explanations[0].rms < 1e-4
    # Of all betas the fitted one leaves least: beside it the lengths' residuals are larger.
    least = sum(residual**2 for residual in setup.length_residuals)
    for beside in (-0.01, 0.01):
        other = msgspec.structs.replace(setup.drive, beta_deg=setup.drive.beta_deg + beside)
        left = sum((one.length - other.length(one.angle_deg)) ** 2 for one in observations)
        assert left > least


def test_the_wrong_sense_is_named():
    turned = msgspec.structs.replace(UNSET, sign=1)
    close = fit_beta(turned, observed(JACK, -10.0, 5.0, 20.0))
    assert close.consistent is False
    assert close.explanations[0].name == "sense"
    with pytest.raises(ConfigurationError, match="with the other sense they agree"):
        fit_beta(turned, observed(JACK, -55.0, -10.0, 20.0, 60.0))


def test_another_sense_is_not_named_where_it_explains_nothing_either():
    turned = msgspec.structs.replace(UNSET, sign=1)
    wrong = observed(JACK, -55.0, -10.0, 20.0, 60.0)
    wrong[0] = wrong[0]._replace(length=wrong[0].length + 2.0)
    # Twice as long as both arms: no triangle closes, whatever the sense.
    for lengths in (wrong, [*wrong[:3], Measured(60.0, 100.0)]):
        with pytest.raises(ConfigurationError) as refused:
            fit_beta(turned, lengths)
        assert "other sense" not in str(refused.value)


def test_the_dead_points_lie_where_the_triangle_is_flat():
    low, high = dead_points_deg(JACK)
    assert (low, high) == (-90.0, 90.0)
    lowest, highest = reach_deg(JACK)
    # Nearly flat: the jack is nearly R1 - R2 and R1 + R2 long (but for the tube's offset).
    assert JACK.length(lowest) == pytest.approx(math.sqrt(10.0**2 - 1.5**2), abs=1e-3)
    assert JACK.length(highest) == pytest.approx(math.sqrt(50.0**2 - 1.5**2), abs=1e-3)


def test_a_tube_offset_larger_than_the_pivots_gap_ends_the_reach_earlier():
    jack = ScrewjackDrive(R1=20.0, R2=19.0, R3=5.0, beta_deg=0.0, counts_per_length=1.0)
    lowest, _ = reach_deg(jack)
    assert lowest > 1.0
    assert jack.length(lowest) < 0.02
    with pytest.raises(ConfigurationError, match="cannot close"):
        jack.length(lowest - 0.01)


def test_five_millimetres_of_R1_bend_the_tracking():
    """An offset and a scale take most of it away, and leave what no P1..P6 can."""
    true = msgspec.structs.replace(JACK, R1=30.0 + 5.0 / 25.4)
    angles = np.linspace(-70.0, 70.0, 141)
    effect = wrong_length(true, JACK, 66.0, angles)
    at_reference = wrong_length(true, JACK, 66.0, np.array([65.0, 66.0]))
    assert at_reference.error_deg[1] == pytest.approx(0.0, abs=1e-9)
    assert 0.1 < np.abs(effect.error_deg).max() < 0.2
    assert 0.02 < np.abs(effect.left_deg).max() < np.abs(effect.error_deg).max()
    again = effect.offset_deg + effect.scale * angles + effect.left_deg
    assert again == pytest.approx(effect.error_deg)
    assert wrong_length(JACK, JACK, 66.0, angles).error_deg == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (lambda: fit_beta(UNSET, []), "measure it at two"),
        (lambda: fit_beta(UNSET, [Measured(0.0, 60.0)]), "cannot close"),
        (lambda: measured(0.0, 0.0, 1.5, pin_to_pin=False), "greater than zero"),
        (lambda: measured(0.0, 1.0, 1.5, pin_to_pin=True), "longer than the tube"),
    ],
)
def test_a_triangle_that_cannot_be_is_answered_in_one_line(asked, said):
    with pytest.raises(ConfigurationError, match=said) as refusal:
        asked()
    assert "\n" not in str(refusal.value)


def test_lengths_at_one_angle_cannot_contradict_each_other():
    with pytest.raises(ConfigurationError, match="measure one at another angle"):
        fit_beta(JACK, [Measured(0.0, 30.0), Measured(0.0, 30.0)])
