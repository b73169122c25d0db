"""The workstation with a rotator: the station is its controller, the keys are the same."""

import pytest
from procedure_bench import on_loop, screen_words, shows, take_points, until, workstation
from textual.pilot import Pilot

from solarcal.emulated_units import emulated_unit
from solarcal.mount.formula import Offsets
from solarcal.session.journal import Journal
from solarcal.station.clocks import EmulatedClock
from solarcal.station.procedure import Station
from solarcal.station.question_evidence import question_evidence
from solarcal.tui.dialogs.link import ClockDialog, kept_by_station
from solarcal.tui.offset.dialog import SunOffsetDialog
from solarcal.tui.workstation.screen import WorkstationScreen
from solarcal.unit.tracker import ROTATOR, Capabilities, Emulation, Mode


def rotator_bench(noise_deg: float | None = None) -> Station:
    """Connected, its clock set, standing; time moves only by its clock."""
    unit = emulated_unit(
        "tijeras-azel",
        "rotctld",
        settings=("start=2026-06-03T16:00:00Z",),
        seed=7,
        noise_deg=noise_deg,
    )
    unit.tracker.open()
    emulation = unit.tracker.emulation
    assert emulation is not None
    station = Station(unit.tracker, EmulatedClock(emulation), operator="test")
    station.connect()
    station.open_session(Journal.memory)
    station.set_unit_clock()
    station.poll()
    return station


def emulation_of(station: Station) -> Emulation:
    emulation = station.tracker.emulation
    assert emulation is not None
    return emulation


async def pass_time(pilot: Pilot[int], station: Station, seconds: int) -> None:
    """Emulated seconds, with a look of the dialog after each."""
    dialog = pilot.app.screen
    assert isinstance(dialog, SunOffsetDialog)
    for _ in range(seconds):
        station.clock.wait(1.0)
        seen = dialog._view
        await until(pilot, lambda seen=seen: dialog._view is not seen)


@on_loop
async def test_the_reference_check_does_not_claim_to_have_found_counts() -> None:
    station = rotator_bench()
    async with workstation(station) as (_, pilot):
        await pilot.press("f5")
        await shows(pilot, "This unit has no switches", "Start: go to the reference position")
        await pilot.press("enter")
        await shows(pilot, "Check no. 1 recorded", "Are both axes at their marks?")
        await pilot.press("t")
        await until(pilot, lambda: station.poll().mode is Mode.TRACK)
    assert not station.session.ref_checks[0].at_switches
    station.initialise(confirmed=True)
    async with workstation(station) as (_, pilot):
        await pilot.press("f7")
        await shows(pilot, "No switches: the read-outs stood", "at their marks there?")


@on_loop
async def test_a_unit_without_a_clock_has_nothing_to_set_but_a_time_tick_to_use() -> None:
    station = rotator_bench()
    station.ref_check()
    station.track()
    station.clock.wait(120.0)
    station.initialise(confirmed=True)
    set_before = len(station.session.clock_sets)
    async with workstation(station) as (app, pilot):
        await pilot.press("f10")
        await shows(
            pilot, "This unit has no clock", "Use the time tick", "Correction of the laptop"
        )
        assert "Set the unit" not in screen_words(app)
        await pilot.press("enter")
        await shows(pilot, "Give the time tick first")
        await pilot.press("tab", *"3.0", "enter", *"0.2", "enter")
        await shows(pilot, "Used and recorded: the correction was +0.000 s, is +3.000 s")
    assert len(station.session.clock_sets) == set_before + 1
    station.poll()
    assert station.state.live.unit_minus_laptop_s == pytest.approx(3.0, abs=0.01)
    facts = question_evidence(2, station.session, station.state.live)
    assert not [fact for fact in facts if "clock" in fact.sentence]


@on_loop
@pytest.mark.parametrize("typed", ["", "3.0"], ids=["no tick", "no uncertainty"])
async def test_a_time_tick_that_is_refused_lets_the_next_step_follow(typed: str) -> None:
    async with workstation(rotator_bench()) as (app, pilot):
        await pilot.press("f10")
        await shows(pilot, "Use the time tick")
        if typed:
            await pilot.press("tab", *typed, "f5")
            await pilot.pause()
            assert isinstance(app.screen, ClockDialog)
            await pilot.press("enter")
        await pilot.press("enter")
        await shows(pilot, "needs its uncertainty" if typed else "Give the time tick first")
        await pilot.press("f5")
        await shows(pilot, "Start: go to the reference")
        assert len(app.screen_stack) == 2


@on_loop
async def test_the_local_time_is_that_of_the_emulated_site() -> None:
    """Tijeras keeps Mountain Standard Time, 7 h behind UTC; solar noon is near 12:00 of it."""
    station = rotator_bench()
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await shows(pilot, "UTC 2026-06-03 16:00", "Local 09:00", "apparent solar time 08:5")


@on_loop
async def test_sun_offset_point_and_upload_by_the_keys() -> None:
    # Each look at the spot draws the eye's noise, and the dialog looks in real time: how well three
    # points fit would depend on how busy the machine is.
    station = rotator_bench(noise_deg=0.0)
    station.ref_check()
    station.track()
    station.clock.wait(120.0)
    station.initialise(confirmed=True)
    async with workstation(station) as (app, pilot):
        await pilot.press("f6")
        await shows(pilot, "Nothing moves before one", "mode TRACK")
        before = station.poll()
        await pilot.press("5", "right", "right", "up")
        await pass_time(pilot, station, 3)
        after = station.poll()
        moved1 = after.reading1_deg - after.ideal1_deg - before.reading1_deg + before.ideal1_deg
        moved2 = after.reading2_deg - after.ideal2_deg - before.reading2_deg + before.ideal2_deg
        assert (moved1, moved2) == pytest.approx((0.2, 0.1), abs=0.03)
        await pilot.press("enter")
        await shows(pilot, "SET and recorded")
        await pilot.press("escape")
        station.clock.wait(90.0)
        await pilot.press("f7")
        for words in ("1. Did", "2. Did", "3. Do", "Store it?"):
            await shows(pilot, words)
            await pilot.press("y")
        await until(pilot, lambda: len(app.screen_stack) == 1)
    point = station.session.accepted[0]
    assert point.basis == "sun_offset"
    assert point.error_deg is not None
    assert point.error_deg[0] == pytest.approx(station.session.sun_offsets[-1].offsets.O1, abs=1e-5)
    # That point was taken off the Sun: strike it, and let the day be taken by eye.
    station.void(point.seq, "taken to try the keys")
    before_deg = emulation_of(station).truth().day_rms_deg
    assert before_deg > 0.6
    take_points(station, 3, every_min=60.0)
    async with workstation(station) as (_, pilot):
        await pilot.press("u")
        await shows(pilot, "Upload?")
        await pilot.press("y")
        await shows(pilot, "once more", "Against it")
        await pilot.press("y")
        await shows(pilot, "read back EQUAL")
        await pilot.press("t")
        await until(pilot, lambda: station.poll().mode is Mode.TRACK)
    upload = station.session.uploads[0]
    assert station.tracker.stored().coefficients == upload.new_coefficients
    assert station.tracker.stored().offsets == Offsets()
    assert emulation_of(station).truth().day_rms_deg < 0.25


def test_what_the_station_does_for_a_rotator_is_said():
    assert kept_by_station(ROTATOR) == "follows the Sun; keeps its clock, offsets, coefficients"
    assert kept_by_station(Capabilities()) == ""
