"""Keys of gloves and of a slow terminal: two that arrive before the first has been shown."""

import asyncio
import threading

import pytest
from procedure_bench import bench, on_loop, shows, take_points, until, workstation
from textual.events import Key
from textual.pilot import Pilot
from textual.screen import Screen

from solarcal.session.records import Note, Void
from solarcal.station.news import StatusRead
from solarcal.tui.app import SolarcalApp
from solarcal.tui.dialogs.data_file import NoteDialog, VoidDialog
from solarcal.tui.dialogs.link import ClockDialog
from solarcal.tui.dialogs.ref_check import RefCheckDialog


def at_once(pilot: Pilot[int], *keys: str) -> None:
    """All of them are in the app's queue before it looks at the first."""
    for key in keys:
        pilot.app.post_message(Key(key, None))


async def idle(app: SolarcalApp) -> None:
    """Until all steps asked for so far are done."""
    worker = app.station_worker()
    done = threading.Event()
    worker.submit(StatusRead, lambda station: done.set())
    assert await asyncio.to_thread(done.wait, 10.0)


@on_loop
async def test_the_key_of_the_next_step_held_on_a_finished_dialog_opens_that_step_once() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f10", "enter")
        await shows(pilot, "Set and recorded")
        assert isinstance(app.screen, ClockDialog)
        at_once(pilot, "f5", "f5", "f5")
        await shows(pilot, "Watch both axes reach their switches")
        assert [type(screen) for screen in app.screen_stack] == [Screen, RefCheckDialog]


@on_loop
async def test_a_screen_left_twice_takes_no_other_with_it() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes reach their switches")
        dialog = app.screen
        assert isinstance(dialog, RefCheckDialog)
        dialog.dismiss(None)
        dialog.dismiss(None)
        assert type(app.screen) is Screen


@on_loop
async def test_a_key_that_bounces_does_not_confirm_what_it_has_not_shown_yet() -> None:
    station, _ = bench()
    take_points(station, 4)
    async with workstation(station) as (app, pilot):
        await pilot.press("f8")
        await shows(pilot, "Upload?")
        at_once(pilot, "y", "y", "y")
        await shows(pilot, "not DONE", "once more", "Against it")
        await idle(app)
        assert station.session.uploads == ()
        await pilot.press("y")
        await shows(pilot, "read back EQUAL")


@on_loop
async def test_enter_that_bounces_writes_one_note() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("n")
        await shows(pilot, "Written into the session file")
        assert isinstance(app.screen, NoteDialog)
        await pilot.press(*"haze")
        at_once(pilot, "enter", "enter")
        await until(pilot, lambda: type(app.screen) is Screen)
        await idle(app)
        written = [r for r in station.session.records if isinstance(r, Note) and r.text == "haze"]
        assert len(written) == 1


@on_loop
async def test_enter_that_bounces_strikes_a_point_once() -> None:
    station, _ = bench()
    take_points(station, 1)
    async with workstation(station) as (app, pilot):
        await pilot.press("x")
        await shows(pilot, "Choose with the arrow keys")
        assert isinstance(app.screen, VoidDialog)
        await pilot.press("enter")
        await shows(pilot, "Why is record")
        await pilot.press(*"cloud")
        at_once(pilot, "enter", "enter")
        await until(pilot, lambda: type(app.screen) is Screen)
        await idle(app)
        assert len([r for r in station.session.records if isinstance(r, Void)]) == 1


@on_loop
async def test_a_screen_that_is_open_below_others_comes_back_and_is_not_opened_twice() -> None:
    from solarcal.tui.action_handlers import HelpScreen
    from solarcal.tui.calculators import CalculatorsScreen
    from solarcal.tui.plan import PlanScreen
    from solarcal.tui.recompute import RecomputeScreen
    from solarcal.tui.workstation.screen import WorkstationScreen

    kinds = {"g": CalculatorsScreen, "f4": PlanScreen, "f9": RecomputeScreen, "f1": HelpScreen}
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        for key in ("g", "f4", "f9", "g", "f9", "f4", "f9", "f1", "f4", "f9", "g"):
            await pilot.press(key)
            await until(pilot, lambda kind=kinds[key]: isinstance(app.screen, kind))
        assert [type(screen) for screen in app.screen_stack[2:]] == [CalculatorsScreen]
        await pilot.press("escape")
        assert isinstance(app.screen, WorkstationScreen)


@pytest.mark.parametrize("key", ["y", "n"])
@on_loop
async def test_a_key_held_down_answers_one_question_however_late_it_first_repeats(
    monkeypatch: pytest.MonkeyPatch, key: str
) -> None:
    """The first repeat comes as late as a second press would; the ones after it come at once."""
    monkeypatch.setattr("solarcal.tui.dialogs.dialog.BLINK_S", 3600.0)
    station, _ = bench()
    station.initialise(confirmed=True)
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did you do a reference check?")
        await pilot.press("y")
        await shows(pilot, "2. Did you do a 'Set Sun Offset'?")
        await pilot.press(key, key)
        if key == "n":
            await until(pilot, lambda: app.state.attempt is None)
            return
        await until(pilot, lambda: app.screen.query("#dialog.-early") and app.screen.offered("yes"))
        await pilot.press(key)
        await shows(pilot, "y not taken: let it go first")
        await idle(app)
        assert app.state.attempt is not None
        assert app.state.attempt.answers.sun_offset is None


@pytest.mark.parametrize("blink_s", [3600.0, 0.01])
@on_loop
async def test_a_key_held_down_answers_no_question_until_it_was_let_go(
    monkeypatch: pytest.MonkeyPatch, blink_s: float
) -> None:
    """It comes again before the next question is on the screen, and from then on does not count."""
    monkeypatch.setattr("solarcal.tui.dialogs.dialog.BLINK_S", blink_s)
    station, _ = bench()
    station.initialise(confirmed=True)
    answered = threading.Event()
    async with workstation(station) as (app, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did you do a reference check?")
        app.station_worker().submit(StatusRead, lambda station: answered.wait(10.0))
        await pilot.press("y", "y")
        answered.set()
        await shows(pilot, "2. Did you do a 'Set Sun Offset'?")
        dialog = app.screen
        if blink_s > 1.0:
            await pilot.press("y", "y")
            await shows(pilot, "y not taken: let it go first")
            await idle(app)
            assert app.state.attempt is not None
            assert app.state.attempt.answers.sun_offset is None
        else:
            await until(pilot, lambda: not dialog.query("#dialog.-early"))
            await pilot.press("y")
            await shows(pilot, "3. Do you like the way it is tracking?")
