"""A slip of typing is noticed and named; an honest reading never is."""

from collections.abc import Mapping
from dataclasses import replace

import pytest
from hand_bench import MORNING, MOUNT, displayed, unit_model
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace as with_fields

from solarcal.mount.formula import Coefficients, Offsets
from solarcal.station.described_unit import TypedControllerModel as Model
from solarcal.station.typed.plausibility import (
    clock_doubts,
    key_in_doubts,
    reading_fit,
    reading_sheet_doubts,
)
from solarcal.station.typed.typo_hints import Fit, difference_named, reading_doubts

IN_FORCE = Coefficients(0.2, -0.35, 0.5, 0.2, 0.0008, -0.0006)
O1, O2 = -0.812, 0.357
COUNTS = with_fields(MOUNT, display="counts")


def said(
    held: Model,
    texts: dict[str, str],
    *,
    at_s: float = MORNING,
    offset_just_set: bool = True,
) -> str:
    doubts = reading_sheet_doubts(held, texts, at_s, offset_just_set=offset_just_set)
    return " ".join(doubt.sentence for doubt in doubts)


@pytest.fixture
def held() -> Model:
    return unit_model(coefficients=IN_FORCE)


@pytest.fixture
def shown(held: Model) -> dict[str, str]:
    return displayed(held, MORNING, O1, O2)


@given(
    minutes=st.integers(-120, 150),
    o1=st.floats(-2.0, 2.0),
    o2=st.floats(-2.0, 2.0),
    lag1=st.floats(-0.1, 0.1),
    lag2=st.floats(-0.1, 0.1),
    late_s=st.floats(-14.0, 14.0),
    counts=st.booleans(),
)
def test_an_honest_reading_is_never_doubted(
    minutes: int, o1: float, o2: float, lag1: float, lag2: float, late_s: float, counts: bool
) -> None:
    held = unit_model(COUNTS if counts else MOUNT, IN_FORCE)
    at_s = MORNING + 60.0 * minutes
    texts = displayed(held, at_s, round(o1, 3), round(o2, 3), (lag1, lag2))
    assert said(held, texts, at_s=at_s + late_s) == ""


def test_axes_exchanged(held: Model, shown: dict[str, str]) -> None:
    wrong = {**shown, "ax1": shown["ax2"], "ax2": shown["ax1"]}
    assert said(held, wrong).startswith("AX1 and AX2 exchanged?")


def test_offsets_exchanged(held: Model, shown: dict[str, str]) -> None:
    wrong = {**shown, "o1": shown["o2"], "o2": shown["o1"]}
    assert said(held, wrong).startswith("O1 and O2 exchanged?")


@pytest.mark.parametrize("field", ["ax1", "ax2", "o1", "o2"])
def test_a_sign(held: Model, shown: dict[str, str], field: str) -> None:
    right = shown[field]
    wrong = right[1:] if right.startswith("-") else f"-{right}"
    assert f"{field.upper()} typed {wrong}, the sign: {right}?" in said(
        held, {**shown, field: wrong}
    )


@pytest.mark.parametrize("field", ["ax1", "ax2"])
def test_two_digits_exchanged(held: Model, shown: dict[str, str], field: str) -> None:
    right = shown[field]
    wrong = right[1] + right[0] + right[2:]
    assert wrong != right
    sentence = said(held, {**shown, field: wrong})
    assert f"{field.upper()} typed {wrong}, two digits exchanged: {right}?" in sentence


def test_a_decimal_point_left_out(held: Model, shown: dict[str, str]) -> None:
    wrong = shown["ax2"].replace(".", "")
    assert f"AX2 typed {wrong}, no decimal point: {shown['ax2']}?" in said(
        held, {**shown, "ax2": wrong}
    )


def test_a_wrong_digit_that_matters(held: Model, shown: dict[str, str]) -> None:
    right = shown["ax1"]
    wrong = ("3" if right[0] != "3" else "4") + right[1:]
    assert f"AX1 typed {wrong}, a digit wrong: {right}?" in said(held, {**shown, "ax1": wrong})


def test_an_offset_that_was_not_really_set(held: Model) -> None:
    before = replace(held, offsets=Offsets(0.4, -0.3))
    texts = displayed(before, MORNING, 0.4, -0.3)
    sentence = said(before, {**texts, "o1": "-0.812", "o2": "0.357"})
    assert sentence.startswith("They fit the previous offsets")


def test_an_hour(held: Model) -> None:
    texts = displayed(held, MORNING + 3600.0, O1, O2)
    assert "a clock 1 h ahead" in said(held, texts)


def test_a_reading_of_another_time(held: Model) -> None:
    texts = displayed(held, MORNING - 12 * 60.0, O1, O2)
    assert "a reading 12 min earlier" in said(held, texts)


@pytest.mark.parametrize(("minutes", "when"), [(-45, "45 min earlier"), (45, "45 min later")])
def test_three_quarters_of_an_hour_is_the_most_that_is_recognised(
    held: Model, minutes: int, when: str
) -> None:
    texts = displayed(held, MORNING + 60.0 * minutes, O1, O2)
    assert f"a reading {when}" in said(held, texts)
    farther = displayed(held, MORNING + 60.0 * minutes * 47 / 45, O1, O2)
    assert "a reading" not in said(held, farther)


def test_the_units_clock_typed_with_the_reading(held: Model) -> None:
    texts = displayed(held, MORNING - 40.0, O1, O2)
    assert said(held, {**texts, "time": "08:59:20"}) == ""
    assert "it must have shown about 09:00:00" in said(held, {**texts, "time": "09:59:20"})


def test_what_no_slip_explains_is_said_in_degrees(held: Model, shown: dict[str, str]) -> None:
    texts = {**shown, "ax1": "12.34", "ax2": "81.11"}
    sentence = said(held, texts)
    assert "no single slip explains it" in sentence
    assert "AX1 by" in sentence
    assert "AX2 by" in sentence
    for field in ("ax1", "ax2"):
        one = {**shown, field: "12.34"}
        (doubt,) = reading_sheet_doubts(held, one, MORNING, offset_just_set=True)
        assert doubt.field == field
        assert doubt.sentence.startswith(f"{field.upper()} by ")


def test_offsets_typed_otherwise_a_moment_ago(held: Model) -> None:
    tracked = replace(held, offsets=Offsets(O1, O2))
    texts = displayed(tracked, MORNING, O1, O2)
    assert said(tracked, texts, offset_just_set=False) == ""
    sentence = said(tracked, {**texts, "o1": "-0.182"}, offset_just_set=False)
    assert "O1 was typed -0.182, two digits exchanged: -0.812 belongs there" in sentence
    assert "The read-outs fit what was typed before." in sentence
    before = replace(held, offsets=Offsets(-0.182, O2))
    assert "The read-outs fit what was typed now." in said(before, texts, offset_just_set=False)
    # A thousandth more or less fits as well, and nothing at all fits other read-outs.
    for other in ({"o1": "-0.811"}, {"o1": "-0.182", "ax2": "12.34"}):
        sentence = said(tracked, {**texts, **other}, offset_just_set=False)
        assert "as typed before." in sentence
        assert "read-outs fit" not in sentence
    swapped = {**texts, "o1": texts["o2"], "o2": texts["o1"]}
    assert said(tracked, swapped, offset_just_set=False).startswith("O1 and O2 exchanged?")


def test_beyond_a_limit() -> None:
    low = unit_model(with_fields(MOUNT, limits2_deg=(50.0, 88.0)), IN_FORCE)
    assert "beyond a software limit" in said(low, displayed(low, MORNING, O1, O2))


def test_counts_typed_wrong() -> None:
    held = unit_model(COUNTS, IN_FORCE)
    texts = displayed(held, MORNING, O1, O2)
    wrong = texts["ax1"].removeprefix("-")
    assert f"AX1 typed {wrong}, the sign: {texts['ax1']}?" in said(held, {**texts, "ax1": wrong})


def test_a_display_is_right_to_half_of_its_last_digit(held: Model, shown: dict[str, str]) -> None:
    fine = reading_fit(held, {**shown, "ax1": "45.000", "o1": "0.000"}, MORNING)
    for coarser in ({"ax1": "45"}, {"o1": "0"}):
        coarse = reading_fit(held, {**shown, "ax1": "45.000", "o1": "0.000", **coarser}, MORNING)
        wider = coarse.tolerance_deg[0] - fine.tolerance_deg[0]
        assert wider == pytest.approx(0.5 * (1.0 - 0.001))
        assert coarse.tolerance_deg[1] == fine.tolerance_deg[1]


def test_counts_that_no_screwjack_has_are_doubted() -> None:
    held = unit_model(with_fields(COUNTS, drive2="screwjack:40:12:2.5:70:1200:-"), IN_FORCE)
    texts = displayed(held, MORNING, O1, O2)
    assert said(held, texts) == ""
    off = said(held, {**texts, "ax2": f"{texts['ax2']}9"})
    assert off.startswith(f"no position of axis 2 has {texts['ax2']}9 counts; no single slip")
    sign = texts["ax2"].removeprefix("-")
    assert f"AX2 typed {sign}, the sign: {texts['ax2']}?" in said(held, {**texts, "ax2": sign})


def test_the_displays_sun_against_ours(held: Model, shown: dict[str, str]) -> None:
    sun1, sun2 = held.ideal_deg(MORNING)
    right = {**shown, "sun1": f"{sun1:.3f}", "sun2": f"{sun2:.3f}", "time": "09:00:00"}
    assert said(held, right) == ""
    other1, other2 = held.ideal_deg(MORNING + 3600.0)
    wrong = {**right, "sun1": f"{other1:.3f}", "sun2": f"{other2:.3f}"}
    assert "its clock or zone is wrong by +1 h" in said(held, wrong)
    for missing in ("sun1", "sun2"):
        (doubt,) = reading_sheet_doubts(held, {**right, missing: ""}, MORNING, offset_just_set=True)
        assert "Type both Sun angles" in doubt.sentence
        assert doubt.field == missing
    beside = {**right, "sun1": f"{sun1 + 0.03:.3f}", "sun2": f"{sun2 + 0.03:.3f}"}
    assert "deg from ours" in said(held, beside)


def test_a_clock_hours_off(held: Model) -> None:
    assert clock_doubts(held, {"clock": "09:00:03"}, MORNING) == ()
    (doubt,) = clock_doubts(held, {"clock": "10:00:01"}, MORNING)
    assert "by +1 h: daylight-saving time, or the zone (7 h west" in doubt.sentence
    (doubt,) = clock_doubts(held, {"clock": "09:15:00"}, MORNING)
    assert "by +900 s" in doubt.sentence


def test_a_clock_across_midnight(held: Model) -> None:
    assert clock_doubts(held, {"clock": "23:59:58"}, MORNING - 9 * 3600.0) == ()


def test_typed_back_exactly_or_not() -> None:
    wanted = (("P1", "+0.2890"), ("P5", "-0.000154"), ("O1", "0.0000"))
    same = {"p1": "0.289", "p5": "-.000154", "o1": "0", "stored": "yes"}
    assert key_in_doubts(wanted, same) == ()
    (doubt,) = key_in_doubts(wanted, {**same, "p1": "0.2980"})
    assert "P1 was typed 0.2980, two digits exchanged: +0.2890 belongs there" in doubt.sentence
    (doubt,) = key_in_doubts(wanted, {**same, "stored": "no"})
    assert "lost when the unit is switched off" in doubt.sentence


@pytest.mark.parametrize(
    ("typed", "wanted", "what"),
    [
        ("-0.5", "0.5", "the sign"), ("5", "0.5", ""), ("0.05", "0.5", "the decimal point"),
        ("0.21", "0.12", "two digits exchanged"),
    ],
)  # fmt: skip
def test_how_a_value_came_to_differ(typed: str, wanted: str, what: str) -> None:
    sentence = difference_named("O1", typed, wanted)
    assert f"{wanted} belongs there" in sentence
    assert what in sentence


@pytest.mark.parametrize(("tolerances", "named"), [(2.9, False), (3.1, True)])
def test_a_wrong_digit_is_looked_for_where_it_moves_the_reading_by_three_tolerances(
    tolerances: float, named: bool
) -> None:
    """Where a unit of it is worth less, some digit or other explains any error."""
    tolerance_deg = 1.0 / tolerances
    texts = {"ax1": "42.0", "ax2": "10.0", "o1": "0.0", "o2": "0.0"}

    def off_deg(tried: Mapping[str, str], shift_s: float) -> tuple[float, float]:
        return float(tried["ax1"]) - 45.0 + 90.0 * (shift_s != 0.0), 0.0

    (doubt,) = reading_doubts(Fit(off_deg, (tolerance_deg, 1.0)), texts)
    assert ("AX1 typed 42.0, a digit wrong: 45.0?" in doubt.sentence) == named
    assert ("no single slip explains it" in doubt.sentence) != named
