"""Upload with its read-back and rollback, and recomputing another file beside the session."""

import os
from pathlib import Path

import pytest
from procedure_bench import (
    LARGE,
    bench,
    on_loop,
    screen_words,
    shows,
    take_points,
    until,
    workstation,
)
from textual.geometry import Offset
from textual.widgets import Input

from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.records import UploadRecord
from solarcal.session.view import read_session
from solarcal.station.news import ClockAdjusted
from solarcal.station.uploading import propose_upload
from solarcal.tui.dialogs.upload import UploadDialog
from solarcal.tui.widgets.footer import Keys
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Stored


@on_loop
async def test_too_few_points_offer_nothing_to_upload() -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    async with workstation(station) as (app, pilot):
        await pilot.press("u")
        await shows(pilot, "0 accepted points")
        await pilot.press("y")
        assert "Write and read" not in screen_words(app)
        await pilot.press("f6")
        await shows(pilot, "Set here")
        assert len(app.screen_stack) == 2
    assert station.session.uploads == ()


@on_loop
async def test_after_a_rollback_the_upload_is_offered_on_the_same_terms_as_before() -> None:
    """Not on those of the offsets that the unit had a moment ago."""
    station, _ = bench()
    take_points(station, 5)
    station.set_sun_offset()
    assert station.poll().offsets != Offsets()
    async with workstation(station) as (app, pilot):
        await pilot.press("u")
        await shows(pilot, "Upload?")
        dialog = app.screen
        assert isinstance(dialog, UploadDialog)
        before = dialog._proposal
        assert before is not None
        await pilot.press("y")
        await shows(pilot, "once more", "Against it")
        await pilot.press("y")
        await shows(pilot, "read back EQUAL")
        await until(pilot, lambda: dialog._proposal is not before)
        held = dialog._proposal
        assert held is not None
        assert held.held.year_p95_deg == held.kept.year_p95_deg
        await pilot.press("b")
        await shows(pilot, "Rolled back")
        await until(pilot, lambda: dialog._proposal is not held)
        again = dialog._proposal
        assert again is not None
        assert (again.held.year_p95_deg, again.better, again.against) == (
            before.held.year_p95_deg,
            before.better,
            before.against,
        )


@on_loop
async def test_an_upload_is_read_back_and_rolled_back_and_each_is_recorded(
    tmp_path: Path,
) -> None:
    path = tmp_path / "day.jsonl"
    station, _ = bench(path)
    take_points(station, 5)
    before = station.tracker.stored().coefficients
    async with workstation(station) as (app, pilot):
        await pilot.press("u")
        await shows(
            pilot, "in force", "in sigmas", "5 points", "Upload?", "better, more than 99.5 % sure"
        )
        await pilot.press("y")
        # Few points are not done: asked a second time, with the reason of the verdict.
        await shows(pilot, "not DONE. Press", "Against it", "% sure (95 % needed)", "once more")
        await pilot.press("y")
        await shows(pilot, "read back EQUAL", "check points alone do not sign it off")
        await shows(pilot, "no check point was taken", "2 more")
        await pilot.press("pagedown")
        await shows(pilot, "the new ones are in force already")
        uploaded = station.session.uploads[-1].new_coefficients
        assert station.tracker.stored().permanent_coefficients == uploaded
        await pilot.press("b")
        await shows(pilot, "Rolled back", "Not signed off: the newest upload was rolled back")
        await until(pilot, lambda: app.screen._proposal.changes[0].old == before.P1)
        stored = station.tracker.stored()
        assert stored.coefficients == stored.permanent_coefficients == before
        await pilot.press("t")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    uploads = [r for r in read_session(path).records if isinstance(r, UploadRecord)]
    assert [(u.verified, u.rollback) for u in uploads] == [(True, False), (True, True)]


@on_loop
async def test_beside_an_offset_in_force_the_uploaded_coefficients_are_written_again() -> None:
    station, _ = bench()
    take_points(station, 5)
    upload = propose_upload(station.session, station.coefficients_in_force)
    assert upload is not None
    station.upload(upload.rounded, method="robust")
    station.clock.wait(60.0)
    station.set_sun_offset()
    assert station.session.offset_left is not None
    async with workstation(station) as (app, pilot):
        await pilot.press("f8")
        await shows(pilot, "a: those uploaded once more, with O = 0")
        await pilot.press("a")
        await shows(pilot, "read back EQUAL")
        await until(pilot, lambda: not app.screen.offered("again"))
    assert station.session.offset_left is None
    assert station.tracker.stored().offsets == Offsets()


@on_loop
async def test_a_read_back_that_differs_is_cried_out(monkeypatch: pytest.MonkeyPatch) -> None:
    station, _ = bench()
    take_points(station, 4)

    def forgetful(unit: SolarTrakUnit, coefficients: Coefficients, offsets: Offsets) -> Stored:
        del unit, coefficients
        return Stored(Coefficients(), offsets, Coefficients(), offsets)

    monkeypatch.setattr(SolarTrakUnit, "write_coefficients", forgetful)
    async with workstation(station) as (_, pilot):
        await pilot.press("f8")
        await shows(pilot, "Upload?")
        await pilot.press("y")
        # Few points are not done: asked a second time, in other words.
        await shows(pilot, "not DONE", "once more", "Against it")
        await pilot.press("y")
        await shows(pilot, "READ BACK DIFFERS", "Roll back")
    assert [u.verified for u in station.session.uploads] == [False]


@on_loop
async def test_a_link_lost_while_uploading_is_said_and_the_unit_read_anew() -> None:
    station, cable = bench()
    take_points(station, 4)
    async with workstation(station) as (app, pilot):
        await pilot.press("f8")
        await shows(pilot, "Upload?")
        await pilot.press("y")
        await shows(pilot, "once more", "Against it")
        cable.pulled = True
        await pilot.press("y")
        await shows(pilot, "LINK LOST")
        cable.pulled = False
        app.station_worker().reconnect_now()
        await shows(pilot, "Upload?")
        await pilot.press("y")
        # Few points are not done: asked a second time, in other words.
        await shows(pilot, "not DONE", "once more", "Against it")
        await pilot.press("y")
        await shows(pilot, "read back EQUAL")


@pytest.fixture
def saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a session of five points and a damaged one, the damaged one newer."""
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path))
    station, _ = bench(tmp_path / "earlier.jsonl")
    take_points(station, 5)
    station.close()
    (tmp_path / "broken.jsonl").write_text("{}\n")
    os.utime(tmp_path / "earlier.jsonl", (1.0, 1.0))
    return tmp_path


@pytest.mark.parametrize("size", [(80, 24), LARGE])
@on_loop
async def test_space_steps_the_names_and_enter_opens_without_touching_the_session(
    saved: Path, size: tuple[int, int]
) -> None:
    station, _ = bench()
    running = station.session
    async with workstation(station, size) as (app, pilot):
        await pilot.press("ctrl+f9")
        # The newest one is opened at once; the others wait for Enter.
        await shows(pilot, "RECOMPUTE", "broken.jsonl (1 of 2, OPEN)")
        await pilot.press("space")
        await shows(pilot, "earlier.jsonl (2 of 2, Enter opens it)")
        await pilot.press("enter")
        await shows(pilot, "earlier.jsonl (2 of 2, OPEN)", "P1", "P6", "axis error, deg")
        await pilot.press("v")
        await shows(pilot, "residual")
        await pilot.press("escape")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    assert station.session == running


@on_loop
async def test_a_file_that_cannot_be_read_says_why(saved: Path) -> None:
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        await pilot.press("c")
        await shows(pilot, "broken.jsonl:1")


@pytest.mark.parametrize("key", ["a", "ctrl+o", "click"])
@on_loop
async def test_a_file_elsewhere_is_opened_by_its_path(saved: Path, key: str) -> None:
    elsewhere = saved / "stick"
    elsewhere.mkdir()
    (saved / "earlier.jsonl").rename(elsewhere / "roof.jsonl")
    (elsewhere / "points.csv").write_text("utc,ax1_deg\n")
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await pilot.press("f9")
        await shows(pilot, "broken.jsonl (1 of 1, OPEN)")
        if key == "click":
            keys = app.screen.query_one(Keys)
            at = next(at for entry, at in keys.places() if entry.action == "screen.path")
            await pilot.click(keys, offset=at.offset + Offset(1, 0))
        else:
            await pilot.press(key)
        await shows(pilot, "Type or paste the path")
        for name, said in (("none.jsonl", "none.jsonl"), ("points.csv", "points.csv:1")):
            app.screen.query_one(Input).value = str(elsewhere / name)
            await pilot.press("enter")
            # A long path is broken wherever its line ends.
            await until(pilot, lambda said=said: said in screen_words(app).replace(" ", ""))
            await shows(pilot, "Recompute a file")
        app.screen.query_one(Input).value = f"'{elsewhere / 'roof.jsonl'}'"
        await pilot.press("enter")
        await shows(pilot, "roof.jsonl (1 of 2, OPEN)", "P1", "P6")


@on_loop
async def test_an_empty_folder_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "none"))
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        await pilot.press("f9", "space", "enter")
        await shows(pilot, "No saved sessions in")


@on_loop
async def test_evidence_after_the_last_point_reaches_the_verdict_and_the_upload() -> None:
    """A time signal 30 s from the laptop's clock speaks against the points taken before it."""
    station, _ = bench()
    take_points(station, 8)
    async with workstation(station, LARGE) as (app, pilot):
        await until(pilot, lambda: app.judgement is not None)
        assert app.judgement.verdict.state != "does_not_fit"
        app.worker.submit(ClockAdjusted, lambda station: station.set_unit_clock(30.0, 0.5))
        await until(pilot, lambda: app.judgement.verdict.state == "does_not_fit")
        shown = app.judgement
        await pilot.press("u")
        await shows(pilot, "REFUSED: the time signal was +30.0 +- 0.5 s")
        assert app.screen._proposal.judgement is shown
    assert station.session.uploads == ()
