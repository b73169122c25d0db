"""The tracker made of what is typed: asks only where a step needs it, and keeps to the law."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from hand_bench import (
    MORNING,
    MOUNT,
    NOTHING,
    SITE,
    Answering,
    SetClock,
    displayed,
    typed_unit,
    unit_model,
)
from msgspec.structs import replace

from solarcal.config import Choice
from solarcal.errors import ConfigurationError, ProcedureRefused
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import PointRecord, Typed
from solarcal.station import opening
from solarcal.station.connect import disagreements, open_tracker
from solarcal.station.next_step import next_step
from solarcal.station.procedure import Station
from solarcal.station.typed.unit import TypedUnit
from solarcal.timescale import format_utc
from solarcal.unit.tracker import Mode

O1, O2 = -0.812, 0.357
READ = displayed(unit_model(), MORNING, O1, O2)


def station_on(unit: TypedUnit, display: Answering) -> Station:
    station = Station(unit, display.clock, site=SITE)
    station.connect()
    station.open_session(Journal.memory)
    return station


def typed(station: Station) -> list[Typed]:
    return [record for record in station.session.records if isinstance(record, Typed)]


def test_opening_asks_once_and_tells_who_it_is() -> None:
    unit, display, _ = typed_unit()
    identity = unit.open()
    assert display.asked == ["open"]
    assert (identity.model, identity.serial) == ("SolarTrak", "4711")
    assert not unit.capabilities.has_link
    assert unit.display is unit
    assert not unit.capabilities.has_link
    assert unit.recent_traffic()[0].startswith("16:00:00  open: p1 0")


def test_a_status_asks_nothing_and_follows_the_sun_by_the_units_clock() -> None:
    unit, display, clock = typed_unit(open={**NOTHING, "clock": "09:00:24"})
    clock.wait(3600.0)
    status = unit.status()
    assert display.asked == ["open"]
    assert status.unit_utc_s == MORNING + 3624.0
    ideal = unit_model().ideal_deg(MORNING + 3624.0)
    assert (status.ideal1_deg, status.ideal2_deg) == ideal
    # Before anything is typed the axes are taken to stand where they are driven.
    assert (status.reading1_deg, status.target1_deg) == (ideal[0], ideal[0])
    assert status.typed_utc_s is None
    assert (status.mode, status.moving) == (Mode.TRACK, (0, 0))
    assert status.counts == tuple(unit_model().counts(axis, ideal[axis]) for axis in (0, 1))


def test_what_was_typed_is_shown_until_it_is_typed_anew() -> None:
    unit, _, clock = typed_unit(offset={**READ, "came1": "-", "came2": "-"})
    now = unit.set_sun_offset()
    clock.wait(600.0)
    later = unit.status()
    assert now.typed_utc_s == later.typed_utc_s == MORNING
    assert later.reading1_deg == now.reading1_deg == float(READ["ax1"])
    assert later.offsets == Offsets(O1, O2)
    assert later.approach == (-1, -1)
    held = replace(MOUNT)
    assert later.target1_deg == pytest.approx(
        unit_model(held).ideal_deg(MORNING + 600.0)[0] + O1, abs=1e-9
    )


def test_axis_1_is_read_on_its_branch_whichever_turn_the_display_counts() -> None:
    for turns in (-360.0, 0.0, 360.0):
        shown = {**READ, "ax1": f"{float(READ['ax1']) + turns:.2f}"}
        unit, _, _ = typed_unit(offset=shown)
        status = unit.set_sun_offset()
        assert status.reading1_deg == pytest.approx(float(READ["ax1"]), abs=1e-9)
        assert status.reading2_deg == float(READ["ax2"])


def test_a_set_sun_offset_on_the_units_own_keys_is_not_taken_back_from_here() -> None:
    unit, display, _ = typed_unit(reference={"complete": "yes"}, offset=READ)
    station = station_on(unit, display)
    station.poll()
    station.set_sun_offset()
    assert station.session.fresh_sun_offset is not None
    assert station.replaced_offsets is None
    with pytest.raises(ProcedureRefused, match="no Set Sun Offset to take back"):
        station.take_back_sun_offset()


def test_stop_says_where_the_key_is_and_nothing_else_moves_it() -> None:
    unit, display, _ = typed_unit()
    with pytest.raises(ProcedureRefused, match="PRESS STOP ON THE UNIT"):
        unit.stop()
    for move in (unit.stow, lambda: unit.jog(1.0, 2.0)):
        with pytest.raises(ProcedureRefused, match="there is no line to it"):
            move()
    assert display.asked == ["open"]


def test_a_point_stands_on_e_and_o_and_the_typed_readings_are_kept_as_typed() -> None:
    in_force = Coefficients(0.2, -0.35, 0.5, 0.2, 0.0008, -0.0006)
    held = unit_model(coefficients=in_force)
    set_ = displayed(held, MORNING, O1, O2, lag=(0.06, -0.05))
    p = {f"p{i}": str(v) for i, v in enumerate(in_force.as_tuple(), start=1)}
    unit, display, clock = typed_unit(
        open={**NOTHING, **p, "clock": "09:00:00"},
        reference={"complete": "yes"},
        offset=set_,
        point=displayed(held, MORNING + 90.0, O1, O2),
    )
    station = station_on(unit, display)
    station.ref_check()
    station.set_sun_offset()
    station.initialise(confirmed=True)
    clock.wait(90.0)
    station.begin_point()
    for _ in range(3):
        station.answer(True)
    progress: list[float] = []
    point = station.gather_point(progress.append)
    assert progress[-1] == 1.0
    assert isinstance(point, PointRecord)
    status = unit.status()
    assert status.offsets == Offsets(O1, O2)
    assert point.read_utc == format_utc(MORNING)
    assert point.ideal_deg == held.ideal_deg(MORNING)
    assert point.reading_deg == (float(set_["ax1"]), float(set_["ax2"]))
    ideal = held.ideal_deg(MORNING)
    target = held.target_deg(MORNING, Offsets(O1, O2))
    assert point.error_deg is not None
    assert point.error_deg == pytest.approx((target[0] - ideal[0], target[1] - ideal[1]), abs=2e-6)
    assert point.coefficients == in_force
    station.store(True)
    assert station.session.ref_checks[0].difference_counts is None
    words = [record.form for record in typed(station)]
    assert words == ["open", "reference", "offset", "point"]
    assert typed(station)[2].values["ax1"] == set_["ax1"]


def test_given_up_at_the_reading_the_attempt_is_aborted() -> None:
    unit, display, _ = typed_unit(reference={"complete": "yes"}, offset=READ)
    station = station_on(unit, display)
    station.ref_check()
    station.set_sun_offset()
    station.initialise(confirmed=True)
    station.begin_point()
    for _ in range(3):
        station.answer(True)
    with pytest.raises(ProcedureRefused):
        station.gather_point()
    assert station.session.points[-1].status == "aborted"
    assert station.session.points[-1].reason == "given up"


def test_the_units_clock_typed_with_a_reading_says_when_it_was() -> None:
    early = displayed(unit_model(), MORNING - 30.0, O1, O2)
    unit, _, _ = typed_unit(offset={**early, "time": "08:59:30"})
    assert unit.set_sun_offset().typed_utc_s == MORNING - 30.0


def test_counts_are_read_through_the_nominal_drive() -> None:
    mount = replace(MOUNT, display="counts")
    held = unit_model(mount)
    shown = displayed(held, MORNING, O1, O2)
    unit, _, _ = typed_unit(mount, offset=shown)
    status = unit.set_sun_offset()
    assert (status.counts1, status.counts2) == (int(shown["ax1"]), int(shown["ax2"]))
    assert status.reading1_deg == pytest.approx(status.target1_deg, abs=0.002)
    assert status.reading2_deg == pytest.approx(status.target2_deg, abs=0.002)


def test_the_clocks_are_compared_before_and_after_setting() -> None:
    unit, display, _ = typed_unit(
        open={**NOTHING, "clock": "08:59:40"}, clock={"clock": "09:00:00"}
    )
    station = station_on(unit, display)
    record = station.set_unit_clock()
    assert (record.before_s, record.after_s) == (-20.0, 0.0)


NEW = Coefficients(0.289, -0.3757, 0.5372, 0.2373, 0.000658, 0.000051)
TYPED_BACK = {
    "p1": "0.2890", "p2": "-.3757", "p3": "0,5372", "p4": "0.2373", "p5": "0.000658",
    "p6": "0.000051", "o1": "0", "o2": "0",
}  # fmt: skip


def test_an_upload_is_what_the_display_shows_after_it_exactly() -> None:
    unit, display, _ = typed_unit(upload=TYPED_BACK)
    station = station_on(unit, display)
    assert station.upload(NEW, method="robust").verified
    display.prepared["upload"] = {**TYPED_BACK, "p3": "0.5373"}
    assert not station.upload(NEW, method="robust").verified
    display.prepared["upload"] = {**TYPED_BACK, "stored": "no"}
    assert not station.upload(NEW, method="robust").verified


def test_a_rollback_asks_for_what_was_replaced() -> None:
    unit, display, _ = typed_unit(
        open={**NOTHING, "o1": "0.25", "clock": "09:00:00"}, upload=TYPED_BACK
    )
    station = station_on(unit, display)
    station.upload(NEW, method="robust")
    display.prepared["upload"] = {**NOTHING, "o1": "0.25"}
    record = station.rollback()
    assert (record.verified, record.rollback) == (True, True)
    assert unit.stored().offsets == Offsets(0.25, 0.0)


def test_after_a_check_only_the_offsets_are_asked_back() -> None:
    unit, display, _ = typed_unit(
        upload=TYPED_BACK, zero={"o1": "0", "o2": "0"}, offset={**READ, "o1": "0", "o2": "0"}
    )
    unit.write_coefficients(NEW, Offsets())
    # Whatever O the check gave: it may have been zero by chance.
    unit.set_sun_offset()
    back = unit.write_coefficients(NEW, Offsets())
    assert display.asked[-1] == "zero"
    assert back.coefficients == NEW


def test_keyed_in_and_given_up_nobody_knows_what_it_holds_until_it_is_read_again() -> None:
    unit, display, _ = typed_unit()
    with pytest.raises(ProcedureRefused):
        unit.write_coefficients(NEW, Offsets())
    display.prepared["held"] = {**NOTHING, "p1": "0.2890"}
    assert unit.stored().coefficients == Coefficients(P1=0.289)
    assert display.asked == ["open", "upload", "held"]


def test_gone_on_with_coefficients_typed_otherwise_are_noticed() -> None:
    unit, display, _ = typed_unit()
    station = Station(unit, display.clock, site=SITE)
    station.connect()
    journal = station.open_session(Journal.memory)
    assert list(disagreements(station)) == []
    again, display, _ = typed_unit(open={**NOTHING, "p2": "0.35", "clock": "09:00:00"})
    later = Station(again, display.clock, site=SITE)
    later.connect()
    later.resume_session(journal)
    (sentence,) = disagreements(later)
    assert "P2 was typed 0.35, but the last value in this session is 0" in sentence


def test_a_check_numbered_here_goes_on_counting_in_a_continued_session() -> None:
    done = {"complete": "yes", "found1": "3", "found2": "-4"}
    unit, display, _ = typed_unit(reference=done)
    station = Station(unit, display.clock, site=SITE)
    station.connect()
    journal = station.open_session(Journal.memory)
    assert [station.ref_check().number for _ in range(2)] == [1, 2]
    again, display, _ = typed_unit(reference=done)
    later = Station(again, display.clock, site=SITE)
    later.connect()
    later.resume_session(journal)
    assert [later.ref_check().number for _ in range(2)] == [3, 4]
    assert {check.difference_counts for check in later.session.ref_checks} == {(3, -4)}


def test_without_somebody_who_reads_the_display_or_without_a_site_it_says_so() -> None:
    with pytest.raises(ConfigurationError, match="a person who reads the display"):
        open_tracker("", "typed", profile=Profile(site=SITE))
    _, display, _ = typed_unit()
    with pytest.raises(ConfigurationError, match="driver typed needs the site"):
        open_tracker("", "typed", display=display)


def test_gone_on_with_the_last_upload_is_what_the_display_must_show() -> None:
    keyed_in = {**NOTHING, "p2": "0.35"}
    unit, display, _ = typed_unit(upload=keyed_in, zero=NOTHING, held=keyed_in)
    station = Station(unit, display.clock, site=SITE)
    station.connect()
    journal = station.open_session(Journal.memory)
    assert station.upload(Coefficients(P2=0.35), method="linear").verified
    for shown, doubts in (("0.35", 0), ("0.53", 1)):
        again, display, _ = typed_unit(open={**NOTHING, "p2": shown, "clock": "09:00:00"})
        later = Station(again, display.clock, site=SITE)
        later.connect()
        later.resume_session(journal)
        assert len(list(disagreements(later))) == doubts


def test_a_real_unit_goes_by_the_laptops_clock_as_well_as_that_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opening, "clock_sigma_s", lambda: 5.0)
    unit, _, _ = typed_unit()
    choice = Choice(driver="typed")
    line = opening.open_line(unit, choice, Profile(site=SITE), output=tmp_path / "new.jsonl")
    assert line.station.session.header.unmodelled.clock_s == 5.0
    line.close()


def test_a_program_that_ended_is_no_restart_of_the_unit() -> None:
    unit, display, _ = typed_unit(reference={"complete": "yes", "found1": "0", "found2": "0"})
    station = Station(unit, display.clock, site=SITE)
    station.connect()
    journal = station.open_session(Journal.memory)
    station.ref_check()
    again, display, _ = typed_unit()
    later = Station(again, display.clock, site=SITE)
    later.connect()
    later.resume_session(journal)
    for _ in range(3):
        later.poll()
    assert later.session.restarts == ()
    assert "lost its reference" not in next_step(later.state).sentence


def test_unfinished_sessions_are_offered_before_anything_is_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved = SimpleNamespace(words=lambda: "yesterday's", path=tmp_path / "yesterday.jsonl")
    asked_for: list[tuple[str, ...]] = []

    def unfinished(*of: str) -> list[SimpleNamespace]:
        asked_for.append(of)
        return [saved]

    monkeypatch.setattr(opening, "unfinished_sessions", unfinished)
    clock = SetClock()
    display = Answering(clock, {})
    unit = TypedUnit(SITE, MOUNT, display, clock)
    with pytest.raises(opening.UnfinishedSessions):
        opening.open_line(unit, Choice(driver="typed", offers_unfinished=True), Profile(site=SITE))
    assert display.asked == []
    assert asked_for[0][0] == "SolarTrak"
