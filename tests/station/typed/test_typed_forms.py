"""What is typed, read as it is meant."""

import pytest
from hand_bench import SetClock

from solarcal.errors import ProcedureRefused
from solarcal.station.typed.entry_forms import (
    came_field,
    reading_fields,
    ref_check_form,
    sun_fields,
)
from solarcal.station.typed.forms import (
    AskedForm,
    DisplayField,
    Kind,
    TypedAnswer,
    TypedWrong,
    WaitingDisplay,
    decimals,
    looked_again,
    plain_text,
)


def value(kind: Kind, text: str) -> object:
    return DisplayField("x", "X", kind).value(text)


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("43.21", 43.21), ("43,21", 43.21), (" -0,5 ", -0.5), ("+7", 7.0), ("−12.5", -12.5),
        (".25", 0.25), ("12°", 12.0), ("-0", 0.0),
    ],
)  # fmt: skip
def test_degrees_with_comma_sign_and_whatever_a_keyboard_has(text: str, degrees: float) -> None:
    assert value(Kind.DEGREES, text) == degrees


@pytest.mark.parametrize("text", ["4 3", "nan", "inf", "1e5", "4.3.2", "--1", "x", "1,2,3"])
def test_what_is_no_number_is_refused_with_its_label(text: str) -> None:
    with pytest.raises(TypedWrong, match=r"X: .* is not a number of degrees") as refused:
        value(Kind.DEGREES, text)
    assert refused.value.field == "x"


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("08:15:30", 29730.0), ("8:15:30", 29730.0), ("081530", 29730.0), ("08.15.30", 29730.0),
        ("23:59:59.5", 86399.5), ("00:00:00", 0.0),
    ],
)  # fmt: skip
def test_times_as_clocks_show_them(text: str, seconds: float) -> None:
    assert value(Kind.TIME, text) == pytest.approx(seconds)


@pytest.mark.parametrize("text", ["24:00:00", "12:60:00", "12:00", "noon"])
def test_what_no_clock_shows(text: str) -> None:
    with pytest.raises(TypedWrong, match="is not a time"):
        value(Kind.TIME, text)


def test_counts_are_whole_senses_are_signs_answers_are_words() -> None:
    assert value(Kind.COUNTS, "-119880") == -119880
    with pytest.raises(TypedWrong, match="whole number"):
        value(Kind.COUNTS, "12.5")
    assert [value(Kind.SENSE, sign) for sign in "+-"] == [1, -1]
    assert [value(Kind.YES_NO, word) for word in ("y", "YES", "no")] == [True, True, False]


def test_only_an_optional_field_may_stay_empty() -> None:
    assert DisplayField("x", "X", optional=True).value("  ") is None
    with pytest.raises(TypedWrong, match="X: is missing"):
        DisplayField("x", "X").value("")


def test_what_cannot_be_meant_is_refused() -> None:
    with pytest.raises(TypedWrong, match="31 is not between -30 and 30"):
        DisplayField("o1", "O1", low=-30.0, high=30.0).value("31")
    # No read-out and no Sun is further than a turn and a half from zero.
    for shown in (*reading_fields(counts=False), *sun_fields(shown=True)):
        assert (shown.value("540"), shown.value("-540")) == (540.0, -540.0)
        for beyond in ("540.5", "-540.5"):
            with pytest.raises(TypedWrong, match="is not between -540 and 540"):
                shown.value(beyond)


def test_the_digits_stay_as_they_were_typed() -> None:
    assert plain_text("−0,310 ") == "-0.310"
    assert [decimals(text) for text in ("12", "12,5", "0.310")] == [0, 1, 3]


def test_a_correction_of_both_axes_is_another_look() -> None:
    before = {"ax1": "1", "ax2": "2", "o1": "0"}
    assert looked_again(before, {"ax1": "1.5", "ax2": "2.1", "o1": "0"})
    assert not looked_again(before, {"ax1": "1.5", "ax2": "2", "o1": "3"})


FORM = ref_check_form()
ANSWERS = [
    TypedAnswer(FORM, {"complete": word}, utc_s) for word, utc_s in (("yes", 1.0), ("no", 2.0))
]


def test_a_form_has_one_answer_the_first() -> None:
    asked = AskedForm(FORM, SetClock())
    assert not asked.done
    for answer in (*ANSWERS, None):
        asked.answer(answer)
    assert asked.done
    assert asked.wait() == ANSWERS[0]
    given_up = AskedForm(FORM, SetClock())
    given_up.answer(None)
    given_up.answer(ANSWERS[0])
    with pytest.raises(ProcedureRefused):
        given_up.wait()


def test_a_display_that_waits_asks_no_more_once_it_is_closed() -> None:
    posted: list[AskedForm] = []

    def post(asked: AskedForm) -> None:
        posted.append(asked)
        assert display.asking
        if len(posted) == 1:
            asked.answer(ANSWERS[0])
        else:
            display.close()

    display = WaitingDisplay(post, SetClock(7.0))
    assert not display.asking
    assert display.ask(FORM) == ANSWERS[0]
    assert (posted[0].form, posted[0].clock.utc_s()) == (FORM, 7.0)
    assert not display.asking
    # The form that waits when it is closed is given up; after that none is shown.
    for _ in range(2):
        with pytest.raises(ProcedureRefused):
            display.ask(FORM)
    assert len(posted) == 2
    assert posted[1].done
    WaitingDisplay(post, SetClock()).close()


@pytest.mark.parametrize(("sense", "forward"), [(1, "+"), (-1, "-")])
def test_from_behind_is_the_suns_sense(sense: int, forward: str) -> None:
    field = came_field(2, sense)
    assert (field.name, field.hint) == ("came2", f"{forward} is from behind; empty: not known")
