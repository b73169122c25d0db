"""What is seen behind a dialog is what Textual itself would draw, and follows what changes."""

import importlib

import pytest
import textual._context
from procedure_bench import LARGE, SMALL, bench, until, workstation
from rich.segment import Segment
from textual.renderables.background_screen import BackgroundScreen
from textual.screen import Screen
from textual.visual import RichVisual, Visual

from solarcal.tui import behind as behind_module
from solarcal.tui.dialogs.link import LinkDialog
from solarcal.tui.palette import Palette
from solarcal.tui.workstation.screen import WorkstationScreen


def textuals_own(screen: Screen) -> list[list[Segment]]:
    """Each line as Textual would draw it, with its colours."""
    behind = screen.app.screen_stack[-2]
    textual._context.visible_screen_stack.set(list(screen.app.screen_stack[:-2]))
    picture = BackgroundScreen(behind, screen.styles.background)
    width, height = screen.size
    strips = Visual.to_strips(
        screen, RichVisual(screen, picture), width, height, screen.visual_style
    )
    return [list(strip.simplify()) for strip in strips]


def drawn(screen: Screen) -> list[list[Segment]]:
    return [list(screen.render_line(y).simplify()) for y in range(screen.size.height)]


def words(screen: Screen) -> str:
    return "\n".join("".join(segment.text for segment in line) for line in drawn(screen))


async def alike(pilot) -> None:
    """What is behind may still be drawing its plots; then the dialog draws them a turn later."""
    await until(pilot, lambda: drawn(pilot.app.screen) == textuals_own(pilot.app.screen))


@pytest.mark.parametrize("size", [SMALL, LARGE])
@pytest.mark.parametrize("dialog", [LinkDialog, Palette])
async def test_the_picture_is_textuals(size, dialog):
    station, _ = bench()
    async with workstation(station, size) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await app.push_screen(dialog())
        await pilot.pause()
        await alike(pilot)
        assert "SOLARTRAK-EMU" in words(app.screen)


@pytest.mark.parametrize("dialog", [LinkDialog, Palette])
async def test_what_changes_behind_is_seen(dialog):
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await app.push_screen(dialog())
        await pilot.pause()
        app.screen_stack[-2].query_one("#log").say("the wind has risen")
        await until(pilot, lambda: "the wind has risen" in words(app.screen))
        await alike(pilot)


async def test_after_a_change_of_size_all_of_it_is_drawn():
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await app.push_screen(LinkDialog())
        await pilot.pause()
        await pilot.resize_terminal(*LARGE)
        await alike(pilot)
        assert len(drawn(app.screen)) == LARGE[1]


async def test_a_full_screen_covers_those_below_it():
    """Each of the program's is opaque: nothing below it is laid out, drawn or seen."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        assert app.screen.styles.background.a == 1.0
        await app.push_screen(WorkstationScreen())
        await pilot.pause()
        assert app.screen.styles.background.a == 1.0
        screen = app.screen
        await app.push_screen(LinkDialog())
        await until(pilot, lambda: "SOLARTRAK-EMU" in words(app.screen))
        assert app._background_screens == [screen]


async def test_a_dialog_behind_a_dialog_and_a_screen_that_lets_through_are_drawn_too():
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        screen = WorkstationScreen()
        await app.push_screen(screen)
        await app.push_screen(LinkDialog())
        await app.push_screen(Palette())
        screen.styles.background = "black 50%"
        await pilot.pause()
        await alike(pilot)
        assert "Last over the line" in words(app.screen)


async def test_a_textual_without_what_is_used_of_it_draws_by_itself(monkeypatch):
    """A name that is away, and one that means something else; the screen is the same, slower."""
    known = textual._context.visible_screen_stack
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await app.push_screen(LinkDialog())
        await pilot.pause()
        assert behind_module.draw_behind(app.screen)
        monkeypatch.setattr(behind_module, "visible_screen_stack", object())
        app.screen.refresh()
        assert not behind_module.draw_behind(app.screen)
        monkeypatch.delattr(textual._context, "visible_screen_stack")
        importlib.reload(behind_module)
        app.screen.refresh()
        assert not behind_module.draw_behind(app.screen)
        app.screen_stack[-2].query_one("#log").say("the wind has risen")
        await until(pilot, lambda: "the wind has risen" in words(app.screen))
        monkeypatch.setattr(textual._context, "visible_screen_stack", known, raising=False)
        await alike(pilot)
        importlib.reload(behind_module)
        assert behind_module.draw_behind(app.screen)


@pytest.mark.parametrize("size", [(80, 30), (40, 10), (200, 60)])
async def test_a_terminal_without_colour_may_be_resized_under_a_dialog(monkeypatch, size):
    monkeypatch.setenv("NO_COLOR", "1")
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        await app.push_screen(LinkDialog())
        for new in (size, SMALL):
            await pilot.resize_terminal(*new)
            await pilot.pause()
        await until(pilot, lambda: "SOLARTRAK-EMU" in words(app.screen))
