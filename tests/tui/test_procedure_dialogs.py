"""Reference check, initialise, clock, note, void and link: by their keys, on an emulated unit."""

import contextlib
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from procedure_bench import (
    LARGE,
    SMALL,
    bench,
    keys_beside_each_other,
    on_loop,
    screen_text,
    screen_words,
    settled_text,
    shows,
    take_points,
    unreferenced_bench,
    until,
    workstation,
)
from textual.widgets import Input

from solarcal.config import Choice
from solarcal.errors import ProcedureRefused
from solarcal.session.journal import Journal
from solarcal.session.records import Closed, Note, Override, Void
from solarcal.session.view import read_session
from solarcal.session.voids import live_records
from solarcal.station.news import SpeedTold, StateChanged, StepFailed, Stopped
from solarcal.station.opening import OpenLine
from solarcal.station.state import Activity, LinkState
from solarcal.tui.action_handlers import ACTION_HANDLERS
from solarcal.tui.base import Told
from solarcal.tui.dialogs.link import ClockDialog, LinkDialog
from solarcal.tui.dialogs.ref_check import RefCheckDialog, ref_check_words
from solarcal.tui.keys import ACTIONS
from solarcal.tui.plan import PlanScreen
from solarcal.unit.tracker import Mode

SCREEN_KEYS = ("f2", "f3", "f5", "f6", "f7", "f8", "f9", "f10", "x", "n")


def test_every_action_of_the_table_does_something() -> None:
    assert set(ACTION_HANDLERS) == {action.id for action in ACTIONS} - {"stop"}


@on_loop
async def test_every_screen_fits_a_large_terminal_and_shows_stop_and_the_way_out() -> None:
    """That it fits the smallest: ``test_every_screen.py``."""
    station, _ = bench()
    station.initialise(confirmed=True)
    async with workstation(station, LARGE) as (app, pilot):
        for key in SCREEN_KEYS:
            at = len(app.screen_stack)
            await pilot.press(key)
            await until(pilot, lambda at=at: len(app.screen_stack) == at + 1)
            await shows(pilot, "STOP", "Esc")
            assert all(len(line) <= LARGE[0] for line in screen_text(app).splitlines())
            await pilot.press("escape")
            await until(pilot, lambda at=at: len(app.screen_stack) == at)


@on_loop
async def test_a_key_that_comes_too_early_is_seen_not_to_be_taken() -> None:
    """A fast y before its question is on the screen does nothing, and that is shown."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("u")
        await shows(pilot, "0 accepted points")
        assert "not taken" not in screen_words(app)
        await pilot.press("y")
        await shows(pilot, "y not taken: not asked yet")
        await pilot.press("b")
        await shows(pilot, "b not taken: not asked yet")
        await until(pilot, lambda: "not taken" not in screen_words(app))
    assert station.session.uploads == ()


@on_loop
async def test_without_a_unit_the_keys_say_so() -> None:
    from solarcal.tui.app import SolarcalApp

    app = SolarcalApp()
    async with app.run_test(size=SMALL) as pilot:
        app.action_perform("ref_check")
        await shows(pilot, "no unit is connected")
        assert len(app.screen_stack) == 1


@on_loop
async def test_stop_works_on_a_modal_and_with_a_field_focused() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("n")
        await until(pilot, lambda: isinstance(app.focused, Input))
        await pilot.press("ctrl+s")
        await shows(pilot, "STOPPED")
        assert station.poll().mode is Mode.STOP


@on_loop
async def test_a_click_on_stop_is_a_stop() -> None:
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes")
        await pilot.click("KeyButton.-stop")
        await shows(pilot, "STOPPED")


@on_loop
async def test_a_reference_check_runs_and_shows_the_difference() -> None:
    station, cable = bench()
    cable.emulator.lose_counts(1, 25)
    async with workstation(station) as (app, pilot):
        await pilot.press("alt+f5")
        await shows(pilot, "Start: drive")
        await pilot.press("enter")
        await shows(pilot, "counts were missed")
        assert [check.number for check in station.session.ref_checks] == [1, 2]
        await pilot.press("t")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert station.poll().mode is Mode.TRACK


@on_loop
async def test_the_first_check_after_a_restart_may_find_any_number() -> None:
    station, cable = bench()
    cable.emulator.reboot()
    async with workstation(station) as (app, pilot):
        await until(pilot, lambda: station.session.restarts != ())
        await pilot.press("alt+f5")
        await shows(pilot, "Start: drive")
        await pilot.press("enter")
        await shows(pilot, "Check no. 2 complete", "any number is normal after a restart.")
        assert "missed" not in screen_words(app)
    first, check = station.session.ref_checks
    assert first.seq < station.session.restarts[0].seq < check.seq
    assert check.difference_counts is not None
    assert max(map(abs, check.difference_counts)) > 100
    assert ref_check_words(check, station.session)[1] == "good"


@on_loop
async def test_the_keys_of_a_unit_without_switches_stand_beside_each_other_too() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        dialog = RefCheckDialog(switches=False)
        await app.push_screen(dialog)
        await keys_beside_each_other(pilot, dialog, ["start", "track"])


@on_loop
async def test_a_running_check_shows_how_far_it_is_and_the_time_that_is_left() -> None:
    """By the read-outs: 40 deg in 20 s, so 60 deg more are about 30 s."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5")
        await shows(pilot, "Start: drive")
        state, unit = station.state, station.session.header.unit
        status = state.live.status
        assert status is not None
        for seconds, to_go, words in (
            (0.0, 100.0, "[..............................] 0 % 100 deg to go. STOP"),
            (20.0, 60.0, "[############..................] 40 % 60 deg to go, about 30 s. STOP"),
            (35.0, 30.0, "[#####################.........] 70 % 30 deg to go, about 15 s. STOP"),
        ):
            seen = msgspec.structs.replace(
                status,
                mode=Mode.REF,
                unit_utc_s=status.unit_utc_s + seconds,
                reading1_deg=unit.reference1_deg - to_go,
                reading2_deg=unit.reference2_deg - 0.5 * to_go,
            )
            app.screen.show_state(
                replace(state, activity=Activity.REF_CHECK, live=replace(state.live, status=seen))
            )
            await shows(pilot, f"Reference check running {words}")


@on_loop
async def test_a_reference_check_that_runs_is_accelerated_from_its_dialog() -> None:
    """At x1 it takes a minute and a half; nobody waits for it here."""
    station, _ = bench()
    station.tracker.emulation.set_speed(1.0)
    async with workstation(station) as (app, pilot):
        await until(pilot, lambda: app.emulated_speed == 1.0)
        await pilot.press("f5")
        await shows(pilot, "Start: drive", "time x1 [+ -]")
        await pilot.press("enter")
        await shows(pilot, "deg to go")
        await pilot.press("plus", "plus", "plus", "plus", "plus", "plus")
        await shows(pilot, "time x120 [+ -]")
        await shows(pilot, "Check no. 2 complete")
        assert app.emulated_speed == 120.0


@on_loop
async def test_initialise_asks_and_no_changes_nothing() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f3")
        await shows(pilot, "Are you sure?")
        await pilot.press("n")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert station.session.initialised is None
        await pilot.press("i")
        await shows(pilot, "Are you sure?")
        await pilot.press("y")
        await until(pilot, lambda: station.session.initialised is not None)


@on_loop
async def test_near_a_limit_initialise_is_refused_with_the_distance_and_overruled_by_a_reason() -> (
    None
):
    station, _ = bench(None, "unit.limits1_deg=[-128.0, 85.2]")
    async with workstation(station) as (_, pilot):
        await pilot.press("f3")
        await shows(pilot, "0.50 deg from a limit", "Override, with a reason")
        # What must be refused is not asked.
        assert "Are you sure?" not in screen_words(pilot.app)
        assert "Yes, begin" not in screen_words(pilot.app)
        await pilot.press("o", *"dust", "enter")
        await until(pilot, lambda: station.session.initialised is not None)
        overrides = [r for r in station.session.records if isinstance(r, Override)]
        assert [r.reason for r in overrides] == ["dust"]


@on_loop
async def test_where_initialise_is_refused_near_a_limit_the_key_of_another_step_leads_on() -> None:
    station, _ = bench(None, "unit.limits1_deg=[-128.0, 85.2]")
    async with workstation(station) as (app, pilot):
        await pilot.press("f3")
        await shows(pilot, "deg from a limit", "Override, with a reason")
        await pilot.press("f6")
        await shows(pilot, "Set here")
        assert len(app.screen_stack) == 2
    assert station.session.initialised is None


@on_loop
async def test_initialise_again_keeps_the_file_and_starts_another(tmp_path: Path) -> None:
    first, second = tmp_path / "day.jsonl", tmp_path / "day-2.jsonl"
    station, _ = bench(first)
    station.initialise(confirmed=True)
    async with workstation(station) as (app, pilot):
        app.line = OpenLine(
            station,
            Choice(),
            first,
            contextlib.ExitStack(),
            lambda header: Journal.create(second, header),
            station.clock,
        )
        await pilot.press("f3")
        await shows(pilot, "AGAIN closes this file", "day.jsonl")
        await pilot.press("y")
        await until(pilot, lambda: station.session_path == second)
        app.line = None
    kept, new = read_session(first), read_session(second)
    assert isinstance(kept.records[-1], Closed)
    assert kept.records[-1].next == "day-2.jsonl"
    assert new.header.continues == "day.jsonl"


@on_loop
async def test_the_clock_is_set_with_a_time_tick() -> None:
    station, _ = bench(None, "truth.unit_offset_s=7.0")
    async with workstation(station) as (_, pilot):
        await pilot.press("f10")
        await shows(pilot, "Unit - laptop", "emulator's")
        await pilot.press("tab", *"0.8", "enter")
        await pilot.press("enter")
        await shows(pilot, "needs its uncertainty")
        await pilot.press(*"0.2", "enter")
        await shows(pilot, "Set and recorded")
        last = station.session.clock_sets[-1]
        assert (last.tick_minus_laptop_s, last.tick_sigma_s) == (0.8, 0.2)
        assert last.after_s == pytest.approx(0.8, abs=0.01)


@on_loop
async def test_the_pip_of_a_full_minute_fills_the_fields() -> None:
    station, _ = bench()
    station.tracker.emulation.advance(59.0 - station.clock.utc_s() % 60.0)
    async with workstation(station) as (_, pilot):
        await pilot.press("k")
        await shows(pilot, "full minute")
        await pilot.press("m")
        await shows(pilot, "Signal - laptop +1.00 s")


@on_loop
async def test_a_number_that_is_none_is_named_and_kept() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        sets = len(station.session.clock_sets)
        await pilot.press("k")
        await shows(pilot, "Time tick")
        await pilot.press("tab", *"later", "enter", *"1", "enter")
        await shows(pilot, "'later' is not a number")
        assert "later" in screen_words(app)
        assert len(station.session.clock_sets) == sets


@on_loop
async def test_a_note_is_in_the_file_before_the_dialog_goes(tmp_path: Path) -> None:
    path = tmp_path / "noted.jsonl"
    station, _ = bench(path)
    async with workstation(station) as (app, pilot):
        await pilot.press("n")
        await until(pilot, lambda: isinstance(app.focused, Input))
        await pilot.press(*"gusty")
        await pilot.press("enter")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        last = read_session(path).records[-1]
        assert isinstance(last, Note)
        assert last.text == "gusty"


@pytest.mark.parametrize("by_itself", [False, True])
@on_loop
async def test_a_record_is_struck_and_restored(by_itself: bool) -> None:
    station, _ = bench()
    take_points(station, 1)
    point = station.session.accepted[-1]
    below = len([r for r in station.session.records if r.seq > point.seq])
    async with workstation(station) as (app, pilot):
        await pilot.press("x")
        await shows(pilot, "Void a record")
        await pilot.press(*["down"] * below, "enter")
        await shows(pilot, f"Why is record {point.seq} struck?")
        await pilot.press(*"shade", "enter")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert station.session.accepted == ()
        await pilot.press("x")
        await shows(pilot, "Void a record")
        # By what strikes it, as by the record itself.
        await pilot.press(*["down"] * (below + 1) * by_itself, "enter")
        await shows(pilot, f"Why is record {point.seq} restored?")
        await pilot.press(*"no", "enter")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert station.session.accepted == (point,)
        voids = [r for r in station.session.records if isinstance(r, Void)]
        assert [v.reason for v in voids] == ["shade", "no"]
        assert point in live_records(station.session.records)


@on_loop
async def test_without_a_record_nothing_is_offered_to_be_struck_until_there_is_one() -> None:
    station, _ = unreferenced_bench()
    assert station.session.records == ()
    async with workstation(station) as (app, pilot):
        await pilot.press("x")
        await shows(pilot, "Void a record", "Nothing is recorded yet", "STOP")
        assert "Strike it" not in screen_words(app)
        await pilot.press("enter")
        assert "Why is record" not in screen_words(app)
        station.note("haze")
        await shows(pilot, "haze", "Strike it")


@on_loop
async def test_a_lost_link_is_said_in_a_dialog_and_nothing_typed_is_lost() -> None:
    station, cable = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("n")
        await until(pilot, lambda: isinstance(app.focused, Input))
        await pilot.press(*"half a sent")
        cable.pulled = True
        await shows(pilot, "LINK LOST")
        assert "half a sent" in screen_words(app)
        # One that is opened meanwhile begins with that too, not with its own first words.
        app.push_screen(ClockDialog())
        await shows(pilot, "Clocks", "LINK LOST")
        await settled_text(pilot, 3)
        assert "LINK LOST" in screen_words(app)
        await pilot.press("escape")
        cable.pulled = False
        app.station_worker().reconnect_now()
        await shows(pilot, "The link is back", "half a sent")
        await pilot.press(*"ence", "enter")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        notes = [r.text for r in station.session.records if isinstance(r, Note)]
        assert notes == ["half a sentence"]


@on_loop
async def test_why_the_link_was_lost_can_be_noted_before_it_is_back() -> None:
    station, cable = bench()
    async with workstation(station) as (app, pilot):
        cable.pulled = True
        await until(pilot, lambda: app.state.live.link == "lost")
        await pilot.press("n")
        await shows(pilot, "Remark", "LINK LOST")
        await pilot.press(*"a goat", "enter")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert app.state.live.link == "lost"
        assert isinstance(station.session.records[-1], Note)
        assert station.session.records[-1].text == "a goat"


@on_loop
async def test_the_link_dialog_reconnects_now_and_shows_the_traffic() -> None:
    station, cable = bench()
    async with workstation(station) as (_, pilot):
        await pilot.press("f2")
        await shows(pilot, "CONNECTED", "SOLARTRAK-EMU 0001", "STATUS")
        cable.pulled = True
        await shows(pilot, "LOST; it reconnects", "Reconnect now")
        cable.pulled = False
        await pilot.press("enter")
        await until(pilot, lambda: station.state.live.link is LinkState.CONNECTED)
        await shows(pilot, "lost 1 time, restored 1 time in")


@on_loop
async def test_news_that_come_while_a_screen_is_put_together_do_not_break_it() -> None:
    """A status, or what a step before it has done: it shows the newest all the same."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        news = (
            StateChanged(app.state),
            SpeedTold(0.0),
            Stopped(None),
            StepFailed(SpeedTold, ProcedureRefused("not now")),
        )
        for screen, words in (
            (LinkDialog(), "State CONNECTED"),
            (ClockDialog(), ClockDialog.HEADING),
            (RefCheckDialog(), RefCheckDialog.HEADING),
            (PlanScreen(), "The plan begins with"),
        ):
            mounted = app.push_screen(screen)
            for told in news:
                app.on_told(Told(told))
            assert not screen.is_mounted
            await mounted
            await shows(pilot, words, "STOP")
            await pilot.press("escape")


@on_loop
async def test_the_key_of_the_next_step_follows_a_step_that_is_done() -> None:
    """No Escape between clock, check and offset; a step that is not done keeps its dialog."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f10")
        await shows(pilot, "Set the unit's clock")
        await pilot.press("f5")
        await pilot.pause()
        assert isinstance(app.screen, ClockDialog)
        await pilot.press("enter")
        await shows(pilot, "Set and recorded")
        await pilot.press("f5")
        await shows(pilot, "Start: drive")
        assert len(app.screen_stack) == 2
        await pilot.press("f6")
        await pilot.pause()
        assert isinstance(app.screen, RefCheckDialog)
        await pilot.press("enter")
        await shows(pilot, "Check no. 2 complete")
        await pilot.press("o")
        await shows(pilot, "Set here")
        assert len(app.screen_stack) == 2


@on_loop
async def test_time_passes_as_before_after_dialogs_that_follow_one_another() -> None:
    """Each of the two sets a fast emulator to x1; the first must not undo it for the second."""
    station, _ = bench()
    station.tracker.emulation.set_speed(60.0)
    async with workstation(station) as (app, pilot):
        await until(pilot, lambda: app.emulated_speed == 60.0)
        await pilot.press("f10", "enter")
        await shows(pilot, "Set and recorded")
        assert app.emulated_speed == 1.0
        await pilot.press("f6")
        await shows(pilot, "Set here")
        await until(pilot, lambda: len(app.screen_stack) == 2)
        for _ in range(5):
            await pilot.pause()
        assert app.emulated_speed == 1.0
        await pilot.press("escape")
        await until(pilot, lambda: app.emulated_speed == 60.0)


@on_loop
async def test_nothing_is_said_to_run_that_was_asked_for_on_a_lost_line() -> None:
    station, cable = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes")
        cable.pulled = True
        await shows(pilot, "LINK LOST")
        await pilot.press("enter")
        await shows(pilot, "LINK LOST", "Start: drive to the switches")
        await settled_text(pilot, 3)
        assert "running" not in screen_words(app)
