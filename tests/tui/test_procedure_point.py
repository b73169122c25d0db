"""Taking points by the keys: questions, gathering, result, and what happens when it goes wrong."""

import threading
from dataclasses import replace
from pathlib import Path

import pytest
from procedure_bench import (
    bench,
    mouse_click,
    offset_set,
    on_loop,
    screen_words,
    shows,
    take_points,
    until,
    workstation,
)
from textual.geometry import Offset

from solarcal.errors import ConfigurationError, LinkError
from solarcal.session.records import CheckRecord, LinkLost, Override, PointRecord
from solarcal.session.view import read_session
from solarcal.station.analysing import analyse_session
from solarcal.station.news import FitReady, FitRecorded, StatusRead, StepFailed
from solarcal.station.state import QUESTIONS, Activity
from solarcal.tui.app import SolarcalApp
from solarcal.tui.point.dialog import TakePointDialog
from solarcal.tui.workstation.screen import WorkstationScreen
from solarcal.unit.tracker import Mode


@on_loop
async def test_three_times_yes_gathers_shows_the_result_and_stores(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    station, _ = bench(path)
    take_points(station, 3)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("full_stop")
        await shows(pilot, "1. Did you do a reference check?", "Check no.", "complete")
        await pilot.press("y")
        await shows(pilot, "2. Did you do a 'Set Sun Offset'?", "came from behind", "YES")
        await pilot.press("y")
        await shows(pilot, "3. Do you like the way it is tracking?", "mode TRACK", "The spot is")
        await pilot.press("y")
        await shows(pilot, "Store it?", "expected", "found", "in sigmas")
        assert len(station.session.accepted) == 3
        await pilot.press("y")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        # What the screen says is stored is in the file.
        stored = [r for r in read_session(path).records if isinstance(r, PointRecord)]
        assert [p.status for p in stored] == ["accepted"] * 4
        assert stored[-1].answers.tracking is True


@pytest.mark.parametrize("number", [1, 2, 3])
@on_loop
async def test_the_first_no_ends_the_attempt_and_keeps_it_as_aborted(number: int) -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        for question in range(1, number + 1):
            await shows(pilot, f"{question}. Did you" if question < 3 else "3. Do you")
            await pilot.press("y" if question < number else "n")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    point = station.session.points[-1]
    assert point.status == "aborted"
    answers = (point.answers.ref_check, point.answers.sun_offset, point.answers.tracking)
    assert answers == (True,) * (number - 1) + (False,) + (None,) * (3 - number)
    assert station.state.activity is Activity.IDLE


@on_loop
async def test_a_point_that_is_not_stored_is_kept_as_rejected() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        for words in ("1. Did", "2. Did", "3. Do", "Store it?"):
            await shows(pilot, words)
            await pilot.press("n" if words == "Store it?" else "y")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    assert station.session.points[-1].status == "rejected"
    assert station.session.accepted == ()


@on_loop
async def test_the_buttons_do_what_the_keys_do() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        for words in ("1. Did", "2. Did", "3. Do", "Store it?"):
            await shows(pilot, words)
            await pilot.click("#key-yes")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    assert len(station.session.accepted) == 1


@on_loop
async def test_a_double_click_answers_one_question_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(SolarcalApp, "CLICK_CHAIN_TIME_THRESHOLD", 60.0)
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did")
        busy = threading.Event()
        app.station_worker().submit(StatusRead, lambda station: busy.wait(10.0) and None)
        yes = app.screen.query_one("#key-yes").region.offset + Offset(2, 1)
        for _ in range(2):
            await mouse_click(pilot, yes)
        busy.set()
        await shows(pilot, "2. Did")
        assert isinstance(app.screen, TakePointDialog)


@on_loop
async def test_without_initialise_the_reason_is_said_and_nothing_recorded() -> None:
    station, _ = bench()
    before = len(station.session.records)
    async with workstation(station) as (_, pilot):
        await pilot.press("f7")
        await shows(pilot, "initialise the data file first, once per calibration [F3 i]")
        assert "Override" not in screen_words(pilot.app)
    assert len(station.session.records) == before


@on_loop
@pytest.mark.parametrize(("key", "opened"), [("f3", "Are you sure?"), ("f5", "Start: drive")])
async def test_a_refusal_ends_the_attempt_and_the_key_of_the_step_it_asks_for_leads_on(
    key: str, opened: str
) -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "initialise the data file first, once per calibration [F3 i]")
        await pilot.press(key)
        await shows(pilot, opened)
        assert len(app.screen_stack) == 2
    assert station.session.initialised is None
    assert len(station.session.ref_checks) == 1


@on_loop
async def test_a_guard_is_overruled_with_a_typed_reason() -> None:
    station, _ = bench(None, "unit.limits1_deg=[-128.0, 85.2]")
    station.initialise(confirmed=True, override_reason="test")
    async with workstation(station) as (_, pilot):
        await pilot.press("f7")
        await shows(pilot, "deg from a limit", "Override, with a reason")
        await pilot.press("o", "enter")
        await shows(pilot, "needs a reason")
        await pilot.press(*"near", "enter")
        await shows(pilot, "1. Did you do a reference check?")
    overrides = [r.reason for r in station.session.records if isinstance(r, Override)]
    assert overrides == ["test", "near"]


@on_loop
async def test_escape_leaves_the_attempt_open_and_the_key_goes_on_with_it() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did")
        await pilot.press("y")
        await shows(pilot, "2. Did")
        await pilot.press("escape")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert station.state.activity is Activity.QUESTIONS
        await pilot.press("f7")
        await shows(pilot, "2. Did")


@on_loop
async def test_what_a_dialog_left_is_not_said_beside_what_came_of_it() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await shows(pilot, "LINK OK")
        await pilot.press("f7")
        await shows(pilot, "1. Did you")
        await pilot.press("escape")
        await shows(pilot, "The attempt stays open")
        await pilot.press("f7")
        await shows(pilot, "1. Did you")
        await pilot.press("n")
        await shows(pilot, "NO to question 1: the attempt is kept as aborted")
        assert "The attempt stays open" not in screen_words(app)


@on_loop
async def test_a_unit_that_does_not_track_aborts_the_gathering_and_it_can_be_tried_again() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (_, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did")
        station.tracker.set_mode(Mode.MANUAL)
        for words in ("1. Did", "2. Did", "3. Do"):
            await shows(pilot, words)
            await pilot.press("y")
        await shows(pilot, "not tracking", "Try again")
        assert station.session.points[-1].status == "aborted"
        station.track()
        station.clock.wait(60.0)
        await pilot.press("r")
        await shows(pilot, "1. Did")


@on_loop
async def test_a_link_lost_at_a_question_aborts_the_attempt_and_says_so() -> None:
    station, cable = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did")
        cable.pulled = True
        await shows(pilot, "LINK LOST")
        await until(pilot, lambda: station.state.attempt is None)
        cable.pulled = False
        app.station_worker().reconnect_now()
        await shows(pilot, "The attempt was aborted", "Try again")
        await pilot.press("r")
        await shows(pilot, "1. Did")
    kinds = [type(r) for r in station.session.records]
    assert kinds.index(LinkLost) < kinds.index(PointRecord)
    assert station.session.points[-1].reason.startswith("link lost")


@pytest.mark.parametrize("restarted", [False, True])
@on_loop
async def test_a_link_back_speaks_of_no_attempt_where_there_was_none(restarted: bool) -> None:
    station, cable = bench()
    cable.pulled = True
    station.link_lost(LinkError("cable pulled"))
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "Take a data point", "LINK LOST")
        if restarted:
            cable.emulator.reboot()
        cable.pulled = False
        app.station_worker().reconnect_now()
        await shows(pilot, "The link is back.", *(["do a reference check"] if restarted else []))
        assert "attempt was aborted" not in screen_words(app)
        dialog = app.screen
        assert isinstance(dialog, TakePointDialog)
        assert dialog.offered("again") is not restarted


@on_loop
async def test_after_an_upload_a_check_point_is_asked_for_and_judged() -> None:
    station, _ = bench()
    take_points(station, 4)
    from solarcal.station.uploading import propose_upload

    proposal = propose_upload(station.session, station.coefficients_in_force)
    assert proposal is not None
    station.upload(proposal.rounded, method="linear")
    station.track()
    station.clock.wait(120.0)
    offset_set(station)
    judgement = analyse_session(station.session)
    assert judgement is not None
    async with workstation(station) as (app, pilot):
        for state, which in (("done", False), ("continue", True)):
            judged = replace(judgement, verdict=replace(judgement.verdict, state=state))
            app.fit = FitReady(0, station.session, None, judged)
            await pilot.press("f7")
            await shows(pilot, "a check point, or one more data point?")
            assert ("not DONE: a data point (d)" in screen_words(app)) is which
            if not which:
                await pilot.press("escape")
                await until(pilot, lambda: len(app.screen_stack) == 1)
        await pilot.press("enter")
        for words in ("1. Did", "2. Did", "3. Do"):
            await shows(pilot, words, "Take a check point")
            await pilot.press("y")
        await shows(pilot, "left on the sky", "Store it?")
        await pilot.press("y")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    assert [type(c) for c in station.session.checks] == [CheckRecord]
    assert len(station.session.accepted) == 4


@on_loop
async def test_a_step_that_has_to_wait_for_a_point_names_its_key_and_that_leads_on() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    station.begin_point()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5", "enter")
        await shows(pilot, "answer them first [F7 .]")
        await pilot.press("f7")
        await shows(pilot, "1. Did you do a reference check?")
        assert isinstance(app.screen, TakePointDialog)


@on_loop
async def test_a_notice_does_not_take_the_place_of_a_question() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    station.begin_point()
    for _ in QUESTIONS:
        station.answer(True)
    station.gather_point()
    async with workstation(station) as (app, pilot):
        await pilot.press("full_stop")
        await shows(pilot, "Store it?")
        app.emulated_speed = 10.0
        await pilot.press("plus")
        await shows(pilot, "No faster than x10", "Store it?")
        await pilot.press("s")
        await shows(pilot, "STOPPED", "Store it?")
        app.tell(StepFailed(FitRecorded, ConfigurationError("the disk is full")))
        await shows(pilot, "the disk is full", "Store it?")
        app.notify("a word from elsewhere")
        await shows(pilot, "a word from elsewhere", "Store it?")
