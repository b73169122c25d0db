"""What a technician with gloves needs at 80x24: STOP everywhere, big targets, a light screen."""

from pathlib import Path

import pytest
from procedure_bench import (
    SMALL,
    bench,
    mouse_click,
    on_loop,
    screen_text,
    screen_words,
    shows,
    target,
    until,
    workstation,
)
from textual.widgets import Input

from solarcal.session.journal import Journal
from solarcal.tui.action_handlers import HelpScreen
from solarcal.tui.app import SolarcalApp
from solarcal.tui.palette import SUNLIGHT, Palette
from solarcal.tui.widgets.footer import StopKey
from solarcal.tui.widgets.lines import TooSmall
from solarcal.unit.tracker import Mode


@on_loop
async def test_the_palette_leaves_stop_in_sight_and_a_click_on_it_stops() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("ctrl+p")
        await shows(pilot, "Search for commands", "▌ STOP ▐", "F12 ^S")
        assert isinstance(app.screen, Palette)
        await pilot.click(StopKey)
        await until(pilot, lambda: station.poll().mode is Mode.STOP)
        assert isinstance(app.screen, Palette)


@on_loop
async def test_the_themes_made_for_this_program_stand_first() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        app.search_themes()
        await shows(pilot, "phosphor sunlight ansi-dark")


@on_loop
async def test_one_key_goes_to_the_light_theme_and_back() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        app.theme = "nord"
        await pilot.press("h")
        assert app.theme == SUNLIGHT.name
        await pilot.press("h")
        assert app.theme == "nord"


@on_loop
async def test_a_double_click_on_words_is_as_good_as_none() -> None:
    from solarcal.tui.workstation.screen import WorkstationScreen

    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes")
        await pilot.click("#said", times=2)
        await pilot.click("#key-start", times=3)
        await shows(pilot, "complete, recorded")
        await pilot.press("escape")
        await app.push_screen(WorkstationScreen())
        for widget in app.screen.query("Words"):
            if widget.region:
                await pilot.click(widget, times=2)
        await shows(pilot, "e Report")
        assert not app.screen.selections


@on_loop
async def test_a_double_click_on_help_opens_it_and_does_not_close_it_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from solarcal.tui.workstation.screen import WorkstationScreen

    station, _ = bench()
    async with workstation(station, SMALL) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await shows(pilot, "F1 Help")
        place = target(app, "Help").offset
        monkeypatch.setattr(SolarcalApp, "CLICK_CHAIN_TIME_THRESHOLD", 60.0)
        await mouse_click(pilot, place)
        await until(pilot, lambda: isinstance(app.screen, HelpScreen))
        await mouse_click(pilot, place)
        await shows(pilot, "Esc Back")
        assert isinstance(app.screen, HelpScreen)
        monkeypatch.setattr(SolarcalApp, "CLICK_CHAIN_TIME_THRESHOLD", 0.0)
        await mouse_click(pilot, place)
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))


@on_loop
async def test_no_other_step_begins_over_a_dialog() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes")
        await pilot.press("ctrl+p")
        await shows(pilot, "Leave this first")
        assert not isinstance(app.screen, Palette)


@on_loop
async def test_every_action_has_a_target_at_80_columns() -> None:
    from solarcal.tui.workstation.screen import WorkstationScreen

    station, _ = bench()
    async with workstation(station, SMALL) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await shows(pilot, "e Report", "g Calcs", "^P All", "clock paused [+ - w]")
        row = screen_text(app).splitlines()[1]
        await pilot.click("#file", offset=(row.index("+"), 0))
        await until(pilot, lambda: app.emulated_speed)
        await pilot.click(offset=target(app, "All").offset)
        await until(pilot, lambda: isinstance(app.screen, Palette))


@on_loop
async def test_too_small_a_terminal_is_said_and_can_still_be_stopped() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes")
        await pilot.resize_terminal(40, 10)
        await shows(pilot, "40x10: make it 80x24")
        await pilot.click(TooSmall)
        await until(pilot, lambda: station.poll().mode is Mode.STOP)
        await pilot.resize_terminal(*SMALL)
        await until(pilot, lambda: "make it" not in screen_words(app))
        await shows(pilot, "STOPPED")


@on_loop
async def test_a_form_follows_the_keymap_and_page_down_scrolls_its_result() -> None:
    from solarcal.instruments.catalogue import BY_ID
    from solarcal.tui.calculators import CalculatorScreen, CalculatorsScreen
    from solarcal.tui.widgets.text_lines import TextLines

    app = SolarcalApp(keymap={"next_plot": "j", "calculators": "y"})
    async with app.run_test(size=SMALL) as pilot:
        await app.push_screen(CalculatorScreen(BY_ID["energy"]))
        await shows(pilot, "^N View", "y List", "Sun towards")
        result = app.screen.query_one(TextLines)
        assert isinstance(app.focused, Input)
        await pilot.press("pagedown")
        await until(pilot, lambda: result.scroll_offset.y > 0)
        assert isinstance(app.focused, Input)
        await pilot.press("end", "j")
        assert not app.screen.has_class("-drawing")
        await pilot.press("backspace", "ctrl+n")
        await until(pilot, lambda: app.screen.has_class("-drawing"))
        await pilot.press("j")
        await until(pilot, lambda: app.screen.has_class("-text"))
        await pilot.press("y")
        await until(pilot, lambda: isinstance(app.screen, CalculatorsScreen))


@on_loop
async def test_the_file_named_at_the_end_is_the_one_the_session_went_on_in(tmp_path: Path) -> None:
    station, _ = bench(tmp_path / "first.jsonl")
    async with workstation(station) as (app, pilot):
        station.initialise(confirmed=True)
        station.initialise(
            confirmed=True,
            start_next=lambda header: Journal.create(tmp_path / "second.jsonl", header),
        )
        await until(pilot, lambda: app.session_name == "second.jsonl")
        await app.leave()
        assert "second.jsonl" in str(app._exit_renderables)


@on_loop
async def test_stop_shows_and_obeys_the_users_letter_in_a_dialog() -> None:
    station, _ = bench()
    app = SolarcalApp(keymap={"stop": "z", "note": "s"})
    async with app.run_test(size=SMALL) as pilot:
        app.adopt(station)
        await pilot.press("f5")
        await shows(pilot, "F12 z", "Watch both axes")
        await pilot.press("s")
        await pilot.pause()
        assert station.poll().mode is Mode.TRACK
        await pilot.press("z")
        await shows(pilot, "STOPPED")
        assert app.worker is not None
        app.worker.close()
