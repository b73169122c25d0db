"""Looking closer: zoom and cursor of a plot, a point opened, panes that scroll by keys."""

import pytest
from golden_screens import shows_golden
from procedure_bench import (
    LARGE,
    SMALL,
    bench,
    screen_text,
    settled_text,
    shows,
    take_points,
    until,
    workstation,
)
from rich.console import COLOR_SYSTEMS
from textual._compositor import Compositor

from solarcal.report.blocks import Table, lines_of
from solarcal.tui.app import SolarcalApp
from solarcal.tui.point.opened import PointScreen
from solarcal.tui.widgets.plot import PLOTS, ExploredPlot
from solarcal.tui.widgets.text_lines import ChosenLines
from solarcal.tui.workstation.screen import WorkstationScreen
from solarcal.tui.workstation.view import WorkstationView

SIZES = [pytest.param(SMALL, id="80x24"), pytest.param(LARGE, id="140x45")]


@pytest.fixture(scope="module")
def station(tmp_path_factory):
    """Five points, taken once for all tests that only look."""
    path = tmp_path_factory.mktemp("points") / "five.jsonl"
    station, _ = bench(path, start="2026-06-03T13:30:00Z")
    take_points(station, 5, 40.0)
    return station


async def on_workstation(app, pilot):
    app.push_screen(WorkstationScreen())
    await shows(pilot, "LINK OK")
    await until(pilot, lambda: app.judgement is not None)
    await until(pilot, lambda: app.state.session is not None and app.emulated_speed == 0.0)
    return app.screen.query_one(WorkstationView)


async def test_a_plot_zooms_pans_shows_all_again_and_takes_the_whole_screen(station):
    async with workstation(station, SMALL) as (app, pilot):
        view = await on_workstation(app, pilot)
        await pilot.press("4")
        plot = view.query_one("#plot", ExploredPlot)
        await until(pilot, lambda: app.focused is plot)
        await shows(pilot, "error, deg")
        whole = screen_text(app)
        await pilot.press("plus", "plus")
        assert plot.view.zoom == 4.0
        await pilot.press("left")
        assert plot.view.x < 0.5
        await shows(pilot, "10:30")
        await pilot.press("0")
        await until(pilot, lambda: screen_text(app) == whole)
        await pilot.press("z")
        await until(pilot, lambda: plot.size.height == SMALL[1] - 4)
        await shows(pilot, "STOP", "zoom")
        await pilot.press("z")
        await until(pilot, lambda: plot.size.height < SMALL[1] - 4)


async def test_a_pane_or_plot_that_is_changed_repaints_itself_alone(station, monkeypatch):
    """A repaint of everything takes as long as the first paint."""
    async with workstation(station, LARGE) as (app, pilot):
        view = await on_workstation(app, pilot)
        await settled_text(pilot)
        repainted = []
        partial = Compositor.render_partial_update

        def watched(compositor):
            repainted.extend(compositor._dirty_regions)
            return partial(compositor)

        monkeypatch.setattr(Compositor, "render_partial_update", watched)
        monkeypatch.setattr(
            Compositor,
            "render_full_update",
            lambda self, **how: pytest.fail("the whole screen was repainted"),
        )
        for key, words in (("5", "Reference checks"), ("2", "Points (5"), ("v", "sky map:")):
            await pilot.press(key)
            await shows(pilot, words)
            await settled_text(pilot)
        left = view.query_one("#coefficients").region
        assert repainted
        assert not any(region.contains_region(left) for region in repainted)


async def test_going_through_the_kinds_of_plot_draws_each_once(station, monkeypatch):
    async with workstation(station, LARGE) as (app, pilot):
        view = await on_workstation(app, pilot)
        await settled_text(pilot)
        plot = view.query_one("#second", ExploredPlot)
        drawn = []
        drawing = plot._drawing
        monkeypatch.setattr(
            plot, "_drawing", lambda *size: drawn.append(plot._what) or drawing(*size)
        )
        top, height = plot.region.y, plot.region.height
        first = screen_text(app).split("\n")[top : top + height]
        for words in ("sky map:", "history:", "forecast:", "residuals:"):
            await pilot.press("v")
            await shows(pilot, words)
            shown = (await settled_text(pilot)).split("\n")[top : top + height]
        assert shown == first
        assert len(drawn) == 3, "the first one was there already"


async def test_an_emulators_time_keeps_its_keys_where_no_plot_has_the_focus(station):
    async with workstation(station, SMALL) as (app, pilot):
        view = await on_workstation(app, pilot)
        await pilot.press("1")
        await until(pilot, lambda: app.emulated_speed == 0.0)
        await pilot.press("plus")
        await until(pilot, lambda: station.tracker.emulation.speed() != 0.0)
        assert view.query_one("#plot", ExploredPlot).view.zoom == 1.0
        station.tracker.emulation.set_speed(0.0)


async def test_the_cursor_reads_point_after_point_and_enter_opens_it(station):
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await pilot.press("4", "pagedown", "pagedown")
        second = station.session.points[1]
        await shows(pilot, f"record {second.seq}", f"{second.error_deg[0]:+.4f}")
        await pilot.press("enter")
        await until(pilot, lambda: isinstance(app.screen, PointScreen))
        await shows(pilot, "Point 2 of 5", f"record {second.seq}")
        await pilot.press("escape")
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))


@pytest.mark.parametrize("size", SIZES)
async def test_a_point_opened_says_all_about_it(station, size):
    async with workstation(station, size) as (app, pilot):
        await on_workstation(app, pilot)
        # The newest point is the one chosen; one before it.
        await pilot.press("2", "up", "enter")
        await until(pilot, lambda: isinstance(app.screen, PointScreen))
        await shows(pilot, "Point 4 of 5", "in sigmas", "Leverage", "without")
        await shows_golden(pilot, f"point-opened-{size[0]}x{size[1]}")
        await pilot.press("end")
        await shows(pilot, "Records", "Set Sun Offset")


async def test_a_point_is_struck_out_and_restored_where_it_is_looked_at(tmp_path):
    station, _ = bench(tmp_path / "three.jsonl", start="2026-06-03T13:30:00Z")
    take_points(station, 3, 40.0)
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await pilot.press("2", "enter")
        await until(pilot, lambda: isinstance(app.screen, PointScreen))
        await pilot.press("x")
        # The sentence needs more than a row, and has it.
        await shows(pilot, "Why is this point struck out?", "F12 or ^S stops.")
        await pilot.press(*"cloud", "enter")
        await shows(
            pilot, "STRUCK OUT", "It is struck out: the fit in force is the one without it."
        )
        assert len(station.session.accepted) == 2
        # It stays in the table, and is opened from there.
        await pilot.press("escape")
        await shows(pilot, "struck", "cloud")
        await pilot.press("enter")
        await shows(pilot, "Point 3 of 3", "STRUCK OUT")
        await pilot.press("x", *"clear", "enter")
        await shows(pilot, "accepted")
        await until(pilot, lambda: len(station.session.accepted) == 3)


async def test_every_line_of_the_checks_is_reached_by_keys_at_80x24(station):
    async with workstation(station, SMALL) as (app, pilot):
        view = await on_workstation(app, pilot)
        await pilot.press("5")
        pane = view.query_one("#checks")
        await until(pilot, lambda: app.focused is pane)
        await settled_text(pilot, 3)
        last = next(line for line in reversed(pane.lines) if line.strip()).strip()
        if pane.below:
            await shows(pilot, f"▼ {pane.below} more")
        await pilot.press("end")
        await shows(pilot, last)
        assert all(len(line) <= pane.scrollable_content_region.width for line in pane.lines)
        await pilot.press("home")
        await shows(pilot, pane.lines[0].strip())


async def test_after_a_stored_point_the_parameters_then_the_plot_come_up(tmp_path):
    """On a wide screen from the third point on; any key that is no action's goes on."""
    station, _ = bench(tmp_path / "two.jsonl", start="2026-06-03T13:30:00Z")
    take_points(station, 2, 40.0)
    async with workstation(station, LARGE) as (app, pilot):
        view = await on_workstation(app, pilot)
        coefficients = view.query_one("#coefficients")
        coefficients.scroll_end(animate=False)
        station.tracker.emulation.advance(1800.0)
        await pilot.press("f6")
        await shows(pilot, "Set here")
        await pilot.press("enter")
        await shows(pilot, "SET and recorded")
        await pilot.press("full_stop")
        for question in ("1. Did", "2. Did", "3. Do"):
            await shows(pilot, question)
            await pilot.press("y")
        for _ in range(40):
            if "Counts moved" in screen_text(app):
                break
            station.tracker.emulation.advance(1.0)
            await pilot.pause(0.05)
        await shows(pilot, "Counts moved")
        await until(pilot, lambda: app.screen.offered("yes"))
        await pilot.press("y")
        await shows(pilot, "Any key: the error plot")
        assert view.tab == "coefficients"
        await until(pilot, lambda: coefficients.scroll_offset.y == 0)
        await pilot.press("space")
        await shows(
            pilot, "on the curve of the previous fit", f"record {station.session.points[-1].seq}"
        )
        await pilot.press("space")
        await until(pilot, lambda: view.tab == "now")


async def test_a_reason_without_room_is_not_cut(station):
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await shows(pilot, "CONTINUE")
        rows = screen_text(app).split("\n")[2:5]
        assert not any("…" in row for row in rows)


@pytest.mark.parametrize(("colours", "glyph"), [("standard", "▒"), ("256", "▀")])
async def test_in_16_colours_the_forecast_map_has_glyphs(station, monkeypatch, colours, glyph):
    """Two of its shades of grey are one colour there."""
    async with workstation(station, SMALL) as (app, pilot):
        monkeypatch.setattr(app.console, "_color_system", COLOR_SYSTEMS[colours])
        view = await on_workstation(app, pilot)
        view.plot = PLOTS.index("forecast")
        await pilot.press("4")
        await shows(pilot, "error, deg rms", glyph)


@pytest.mark.parametrize("size", SIZES)
async def test_a_remark_is_folded_to_the_pane_and_is_no_row(size):
    """Its words are all there; a number in it that begins a row of the screen opens no point."""
    app = SolarcalApp()
    remark = "7 clouds came and went, " + "and 12 more stood in the west, " * 6 + "to the end."
    table = Table(("no.", "status"), (("4", "rejected"), ("5", "accepted")), "><", (), (remark, ""))
    async with app.run_test(size=size) as pilot:
        lines = ChosenLines()
        await app.screen.mount(lines)
        lines.show(lines_of(table, width=10_000), pinned=2)
        await settled_text(pilot, 3)
        assert remark in " ".join(" ".join(lines.lines).split())
        width = lines.scrollable_content_region.width
        assert all(len(line) <= width for line in lines.lines)
        assert all(line.startswith(" " * 6) for line in lines.lines[3:-1])
        assert [number for _, number in lines._rows] == [4, 5]
        lines.focus()
        await pilot.press("up", "up")
        assert lines._chosen == 0


async def test_alerts_ring_and_notify_and_m_turns_them_off(station, monkeypatch):
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        written = []
        monkeypatch.setattr(app._driver, "write", written.append)
        app.alert("due now\x1b: point 6")
        sent = "".join(written)
        assert "\x1b]9;solarcal: due now" in sent
        assert "\x1b]777;notify;solarcal;due now" in sent
        assert "\x1b: point" not in sent, "what a unit says cannot end the sequence"
        await pilot.press("m")
        await until(pilot, lambda: not app.settings.alerts)
        written.clear()
        app.alert("due now")
        assert "".join(written).count("\x1b]9;") == 0
