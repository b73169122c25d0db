"""The screen of the day: panes and tabs, footer, palette, link, fit, emulated time, leaving."""

import re
from dataclasses import replace
from threading import Event

import pytest
from procedure_bench import (
    LARGE,
    SMALL,
    bench,
    offset_set,
    screen_words,
    settled_text,
    shows,
    take_points,
    target,
    until,
    workstation,
)

from solarcal.session.records import FitRecord, LinkLost, LinkRestored
from solarcal.station.news import FitReady, RecordVoided, StateChanged, StatusRead
from solarcal.station.state import LiveView
from solarcal.tui.base import Told
from solarcal.tui.keys import ACTIONS
from solarcal.tui.palette import ActionProvider
from solarcal.tui.widgets.footer import KeysInLine, KeysInTwoRows, StopKey
from solarcal.tui.widgets.plot import strips_of_ansi
from solarcal.tui.workstation.lines import sparkline
from solarcal.tui.workstation.live_pane import limit_bar, phase_bar
from solarcal.tui.workstation.screen import FOOTER, WorkstationScreen
from solarcal.tui.workstation.view import TABS, WorkstationView
from solarcal.unit.tracker import Mode


@pytest.fixture
def station_and_cable(tmp_path):
    return bench(tmp_path / "calibration.jsonl")


async def on_workstation(app, pilot):
    app.push_screen(WorkstationScreen())
    await shows(pilot, "LINK OK")
    return app.screen


async def test_the_file_name_is_just_below_the_title(station_and_cable):
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await shows(pilot, "calibration.jsonl")
        assert app.screen.query_one("#file").region.y == 1


async def test_the_compact_form_has_every_pane_as_a_tab(station_and_cable):
    station, _ = station_and_cable
    offset_set(station)
    seen = {
        "now": "apparent solar time", "points": "No points yet", "coefficients": "In force",
        "plot": "axis error", "checks": "Reference checks",
    }  # fmt: skip
    assert set(seen) == {name for name, _ in TABS}
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        for number, (name, _) in enumerate(TABS, start=1):
            await pilot.press(str(number))
            await shows(pilot, seen[name], "STOP", "calibration.jsonl")
        await pilot.press("1")
        for name, _ in [*TABS[1:], TABS[0]]:
            await pilot.press("tab")
            await shows(pilot, seen[name])


@pytest.mark.parametrize("key", ["l", "L"])
async def test_a_lost_link_counts_down_and_l_tries_at_once(station_and_cable, key):
    station, cable = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        cable.pulled = True
        await shows(pilot, "LINK LOST", "next try in", "press L to try now")
        cable.pulled = False
        await pilot.press(key)
        await shows(pilot, "The link is back")
        await pilot.press("escape")
        await shows(pilot, "LINK OK")


async def test_a_click_on_a_tab_opens_it(station_and_cable):
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await pilot.click("#tab-checks")
        await shows(pilot, "Reference checks")


async def test_growing_and_shrinking_the_window_changes_the_form_and_loses_nothing(
    station_and_cable,
):
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        screen = await on_workstation(app, pilot)
        view = screen.query_one(WorkstationView)
        assert not view.wide
        await pilot.resize_terminal(*LARGE)
        await until(pilot, lambda: view.wide)
        await shows(pilot, "apparent solar time", "In force", "axis error", "No points yet")
        await pilot.resize_terminal(*SMALL)
        await until(pilot, lambda: not view.wide)
        await shows(pilot, "1 Now", "apparent solar time", "STOP")


async def test_v_goes_round_the_plots_in_both_forms(station_and_cable):
    station, _ = station_and_cable
    for size, words in (
        (SMALL, ["axis error", "on the sky", "elevation", "one sigma", "the year", "axis error"]),
        (LARGE, ["elevation", "one sigma", "the year", "on the sky"]),
    ):
        async with workstation(station, size) as (app, pilot):
            await on_workstation(app, pilot)
            for expected in words:
                await pilot.press("v")
                await shows(pilot, expected)
        station, _ = bench()


async def test_every_footer_target_is_on_the_screen_and_does_what_its_key_does(station_and_cable):
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        screen = await on_workstation(app, pilot)
        footer, beside_tabs = screen.query_one(KeysInTwoRows), screen.query_one(KeysInLine)
        shown = [entry for entry, _ in footer.places()]
        assert [entry.action for entry in shown] == [f"app.perform('{n}')" for n, _ in FOOTER]
        assert [entry.label for entry, _ in beside_tabs.places()] == ["Report", "Calcs", "All"]
        for keys in (footer, beside_tabs):
            for entry, place in keys.places():
                assert keys.size.region.contains_region(place)
                assert screen.region.contains_region(place.translate(keys.region.offset))
                assert place.width >= (10 if keys is footer else 5)
                assert entry.words.cell_length <= place.width, entry
        await pilot.click(offset=target(app, shown[0].label).offset)
        await shows(pilot, "THE PROCEDURE")


@pytest.mark.parametrize("width", [80, 99, 100, 140])
async def test_the_footer_leaves_no_gap_between_targets(width, station_and_cable):
    async with workstation(station_and_cable[0], (width, 45)) as (app, pilot):
        await on_workstation(app, pilot)
        keys = app.screen.query_one(KeysInTwoRows)
        places = [place for _, place in keys.places()]
        a_row = 9 if width >= 100 else 7
        assert len(places) == 2 * a_row
        for row in (places[:a_row], places[a_row:]):
            assert [place.x for place in row] == [0, *(place.right for place in row[:-1])]
            assert row[-1].right == keys.size.width == width - 10


async def test_the_target_under_the_mouse_is_lit_and_explained(station_and_cable):
    def lit(place):
        strip = app.screen._compositor.render_strips()[place.y].crop(place.x, place.right)
        primary = app.theme_variables["primary"]
        return {segment.style.bgcolor.name == primary.lower() for segment in strip}

    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        screen = await on_workstation(app, pilot)
        footer = screen.query_one(KeysInTwoRows)
        for label, keys in (
            ("Link", footer), ("Upload", footer), ("All", screen.query_one(KeysInLine)),
        ):  # fmt: skip
            await pilot.hover(offset=target(app, label).offset)
            await until(pilot, lambda label=label: lit(target(app, label)) == {True})
            entry = next(entry for entry, _ in keys.places() if entry.label == label)
            assert keys.tooltip == entry.tooltip
            others = [e.label for e, _ in footer.places() if e.label != label]
            assert all(lit(target(app, other)) == {False} for other in others)
        await pilot.hover("#title")
        await until(pilot, lambda: lit(target(app, "All")) == {False})


async def test_stop_is_large_clickable_and_acts_at_once(station_and_cable):
    station, _ = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        screen = await on_workstation(app, pilot)
        stop = screen.query_one(StopKey)
        assert stop.region.area >= 20
        await pilot.click(stop)
        await shows(pilot, "every motion is stopped")
        assert station.tracker.status().mode is Mode.STOP


@pytest.mark.parametrize("key", ["f12", "s", "ctrl+s"])
async def test_stop_has_three_keys(key, station_and_cable):
    station, _ = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await pilot.press(key)
        await shows(pilot, "every motion is stopped")


async def test_the_age_of_the_last_answer_is_shown_while_the_line_is_silent(
    station_and_cable, monkeypatch
):
    station, _ = station_and_cable
    answer = Event()
    asked, poll = Event(), station.poll

    def silent_poll():
        asked.set()
        answer.wait()
        return poll()

    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        monkeypatch.setattr(station, "poll", silent_poll)
        try:
            await until(pilot, asked.is_set)
            for _ in range(6):
                app._count_silence()
            await until(pilot, lambda: re.search(r"LINK silent \d+ s", screen_words(app)))
            await pilot.press("f2")
            await until(
                pilot,
                lambda: re.search(r"CONNECTED; the last answer is \d+ s old", screen_words(app)),
            )
        finally:
            answer.set()
        await shows(pilot, "LINK OK", "State CONNECTED Unit")


@pytest.mark.parametrize("keys", [["f1"], ["g"], ["g", "enter"], ["f4"], ["f9"], ["ctrl+p"]])
@pytest.mark.parametrize("pulled", [False, True])
async def test_every_screen_says_what_came_of_a_stop(keys, pulled, station_and_cable):
    station, cable = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        below = await on_workstation(app, pilot)
        for key in keys:
            before = app.screen
            await pilot.press(key)
            await until(pilot, lambda: app.screen is not before)  # noqa: B023
        await settled_text(pilot, 3)
        cable.pulled = pulled
        await pilot.press("f12")
        await shows(pilot, "check the cable" if pulled else "every motion is stopped")
        assert app.screen is not below


async def test_stop_works_while_text_is_typed_in_the_palette(station_and_cable):
    station, _ = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await pilot.press("ctrl+p", "s", "f12")
        await until(pilot, lambda: station.tracker.status().mode is Mode.STOP)


async def test_the_palette_has_every_action(station_and_cable):
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        screen = await on_workstation(app, pilot)
        hits = [hit async for hit in ActionProvider(screen).discover()]
        assert len(hits) >= len(ACTIONS)
        for action in ACTIONS:
            found = [hit async for hit in ActionProvider(screen).search(action.label)]
            assert found, action.label


async def test_a_lost_line_is_said_recorded_and_comes_back_by_itself(station_and_cable):
    station, cable = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        cable.pulled = True
        app.worker.submit(StatusRead, lambda s: s.poll())
        await shows(pilot, "LINK LOST", "reconnects automatically")
        assert isinstance(station.session.records[-1], LinkLost)
        cable.pulled = False
        app.worker.reconnect_now()
        await shows(pilot, "LINK OK")
        assert isinstance(station.session.records[-1], LinkRestored)


async def test_a_new_point_is_fitted_and_the_fit_kept_once(station_and_cable):
    station, _ = station_and_cable
    take_points(station, 3, 20.0)
    fits = [r for r in station.session.records if isinstance(r, FitRecord)]
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        victim = station.session.accepted[0].seq
        app.worker.submit(RecordVoided, lambda s: s.void(victim, "test"))
        await until(pilot, lambda: len(app.state.session.fits) == len(fits) + 1)
        await pilot.press("3")
        await shows(pilot, "2 points, rank")
        assert app.state.session.fit_recorded
        await pilot.pause(0.1)
        assert len(station.session.fits) == len(fits) + 1


async def test_what_is_refused_says_why_and_changes_nothing(station_and_cable):
    station, _ = station_and_cable
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        before = station.session.records
        app.emulated_speed = None
        await pilot.press("plus")
        await shows(pilot, "only emulated time can be accelerated")
        assert station.session.records == before


async def test_emulated_time_is_skipped_to_the_next_point(station_and_cable):
    station, _ = station_and_cable
    take_points(station, 1)
    due = 1800.0
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        before = app.state.live.laptop_utc_s
        await shows(pilot, "] in ")
        await pilot.press("w")
        await shows(pilot, "due NOW")
        assert 0.0 < app.state.live.laptop_utc_s - before <= due


async def test_leaving_in_the_middle_of_a_point_asks_first(station_and_cable):
    station, _ = station_and_cable
    station.initialise(confirmed=True)
    station.begin_point()
    async with workstation(station, SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        await pilot.press("ctrl+q")
        await shows(pilot, "The questions of a point are open.", "Leave?", "STOP")
        await pilot.press("n")
        await shows(pilot, "calibration.jsonl")
        assert station.state.attempt is not None


async def test_the_screen_is_complete_without_colours(station_and_cable, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        await on_workstation(app, pilot)
        assert "● LINK OK" in screen_words(app)
        await pilot.press("4")
        await shows(pilot, "● axis 1", "◆ axis 2")


# -- the small parts -------------------------------------------------------------------------


def test_a_limit_bar_shows_where_and_beyond_which_end():
    assert limit_bar(0.0, 10.0, 0.0, 12) == "├●─────────┤"
    assert limit_bar(0.0, 10.0, 10.0, 12) == "├─────────●┤"
    assert limit_bar(0.0, 10.0, -1.0, 12).startswith("●")
    assert limit_bar(0.0, 10.0, 11.0, 12).endswith("●")
    assert {len(limit_bar(0.0, 10.0, value, 12)) for value in (-1.0, 0.0, 5.0, 11.0)} == {12}


def test_a_phase_bar_fills_up():
    assert phase_bar(0.0, 4) == "░░░░"
    assert phase_bar(0.5, 4) == "██░░"
    assert phase_bar(7.0, 4) == "████"


def test_a_sparkline_keeps_the_newest_and_spans_its_values():
    assert sparkline([9.0, 0.0, 1.0, 2.0], 3) == "▁▅█"
    assert len(set(sparkline([2.0, 2.0], 5))) == 1
    assert sparkline([], 5) == ""


def test_a_plots_ansi_becomes_strips_of_full_width_in_its_colours():
    from rich.style import Style

    base = Style.parse("#ffffff on #000000")
    first, second = strips_of_ansi("\x1b[38;5;214mab\x1b[0mc\n\x1b[1mx", 6, base)
    assert (first.text, second.text) == ("abc   ", "x     ")
    segments = list(first)
    assert segments[0].style.color.number == 214
    assert segments[1].style.color == base.color
    assert next(iter(second)).style.bold
    assert all(segment.style.bgcolor == base.bgcolor for segment in segments)


async def test_a_state_older_than_the_one_shown_is_dropped():
    """States come from the worker's thread: a late one must not take the screen back in time."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        station.poll()
        await until(pilot, lambda: app.state.generation == station.state.generation)
        shown = app.state
        older = replace(shown, generation=shown.generation - 1, live=LiveView())
        app.on_told(Told(StateChanged(older)))
        assert app.state is shown
        newer = replace(shown, generation=shown.generation + 1)
        app.on_told(Told(StateChanged(newer)))
        assert app.state is newer


async def test_a_fit_of_fewer_points_that_comes_late_is_dropped():
    station, _ = bench()
    async with workstation(station) as (app, _):
        session = station.session
        newest = FitReady(10_001, session, None, reason="of the newest points")
        app.on_told(Told(newest))
        app.on_told(Told(FitReady(10_000, session, None, reason="late")))
        assert app.fit is newest
        as_new = FitReady(10_001, session, None, reason="planned anew")
        app.on_told(Told(as_new))
        assert app.fit is as_new


async def test_the_thread_of_the_fits_ends_with_the_app():
    station, _ = bench()
    async with workstation(station) as (app, _pilot):
        thread = app._fitter._thread
        assert thread.is_alive()
    thread.join(30.0)
    assert not thread.is_alive()


async def test_news_that_come_while_the_screens_are_taken_down_are_not_for_them(
    station_and_cable, monkeypatch
):
    """A worker's thread tells until the very end, when the widgets of a screen are gone."""
    async with workstation(station_and_cable[0], SMALL) as (app, pilot):
        screen = await on_workstation(app, pilot)
        state = replace(app.state, generation=app.state.generation + 1)
        with monkeypatch.context() as ending:
            ending.setattr(app, "_running", False)
            ending.setattr(screen, "query_one", pytest.fail)
            app.on_told(Told(StateChanged(state)))
        assert app.state.generation == state.generation
