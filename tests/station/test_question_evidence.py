"""The evidence beside the three questions, and what it speaks for."""

from dataclasses import replace

import msgspec
import pytest
from emulated_station import emulated_station

from solarcal.station.next_step import next_step
from solarcal.station.procedure import Station
from solarcal.station.question_evidence import Fact, ago_text, question_evidence
from solarcal.timescale import format_utc
from solarcal.unit.tracker import Mode, Spot


def facts(station: Station, number: int, spot: Spot | None = None) -> tuple[Fact, ...]:
    return question_evidence(number, station.session, station.state.live, spot)


def against(said: tuple[Fact, ...]) -> str:
    return " ".join(fact.sentence for fact in said if fact.against)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(-3, "0 s ago"), (40, "40 s ago"), (720, "12 min ago"), (11100, "3 h 05 min ago")],
)
def test_how_long_ago(seconds: float, words: str) -> None:
    assert ago_text(seconds) == words


def test_a_fresh_reference_check_is_told_with_its_counts() -> None:
    station, _ = emulated_station()
    said = facts(station, 0)
    assert not against(said)
    assert "Check no. 1" in said[0].sentence
    assert "axis 1" in said[1].sentence
    assert said[1].sentence.endswith("; any number is normal at the first check.")
    station.ref_check()
    assert "normal" not in facts(station, 0)[1].sentence


def test_without_a_reference_check_the_answer_should_be_no() -> None:
    station, _ = emulated_station()
    empty = replace(station.session, ref_checks=())
    assert "No reference check" in against(question_evidence(0, empty, station.state.live))


def test_a_check_that_was_stopped_does_not_count() -> None:
    station, _ = emulated_station()
    stopped = msgspec.structs.replace(station.session.ref_checks[-1], complete=False)
    session = replace(station.session, ref_checks=(stopped,))
    assert "did NOT end" in against(question_evidence(0, session, station.state.live))


def test_counts_missed_since_the_check_before_are_said() -> None:
    station, emulator = emulated_station()
    emulator.lose_counts(1, 40)
    station.ref_check()
    station.track()
    assert "counts were missed" in facts(station, 0)[1].sentence


def test_the_first_check_after_a_restart_misses_no_counts_the_next_one_may() -> None:
    station, emulator = emulated_station()
    emulator.reboot()
    station.poll()
    station.ref_check()
    said = facts(station, 0)[1].sentence
    assert said.endswith("; any number is normal after a restart.")
    emulator.lose_counts(1, 40)
    station.ref_check()
    assert "counts were missed" in facts(station, 0)[1].sentence


def test_a_check_that_was_stopped_before_the_first_one_misses_no_counts() -> None:
    station, _ = emulated_station()
    first = msgspec.structs.replace(
        station.session.ref_checks[-1], number=2, difference_counts=(656, 361)
    )
    stopped = msgspec.structs.replace(first, seq=first.seq - 1, number=1, complete=False)
    session = replace(station.session, ref_checks=(stopped, first))
    said = question_evidence(0, session, station.state.live)[1].sentence
    assert "axis 1 +656" in said
    assert "missed" not in said


def test_a_unit_that_lost_its_reference_is_told() -> None:
    station, emulator = emulated_station()
    emulator.reboot()
    station.poll()
    assert "NOT referenced" in against(facts(station, 0))


def test_no_sun_offset_speaks_for_no() -> None:
    station, _ = emulated_station()
    assert "No Set Sun Offset" in against(facts(station, 1))


def test_a_sun_offset_is_told_with_its_age_and_sides() -> None:
    station, _ = emulated_station()
    set_at = format_utc(station.clock.utc_s(), 0)
    station.set_sun_offset()
    station.clock.wait(120.0)
    station.poll()
    said = facts(station, 1)
    assert not against(said)
    # The moment it was set, in hours, minutes and seconds.
    hms = set_at.partition("T")[2].rstrip("Z")
    assert said[0].sentence.startswith(f"Set at {hms} UTC, 2 min ago: O1 ")
    assert "came from behind" in said[1].sentence


def test_a_sun_offset_gives_no_second_point() -> None:
    """Struck out, not stored or answered NO: the next point from it would have the same error."""
    for ending in ("struck", "rejected", "NO", "NO to the check"):
        station, _ = emulated_station()
        station.set_unit_clock()
        offset = station.set_sun_offset()
        station.initialise(confirmed=True)
        station.clock.wait(60.0)
        station.begin_point()
        station.answer(not ending.endswith("check"))
        if ending != "NO to the check":
            station.answer(ending != "NO")
        if ending in ("struck", "rejected"):
            station.answer(True)
            station.gather_point()
            point = station.store(ending == "struck")
            if ending == "struck":
                assert not station.session.unused_sun_offset
                station.void(point.seq, "not on the Sun")
        said, step = against(facts(station, 1)), next_step(station.state)
        assert station.session.unused_sun_offset == offset
        if ending == "NO to the check":
            assert not said
            assert step.action == "take_point"
            continue
        assert "was given up with its point: one more would repeat its error; set it again" in said
        assert step.action == "sun_offset"
        # The unit still has it: it can be put back.
        station.take_back_sun_offset()
        assert "No Set Sun Offset seen" in against(facts(station, 1))


def test_an_old_sun_offset_speaks_for_no() -> None:
    station, _ = emulated_station()
    station.set_sun_offset()
    station.clock.wait(1900.0)
    station.poll()
    assert "half an hour" in against(facts(station, 1))


def test_an_offset_that_no_tracker_has_speaks_for_no() -> None:
    station, _ = emulated_station()
    record = station.set_sun_offset()
    station.poll()
    for off_deg, told in ((14.0, False), (16.0, True)):
        reading = (record.ideal_deg[0], record.ideal_deg[1] + off_deg)
        far = msgspec.structs.replace(record, reading_deg=reading)
        session = replace(station.session, sun_offsets=(far,))
        said = against(question_evidence(1, session, station.state.live))
        assert said == ("Set 16 deg from the ideal Sun: is the collector on the Sun?" * told)


def test_the_wrong_side_is_named() -> None:
    station, _ = emulated_station()
    record = station.set_sun_offset()
    wrong = msgspec.structs.replace(record, approach=(-record.approach[0], record.approach[1]))
    session = replace(station.session, sun_offsets=(wrong,))
    said = against(question_evidence(1, session, station.state.live))
    assert "Axis 1 came from the WRONG side" in said


def test_offsets_changed_on_the_units_own_keys_are_seen() -> None:
    station, _ = emulated_station()
    station.set_sun_offset()
    station.tracker.write_coefficients(station.coefficients_in_force, station.poll().offsets)
    emulated = station.tracker.set_sun_offset()
    assert emulated.offsets == station.session.sun_offsets[-1].offsets or "others now" in against(
        facts(station, 1)
    )


def test_tracking_is_told_with_what_the_eye_sees() -> None:
    station, _ = emulated_station()
    station.set_sun_offset()
    station.clock.wait(90.0)
    station.poll()
    said = facts(station, 2, Spot(True, 0.012, -0.034))
    assert not against(said)
    assert "The spot is 0.035 deg off centre now." in [fact.sentence for fact in said]


def test_a_unit_that_does_not_track_or_shows_no_spot_speaks_for_no() -> None:
    station, _ = emulated_station()
    station.set_sun_offset()
    station.tracker.set_mode(Mode.MANUAL)
    station.poll()
    said = against(facts(station, 2, Spot(False, 0.0, 0.0)))
    assert "mode MANUAL" in said
    assert "No spot" in said
    assert "a minute" in said


@pytest.mark.parametrize(("off_s", "said"), [(0, False), (60, True)])
def test_a_clock_that_is_wrong_speaks_for_no_where_it_is_known(off_s: int, said: bool) -> None:
    station, _ = emulated_station("tijeras-azel", f"truth.unit_offset_s={off_s}")
    assert ("Its clock is" in against(facts(station, 2))) is said
    unknown = replace(station.state.live, unit_minus_laptop_s=None)
    assert "Its clock is" not in against(question_evidence(2, station.session, unknown))
