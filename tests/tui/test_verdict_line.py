"""The line of the verdict: which reason it gives, and what it leaves out where room is short."""

from types import SimpleNamespace

import pytest

from solarcal.model.verdict import Verdict, sure_sentence
from solarcal.stopping_rule import StoppingRule
from solarcal.tui.workstation.lines import verdict_words

SESSION = SimpleNamespace(uploads=(), checks=(), accepted=(1, 2))
PASSED = "leave-one-out rms 0.020 deg (limit 0.1 deg)"
WAITING = "the last 2 points changed the forecast by 0.074 deg rms (limit 0.05 deg)"


def judged(state, probability, *reasons):
    """A judgement of so much, its reasons in the order of the verdict; '' is the forecast's."""
    forecast = SimpleNamespace(
        rule=StoppingRule(),
        year_p95_deg=0.063,
        probability_within_tolerance=probability,
        sure=probability >= 0.95,
        sure_words=f"{100 * probability:.0f} % sure (95 % needed)",
    )
    told = tuple(reason or sure_sentence(forecast) for reason in reasons)
    return SimpleNamespace(verdict=Verdict(state, told), forecast=forecast)


def line(judgement, width=200, rows=2):
    words = verdict_words(SESSION, judgement)
    return " ".join(row.plain for row in words.fitted(width, rows))


def test_where_the_probability_decides_the_one_needed_is_said_and_no_limit_that_is_kept():
    text = line(judged("continue", 0.9, "", PASSED))
    assert "90 % sure (95 % needed) of 0.1 deg" in text
    assert "limit" not in text
    assert "[3: reasons]" in text


@pytest.mark.parametrize("state", ["continue", "does_not_fit"])
def test_where_something_else_decides_it_is_said(state):
    assert WAITING in line(judged(state, 0.97, WAITING, "", PASSED))


def test_in_one_row_of_a_small_terminal_the_figures_are_whole():
    text = line(judged("continue", 0.49, "", PASSED), width=78, rows=1)
    assert "49 % sure (95 % needed) of 0.1 deg. Year 95 %: 0.063 deg." in text
    assert "CONTINUE." in text
