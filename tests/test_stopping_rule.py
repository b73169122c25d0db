"""The words of the stopping rule: probabilities and limits beside each other."""

import pytest

from solarcal.errors import ConfigurationError
from solarcal.stopping_rule import StoppingRule, apart_from, percent


@pytest.mark.parametrize(
    ("probability", "needed", "words"),
    [
        (0.902, 0.95, "90 %"),
        (0.9497, 0.95, "94.97 %"),
        (1.0, 0.95, "more than 99.5 %"),
        (0.0, 0.95, "less than 0.5 %"),
        # A thousand draws cannot show more.
        (1.0, 0.9995, "more than 99.9 %"),
        (0.999, 0.9995, "99.9 %"),
        (0.996, 0.9995, "99.6 %"),
    ],
)
def test_a_probability_reads_on_its_side_of_the_limit_and_never_as_certainty(
    probability, needed, words
):
    assert percent(probability, needed) == words


def test_a_rounded_value_does_not_cross_its_limit():
    assert apart_from(0.1004, 0.1) == "0.1004"
    assert apart_from(99.9, 99.95, 0) == "99.9"
    assert apart_from(0.1, 0.1) == "0.100"


@pytest.mark.parametrize("probability", [0.49, 1.0])
def test_a_probability_that_cannot_be_needed_is_refused_with_the_range_taken(probability):
    StoppingRule(probability=0.9995)
    with pytest.raises(ConfigurationError, match=r"give at least 0\.5 and less than 1"):
        StoppingRule(probability=probability)
