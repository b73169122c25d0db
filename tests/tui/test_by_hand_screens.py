"""A unit by hand in the workstation: forms over the procedure's own dialogs."""

import re
from pathlib import Path

import pytest
from procedure_bench import (
    LARGE,
    SMALL,
    keys_beside_each_other,
    on_loop,
    screen_words,
    settled_text,
    shows,
    until,
)
from test_procedure_goldens import compare, only_dialog
from textual.pilot import Pilot
from textual.widgets import Input
from typed_screens import NOON, displayed, fill, type_in, workstation_by_hand

from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.records import PointRecord, Typed
from solarcal.station.news import StatusRead
from solarcal.station.procedure import Station
from solarcal.tui.dialogs.link import ClockDialog
from solarcal.tui.dialogs.ref_check import TypedRefCheckDialog
from solarcal.tui.dialogs.report import ReportDialog
from solarcal.tui.dialogs.upload import UploadDialog
from solarcal.tui.offset.spot import TypedOffsetDialog

SET = displayed(NOON)
O1, O2 = SET[2:]
ON_SUN = dict(zip(("ax1", "ax2", "o1", "o2"), SET, strict=True))


def recorded(station: Station, kind: type) -> list:
    return [record for record in station.session.records if isinstance(record, kind)]


async def ask_for_an_offset(pilot: Pilot[int]) -> None:
    await pilot.press("f6")
    await shows(pilot, "Set Sun Offset, at the unit")
    await pilot.press("enter")
    await shows(pilot, "Axis 1 came last in sense")
    await until(pilot, lambda: isinstance(pilot.app.focused, Input))


async def ask_for_a_point(pilot: Pilot[int]) -> None:
    await pilot.press("f7")
    for words in ("1. Did", "2. Did", "3. Do"):
        await shows(pilot, words)
        await pilot.press("y")
    await shows(pilot, "Type what the display shows")
    # The question's own screen says so too, before the form is there.
    await until(pilot, lambda: isinstance(pilot.app.focused, Input))


@on_loop
async def test_a_point_by_keys_alone_with_a_slip_noticed_and_put_right() -> None:
    async with workstation_by_hand(offset_set=True) as (_, pilot, station, clock):
        await ask_for_a_point(pilot)
        ax1, ax2, *_ = displayed(clock.now_s, (float(O1), float(O2)))
        # With a decimal comma, and the sign of O1 wrong.
        wrong = O1.removeprefix("-")
        await type_in(pilot, ax1.replace(".", ","), ax2, wrong, O2, "")
        await shows(pilot, f"O1 was typed {wrong}, the sign: {O1} belongs there as typed before.")
        await shows(pilot, "The read-outs fit what was typed before.", "Keep as typed")
        # It stands in the field that was doubted, selected: typing replaces it.
        await type_in(pilot, O1)
        await shows(pilot, "Store it?")
        await pilot.press("y")
        await until(pilot, lambda: station.session.accepted)
    (point,) = recorded(station, PointRecord)
    assert point.error_deg == (float(O1), float(O2))
    assert point.basis == "sun_offset"
    last = recorded(station, Typed)[-1]
    assert (last.form, last.values["ax1"], last.values["o1"]) == ("point", ax1, O1)
    assert [before["o1"] for before in last.corrected] == [wrong]


@on_loop
async def test_a_reference_check_with_the_mouse_where_the_display_shows_no_counts() -> None:
    async with workstation_by_hand() as (_, pilot, station, _clock):
        await pilot.press("f5")
        await shows(pilot, "Reference check, at the unit")
        await pilot.click("#key-type")
        await shows(pilot, "Did both reach their switches", "at the first check and")
        await fill(pilot, complete="yes", found1="3")
        await pilot.click("#key-done")
        await shows(pilot, "Type the counts of both axes, or of none.")
        await fill(pilot, found1="")
        await pilot.click("#key-done")
        await shows(pilot, "recorded: counts not shown by the unit")
    assert station.session.ref_checks[0].difference_counts is None


@on_loop
async def test_what_is_doubted_can_be_kept_and_that_is_in_the_record() -> None:
    async with workstation_by_hand() as (_, pilot, station, _clock):
        await ask_for_an_offset(pilot)
        await fill(pilot, **{**ON_SUN, "ax1": ON_SUN["ax2"], "ax2": ON_SUN["ax1"]})
        await pilot.press("ctrl+w")
        await shows(pilot, "AX1 and AX2 exchanged?")
        await pilot.press("f3")
        await until(pilot, lambda: station.session.sun_offsets)
    assert "AX1 and AX2 exchanged?" in recorded(station, Typed)[-1].kept[0]


@on_loop
async def test_a_wrong_text_keeps_its_field_and_escape_gives_up_only_the_second_time() -> None:
    async with workstation_by_hand() as (_, pilot, station, _clock):
        await ask_for_an_offset(pilot)
        await type_in(pilot, "4x3")
        await shows(pilot, "'4x3' is not a number of degrees")
        await pilot.press("escape")
        await shows(pilot, "Escape again cancels")
        await pilot.press("escape")
        await shows(pilot, "given up: nothing was typed")
    assert not station.session.sun_offsets
    assert [record.form for record in recorded(station, Typed)] == ["open"]


@on_loop
async def test_stop_says_where_it_is_on_every_screen_and_asks_nothing() -> None:
    async with workstation_by_hand() as (_, pilot, station, _clock):
        await shows(pilot, "STOP is at the unit", "TYPED BY HAND", "No connection to this unit")
        await pilot.press("f12")
        await shows(pilot, "PRESS STOP ON THE UNIT: there is no line to it")
        await ask_for_an_offset(pilot)
        await shows(pilot, "STOP: at the unit")
        await pilot.press("f12")
        await shows(pilot, "PRESS STOP ON THE UNIT: there is no line to it")
    assert len(recorded(station, Typed)) == 1


@on_loop
async def test_the_status_asks_nothing_and_shows_how_old_the_typed_is() -> None:
    async with workstation_by_hand(offset_set=True) as (app, pilot, station, clock):
        clock.wait(630.0)
        app.station_worker().submit(StatusRead, lambda station: station.poll())
        await shows(pilot, "typed as read at 17:00:00 UTC, 12 min ago")
    words = [record.form for record in recorded(station, Typed)]
    assert words == ["open", "clock", "reference", "offset"]


@on_loop
async def test_another_look_at_the_axes_takes_the_moment_anew() -> None:
    async with workstation_by_hand() as (_, pilot, station, clock):
        await ask_for_an_offset(pilot)
        await fill(pilot, ax1="1", ax2="2", o1=O1, o2=O2)
        await pilot.press("ctrl+w")
        await shows(pilot, "no single slip explains it")
        clock.wait(300.0)
        ax1, ax2, *_ = displayed(clock.now_s, (float(O1), float(O2)))
        await fill(pilot, ax1=ax1, ax2=ax2)
        await pilot.press("enter")
        await until(pilot, lambda: station.session.sun_offsets)
    assert station.session.sun_offsets[0].read_utc == "2026-06-03T17:05:00.000Z"


@on_loop
async def test_the_clock_is_compared_at_the_press_of_enter() -> None:
    async with workstation_by_hand() as (_, pilot, station, clock):
        await pilot.press("f10")
        await shows(pilot, "Set the unit's")
        await pilot.press("enter")
        await shows(pilot, "type a time it is ABOUT to show")
        await fill(pilot, clock="10:00:30")
        clock.wait(29.5)
        await pilot.press("enter")
        await shows(pilot, "Set and recorded: unit - laptop was +0.000 s, is +0.500 s")
    assert station.session.clock_sets[0].after_s == 0.5


@on_loop
async def test_coefficients_are_keyed_in_and_typed_back() -> None:
    async with workstation_by_hand(points=3) as (_, pilot, station, _clock):
        await pilot.press("f8")
        await shows(pilot, "type them back. Upload?", "Key in and type back")
        assert "Write and read back" not in screen_words(pilot.app)
        await pilot.press("y")
        await shows(pilot, "not DONE", "once more", "Against it")
        await pilot.press("y")
        await shows(pilot, "Key in the coefficients", "O2 key in")
        compare("by-hand-key-in", SMALL, only_dialog(await settled_text(pilot)))
        wanted = dict(re.findall(r"([PO]\d) +key in +([-+.\d]+)", screen_words(pilot.app)))
        assert len(wanted) == 8
        typed = {name.lower(): value for name, value in wanted.items()}
        await fill(pilot, **{**typed, "p3": "9" + typed["p3"][2:]})
        await pilot.press("ctrl+w")
        await shows(pilot, f"{wanted['P3']} belongs there", "key it in again")
        await fill(pilot, p3=typed["p3"])
        await pilot.press("ctrl+w")
        await shows(pilot, "read back EQUAL")
    (upload,) = station.session.uploads
    assert upload.verified
    values = upload.new_coefficients.as_tuple()
    assert values == tuple(float(wanted[f"P{i}"]) for i in range(1, 7))


@on_loop
async def test_after_a_check_both_offsets_are_set_back_before_it_is_stored() -> None:
    # Nothing but zeros were keyed in, so that the display shows what it showed before.
    nothing = Coefficients()
    async with workstation_by_hand(points=1, uploaded=nothing, offset_set=True) as opened:
        _, pilot, station, clock = opened
        await pilot.press("f7")
        await shows(pilot, "a check point, or one more data point?")
        await pilot.press("c")
        for words in ("1. Did", "2. Did", "3. Do"):
            await shows(pilot, words)
            await pilot.press("y")
        await shows(pilot, "Type what the display shows")
        o1, o2 = (f"{offset:.3f}" for offset in (-1.144, -0.188))
        ax1, ax2, *_ = displayed(clock.now_s, (float(o1), float(o2)))
        await fill(pilot, ax1=ax1, ax2=ax2, o1=o1, o2=o2)
        await pilot.press("ctrl+w")
        await shows(pilot, "Store it?")
        await pilot.press("y")
        await shows(pilot, "Set both offsets back", "O2 key in 0.0000")
        assert not station.session.checks
        await fill(pilot, o1="0", o2="0")
        await pilot.press("ctrl+w")
        await until(pilot, lambda: station.session.checks)
    assert station.session.checks[0].error_deg == (-1.144, -0.188)
    assert station.tracker.stored().offsets == Offsets()


@pytest.mark.parametrize("size", [SMALL, LARGE])
@on_loop
async def test_the_form_of_a_point_with_a_doubt(size: tuple[int, int]) -> None:
    async with workstation_by_hand(size, offset_set=True) as (_, pilot, _station, clock):
        await ask_for_a_point(pilot)
        ax1, ax2, *_ = displayed(clock.now_s, (float(O1), float(O2)))
        await fill(pilot, ax1=ax1, ax2=ax2, o1=O1.removeprefix("-"), o2=O2)
        await pilot.press("ctrl+w")
        await shows(pilot, "Keep as typed", "Looked at")
        compare("by-hand-point", size, only_dialog(await settled_text(pilot)))


@on_loop
async def test_the_workstation() -> None:
    async with workstation_by_hand(SMALL, offset_set=True) as (_, pilot, _station, _clock):
        await shows(pilot, "typed as read at")
        top = (await settled_text(pilot)).splitlines()[:22]
        compare("by-hand-now", SMALL, "\n".join(line[:60] for line in top))


@on_loop
async def test_initialise_near_a_limit_is_refused_for_the_sun_not_asked_and_all_buttons_show() -> (
    None
):
    async with workstation_by_hand() as (_, pilot, station, clock):
        clock.now_s += 10.0 * 3600.0
        station.poll()
        await pilot.press("f3")
        await shows(pilot, "for this Sun the axes lie", "deg beyond a limit", "Override")
        assert "Are you sure?" not in screen_words(pilot.app)
        assert "-" not in screen_words(pilot.app).split("axes lie")[1].split("a limit")[0]


@on_loop
async def test_the_keys_of_a_dialog_stand_beside_each_other_whatever_it_offers(
    tmp_path: Path,
) -> None:
    async with workstation_by_hand() as (app, pilot, _, _clock):
        dialogs = (
            ClockDialog(),
            UploadDialog(),
            ReportDialog(tmp_path / "day.jsonl"),
            TypedOffsetDialog(),
            TypedRefCheckDialog(),
        )
        for dialog in dialogs:
            await app.push_screen(dialog)
            await pilot.pause()
            offered = [key.action for key in dialog.KEYS if key.button and key.action != "use"]
            await keys_beside_each_other(pilot, dialog, offered)
            dialog.dismiss(None)
            await pilot.pause()


@on_loop
async def test_set_sun_offset_of_a_typed_unit_computes_a_jog_and_says_so_on_its_key() -> None:
    async with workstation_by_hand() as (_, pilot, _station, _clock):
        await pilot.press("f6")
        await shows(pilot, "moves and sets nothing", "j: compute the jog", "Compute the jog")
