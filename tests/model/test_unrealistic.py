"""'Parameters still unrealistic': the contract's rule, limit by limit."""

import pytest
from calibration_days import JUNE, points_of_day

from solarcal.model.fit import fit_linear
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import AxisLimits, Limits

MESSAGE = "Parameters still unrealistic"
WIDE = Limits(AxisLimits(-130.0, 130.0), AxisLimits(0.0, 90.0))


def message(limits: Limits | None = None, **truth: float) -> str | None:
    points = points_of_day("azel", JUNE, 10, truth=Coefficients(**truth))
    return fit_linear(points, limits=limits).message


@pytest.mark.parametrize(
    ("just_within", "just_beyond"),
    [
        ({"P1": 7.0, "P3": -7.0}, {"P1": 7.1, "P3": -7.1}),
        ({"P1": 9.9}, {"P1": -10.1}),
    ],
)
def test_lean_is_limited_to_ten_degrees(
    just_within: dict[str, float], just_beyond: dict[str, float]
) -> None:
    assert message(**just_within) is None
    assert message(**just_beyond) == MESSAGE


def test_zeros_are_limited_to_thirty_degrees() -> None:
    # An azimuth zero is small on sky only near the zenith: within such limits alone 29 deg pass.
    zenith = Limits(AxisLimits(-130.0, 130.0), AxisLimits(0.0, 25.0))
    assert message(limits=zenith, P2=29.9) is None
    assert message(limits=zenith, P2=30.1) == MESSAGE
    assert message(P4=-30.1) == MESSAGE


@pytest.mark.parametrize("name", ["P5", "P6"])
def test_scales_are_limited_to_five_percent(name: str) -> None:
    # The zero takes back what the scale does in the middle of the range.
    zero = {"P5": {}, "P6": {"P4": 0.049 * 45.0}}[name]
    assert message(**{name: 0.049}, **zero) is None
    assert message(**{name: 0.051}, **zero) == MESSAGE


def test_a_correction_of_fifteen_degrees_is_judged_within_limits() -> None:
    assert message(P4=14.9) is None
    assert message(P4=15.1) == MESSAGE
    # 0.04 of 180 deg and 9 deg of zero: too much only where the axis can really go that far.
    assert message(limits=WIDE, P2=-9.0, P5=0.04) is None
    far = Limits(AxisLimits(-179.0, 179.0), AxisLimits(0.0, 90.0))
    assert message(limits=far, P2=-9.0, P5=0.04) == MESSAGE


@pytest.mark.parametrize(("zero_deg", "scale"), [(15.5, 0.02), (13.9, -0.02)])
def test_a_correction_is_judged_at_both_ends_of_axis_2(zero_deg: float, scale: float) -> None:
    """P4 - P6*AX2 is 15.5 deg near one end of 2..88 deg and 13.9 deg near the other."""
    limits = Limits(AxisLimits(-130.0, 130.0), AxisLimits(2.0, 88.0))
    assert message(limits=limits, P4=zero_deg, P6=scale) == MESSAGE
    assert message(limits=limits, P4=zero_deg - 0.9, P6=scale) is None


def test_a_small_lean_is_realistic_although_the_zenith_is_within_limits() -> None:
    # In axis degrees the azimuth correction is unbounded there, on sky it is the lean.
    assert message(limits=WIDE, P1=1.0, P3=1.0) is None


def test_tpoint_terms_obey_the_same_rule_in_their_own_unit() -> None:
    points = points_of_day("azel", JUNE, 10, truth=Coefficients(P1=10.1))
    assert fit_linear(points, ("IA", "IE", "AN", "AW")).message == MESSAGE
    fine = points_of_day("azel", JUNE, 10, truth=Coefficients(P1=0.5))
    assert fit_linear(fine, ("IA", "IE", "AN", "AW")).message is None


def test_two_hours_around_noon_are_still_unrealistic() -> None:
    points = points_of_day("tiltroll-ew", JUNE, 3, noise_deg=0.05, hours=0.5)
    assert fit_linear(points).message == MESSAGE
