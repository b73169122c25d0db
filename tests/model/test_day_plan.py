"""Planning the rest of a day."""

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise

import msgspec
import numpy as np
import pytest
from made_up_trackers import JUNE, TRACKER, context_of, day_of, measured

from benchmarks.judgement_plan import prior_knowledge
from solarcal.errors import ConfigurationError
from solarcal.model.analysis import analyse
from solarcal.model.forecast import forecast
from solarcal.model.methods import fit_exact
from solarcal.model.more_points import STOP_STEP_S, DayStops, year_ahead
from solarcal.model.plan import Plan
from solarcal.model.planner import plan, times_of
from solarcal.model.prior import PLAIN, Prior
from solarcal.model.schedule import (
    Slots,
    best_schedule,
    cost,
    day_slots,
    equally_spaced,
    gains,
    greedy_for_each,
    with_point,
)
from solarcal.model.sky_context import SkyContext
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.site import Site
from solarcal.stopping_rule import StoppingRule, Unmodelled, percent
from solarcal.timescale import clock_utc, format_utc, parse_utc

UNIT = Prior().sigma_array()
DAY_S = 86400.0
POINT_S = 600.0
"""A point takes ten minutes: the documents promise that no two are planned closer."""


@cache
def june_morning(geometry: str = "azel", **options) -> tuple[Plan, float]:
    """The plan after three points early on a June day, and when it was made."""
    context, points = day_of(geometry, 24, JUNE)
    solution = fit_exact(points.subset([0, 1, 2]), context)
    at = float(points.utc_s[3])
    return plan(solution.posterior, context, at, **options), at


class TestEnds:
    """The times at which the rest of a day could end."""

    @staticmethod
    def of(begins: str) -> DayStops:
        _, slots, year = _first_light("azel")
        first = parse_utc(begins)
        inside = first + 300.0 * np.arange(25)
        some = Slots(inside, slots.rows[:25], POINT_S)
        return DayStops(some, np.eye(6), year, StoppingRule(0.1))

    @pytest.mark.parametrize(
        ("begins", "ends"),
        [
            ("2026-06-21T14:00:00Z", ["14:30", "15:00", "15:30", "16:00"]),
            ("2026-06-21T14:05:00Z", ["14:30", "15:00", "15:30", "16:00", "16:05"]),
            ("2026-06-21T13:58:00Z", ["14:00", "14:30", "15:00", "15:30", "15:58"]),
        ],
    )
    def test_they_are_the_half_hours_of_the_clock_and_the_last_slot(self, begins, ends):
        assert [format_utc(end, 0)[11:16] for end in self.of(begins).ends_s] == ends

    def test_the_first_that_will_do_is_found_wherever_it_is(self, monkeypatch):
        day = self.of("2026-06-21T14:05:00Z")
        for index, sure_s in enumerate(day.ends_s):
            monkeypatch.setattr(
                DayStops, "meets", lambda _, stop, from_s=sure_s: stop.stop_utc_s >= from_s
            )
            assert day.first_dense(day.ends_s) == index


class TestArithmetic:
    def test_a_gain_is_what_the_point_really_saves(self):
        _, slots, year = _first_light("azel")
        root = np.random.default_rng(5).normal(size=(6, 6))
        covariance = np.eye(6) + 0.3 * root @ root.T
        gain = gains(slots.products, covariance, year.weight)
        for index in (0, 17, 40):
            after = with_point(covariance, slots.rows[index])
            rows = slots.rows[index]
            assert after == pytest.approx(
                np.linalg.inv(np.linalg.inv(covariance) + rows.T @ rows), abs=1e-9
            )
            saved = np.sum(year.weight * (covariance - after))
            assert gain[index] == pytest.approx(saved, rel=1e-6)

    @pytest.mark.parametrize("window_s", [650.0, 1250.0, 3000.0])
    def test_points_are_never_closer_than_one_takes(self, window_s):
        _, slots, year = _first_light("azel")
        until = float(slots.utc_s[0]) + window_s
        times = slots.utc_s[best_schedule(slots, np.eye(6), year.weight, 20, until_s=until)]
        assert len(times) >= 2
        assert np.diff(times).min() >= POINT_S - 1.0

    @pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew"])
    @pytest.mark.parametrize("count", [4, 7])
    def test_never_worse_than_greedy_or_equal_spacing(self, geometry, count):
        _, slots, year = _first_light(geometry)
        start = np.eye(6)
        ours = best_schedule(slots, start, year.weight, count)
        assert len(ours) == count
        equal = equally_spaced(slots, count)
        ((plain, _),) = greedy_for_each(
            slots, start, year.weight, [count], np.array([np.inf]), least_gain=1e-9
        )
        best = cost(slots, start, year.weight, ours)
        assert best <= cost(slots, start, year.weight, equal)
        assert best <= cost(slots, start, year.weight, plain)

    def test_points_keep_their_distance(self):
        _, slots, year = _first_light("azel")
        times = slots.utc_s[best_schedule(slots, np.eye(6), year.weight, 12)]
        assert np.diff(times).min() >= POINT_S - 1.0


def _first_light(geometry: str):
    context, points = day_of(geometry, 2, JUNE)
    posterior = prior_knowledge(Prior(widths=PLAIN))
    slots = day_slots(posterior, context, float(points.utc_s[0]), UNIT)
    return posterior, slots, year_ahead(posterior, context, UNIT)


class TestNoons:
    @pytest.mark.parametrize("hours", [0.0, 5.0, 12.0, 23.0])
    def test_the_next_noon_of_each_season_is_after_the_day_is_over(self, hours):
        """Half a day ahead at least, whole days from the grid's noons, and not a day too late."""
        _, _, year = _first_light("azel")
        utc_s = float(year.days_utc_s[10]) + 7 * DAY_S + 3600.0 * hours
        noons = year.noons_after(utc_s)
        season_s = year.days_utc_s + 0.5 * DAY_S
        while (early := season_s < utc_s + 0.5 * DAY_S).any():
            season_s = np.where(early, season_s + 365.2422 * DAY_S, season_s)
        assert (noons > utc_s + 0.5 * DAY_S - 0.02 * DAY_S).all()
        assert (np.abs(noons - season_s - 0.49 * DAY_S) < 0.51 * DAY_S).all()
        days = (noons - (year.days_utc_s + 0.5 * DAY_S)) / DAY_S
        assert days == pytest.approx(np.round(days), abs=1e-9)


class TestStops:
    def test_one_for_every_remaining_half_hour_and_the_end(self):
        day, at = june_morning()
        stops = [stop.stop_utc_s for stop in day.stops if stop is not day.recommended]
        assert np.diff(stops[:-1]).max() <= 2 * STOP_STEP_S
        assert all(stop % STOP_STEP_S == 0 for stop in stops[:-1])
        assert stops[0] > at

    def test_later_stops_are_better(self):
        day, _ = june_morning()
        p95 = [stop.year_p95_deg for stop in day.stops if stop is not day.recommended]
        assert p95[-1] < 0.2 * day.now.year_p95_deg
        assert all(b < a * 1.03 for a, b in pairwise(p95))

    def test_its_points_are_exchanged_for_better_ones_and_one_is_spared_where_that_will_do(self):
        _, slots, year = _first_light("azel")
        day = DayStops(slots, np.eye(6), year, StoppingRule(0.1), points=5)
        ((greedy, _, _),) = day.schedules([float(slots.utc_s[-1])])
        polished = day.polished(greedy, 5, None)
        assert polished.points == greedy.points == 5
        assert polished.year_rms_deg < greedy.year_rms_deg
        assert polished.stop_utc_s == greedy.stop_utc_s
        as_few = DayStops(slots, np.eye(6), year, StoppingRule(0.1)).polished(greedy, 5, 0.99)
        assert as_few.points == 4
        assert as_few.probability >= 0.99

    def test_no_more_points_are_asked_for_than_will_do(self):
        _, slots, year = _first_light("azel")
        day = DayStops(slots, np.eye(6), year, StoppingRule(0.1))
        end_s = float(slots.utc_s[-1])
        (last,) = day.schedules([end_s])
        stop = day.earliest(end_s, last)
        assert day.meets(stop)
        assert stop.points < last[0].points - 2
        assert not day.meets(day.polished(last[0], stop.points - 1, 0.0))

    def test_no_point_lies_after_its_stop_or_before_now(self):
        day, at = june_morning()
        for stop in day.stops:
            assert all(at <= time <= stop.stop_utc_s for time in stop.times_utc_s)


class TestRecommendation:
    def test_the_earliest_stop_that_meets_the_rule(self):
        day, _ = june_morning()
        assert day.reaches
        assert day.recommended.probability >= 0.95
        earlier = [s for s in day.stops if s.stop_utc_s < day.recommended.stop_utc_s]
        assert earlier
        assert all(stop.probability < 0.95 for stop in earlier)
        assert "more point" in day.sentence
        assert "next at" in day.sentence
        assert day.next_point_utc_s == day.recommended.times_utc_s[0]

    def test_fewer_points_than_one_every_twenty_minutes(self):
        context, points = day_of("azel", 24, JUNE)
        solution = fit_exact(points.subset([0, 1, 2]), context)
        at, first = float(points.utc_s[3]), float(points.utc_s[0])
        day = plan(solution.posterior, context, at, taken_utc_s=times_of(solution.points))
        for stop in day.stops[1:]:
            assert stop.points + 3 <= (stop.stop_utc_s - first) / 1200.0

    def test_a_looser_rule_is_met_sooner(self):
        strict, _ = june_morning()
        loose, _ = june_morning(rule=StoppingRule(0.2, 0.9))
        assert loose.recommended.stop_utc_s < strict.recommended.stop_utc_s

    def test_else_when_to_come_back_and_what_to_do_then(self):
        context, points = day_of("tiltroll-ew", 12, day=1)
        solution = fit_exact(points.subset([0, 1]), context)
        day = plan(solution.posterior, context, float(points.utc_s[2]))
        assert day.hopeless
        assert not day.reaches
        assert day.recommended.year_p95_deg <= 1.1 * day.best_p95_deg
        assert "the best of today is" in day.sentence
        assert day.come_back_utc_s is not None
        assert re.search(r"come back around 2026-\d\d-\d\d\b", day.sentence)
        assert day.come_back_utc_s > points.utc_s[-1]
        visit = np.array(day.second_visit_utc_s)
        assert len(visit) >= 2
        assert np.abs(visit - day.come_back_utc_s).max() < DAY_S / 2
        assert f"from {clock_utc(visit[0])} to {clock_utc(visit[-1])}" in day.sentence

    @pytest.mark.parametrize("clear", [True, False])
    def test_probability_enough_and_evidence_against_are_both_said(self, clear):
        context, points = day_of("azel", 16, JUNE)
        solution = fit_exact(points, context)
        at = float(points.utc_s[-1]) + 4.0 * 3600.0
        day = plan(solution.posterior, context, at, clear=clear, until_utc_s=at)
        assert day.now.probability >= 0.95
        assert day.sentence.startswith("no more points are needed") == clear
        assert (
            "would be enough, but the verdict names what else is against it" in day.sentence
        ) != clear

    def test_more_points_than_the_probability_needs_are_explained(self):
        context, points = day_of("azel", 16, JUNE)
        solution = fit_exact(points.subset(range(13)), context)
        at = float(points.utc_s[12]) + 60.0
        day = plan(solution.posterior, context, at, clear=False)
        assert day.now.probability >= 0.95
        assert day.reaches
        assert "; the verdict names what is against it now" in day.sentence
        assert "the verdict names" not in plan(solution.posterior, context, at, clear=True).sentence

    def test_points_are_planned_at_full_five_minutes_on_either_visit(self):
        """Also where the Sun's noon is at an odd minute."""
        context, points = day_of("tiltroll-ew", 12, day=1)
        solution = fit_exact(points.subset([0, 1]), context)
        east = msgspec.structs.replace(context, site=Site(context.site.latitude_deg, 3.1))
        day = plan(solution.posterior, east, float(points.utc_s[2]))
        assert day.second_visit_utc_s
        for times in (day.recommended.times_utc_s, day.second_visit_utc_s):
            assert not np.any(np.array(times) % 300.0)

    def test_a_second_visit_as_planned_is_enough(self):
        context, points = day_of("tiltroll-ew", 12, day=1)
        solution = fit_exact(points.subset([0, 1]), context)
        day = plan(solution.posterior, context, float(points.utc_s[2]))
        times = (*day.recommended.times_utc_s, *day.second_visit_utc_s)
        # This plan knows of P1..P6 alone, so it is judged as if there were nothing beside them.
        nothing = Unmodelled(
            cross_axis_deg=1e-6, large_chance=0.0, sag_deg=1e-6, air=1e-6, clock_s=1e-6
        )
        rule = StoppingRule(unmodelled=nothing)
        within = [
            analyse(
                measured(context, TRACKER, np.array(times), np.random.default_rng(seed)),
                context,
                rule=rule,
            ).forecast.probability_within_tolerance
            for seed in range(5)
        ]
        assert np.median(within) > 0.95

    def test_a_day_that_needs_denser_points_says_so(self):
        day, _ = june_morning(rule=StoppingRule(0.03, 0.95))
        assert not day.hopeless
        assert day.sentence.startswith("denser than usual: ")
        assert day.reaches
        # As dense as points can be taken, where it has to be.
        assert np.diff(day.recommended.times_utc_s).min() == pytest.approx(POINT_S)

    @pytest.mark.parametrize("tolerance_deg", [0.02, 0.1, 0.3])
    def test_an_end_always_has_a_point_however_little_it_adds(self, tolerance_deg):
        context, points = day_of("tiltroll-ew", 40, day=1)
        for n in (20, 30, 36, 39):
            day = analyse(
                points.subset(list(range(n))),
                context,
                rule=StoppingRule(tolerance_deg),
                at_utc_s=float(points.utc_s[n - 1]),
            ).plan
            assert all(stop.points for stop in day.stops)

    def test_before_the_first_point(self):
        context, points = day_of("azel", 2, JUNE)
        day = plan(prior_knowledge(Prior()), context, float(points.utc_s[0]))
        assert day.reaches
        assert day.now.year_p95_deg > 1.0


class TestOneRule:
    """Verdict, plan and sentence never contradict one another."""

    @pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
    def test_no_more_points_only_when_done(self, geometry):
        context, points = day_of(geometry, 20, JUNE)
        for n in range(1, 21):
            whole = analyse(
                points.subset(list(range(n))), context, at_utc_s=float(points.utc_s[n - 1])
            )
            day, verdict = whole.plan, whole.verdict
            assert ("no more points are needed" in day.sentence) == (verdict.state == "done")
            assert day.done == (verdict.state == "done")
            if verdict.state == "not_today":
                assert day.hopeless
                assert whole.forecast.probability_within_tolerance < 0.95

    def test_a_forecast_that_would_do_but_cannot_be_checked_asks_for_another_point(self):
        context, points = day_of("azel", 14)
        two = points.subset([0, 13])
        rule = StoppingRule(20.0)
        whole = analyse(two, context, rule=rule, at_utc_s=float(points.utc_s[5]))
        assert whole.verdict.state == "continue"
        assert whole.plan.now.probability >= 0.95
        assert whole.plan.recommended.points >= 1
        assert "no more points" not in whole.plan.sentence

    def test_enough_is_enough(self):
        context, points = day_of("azel", 20, noise_deg=0.01)
        solution = fit_exact(points, context)
        expected = forecast(solution, context)
        day = plan(
            solution.posterior, context, float(points.utc_s[10]), expected=expected, clear=True
        )
        assert day.recommended.points == 0
        assert day.done
        assert "no more points are needed" in day.sentence

    def test_no_figure_reads_as_the_tolerance_it_is_not(self):
        rule = StoppingRule(0.1)
        assert rule.within_deg(0.10004) == "0.10004"
        assert rule.within_deg(0.0996) == "0.0996"
        assert rule.within_deg(0.062) == "0.062"
        assert rule.within_deg(0.1) == "0.100"


class TestSteadiness:
    """A plan stays until a point is taken, missed or struck out."""

    def made(self, at: float, **options) -> Plan:
        context, points = day_of("azel", 24, JUNE)
        solution = fit_exact(points.subset([0, 1, 2]), context)
        taken = times_of(solution.points)
        return plan(solution.posterior, context, at, taken_utc_s=taken, **options)

    def test_time_alone_changes_nothing(self):
        _, points = day_of("azel", 24, JUNE)
        first = self.made(float(points.utc_s[2]) + POINT_S)
        due = first.next_point_utc_s
        assert due is not None
        for at in np.linspace(float(points.utc_s[2]) + POINT_S, due, 5):
            later = self.made(float(at))
            assert later.recommended.times_utc_s == first.recommended.times_utc_s

    def test_a_missed_point_is_planned_anew_and_never_in_the_past(self):
        _, points = day_of("azel", 24, JUNE)
        due = self.made(float(points.utc_s[2])).next_point_utc_s
        soon = []
        for late_s in (60.0, 400.0, 1500.0, 5400.0):
            later = self.made(due + late_s)
            if later.next_point_utc_s - due <= 1800.0:
                soon.append(later.sentence)
            assert later.next_point_utc_s >= due + late_s
            assert all(t >= due + late_s for s in later.stops for t in s.times_utc_s)
            if later.next_point_utc_s - due > 1800.0 + late_s:
                assert "was not taken" in later.sentence
        assert soon
        assert not any("was not taken" in sentence for sentence in soon)

    def test_a_struck_half_hour_moves_the_point_out_of_it(self):
        _, points = day_of("azel", 24, JUNE)
        at = float(points.utc_s[2]) + POINT_S
        due = self.made(at).next_point_utc_s
        struck = self.made(at, struck=((due - 60.0, due + 1740.0),))
        assert not any(due - 60.0 <= t <= due + 1740.0 for t in struck.recommended.times_utc_s)

    def test_a_change_of_more_than_half_an_hour_says_why(self):
        _, points = day_of("azel", 24, JUNE)
        at = float(points.utc_s[2]) + POINT_S
        before = self.made(at)
        assert self.made(at + 60.0).compared_with(before).sentence == before.sentence
        end = before.recommended.times_utc_s[-1]
        clouded = self.made(at, struck=((end - 3 * 3600.0, end + 1800.0),)).compared_with(before)
        assert "later than planned: the hours that can be used have changed" in clouded.sentence
        context, noisy = day_of("azel", 24, JUNE, noise_deg=0.08)
        rough = analyse(noisy.subset([0, 1, 2, 3, 4]), context, at_utc_s=float(noisy.utc_s[4])).plan
        assert "later than planned: the last point" in rough.compared_with(before).sentence
        # The noise of one is said where it has changed by more than 15 %, either way.
        for factor, noise_said in ((0.8, True), (0.9, False), (1.1, False), (1.2, True)):
            known = replace(before.basis, noise_deg=rough.basis.noise_deg / factor)
            said = rough.compared_with(replace(before, basis=known)).sentence
            assert ("the last point makes the noise of one" in said) == noise_said

    def test_points_of_another_day_do_not_hold_up_todays(self):
        context, points = day_of("azel", 24, JUNE)
        solution = fit_exact(points, context)
        today = float(points.utc_s[0]) + DAY_S
        alone, after_yesterday = (
            plan(solution.posterior, context, today, taken_utc_s=taken)
            for taken in ((), times_of(points))
        )
        assert after_yesterday.next_point_utc_s == alone.next_point_utc_s
        assert after_yesterday.recommended.times_utc_s == alone.recommended.times_utc_s

    def test_no_point_closer_to_the_last_than_one_takes(self):
        _, points = day_of("azel", 24, JUNE)
        at = float(points.utc_s[2])
        assert self.made(at).next_point_utc_s >= at + POINT_S


class TestWishes:
    def test_until(self):
        _, at = june_morning()
        day, _ = june_morning(until_utc_s=at + 2 * 3600.0)
        assert max(stop.stop_utc_s for stop in day.stops) <= at + 2 * 3600.0

    def test_number_of_points(self):
        day, _ = june_morning(points=3)
        assert max(stop.points for stop in day.stops) == 3
        assert day.recommended.points <= 3
        # As many as the technician asks for, though fewer would do.
        day, _ = june_morning(points=12)
        assert day.reaches
        assert day.recommended.points == 12

    def test_a_day_that_may_be_enough_says_how_many_points_until_when(self):
        day, _ = june_morning(points=3, rule=StoppingRule(0.06))
        assert not day.reaches
        assert not day.hopeless
        end = f"{format_utc(day.recommended.stop_utc_s, 0)[11:16]} UTC"
        first = f"{format_utc(day.recommended.times_utc_s[0], 0)[11:16]} UTC"
        assert day.sentence.startswith(f"today's 3 more points until {end} make it ")
        assert day.sentence.endswith(f"next at {first}")

    def test_struck_out_slots(self):
        _, at = june_morning()
        cloud = (at + 3600.0, at + 3 * 3600.0)
        day, _ = june_morning(struck=(cloud,))
        assert day.stops
        for stop in day.stops:
            assert not any(cloud[0] <= time <= cloud[1] for time in stop.times_utc_s)

    def test_limits(self):
        free = context_of("azel")
        limits = Limits(AxisLimits(-60.0, 60.0), AxisLimits(0.0, 90.0))
        context = SkyContext(free.site, free.geometry, limits)
        at = free.first_midnight_utc_s + JUNE * DAY_S
        slots = day_slots(prior_knowledge(Prior()), context, at, UNIT)
        assert 0 < len(slots) < len(day_slots(prior_knowledge(Prior()), free, at, UNIT))

    def test_after_sunset_nothing_is_left(self):
        context, points = day_of("azel", 5)
        solution = fit_exact(points, context)
        day = plan(solution.posterior, context, float(points.utc_s[-1]) + 3600.0)
        assert day.stops == ()
        assert day.recommended.points == 0

    def test_an_end_before_the_beginning_is_refused(self):
        context, points = day_of("azel", 5)
        with pytest.raises(ConfigurationError, match="must end after"):
            plan(prior_knowledge(Prior()), context, float(points.utc_s[0]), until_utc_s=0.0)

    def test_the_document_can_be_written_as_json(self):
        import json

        day, _ = june_morning()
        document = json.loads(json.dumps(day.as_json()))
        assert document["reaches"] is True
        assert document["recommended"]["points"]


def test_before_the_first_point_a_spot_is_taken_to_be_read_to_three_hundredths():
    assert prior_knowledge(Prior(widths=PLAIN)).noise_rms_deg == pytest.approx(0.03)


@pytest.mark.parametrize("geometry", ["tiltroll-ns", "tiltroll-ew", "polar"])
@pytest.mark.parametrize("taken", [1, 2])
def test_the_sentence_gives_the_probability_of_the_advised_stop(geometry: str, taken: int) -> None:
    """A denser schedule may be surer; it is not the one in the table."""
    context, points = day_of(geometry, 14)
    few = points.subset(range(taken))
    planned = analyse(few, context, at_utc_s=times_of(few)[-1]).plan
    assert planned is not None
    said = percent(planned.recommended.probability, planned.rule.probability)
    assert said in planned.sentence
    if "needed; next" in planned.sentence:
        assert planned.recommended is planned.stops[-1]
