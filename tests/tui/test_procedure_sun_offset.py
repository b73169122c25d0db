"""Set Sun Offset by the keys; the emulator's time is moved by hand, one renewal after the other."""

import re
from types import SimpleNamespace

import msgspec
import pytest
from procedure_bench import (
    bench,
    on_loop,
    screen_words,
    shows,
    take_points,
    unreferenced_bench,
    until,
    workstation,
)
from textual.pilot import Pilot

from solarcal.emulator.emulation import Emulator
from solarcal.station.procedure import Station
from solarcal.tui.offset.dialog import SunOffsetDialog
from solarcal.tui.offset.spot import Sunspot
from solarcal.tui.offset.words import jog_warning
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Emulation, Mode, Spot


async def pass_time(pilot: Pilot[int], time: Emulation | Emulator, seconds: float) -> None:
    """Emulated seconds, with a look of the dialog after each."""
    dialog = pilot.app.screen
    assert isinstance(dialog, SunOffsetDialog)
    for _ in range(int(seconds)):
        time.advance(1.0)
        seen = dialog._view
        # Now, and not at the next tick of its clock.
        dialog._look()
        await until(pilot, lambda seen=seen: dialog._view is not seen)


async def opened(pilot: Pilot[int]) -> SunOffsetDialog:
    await pilot.press("f6")
    await shows(pilot, "Nothing moves before one", "mode TRACK")
    dialog = pilot.app.screen
    assert isinstance(dialog, SunOffsetDialog)
    return dialog


def standing(station: Station) -> tuple[float, float]:
    status = station.poll()
    return status.reading1_deg - status.ideal1_deg, status.reading2_deg - status.ideal2_deg


@on_loop
async def test_arrows_jog_in_the_chosen_step_and_enter_sets_the_offset() -> None:
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        await opened(pilot)
        before = standing(station)
        await pilot.press("5", "left", "left", "down")
        await pass_time(pilot, station.tracker.emulation, 5)
        after = standing(station)
        assert after[0] - before[0] == pytest.approx(-0.2, abs=0.02)
        assert after[1] - before[1] == pytest.approx(-0.1, abs=0.02)
        await pilot.press("enter")
        await shows(pilot, "SET and recorded")
        offset = station.session.sun_offsets[-1].offsets
        assert abs(offset.O1 - after[0]) < 0.02
        assert abs(offset.O2 - after[1]) < 0.02
        assert station.poll().mode is Mode.TRACK


@on_loop
async def test_u_puts_the_offsets_back_at_once_and_after_the_dialog_was_left() -> None:
    station, _ = bench()
    before = station.poll().offsets
    async with workstation(station) as (app, pilot):
        for left in (False, True):
            await opened(pilot)
            await pilot.press("5", "left")
            await pass_time(pilot, station.tracker.emulation, 5)
            await pilot.press("enter")
            await shows(pilot, "SET and recorded", f"u: back to O1 {before.O1:+.4f}", "Undo")
            if left:
                await pilot.press("escape")
                await until(pilot, lambda: not isinstance(app.screen, SunOffsetDialog))
                await opened(pilot)
                await shows(pilot, f"u: offsets back to O1 {before.O1:+.4f}")
            await pilot.press("u")
            await shows(pilot, "Set Sun Offset taken back", "is struck")
            assert station.poll().offsets == before
            assert station.session.sun_offsets == ()
            await pilot.press("u")
            await shows(pilot, "no Set Sun Offset here to take back")
            await pilot.press("escape")
            await until(pilot, lambda: not isinstance(app.screen, SunOffsetDialog))


@on_loop
async def test_once_the_offset_is_set_the_key_of_another_step_leads_on() -> None:
    """Before, and after a new jog, the dialog stays: the unit does not track."""
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        dialog = await opened(pilot)
        await pilot.press("5", "left")
        await pass_time(pilot, station.tracker.emulation, 5)
        await pilot.press("f3")
        await pilot.pause()
        assert app.screen is dialog
        await pilot.press("enter")
        await shows(pilot, "SET and recorded")
        await pilot.press("right")
        await until(pilot, lambda: station.poll().mode is Mode.JOG and not dialog.finished())
        await pilot.press("f3")
        await pilot.pause()
        assert app.screen is dialog
        await pilot.press("enter")
        await until(pilot, dialog.finished)
        await pilot.press("f3")
        await shows(pilot, "Are you sure?")
        assert len(app.screen_stack) == 2


@on_loop
async def test_going_backward_warns_until_b_has_gone_behind_and_forward() -> None:
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        await opened(pilot)
        # The Sun goes towards smaller AX1 in the morning: right is backward.
        await pilot.press("5", "right")
        await pass_time(pilot, station.tracker.emulation, 4)
        await shows(pilot, "Axis 1 did NOT come from behind", "Press b")
        await pilot.press("enter")
        await shows(pilot, "SET and recorded", "axis 1 did NOT come from behind", "sets it anew")
        await pilot.press("right")
        await pass_time(pilot, station.tracker.emulation, 4)
        await pilot.press("b")
        await pass_time(pilot, station.tracker.emulation, 10)
        await shows(pilot, "Both axes came from behind")


@pytest.mark.parametrize(
    ("behind", "who"),
    [
        ((False, True), "Axis 1 did"),
        ((True, False), "Axis 2 did"),
        ((False,) * 2, "Axes 1 and 2 did"),
    ],
)
def test_the_warning_names_the_axes_that_came_from_the_wrong_side(
    behind: tuple[bool, bool], who: str
) -> None:
    view = SimpleNamespace(
        status=SimpleNamespace(referenced=True),
        watch=SimpleNamespace(from_behind=behind),
        aim=SimpleNamespace(behind=(False, False)),
    )
    assert jog_warning(view, None).startswith(f"{who} NOT come from behind: the backlash")


@on_loop
async def test_escape_leaves_without_writing_and_the_unit_tracks_again() -> None:
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await opened(pilot)
        before = station.poll().offsets
        await pilot.press("left")
        await pass_time(pilot, station.tracker.emulation, 3)
        await pilot.press("escape")
        await until(pilot, lambda: len(app.screen_stack) == 1)
        assert station.session.sun_offsets == ()
        status = station.poll()
        assert (status.offsets, status.mode) == (before, Mode.TRACK)


@on_loop
async def test_stop_ends_the_jog_and_arrows_do_not_move_a_stopped_unit() -> None:
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        await opened(pilot)
        await pilot.press("8", "left")
        await pass_time(pilot, station.tracker.emulation, 1)
        await pilot.press("s")
        await until(pilot, lambda: station.state.live.status.mode is Mode.STOP)
        await pilot.press("left")
        await shows(pilot, "track first")
        station.tracker.emulation.advance(10.0)
        assert station.poll().moving == (0, 0)
        await pilot.press("t")
        await until(pilot, lambda: station.state.live.status.mode is Mode.TRACK)


@pytest.mark.slow
@on_loop
async def test_far_from_the_sun_the_degrees_to_go_and_the_seconds_are_said() -> None:
    """After a reference check the axes stand at their switches, tens of degrees away."""
    station, _ = unreferenced_bench()
    station.ref_check()
    async with workstation(station) as (_, pilot):
        await pilot.press("f6")
        await shows(pilot, "press t, and it goes to its Sun")
        await pilot.press("t")
        await until(pilot, lambda: station.state.live.status.mode is Mode.TRACK)
        await pass_time(pilot, station.tracker.emulation, 3)
        found = re.search(
            r"Driving to the Sun: (\d+) deg to go, about (\d+) s", screen_words(pilot.app)
        )
        assert found is not None, screen_words(pilot.app)
        to_go, left_s = int(found[1]), int(found[2])
        assert to_go > 10
        await pass_time(pilot, station.tracker.emulation, 3)
        await shows(pilot, "deg to go, about")
        await pass_time(pilot, station.tracker.emulation, left_s)
        await shows(pilot, "The axes have arrived.")


@on_loop
async def test_before_the_reference_check_t_and_arrows_are_refused_naming_its_key() -> None:
    station, _ = unreferenced_bench()
    async with workstation(station) as (_, pilot):
        await pilot.press("f6")
        await shows(pilot, "no reference: do a reference check [F5]")
        for key in ("t", "left"):
            await pilot.press(key)
            await shows(pilot, "Refused. The unit has no reference", "[F5]")
        await pilot.press("f5")
        await shows(pilot, "Start: drive to the switches")
    assert station.poll().moving == (0, 0)


@on_loop
async def test_what_follows_a_set_sun_offset_is_said_and_its_key_leads_on_also_after_leaving() -> (
    None
):
    station, _ = bench()
    async with workstation(station) as (app, pilot):
        await opened(pilot)
        await pilot.press("enter")
        await shows(pilot, "SET and recorded", "next [F3]: Initialise the data file")
        assert "Take point" not in screen_words(app)
        await pilot.press("f3")
        await shows(pilot, "Are you sure?")
        await pilot.press("y")
        await until(pilot, lambda: station.session.initialised is not None)
        dialog = await opened(pilot)
        await shows(pilot, "The offset is set", "take the point [.]", "Take point")
        await pilot.press("5", "left")
        await until(pilot, lambda: not dialog.finished())
        await pilot.press("full_stop")
        await shows(pilot, ". not taken: not asked yet")
        await pilot.press("escape")
        await until(pilot, lambda: not isinstance(app.screen, SunOffsetDialog))
        await opened(pilot)
        await pilot.press("full_stop")
        await shows(pilot, "1. Did you do a reference check?")


@on_loop
async def test_a_lost_link_stops_the_jog_and_nothing_moves_when_it_is_back() -> None:
    station, cable = bench()
    async with workstation(station) as (app, pilot):
        await opened(pilot)
        await pilot.press("8", "left")
        await pass_time(pilot, cable.emulator, 1)
        cable.pulled = True
        await shows(pilot, "LINK LOST")
        cable.emulator.advance(20.0)
        cable.pulled = False
        app.station_worker().reconnect_now()
        await shows(pilot, "The link is back")
        first = station.poll()
        await until(pilot, lambda: "at rest" in screen_words(app))
        station.tracker.emulation.advance(20.0)
        assert station.poll().reading1_deg == first.reading1_deg
        assert first.mode is Mode.MANUAL


@on_loop
async def test_on_a_real_unit_the_calculator_turns_readings_into_jogs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """H 500, Do 4, Ds 13: an edge of 5.37 instead of 4.5 is 0.05 deg on the sky."""
    station, cable = bench()
    monkeypatch.setattr(SolarTrakUnit, "emulation", property(lambda unit: None))
    async with workstation(station) as (_, pilot):
        await opened(pilot)
        await shows(pilot, "Sunspot plate", "Jog E")
        before = standing(station)
        await pilot.press("tab")
        for text in ("500", "4", "13", "4.5", "5.3727"):
            await pilot.press(*text, "tab")
        await pilot.press("escape", "j")
        await shows(pilot, "axis 1 by +0.000, axis 2 by +0.050")
        await pass_time(pilot, cable.emulator, 4)
        after = standing(station)
        assert after[1] - before[1] == pytest.approx(0.05, abs=0.02)


@on_loop
async def test_a_field_of_the_calculator_that_is_empty_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    station, _ = bench()
    monkeypatch.setattr(SolarTrakUnit, "emulation", property(lambda unit: None))
    async with workstation(station) as (_, pilot):
        await opened(pilot)
        await pilot.press("j")
        await shows(pilot, "H plate over mirror: '' is not a number")


def test_the_spot_is_where_the_arrow_keys_have_to_go() -> None:
    sight, status = Sunspot(), bench()[0].poll()
    sight.show(Spot(True, 0.4, -0.2), 30.0)
    assert sight.words(status) == (
        "spot 0.200 right, 0.200 down (deg, sky)\n+-0.5 deg plate; press arrows towards it"
    )
    sight.show(Spot(False, 0.0, 0.0), 30.0)
    for mode, moving, told in (
        (Mode.MANUAL, (0, 0), "no spot on the plate: jog back or\npress t, which tracks the Sun"),
        (Mode.JOG, (1, 0), "no spot on the plate: jog back or\npress t, which tracks the Sun"),
        (Mode.TRACK, (1, 0), "no spot on the plate yet:\nthe axes still drive to the Sun"),
        (Mode.TRACK, (0, 0), "no spot on the plate: the unit tracks,\nbut points elsewhere; jog"),
    ):
        seen = msgspec.structs.replace(status, mode=mode, moving=moving)
        assert sight.words(seen).startswith(told)


def test_the_plate_grows_with_the_spots_distance() -> None:
    sight = Sunspot()
    sight.show(Spot(True, 0.0, 0.1), 30.0)
    near = sight.half_width_deg
    sight.show(Spot(True, 0.0, 1.5), 30.0)
    assert sight.half_width_deg > near


@on_loop
async def test_the_step_of_an_arrow_suits_the_distance_and_can_be_fixed() -> None:
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        dialog = await opened(pilot)
        await until(pilot, lambda: dialog._view is not None and dialog._view.spot is not None)
        assert dialog._view is not None
        assert dialog._view.spot is not None
        far = abs(dialog._view.spot.error1_deg)
        assert far > 0.3
        assert dialog._steps.step_deg(1, 0, dialog._view.spot) == pytest.approx(far, rel=0.5)
        await pilot.press("3")
        assert dialog._steps.step_deg(1, 0, dialog._view.spot) == 0.02
        await pilot.press("0")
        assert dialog._steps.step_deg(1, 0, dialog._view.spot) == pytest.approx(far, rel=0.5)


@on_loop
async def test_a_held_arrow_grows_its_step_and_leaves_little_to_do_after_release() -> None:
    """On a unit without a spot device nothing says how far the centre is."""
    station, _ = bench()
    async with workstation(station) as (_, pilot):
        dialog = await opened(pilot)
        await until(pilot, lambda: dialog._view is not None)
        dialog._view = None
        dialog._steps.jogging = True  # as while the unit answers
        steps = []
        for _ in range(30):
            dialog.action_jog(1, 0)
            steps.append(dialog._steps.step_deg(1, 0, None))
        assert steps[0] < steps[-1] == 0.5
        assert steps == sorted(steps)
        assert dialog._steps._to_jog[0] <= 3 * 0.5


@pytest.mark.slow
@on_loop
async def test_the_fit_brings_the_axes_near_the_sun_from_behind() -> None:
    station, _ = bench(start="2026-06-03T13:30:00Z")
    take_points(station, 3, 40.0)
    async with workstation(station) as (app, pilot):
        await until(pilot, lambda: app.fit is not None and app.fit.solution is not None)
        dialog = await opened(pilot)
        await shows(pilot, "To fit")
        for follows in (False, True):
            # Its button has made room for that of the fit.
            await pilot.press("f")
            await until(pilot, lambda follows=follows: dialog._jog.follows is follows)
        await pilot.press("p")
        await shows(pilot, "from behind")
        await pass_time(pilot, station.tracker.emulation, 20)
        view = pilot.app.screen._view
        assert all(view.watch.from_behind)
        assert abs(view.spot.error2_deg) < 0.3
        await pilot.press("B")
        await until(pilot, lambda: pilot.app.screen.query_one("#big").display)
        await pilot.press("enter")
        await shows(pilot, "SET and recorded")
        await pilot.press("full_stop")
        await shows(pilot, "1. Did you do a reference check?")
