"""The sunspot device: edge distances to angles."""

import math

import pytest

from solarcal.errors import ConfigurationError
from solarcal.optics.sunspot import spot_error_deg


def test_an_even_rim_means_no_error() -> None:
    assert spot_error_deg(500.0, 4.0, 13.0, 4.5) == 0.0


def test_the_light_travels_twice_the_height() -> None:
    """A spot 1 mm too far at H = 500 mm: atan(1 / 1000)."""
    assert spot_error_deg(500.0, 4.0, 13.0, 5.5) == pytest.approx(math.degrees(math.atan(1e-3)))


def test_opposite_edges_give_opposite_errors() -> None:
    """The two edges of one spot sum to twice the even rim."""
    assert spot_error_deg(500.0, 4.0, 13.0, 6.0) == pytest.approx(
        -spot_error_deg(500.0, 4.0, 13.0, 3.0)
    )


def test_the_unit_of_length_does_not_matter() -> None:
    assert spot_error_deg(0.5, 0.004, 0.013, 0.0055) == pytest.approx(
        spot_error_deg(500.0, 4.0, 13.0, 5.5)
    )


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ((0.0, 4.0, 13.0, 5.0), "height H"),
        ((500.0, -4.0, 13.0, 5.0), "diameter Do"),
        ((500.0, 4.0, math.nan, 5.0), "diameter Ds"),
        ((500.0, 4.0, 13.0, math.inf), "edge distance E"),
        ((0.5, 4.0, 13.0, 5.5), "same unit"),
    ],
)
def test_readings_no_device_gives_are_named(
    readings: tuple[float, float, float, float], said: str
) -> None:
    with pytest.raises(ConfigurationError, match=said):
        spot_error_deg(*readings)
