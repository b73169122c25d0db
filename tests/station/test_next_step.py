"""What the workstation tells the technician to do next, step by step of the manual."""

import math
import queue
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from emulated_station import emulated_station

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.errors import ConfigurationError, ProcedureRefused
from solarcal.model.finding import Finding
from solarcal.mount.formula import Offsets
from solarcal.session.journal import Journal
from solarcal.session.view import read_session
from solarcal.station import guards
from solarcal.station.analysing import analyse_session
from solarcal.station.clocks import EmulatedClock
from solarcal.station.next_step import NextStep, countdown_text, next_step
from solarcal.station.planning import (
    HALF_HOUR_S,
    Fitter,
    PlanOptions,
    analyse_with_options,
    fit_message,
)
from solarcal.station.procedure import Station
from solarcal.station.sign_off import sign_off
from solarcal.station.state import Activity, LinkState, StationState
from solarcal.station.sun_path import sun_now
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.timescale import clock_utc, parse_utc
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Mode


def connected(*settings):
    emulator = Emulator(load_scenario("tijeras-azel", list(settings)), seed=1)
    unit = SolarTrakUnit(lambda: InProcessLink(emulator))
    unit.open()
    station = Station(unit, EmulatedClock(unit.emulation))
    station.connect()
    station.open_session(Journal.memory)
    station.poll()
    return station


def uploaded():
    """Three points of a short day, their fit in the unit; the station and its technician."""
    station = connected()
    schedule = Schedule(points=3, every_min=20.0, checks=2)
    technician = AutomaticTechnician(
        station, station.tracker.emulation.spot, schedule, force="a short day"
    )
    technician.prepare()
    technician.take_points()
    technician.upload()
    return station, technician


def asked(station):
    return next_step(station.state).action


def test_without_a_unit_the_next_step_is_the_link():
    assert next_step(StationState()).action == "link"


def test_the_steps_come_in_the_manuals_order():
    station = connected()
    technician = AutomaticTechnician(station, station.tracker.emulation.spot, Schedule())
    assert asked(station) == "clock"
    station.set_unit_clock()
    assert asked(station) == "ref_check"
    station.ref_check()
    assert asked(station) == "sun_offset"
    technician.sight.centre()
    station.set_sun_offset()
    station.track()
    station.clock.wait(60.0)
    station.poll()
    assert asked(station) == "initialise"
    station.initialise(confirmed=True)
    assert asked(station) == "take_point"
    station.begin_point()
    assert "answer the questions" in next_step(station.state).sentence


def test_a_unit_without_power_for_a_moment_needs_its_reference_again():
    station = connected()
    station.set_unit_clock()
    station.ref_check()
    live = station.state.live
    lost = msgspec.structs.replace(live.status, referenced=False)
    step = next_step(replace(station.state, live=replace(live, status=lost)))
    assert step.action == "ref_check"
    assert "lost its reference" in step.sentence


def test_the_next_point_is_due_half_an_hour_after_the_last():
    station = connected()
    technician = AutomaticTechnician(station, station.tracker.emulation.spot, Schedule())
    technician.prepare()
    technician.take_point()
    station.poll()
    step = next_step(station.state)
    taken_s = parse_utc(station.session.accepted[-1].utc)
    assert step.action == "sun_offset"
    assert step.due_utc_s == taken_s + 1800.0
    assert step.countdown_s(taken_s + 600.0) == 1200.0
    assert step.countdown_s(taken_s + 2000.0) == 0.0


def test_a_wrong_clock_comes_before_everything_else():
    station = connected("truth.unit_offset_s=24")
    step = next_step(station.state)
    assert step.action == "clock"
    assert "+24.0 s" in step.sentence
    assert "0.10 deg" in step.sentence


def test_a_unit_without_a_clock_is_not_asked_to_set_one():
    station = connected("truth.unit_offset_s=24")
    live = station.state.live
    without = msgspec.structs.replace(live.capabilities, has_clock=False)
    step = next_step(replace(station.state, live=replace(live, capabilities=without)))
    assert step.action == "ref_check"


def test_a_lost_link_is_said_before_anything_the_session_wants():
    station = connected()
    live = replace(station.state.live, link=LinkState.LOST)
    assert next_step(replace(station.state, live=live)).action == "link"


def test_a_low_sun_is_waited_for():
    station = connected()
    technician = AutomaticTechnician(station, station.tracker.emulation.spot, Schedule())
    technician.prepare()
    station.poll()
    assert "too low" in next_step(station.state, sun_elevation_deg=2.0).sentence
    assert "too low" not in next_step(station.state, sun_elevation_deg=20.0).sentence


def test_from_seven_points_on_they_may_be_uploaded_and_from_twelve_on_they_are_enough():
    """The manual's numbers of points of a calibration, least and most, where none is planned."""
    station, _ = judged_day(1)
    (point,) = station.session.accepted
    for taken, enough in ((6, False), (7, True)):
        points = tuple(msgspec.structs.replace(point, seq=point.seq + i) for i in range(taken))
        state = replace(station.state, session=replace(station.session, points=points))
        low, high = next_step(state, 2.0), next_step(state, 20.0)
        assert ("upload what you have, or go on" in low.sentence) == enough
        assert (low.action == "upload") == enough
        assert ("or upload: there are enough to try" in high.sentence) == enough
        assert high.action == "sun_offset"
    for taken, full in ((11, False), (12, True)):
        points = tuple(msgspec.structs.replace(point, seq=point.seq + i) for i in range(taken))
        step = next_step(replace(state, session=replace(station.session, points=points)), 20.0)
        assert (step.action == "upload") == full
        assert step.sentence.startswith("12 points: upload the coefficients") == full


def test_after_the_upload_two_check_points_prove_it():
    station = connected()
    schedule = Schedule(points=12, every_min=55.0, checks=2)
    technician = AutomaticTechnician(station, station.tracker.emulation.spot, schedule)
    technician.prepare()
    technician.take_points()
    technician.upload()
    step = next_step(station.state)
    assert "check point 1 of 2" in step.sentence
    assert (step.action, step.due_utc_s) == ("sun_offset", None)
    station.track()
    station.clock.wait(60.0)
    technician.sight.centre()
    station.set_sun_offset()
    step = next_step(station.state)
    assert step.action == "take_point"
    assert "check point 1 of 2" in step.sentence
    technician.take_checks()
    judgement = analyse_session(station.session)
    step = next_step(station.state, judgement=judgement)
    assert step.action == "report"
    assert "Signed off" in step.sentence
    few = station.session.accepted[:3]
    early = analyse_session(replace(station.session, points=few))
    step = next_step(station.state, judgement=early)
    assert step.action == "sun_offset"
    assert "(95 % needed). Data point 13 of ~" in step.sentence
    # Whole on two lines of 80 columns, with its key.
    assert len(step.sentence) < 150
    # A data point leaves its offset in force: the unit does not point by what was uploaded.
    station.track()
    technician.take_point()
    judgement = analyse_session(station.session)
    assert judgement.verdict.state == "done"
    step = next_step(station.state, 40.0, judgement)
    then = "set it anew and take check point 3 of 3, or upload again (F8, a)."
    assert step.sentence == f"A Set Sun Offset is in force beside what was uploaded: {then}"
    assert sign_off([station.session], judgement).reason.endswith(
        "UTC is still in force: upload again, or set it anew and take a check point"
    )
    assert next_step(station.state, -6.0, judgement).action == "upload"
    technician.sight.centre()
    station.set_sun_offset()
    step = next_step(station.state, 40.0, judgement)
    assert step.action == "take_point"
    assert ": take check point 3 of 3 with it, or upload" in step.sentence
    station.upload_again()
    assert next_step(station.state, 40.0, judgement).action == "report"


def test_what_is_not_sure_asks_for_more_points_at_once_and_after_every_check():
    """Check points do not make the year surer: they are not asked for before it is."""
    station, technician = uploaded()
    for taken in ("none", "checks", "data point"):
        if taken == "checks":
            technician.take_checks()
        elif taken == "data point":
            station.track()
            technician.take_point()
        now_utc_s = station.clock.utc_s()
        judgement = analyse_session(station.session, at_utc_s=now_utc_s)
        step = next_step(station.state, 40.0, judgement)
        assert (step.action, step.due_utc_s) == ("sun_offset", judgement.plan.next_point_utc_s)
        number = len(station.session.accepted) + 1
        # With all points: of those uploaded it would not grow.
        sure = judgement.forecast.sure_words
        assert step.sentence.startswith(f"NOT signed off: the year is {sure}. ")
        assert f" Data point {number} of ~" in step.sentence
        assert len(step.sentence) < 150
        proof = sign_off([station.session], judgement)
        year, *others = proof.open
        assert year.endswith("(95 % needed): take more points")
        assert all(reason in proof.sentence for reason in proof.open)
        assert (
            others
            == {
                "none": ["no check point was taken after the upload"],
                "checks": [],
                "data point": others,
            }[taken]
        )
    assert len(others) == 1
    assert others[0].endswith("UTC is still in force")
    # Nor is what was uploaded to be uploaded once more when the Sun is low.
    points = station.session.accepted * 2
    many = replace(station.session, points=points)
    judgement = replace(judgement, plan=None)
    for newest in (len(points), -1):
        uploads = tuple(
            msgspec.structs.replace(u, seq=u.seq if newest < 0 else points[-1].seq + 1)
            for u in many.uploads
        )
        state = replace(station.state, session=replace(many, uploads=uploads, records=()))
        low = next_step(state, 3.0, judgement).sentence
        assert ("upload what you have" in low) == (newest < 0)


def test_all_points_struck_out_after_the_upload_begin_anew():
    """The verdict of the points that were is still there until the next one is made."""
    station, _ = uploaded()
    judgement = with_verdict(analyse_session(station.session), "continue")
    for point in station.session.accepted:
        station.void(point.seq, "another tower")
    assert "data point 1" in next_step(station.state, 40.0, judgement).sentence.lower()


def test_surer_coefficients_are_uploaded_before_any_check_point():
    station, _ = uploaded()
    judgement = with_verdict(analyse_session(station.session), "done")
    proof = sign_off([station.session], judgement)
    assert proof.superseded
    assert "upload the coefficients of all points; no check point was taken" in proof.reason
    step = next_step(station.state, 40.0, judgement)
    assert step.action == "upload"
    # They are in the unit already.
    assert step.sentence.endswith("(95 % needed). Upload the coefficients of all points.")
    station.clock.wait(60.0)
    station.set_sun_offset()
    station.poll()
    step = next_step(station.state, 40.0, judgement)
    assert step.sentence.endswith("Upload the coefficients of all points (it asks for a reason).")


def test_an_offset_that_is_struck_out_is_still_in_the_unit():
    station, technician = uploaded()
    technician.sight.centre()
    offset = station.set_sun_offset()
    assert station.session.offset_left == offset
    station.void(offset.seq, "not on the Sun")
    assert station.session.offset_left == offset
    second = station.set_sun_offset()
    assert station.session.offset_left == second
    station.take_back_sun_offset()
    assert station.session.offset_left == offset
    # One that was set on the unit's own keys is seen in the point it gave.
    point = msgspec.structs.replace(station.session.accepted[-1], seq=99, offsets=Offsets(0.5, 0))
    session = station.session
    seen = replace(session, records=(*session.records, point))
    assert seen.offset_left == point
    as_uploaded = msgspec.structs.replace(point, offsets=Offsets())
    assert replace(session, records=(*session.records, as_uploaded)).offset_left is None


def test_after_a_rollback_the_points_go_on():
    station, technician = uploaded()
    station.rollback()
    judgement = analyse_session(station.session)
    step = next_step(station.state, judgement=judgement)
    assert step.action == "sun_offset"
    assert step.sentence.startswith("Rolled back. Point 4 of ~")
    assert step.due_utc_s == judgement.plan.next_point_utc_s
    station.track()
    technician.take_point()
    step = next_step(station.state, judgement=analyse_session(station.session))
    assert step.sentence.startswith("Point 5 of ~")


def test_an_old_sun_offset_is_to_be_set_again():
    station = connected()
    technician = AutomaticTechnician(station, station.tracker.emulation.spot, Schedule())
    technician.prepare()
    technician.sight.centre()
    station.set_sun_offset()
    station.track()
    station.clock.wait(60.0)
    station.poll()
    step = next_step(station.state)
    assert step.action == "take_point"
    assert step.sentence.endswith("then take point 1.")
    station.clock.wait(1800.0)
    station.poll()
    step = next_step(station.state)
    assert step.action == "sun_offset"
    assert "more than half an hour old: set it again, then take point 1" in step.sentence


def test_check_points_beyond_the_tolerance_do_not_prove_it():
    station, technician = uploaded()
    technician.take_checks()
    session = station.session
    checks = tuple(msgspec.structs.replace(c, sky_error_deg=0.3) for c in session.checks)
    step = next_step(replace(station.state, session=replace(session, checks=checks)))
    assert step.action == "sun_offset"
    assert "NOT signed off: 2 of 2 check points after the upload beyond the tol" in step.sentence
    for beyond in (1, 2):
        some = (*checks[:beyond], *session.checks[beyond:])
        reason = sign_off([replace(session, checks=some)], None).reason
        assert reason.startswith(f"{beyond} of 2 check points after the upload beyond")


def test_two_check_points_decide_and_no_fewer_or_too_soon():
    """One beyond the tolerance may be a slip; two of one moment are one."""
    station, technician = uploaded()
    technician.take_checks()
    session = station.session
    first, second = session.checks
    beyond = msgspec.structs.replace(first, sky_error_deg=0.3)
    soon = msgspec.structs.replace(second, utc=first.utc)
    for checks, asked_for in (((beyond,), "check point 2 of 2"), ((first, soon), "3 of 3")):
        state = replace(station.state, session=replace(session, checks=checks))
        assert asked_for in next_step(state).sentence


@pytest.mark.parametrize("last_answer", ["rejected", "NO"])
def test_the_offset_of_a_check_point_that_was_not_stored_is_settled_first(last_answer):
    """Only a stored check point puts O back: until then the unit points off by it."""
    station, technician = uploaded()
    technician.take_checks()
    assert station.session.offset_left is None
    technician.sight.centre()
    station.set_sun_offset()
    station.track()
    station.clock.wait(60.0)
    station.begin_point(check=True)
    if last_answer == "NO":
        # To the reference check: the offset may still give a check point.
        station.answer(False)
        then = "take check point 3 of 3 with it"
    else:
        then = "set it anew and take check point 3 of 3"
        for _ in range(3):
            station.answer(True)
        station.gather_point()
        station.store(False, "a reflection")
    step = next_step(station.state, 40.0)
    assert f"beside what was uploaded: {then}, or upload again (F8, a)." in step.sentence
    assert "is still in force" in sign_off([station.session], None).reason
    station.take_back_sun_offset()
    assert station.session.offset_left is None
    assert "is still in force" not in sign_off([station.session], None).reason


def judged_day(points=2):
    station = connected()
    technician = AutomaticTechnician(
        station, station.tracker.emulation.spot, Schedule(points=points, every_min=20.0)
    )
    technician.prepare()
    technician.take_points()
    station.clock.wait(60.0)
    station.poll()
    now_utc_s = station.state.live.laptop_utc_s
    return station, analyse_session(station.session, at_utc_s=now_utc_s)


def with_verdict(judgement, state):
    return replace(judgement, verdict=replace(judgement.verdict, state=state))


def test_with_a_plan_the_next_point_is_due_when_the_plan_says():
    station, judgement = judged_day()
    planned = judgement.plan.recommended
    step = next_step(station.state, 40.0, judgement)
    assert step.action == "sun_offset"
    assert f"Point 3 of ~{2 + planned.points}:" in step.sentence
    assert step.due_utc_s == planned.times_utc_s[0]
    hopeless = replace(judgement, plan=replace(judgement.plan, hopeless=True))
    said = next_step(station.state, 40.0, hopeless).sentence
    assert said == f"{step.sentence} Today's will not reach the tolerance."
    # A planned time is one with the Sun high enough, however low it is now.
    later = replace(judgement.plan.recommended, times_utc_s=(judgement.plan.at_utc_s + 3600.0,))
    waiting = replace(judgement, plan=replace(judgement.plan, recommended=later))
    assert "too low" not in next_step(station.state, 3.0, waiting).sentence
    assert "too low" in next_step(station.state, 3.0).sentence


def test_the_verdict_says_when_there_are_enough_and_when_something_is_wrong():
    station, judgement = judged_day()
    good = next_step(station.state, 40.0, with_verdict(judgement, "done"))
    assert good.action == "upload"
    assert "Good for the year" in good.sentence
    # Only counts that were found missing are to be looked for, not what nobody checked.
    for certainty, missed in (("found", True), ("not_determinable", False)):
        finding = Finding(kind="missed_counts", subject="axis 1", sentence="", certainty=certainty)
        with_it = replace(with_verdict(judgement, "done"), findings=(finding,))
        assert ("counts were missed" in next_step(station.state, 40.0, with_it).sentence) == missed
    wrong = next_step(station.state, 40.0, with_verdict(judgement, "does_not_fit"))
    assert "why the points do not fit, or go on with point 3" in wrong.sentence


def test_what_more_points_do_not_settle_comes_first():
    station, judgement = judged_day()
    named = replace(with_verdict(judgement, "continue").verdict, first="first settle it")
    step = next_step(station.state, 40.0, replace(judgement, verdict=named))
    assert step.action == "void"
    assert "More points alone will not do" in step.sentence


def test_missed_counts_are_looked_into_before_the_upload():
    station, judgement = judged_day()
    lost = Finding(kind="missed_counts", subject="axis 1", sentence="check 2 found +200 counts")
    found = replace(with_verdict(judgement, "done"), findings=(lost,))
    step = next_step(station.state, 40.0, found)
    assert "counts were missed: find the cause, then upload" in step.sentence


def test_a_low_sun_is_waited_for_with_a_stale_offset_and_with_check_points_too():
    station, technician = uploaded()
    assert "too low for check point 1 of 2 (-6 deg)" in next_step(station.state, -6.0).sentence
    technician.sight.centre()
    station.set_sun_offset()
    station.clock.wait(1900.0)
    station.poll()
    for step in (next_step(station.state, -6.0), next_step(connected().state, -6.0)):
        assert "set it again" not in step.sentence


@pytest.mark.parametrize("points", [2, 8, 14])
@pytest.mark.parametrize("planned", [True, False])
@pytest.mark.parametrize("elevation_deg", [3.0, 40.0])
def test_the_next_step_never_contradicts_the_verdict(points, planned, elevation_deg):
    """Done asks for the upload whatever the Sun; what does not fit is never to be uploaded; while
    more points are wanted the year is not called good."""
    station, judgement = judged_day()
    session = station.state.session
    state = replace(station.state, session=replace(session, points=session.points * (points // 2)))
    judgement = judgement if planned else replace(judgement, plan=None)

    def step(verdict):
        return next_step(state, elevation_deg, with_verdict(judgement, verdict))

    assert step("done").action == "upload"
    misfit = step("does_not_fit")
    assert misfit.action != "upload"
    assert "upload" not in misfit.sentence
    assert "do not fit" in misfit.sentence
    for verdict in ("continue", "not_today"):
        assert "Good for the year" not in step(verdict).sentence
        assert "do not fit" not in step(verdict).sentence


def test_a_day_that_cannot_reach_the_tolerance_says_so_beside_its_next_point():
    station, _ = judged_day()
    plan_options = PlanOptions(until_utc_s=station.state.live.laptop_utc_s + 1800.0)
    judgement = analyse_with_options(station.session, plan_options, station.state.live.laptop_utc_s)
    assert not judgement.plan.reaches
    step = next_step(station.state, 40.0, judgement)
    assert "not reach the tolerance" in step.sentence


def test_options_shape_the_plan():
    station, judgement = judged_day()
    now_utc_s = station.state.live.laptop_utc_s
    first = judgement.plan.recommended.times_utc_s[0]
    begin = (first - 1.0) // HALF_HOUR_S * HALF_HOUR_S
    clouded = analyse_with_options(station.session, PlanOptions().strike(begin), now_utc_s)
    times = clouded.plan.recommended.times_utc_s
    assert times
    assert not any(begin < time <= begin + HALF_HOUR_S for time in times)
    five = PlanOptions().points_more(-1, taken=2, planned=4)
    assert five.points == 5
    # Not fewer than are taken, and not more than a day has.
    assert PlanOptions(points=2).points_more(-1, taken=2, planned=0).points == 2
    assert PlanOptions(points=40).points_more(+1, taken=2, planned=0).points == 40
    counted = analyse_with_options(station.session, five, now_utc_s)
    assert max(stop.points for stop in counted.plan.stops) == 3
    leaving = PlanOptions().leave_at(now_utc_s + 7200.0)
    left = analyse_with_options(station.session, leaving, now_utc_s)
    assert max(left.plan.recommended.times_utc_s) <= now_utc_s + 7200.0
    late = analyse_with_options(station.session, leaving, now_utc_s + 9000.0)
    assert late.plan.recommended.points <= 1
    assert leaving.leave_at(now_utc_s + 7200.0) == PlanOptions().strike(0.0).strike(0.0)


def test_a_plan_is_made_once_and_anew_when_its_point_was_missed():
    station, _ = judged_day()
    posted = queue.Queue()
    fitter = Fitter(posted.put)
    fitter.start()
    try:
        fitter.fit_if_needed(station.state)
        plan = posted.get(timeout=20.0).judgement.plan
        due_s = plan.next_point_utc_s
        assert fitter._plan_of(station.session) == plan
        renewed = msgspec.structs.replace(station.session.header, operator="another")
        assert fitter._plan_of(replace(station.session, header=renewed)) is None

        def at(utc_s):
            return replace(station.state, live=replace(station.state.live, laptop_utc_s=utc_s))

        # Ten minutes are a point's: until then it may still be taken.
        fitter.fit_if_needed(at(due_s + 599.0))
        fitter.fit_if_needed(at(due_s + 601.0))
        anew = posted.get(timeout=20.0).judgement.plan
        assert anew.at_utc_s == due_s + 601.0
        assert anew.next_point_utc_s > due_s
        fitter.fit_if_needed(at(due_s + 602.0))
    finally:
        fitter.close()
    assert posted.empty()


@pytest.mark.parametrize(
    "error", [ConfigurationError("odd"), ValueError("odd"), ZeroDivisionError("odd")]
)
def test_a_session_that_cannot_be_judged_keeps_its_fit_and_says_why(monkeypatch, error):
    """Arithmetic on strange points fails in its own words, and the thread goes on."""

    def fails(*of):
        raise error

    session = read_session(Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl")
    monkeypatch.setattr("solarcal.station.planning.analyse_with_options", fails)
    message = fit_message(3, session)
    assert (message.generation, message.judgement) == (3, None)
    assert message.reason == "no forecast: odd"
    assert message.solution is not None
    assert message.solution.n_points == len(session.accepted)
    monkeypatch.setattr("solarcal.station.planning.solve", fails)
    if isinstance(error, ConfigurationError):
        message = fit_message(3, session)
        assert (message.solution, message.reason) == (None, "odd")


def test_where_there_is_no_plan_none_is_overtaken(monkeypatch):
    station, posted, fits = connected(), queue.Queue(), []
    fitter = Fitter(posted.put)
    fitter.start()
    try:
        fitter.fit_if_needed(station.state)
        assert posted.get(timeout=20.0).judgement is None
        monkeypatch.setattr(fitter, "fit", lambda *of: fits.append(of))
        fitter.fit_if_needed(station.state)
    finally:
        fitter.close()
    assert fits == []


@pytest.mark.parametrize("activity", [Activity.REF_CHECK, Activity.GATHERING, Activity.UPLOADING])
def test_in_the_middle_of_a_step_nothing_else_is_asked_for(activity):
    station = connected()
    assert next_step(replace(station.state, activity=activity)).action is None


def test_a_countdown_names_its_units_and_is_no_time_of_day():
    assert countdown_text(0.2) == "1 s"
    assert countdown_text(725.0) == "12 min 5 s"
    assert countdown_text(3599.5) == "1 h 0 min"
    assert countdown_text(3725.0) == "1 h 3 min"
    assert countdown_text(7199.0) == "2 h 0 min"
    assert NextStep("x").countdown_s(5.0) is None


def test_both_suns_are_a_few_hundredths_apart_and_a_minute_of_clock_a_quarter_degree():
    right, wrong = connected(), connected("truth.unit_offset_s=60")
    near = sun_now(right.session, right.state.live)
    far = sun_now(wrong.session, wrong.state.live)
    assert near.apart_deg < 0.1
    assert far.apart_deg == pytest.approx(0.25, abs=0.1)
    assert near.azimuth_deg == pytest.approx(near.unit_azimuth_deg, abs=0.1)
    assert near.elevation_deg == pytest.approx(near.unit_elevation_deg, abs=0.1)


@pytest.mark.parametrize("scenario", ["tijeras-azel", "heliostat"])
def test_the_difference_is_that_of_the_two_suns_shown(scenario):
    """Of a heliostat too: its mirror's normal is half as far off as the Sun."""
    emulator = Emulator(load_scenario(scenario, ["truth.unit_offset_s=60"]), seed=1)
    unit = SolarTrakUnit(lambda: InProcessLink(emulator))
    unit.open()
    station = Station(unit, EmulatedClock(unit.emulation))
    station.connect()
    station.open_session(Journal.memory)
    station.poll()
    sun = sun_now(station.session, station.state.live)
    east = math.cos(math.radians(sun.elevation_deg)) * (sun.azimuth_deg - sun.unit_azimuth_deg)
    shown = math.hypot(east, sun.elevation_deg - sun.unit_elevation_deg)
    assert sun.apart_deg == pytest.approx(shown, rel=0.01)
    assert sun.apart_deg > 0.1


@pytest.mark.parametrize(
    ("limits1_deg", "since", "day"),
    [
        ("[-100,128]", "2026-06-03T22:30:00Z", "2026-06-04 "),
        ("[-120,60]", "2026-06-03T14:00:00Z", ""),
    ],
)
def test_a_sun_beyond_a_limit_is_waited_for_until_it_is_back(limits1_deg, since, day):
    """In the evening until the next day, in the morning for some hours."""
    station, _ = emulated_station("tijeras-azel", f"unit.limits1_deg={limits1_deg}", start=since)
    station.set_unit_clock()
    while station.poll().mode is not Mode.LIMIT:
        station.clock.wait(600.0)
    step = next_step(station.state, 40.0)
    back_s = step.due_utc_s
    assert step.action is None
    assert step.sentence == (
        "The unit waits at an axis limit, the Sun is beyond that of axis 1: wait until the Sun is "
        f"clear of it, about {day}{clock_utc(back_s)}."
    )

    def refused():
        try:
            guards.demand_clear_of_limits(station.session.header, station.poll(), "initialise")
            guards.demand_sun_high_enough(station.sun_elevation_deg(), "initialise")
        except guards.GuardRefused as refusal:
            return str(refusal)
        return ""

    assert f"wait until the Sun is clear of it, about {day}" in refused()
    station.clock.wait(back_s - station.clock.utc_s() - 600.0)
    assert refused()
    station.clock.wait(600.0)
    assert not refused()


def test_a_unit_that_waits_at_a_limit_is_not_told_to_track():
    station = connected()
    technician = AutomaticTechnician(station, station.tracker.emulation.spot, Schedule())
    station.set_unit_clock()
    station.ref_check()
    technician.sight.centre()
    station.set_sun_offset()
    station.track()
    station.initialise(confirmed=True)
    state = station.state
    for mode, told in (
        (Mode.LIMIT, "The unit waits at an axis limit, the Sun is beyond it; go on when"),
        (Mode.MANUAL, "The unit is in mode MANUAL: let it track"),
    ):
        status = msgspec.structs.replace(station.poll(), mode=mode)
        seen = replace(state, live=replace(state.live, status=status))
        assert next_step(seen).sentence.startswith(told)
        with pytest.raises(ProcedureRefused) as refused:
            guards.demand_tracking(station.session.header, status)
        assert (mode is Mode.MANUAL) == ("set it to TRACK" in str(refused.value))
