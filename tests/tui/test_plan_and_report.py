"""Verdict and plan on the workstation, the plan screen, the report, refusal of a bad upload."""

import re
import zipfile
from dataclasses import replace

import pytest
from golden_screens import shows_golden
from procedure_bench import (
    LARGE,
    SMALL,
    bench,
    plain_start,
    screen_text,
    screen_words,
    settled_text,
    shows,
    take_points,
    until,
    upload_and_check,
    workstation,
)

from solarcal.config import sessions_dir
from solarcal.errors import FitError
from solarcal.model.verdict import Verdict
from solarcal.report.judgement import plan_table
from solarcal.station import planning
from solarcal.station.fitting import solve
from solarcal.station.news import StatusRead
from solarcal.station.planning import HALF_HOUR_S, MISSED_S
from solarcal.tui.plan import HalfHours, PlanScreen
from solarcal.tui.widgets.footer import StopKey
from solarcal.tui.workstation.screen import WorkstationScreen

SIZES = [pytest.param(SMALL, id="80x24"), pytest.param(LARGE, id="140x45")]


def name_of(what, size):
    return f"{what}-{size[0]}x{size[1]}"


@pytest.fixture(scope="module")
def four_points(tmp_path_factory):
    """A morning's four points, on a file."""
    path = tmp_path_factory.mktemp("day") / "calibration.jsonl"
    station, _ = bench(path, start="2026-06-03T14:30:00Z")
    take_points(station, 4, 30.0)
    return station


async def judged(app, pilot):
    app.push_screen(WorkstationScreen())
    await until(pilot, lambda: app.judgement is not None and app.emulated_speed == 0.0)


@pytest.mark.parametrize("size", SIZES)
async def test_verdict_and_next_point_are_on_screen_in_every_pane(four_points, size):
    async with workstation(four_points, size) as (app, pilot):
        await judged(app, pilot)
        for key in "12345":
            await pilot.press(key)
            await shows(pilot, "CONTINUE: more points", "Year 95 %:", "Point 5 of", "] in ", "STOP")


async def test_the_forecast_of_the_year_is_one_of_the_plots(four_points):
    async with workstation(four_points) as (app, pilot):
        await judged(app, pilot)
        await pilot.press("4", "v", "v", "v", "v")
        await shows(pilot, "mean solar hour down", "Jan", "Dec", "12")


@pytest.mark.parametrize("size", SIZES)
async def test_the_plan_screen(four_points, size):
    async with workstation(four_points, size) as (app, pilot):
        await judged(app, pilot)
        await pilot.press("f4")
        await shows(pilot, "more point", "stop, UTC", "CONTINUE", "now ", "STOP")
        await shows_golden(pilot, name_of("plan", size))


async def test_clouds_leaving_and_points_shape_the_plan_and_can_be_taken_back(four_points):
    async with workstation(four_points) as (app, pilot):
        await judged(app, pilot)
        free = app.judgement.plan
        await pilot.press("p")
        await until(pilot, lambda: isinstance(app.screen, PlanScreen))
        hours = app.screen.query_one(HalfHours)

        def rows_of(plan):
            return [(t - 1.0) // HALF_HOUR_S * HALF_HOUR_S for t in plan.recommended.times_utc_s]

        begins = rows_of(free)
        while hours.chosen_utc_s != begins[0]:
            await pilot.press("down")
        await pilot.press("space")
        await shows(pilot, "x CLOUD", "Asked for: 1 half hour of cloud")
        await until(pilot, lambda: app.judgement.plan is not free)
        assert begins[0] not in rows_of(app.judgement.plan)
        await pilot.press("down", "down", "enter")
        await shows(pilot, "LEAVE", "leave at")
        await pilot.press("right")
        await shows(pilot, "points in all")
        await pilot.press("delete")
        await until(pilot, lambda: "Asked for" not in screen_words(app))
        await until(
            pilot,
            lambda: app.judgement.plan.recommended.times_utc_s == free.recommended.times_utc_s,
        )
        await pilot.press("escape")
        await shows(pilot, "Point 5 of")


async def test_screen_and_command_list_the_same_stops(four_points):
    async with workstation(four_points, LARGE) as (app, pilot):
        await judged(app, pilot)
        await pilot.press("f4")
        await shows(pilot, "stop, UTC")
        lines = [line.split() for line in app.screen.query_one(HalfHours).lines]
    rows = [
        list(filter(None, " ".join(row).split())) for row in plan_table(app.judgement.plan).rows
    ]
    mark, *rest = lines[3]
    assert mark == "▶"
    # Beside the mark the screen has the unit's local time, and not of now.
    assert [lines[2], rest[1:], *(line[1:] for line in lines[4:])] == rows
    assert rows[-1][0] == "01:15", "the last stop is its own time, not the end of its half hour"


async def test_no_word_of_a_reason_is_cut_at_the_edge(four_points):
    async with workstation(four_points, SMALL) as (app, pilot):
        await judged(app, pilot)
        verdict = app.judgement.verdict
        for words in range(76, 80):
            reason = "x" * (words - 5) + " in 0.1 deg; expected: 95 % within 1.457 deg"
            fit = replace(
                app.fit,
                judgement=replace(app.judgement, verdict=replace(verdict, reasons=(reason,))),
            )
            app.fit = fit
            await pilot.press("f4")
            await shows(pilot, "stop, UTC")
            pane = app.screen.query_one("#reasons")
            assert all(len(line) <= pane.content_size.width for line in pane.lines)
            assert " ".join(" ".join(pane.lines[1:]).split()) == f"- {reason}"
            await pilot.press("escape")


async def test_a_click_chooses_a_half_hour(four_points):
    async with workstation(four_points) as (app, pilot):
        await judged(app, pilot)
        await pilot.press("p")
        await shows(pilot, "stop, UTC")
        await settled_text(pilot)
        hours = app.screen.query_one(HalfHours)
        first = hours.chosen_utc_s
        await pilot.click(HalfHours, offset=(8, 5))
        assert hours.chosen_utc_s == first + 2.0 * HALF_HOUR_S


async def test_without_a_point_the_plan_says_when_it_begins():
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await pilot.press("f4")
        await shows(pilot, "The plan begins with the first accepted point")
        await pilot.click(HalfHours, offset=(8, 5))
        await pilot.press("down", "space", "enter")
        await shows(pilot, "The plan begins with the first accepted point")


async def test_a_missed_point_has_the_rest_of_the_day_planned_anew(four_points):
    async with workstation(four_points) as (app, pilot):
        await judged(app, pilot)
        plan = app.judgement.plan
        missed_utc_s = plan.recommended.times_utc_s[0] + MISSED_S + 1.0
        live = replace(app.state.live, laptop_utc_s=missed_utc_s)
        app._fitter.fit_if_needed(replace(app.state, live=live))
        await until(pilot, lambda: app.judgement.plan.at_utc_s == missed_utc_s)


def test_a_failure_to_judge_does_not_lose_the_fit(four_points, monkeypatch):
    def fails(*_):
        raise FitError("the forecast went wrong")

    monkeypatch.setattr("solarcal.station.planning.analyse_with_options", fails)
    message = planning.fit_message(3, four_points.session)
    assert message.judgement is None
    assert "the forecast went wrong" in message.reason
    assert (message.solution.values == solve(four_points.session).values).all()


@pytest.mark.parametrize("size", SIZES)
async def test_the_report_is_written_beside_the_session_and_says_where(four_points, size):
    beside = four_points.session_path.parent
    async with workstation(four_points, size) as (app, pilot):
        await judged(app, pilot)
        await pilot.press("e")
        await shows(pilot, "calibration.jsonl, 4 points", "not signed off: nothing was uploaded")
        assert str(beside) in screen_words(app).replace(" ", "")
        await pilot.press("y")
        await shows(pilot, "Written. Not signed off", "calibration-certificate.html", ".zip")
    assert not list(sessions_dir().glob("*"))
    stem = beside / "calibration-certificate"
    for ending in (".html", ".md", ".svg", ".txt"):
        text = stem.with_suffix(ending).read_text(encoding="utf-8")
        assert "calibration certificate" in text.lower()
    with zipfile.ZipFile(stem.with_suffix(".zip")) as archive:
        assert {"calibration.jsonl", "SHA256SUMS"} <= set(archive.namelist())


async def test_without_a_file_there_is_no_report():
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await pilot.press("e")
        await shows(pilot, "no session file to write a report of")


async def test_an_upload_that_does_not_fit_wants_a_reason_which_is_kept(monkeypatch):
    station, _ = bench()
    take_points(station, 4)
    monkeypatch.setattr(
        "solarcal.model.analysis.conclude",
        lambda *_, **__: Verdict("does_not_fit", ("the points scatter by 0.40 deg",)),
    )
    async with workstation(station) as (_, pilot):
        await pilot.press("u")
        await shows(
            pilot, "REFUSED", "scatter by 0.40 deg", "DOES NOT FIT", "as the unit stores it"
        )
        await pilot.press("y")
        await shows(pilot, "Type the reason")
        await pilot.press("enter")
        await shows(pilot, "needs a reason")
        assert not station.session.uploads
        await pilot.press(*"test", "enter")
        await shows(pilot, "read back EQUAL")
    assert station.session.uploads[-1].forced == "test"


async def test_check_points_within_the_tolerance_sign_off(tmp_path):
    from solarcal.station.technician import AutomaticTechnician, Schedule

    station, _ = bench(tmp_path / "day.jsonl")
    spot = station.tracker.emulation.spot
    technician = AutomaticTechnician(station, spot, Schedule(points=11, every_min=45.0, checks=2))
    station.initialise(confirmed=True)
    technician.take_points()
    technician.upload()
    technician.take_checks()
    async with workstation(station) as (app, pilot):
        await judged(app, pilot)
        await shows(pilot, "Signed off: calibrated and proven", "SIGNED OFF", "2 check points")
        await pilot.press("u")
        await shows(pilot, "SIGNED OFF: 2 check points after the upload")


async def test_after_a_reconnection_the_speed_is_read_again():
    station, cable = bench()
    async with workstation(station) as (app, pilot):
        await judged_speed(app, pilot)
        station.tracker.emulation.set_speed(5.0)
        cable.pulled = True
        app.station_worker().submit(StatusRead, lambda s: s.poll())
        await shows(pilot, "LINK LOST")
        app.emulated_speed = 120.0
        cable.pulled = False
        app.station_worker().reconnect_now()
        await until(pilot, lambda: app.emulated_speed == 5.0)


async def judged_speed(app, pilot):
    app.push_screen(WorkstationScreen())
    await until(pilot, lambda: app.emulated_speed == 0.0)


async def test_ctrl_q_leaves_from_a_dialog_too():
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await pilot.press("n")
        await shows(pilot, "STOP")
        await pilot.press("ctrl+q")
        await until(pilot, lambda: app.return_code is not None or app._exit)


async def test_in_the_middle_of_a_point_ctrl_q_asks_over_its_dialog():
    station, _ = bench()
    station.initialise(confirmed=True)
    station.begin_point()
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await pilot.press("f10")
        await pilot.press("ctrl+q", "ctrl+q")
        await shows(pilot, "The questions of a point are open.", "Leave?")
        await pilot.press("n")
        await until(pilot, lambda: "Leave?" not in screen_words(app))


@pytest.mark.parametrize("size", SIZES)
async def test_notices_have_rows_of_their_own_and_lie_over_nothing(size):
    station, _ = bench()
    app = plain_start()
    async with app.run_test(size=size, notifications=True) as pilot:
        app.adopt(station)
        app.push_screen(WorkstationScreen())
        await shows(pilot, "LINK OK")
        await until(pilot, lambda: app.emulated_speed == 0.0)
        before = (await settled_text(pilot)).split("\n")
        for number in range(12):
            app.notify(f"notice {number}, as long as a notice may well become in a bad hour")
        await shows(pilot, "notice 11", "F12 s ^S")
        text = (await settled_text(pilot)).split("\n")
        log = app.screen.query_one("#log").region
        assert 1 <= log.height <= 4
        assert text[:5] == before[:5], "title, file, next step and verdict"
        # The last row of the pane says how many more follow; they are a key away.
        kept, shown = ([row[:55].rstrip() for row in rows[5:16]] for rows in (before, text))
        assert kept == shown, "clocks"
        if size == SMALL:
            assert f"▼ {log.height - 1} more" in "\n".join(text)
            await pilot.press("end")
            await shows(pilot, "mode TRACK")
        stop = app.screen.query_one(StopKey).region
        assert text[stop.y :] == before[stop.y :]
        assert "notice 11" in text[log.y], "the newest first"
        await pilot.press("n")
        await shows(pilot, "Remark")
        app.notify("a notice while a dialog is open")
        # Above what the dialog asks, which stays.
        await shows(pilot, "a notice while a dialog is open", "Written into the session file")
        rows = screen_text(app).split("\n")
        assert "a notice while" in rows[app.screen.query_one("#said").region.y - 1]
        await pilot.press("escape")
        for key, words in (
            ("f1", "THE PROCEDURE"), ("f4", "PLAN"), ("f9", "RECOMPUTE"), ("ctrl+p", "Search"),
        ):  # fmt: skip
            await pilot.press(key)
            await shows(pilot, words)
            app.notify(f"a notice over {words}", severity="error")
            await shows(pilot, f"! a notice over {words}", "STOP", "F12")
            assert not app.screen.query("Toast")
            await pilot.press("escape")
        app.worker.close()


def uploaded(folder, checks):
    """Enough points, uploaded, and so many check points."""
    station, cable = bench(folder / "calibration.jsonl", start="2026-06-03T14:00:00Z")
    take_points(station, 12, 50.0)
    upload_and_check(station, checks)
    return station, cable


@pytest.fixture(scope="module")
def proven(tmp_path_factory):
    return uploaded(tmp_path_factory.mktemp("proof"), 2)[0]


async def second_check(app, pilot, station, cable):
    """As a technician does it: offset, point, three times yes, store."""
    station.tracker.emulation.advance(1800.0)
    await pilot.press("f6")
    await shows(pilot, "Set here")
    await pilot.press("enter")
    await shows(pilot, "SET and recorded")
    await pilot.press("full_stop")
    await shows(pilot, "a check point, or one more data point?")
    await pilot.press("enter")
    for question in ("1. Did", "2. Did", "3. Do"):
        await shows(pilot, question)
        await pilot.press("y")
    for _ in range(40):
        if "never fitted" in screen_text(app):
            break
        station.tracker.emulation.advance(1.0)
        await pilot.pause(0.05)
    await shows(pilot, "never fitted")
    await until(pilot, lambda: app.screen.offered("yes"))
    await pilot.press("y")


async def test_the_second_check_point_shows_the_year_before_and_after(tmp_path):
    station, cable = uploaded(tmp_path, 1)
    async with workstation(station, LARGE) as (app, pilot):
        await judged(app, pilot)
        await second_check(app, pilot, station, cable)
        await shows(pilot, "SIGNED OFF: 2 check points", "BEFORE, as found", "AFTER, as uploaded")
        await pilot.press("e")
        await shows(pilot, "The certificate of this session as of now")
        await pilot.press("v")
        await shows(pilot, "SIGNED OFF: 2 check points")
        await pilot.press("escape", "escape")
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))


@pytest.mark.parametrize("size", SIZES)
async def test_before_and_after_are_beside_each_other(proven, size):
    """The errors on one ruler: what is left looks as small as it is."""
    async with workstation(proven, size) as (app, pilot):
        await judged(app, pilot)
        await pilot.press("e")
        await shows(pilot, "Before and after")
        await pilot.press("v")
        await shows(pilot, "after the upload", "AFTER, as uploaded", "STOP")
        years = [app.screen.query_one(f"#{side}-year") for side in ("before", "after")]
        errors = [app.screen.query_one(f"#{side}-errors") for side in ("before", "after")]
        for left, right in (years, errors):
            assert left.region.y == right.region.y
        if size == LARGE:
            await shows_golden(pilot, name_of("before-and-after", size))
            assert all(plot.display for plot in (*years, *errors))
            return
        await shows(pilot, "Jan", "Nov")
        await pilot.press("v")
        await shows(pilot, "model", "apparent solar time")
        await shows_golden(pilot, name_of("before-and-after", size))
        ticks = [
            re.findall(r"[+ -]\d\.\d+(?=┤)", row)
            for row in screen_text(app).split("\n")
            if row.count("┤") == 2
        ]
        assert len(ticks) >= 3
        assert all(left == right for left, right in ticks), "one ruler"
