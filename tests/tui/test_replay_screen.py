"""A saved session on the workstation's screen: forward, BACK, play, jump."""

import pytest
from procedure_bench import (
    SMALL,
    bench,
    plain_start,
    screen_text,
    settled_text,
    shows,
    take_points,
    until,
)

from solarcal.config import Choice
from solarcal.tui.app import SolarcalApp
from solarcal.tui.replay import ReplayScreen


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / "four.jsonl"
    station, _ = bench(path, start="2026-06-03T15:00:00Z")
    take_points(station, 4, 40.0)
    return path


def replaying(path, speed=None):
    return plain_start(start=Choice(replay=str(path), speed=speed))


async def opened(pilot):
    await until(pilot, lambda: isinstance(pilot.app.screen, ReplayScreen))
    await shows(pilot, "REPLAY")
    return pilot.app.screen


async def test_it_begins_with_nothing_recorded(recorded):
    async with replaying(recorded).run_test(size=SMALL) as pilot:
        screen = await opened(pilot)
        assert screen.replay.position == 0
        await shows(pilot, "0 points so far", "nothing recorded yet")


async def test_a_step_back_shows_exactly_what_was_shown_before(recorded):
    async with replaying(recorded).run_test(size=SMALL) as pilot:
        screen = await opened(pilot)
        shown = []
        for _ in range(len(screen.replay) + 1):
            # The fit of these points comes from its own thread.
            await until(pilot, lambda: not screen.replay.view.points or screen.judged_now)
            shown.append(await settled_text(pilot, 3))
            await pilot.press("right")
        for text in reversed(shown[:-1]):
            await pilot.press("left")
            await until(pilot, lambda text=text: screen_text(pilot.app) == text)


async def test_page_keys_go_from_point_to_point_and_numbers_jump(recorded):
    async with replaying(recorded).run_test(size=SMALL) as pilot:
        screen = await opened(pilot)
        await pilot.press("pagedown", "pagedown")
        assert len(screen.replay.view.points) == 2
        await pilot.press("pagedown", "pageup", "pageup")
        assert len(screen.replay.view.points) == 1
        await pilot.press("j")
        await shows(pilot, "Point, 1 to 4", "STOP")
        await pilot.press("5", "enter")
        await shows(pilot, "There is no point '5'")
        await pilot.press("backspace", "4", "enter")
        await until(pilot, lambda: len(screen.replay.view.points) == 4)
        await pilot.press("home")
        assert screen.replay.position == 0


async def test_playing_comes_to_the_end_and_stops_there(recorded):
    async with replaying(recorded).run_test(size=SMALL) as pilot:
        screen = await opened(pilot)
        await pilot.press("plus", "plus", "space")
        await shows(pilot, "playing")
        for _ in range(200):
            # The timer's ticks, without waiting for them.
            screen._tick()
        assert screen.replay.position == len(screen.replay)
        await shows(pilot, "paused", "4 points so far")
        await pilot.press("minus", "minus", "space")
        assert screen.replay.position < len(screen.replay)


async def test_the_fit_is_the_one_of_the_points_seen(recorded):
    async with replaying(recorded).run_test(size=SMALL) as pilot:
        screen = await opened(pilot)
        await pilot.press("3", "end")
        await shows(pilot, "4 points, rank")
        await pilot.press("pageup", "pageup")
        await until(pilot, lambda: len(screen.replay.view.accepted) < 4)
        count = len(screen.replay.view.accepted)
        await shows(pilot, f"{count} points, rank")


async def test_no_key_of_the_procedure_reaches_a_unit_from_a_replay(recorded):
    before = recorded.read_bytes()
    async with replaying(recorded).run_test(size=SMALL) as pilot:
        screen = await opened(pilot)
        await pilot.press("f7", "f3", "f12")
        await pilot.pause()
        assert pilot.app.screen is screen
    assert recorded.read_bytes() == before


async def test_a_file_that_cannot_be_read_is_said_on_the_start_screen(tmp_path):
    (tmp_path / "bad.jsonl").write_text("{\n")
    start = Choice(replay=str(tmp_path / "bad.jsonl"))
    async with SolarcalApp(start=start).run_test(size=SMALL) as pilot:
        await shows(pilot, "no complete session header")
        assert not isinstance(pilot.app.screen, ReplayScreen)


async def test_a_speed_asked_for_is_kept_and_changed_from_there(recorded):
    async with replaying(recorded, 90.0).run_test(size=SMALL) as pilot:
        await opened(pilot)
        await shows(pilot, "x90 ")
        await pilot.press("plus")
        await shows(pilot, "x300 ")
        await pilot.press("minus")
        await shows(pilot, "x60 ")
