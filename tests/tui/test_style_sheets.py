"""Style sheets are parsed once, in the theme that was chosen, before anything is drawn."""

from collections import Counter

import pytest
from procedure_bench import LARGE, SMALL, bench, shows, workstation
from textual.css import stylesheet

from solarcal.config import Settings
from solarcal.tui.app import SolarcalApp
from solarcal.tui.palette import DEFAULT_THEME
from solarcal.tui.workstation.screen import WorkstationScreen


@pytest.fixture
def parsed(monkeypatch, style_sheets_are_parsed_once):
    """How often each sheet was parsed, as in the program: with nothing known of other apps."""
    monkeypatch.setattr(stylesheet.Stylesheet, "_parse_rules", style_sheets_are_parsed_once)
    counted, parse = Counter(), stylesheet.parse

    def counting(scope, css, read_from, **options):
        counted[read_from, scope, options["tie_breaker"]] += 1
        return parse(scope, css, read_from, **options)

    monkeypatch.setattr(stylesheet, "parse", counting)
    return counted


async def test_no_sheet_is_parsed_twice(parsed):
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await app.push_screen(WorkstationScreen())
        for key, heading in (("f2", "Link"), ("f10", "Clocks"), ("f5", "Reference check")):
            await pilot.press(key)
            await shows(pilot, heading)
            await pilot.press("escape")
    assert len(parsed) > 30
    assert set(parsed.values()) == {1}


@pytest.mark.parametrize(
    ("chosen", "begins_with", "ground"),
    [("sunlight", "sunlight", "#FFFFFF"), ("no such theme", DEFAULT_THEME, "#0A0A06")],
)
async def test_the_first_screen_is_drawn_in_the_theme_that_was_chosen(
    parsed, chosen, begins_with, ground
):
    app = SolarcalApp(settings=Settings(theme=chosen))
    async with app.run_test(size=SMALL) as pilot:
        assert (app.theme, app.screen.styles.background.hex) == (begins_with, ground)
        await shows(pilot, "STOP")
        assert app.has_class(f"-theme-{begins_with}")
        assert app.has_class("-light-mode") == (begins_with == "sunlight")
        assert not app.has_class("-theme-textual-dark")
    assert set(parsed.values()) == {1}


async def test_a_large_workstation_is_large_from_its_first_layout_on():
    station, _ = bench()
    async with workstation(station, LARGE) as (app, _pilot):
        drawn, screen = [], WorkstationScreen()
        compositor = screen._compositor
        update = compositor.render_update
        compositor.render_update = lambda *a, **k: (
            drawn.append(compositor.visible_widgets) or (update(*a, **k))
        )
        await app.push_screen(screen)
        shown = {widget.id for widget in drawn[0]}
        assert {"now", "coefficients", "points", "plot", "second"} <= shown
        assert "tabs" not in shown
