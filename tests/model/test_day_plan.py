"""Planning the rest of a day."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from made_up_trackers import JUNE, context_of, day_of

from solarcal.errors import ConfigurationError
from solarcal.model.known_physics import SkyContext
from solarcal.model.methods import fit_exact
from solarcal.model.plan import GAP_S, STOP_STEP_S, Plan, day_slots, plan, prior_knowledge
from solarcal.model.prior import PLAIN, Prior
from solarcal.model.schedule import (
    best_schedule,
    cost,
    equally_spaced,
    gains,
    greedy,
    with_point,
)
from solarcal.model.year_ahead import year_ahead
from solarcal.mount.limits import AxisLimits, Limits

UNIT = Prior().sigma_array()
DAY_S = 86400.0


@cache
def june_morning(geometry: str = "azel", **options) -> tuple[Plan, float]:
    """The plan after three points early on a June day, and when it was made."""
    context, points = day_of(geometry, 24, JUNE)
    solution = fit_exact(points.subset([0, 1, 2]), context)
    at = float(points.utc_s[3])
    return plan(solution.posterior, context, at, **options), at


class TestArithmetic:
    def test_a_gain_is_what_the_point_really_saves(self):
        _, slots, year = _first_light("azel")
        covariance = np.eye(6)
        gain = gains(slots.rows, covariance, year.weight)
        for index in (0, 17, 40):
            after = with_point(covariance, slots.rows[index])
            rows = slots.rows[index]
            assert after == pytest.approx(np.linalg.inv(np.eye(6) + rows.T @ rows), abs=1e-9)
            saved = np.sum(year.weight * (covariance - after))
            assert gain[index] == pytest.approx(saved, rel=1e-6)

    @pytest.mark.parametrize("window_s", [650.0, 1250.0, 3000.0])
    def test_points_are_never_closer_than_one_takes(self, window_s):
        _, slots, year = _first_light("azel")
        until = float(slots.utc_s[0]) + window_s
        times = slots.utc_s[best_schedule(slots, np.eye(6), year.weight, 20, until_s=until)]
        assert len(times) >= 2
        assert np.diff(times).min() >= GAP_S - 1.0

    @pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew"])
    @pytest.mark.parametrize("count", [4, 7])
    def test_never_worse_than_greedy_or_equal_spacing(self, geometry, count):
        _, slots, year = _first_light(geometry)
        start = np.eye(6)
        ours = best_schedule(slots, start, year.weight, count)
        assert len(ours) == count
        equal = equally_spaced(slots, count)
        plain, _ = greedy(slots, start, year.weight, count)
        best = cost(slots, start, year.weight, ours)
        assert best <= cost(slots, start, year.weight, equal)
        assert best <= cost(slots, start, year.weight, plain)

    def test_points_keep_their_distance(self):
        _, slots, year = _first_light("azel")
        times = slots.utc_s[best_schedule(slots, np.eye(6), year.weight, 12)]
        assert np.diff(times).min() >= GAP_S - 1.0


def _first_light(geometry: str):
    context, points = day_of(geometry, 2, JUNE)
    posterior = prior_knowledge(Prior(widths=PLAIN))
    slots = day_slots(posterior, context, float(points.utc_s[0]), UNIT)
    return posterior, slots, year_ahead(posterior, context, UNIT)


class TestStops:
    def test_one_for_every_remaining_half_hour_and_the_end(self):
        day, at = june_morning()
        stops = [stop.stop_utc_s for stop in day.stops]
        assert np.diff(stops[:-1]) == pytest.approx(STOP_STEP_S)
        assert all(stop % STOP_STEP_S == 0 for stop in stops[:-1])
        assert stops[0] > at

    def test_later_stops_are_better(self):
        day, _ = june_morning()
        p95 = [stop.year_p95_deg for stop in day.stops if stop is not day.recommended]
        assert p95[-1] < 0.2 * day.now.year_p95_deg
        assert all(b < a * 1.03 for a, b in pairwise(p95))

    def test_no_point_lies_after_its_stop_or_before_now(self):
        day, at = june_morning()
        for stop in day.stops:
            assert all(at <= time <= stop.stop_utc_s for time in stop.times_utc_s)


class TestRecommendation:
    def test_the_earliest_stop_that_reaches_the_tolerance(self):
        day, _ = june_morning()
        assert day.reaches
        assert day.recommended.year_p95_deg <= 0.1
        earlier = [s for s in day.stops if s.stop_utc_s < day.recommended.stop_utc_s]
        assert earlier
        assert all(stop.year_p95_deg > 0.1 for stop in earlier)
        assert "more point" in day.sentence
        assert "next at" in day.sentence
        assert day.next_point_utc_s == day.recommended.times_utc_s[0]

    def test_else_the_earliest_near_the_best_and_when_to_come_back(self):
        context, points = day_of("tiltroll-ew", 12, day=1)
        solution = fit_exact(points.subset([0, 1]), context)
        day = plan(solution.posterior, context, float(points.utc_s[2]))
        assert not day.reaches
        assert day.recommended.year_p95_deg <= 1.1 * day.best_p95_deg
        assert "today cannot do better than" in day.sentence
        assert day.come_back_utc_s is not None
        assert "come back around 2026-" in day.sentence
        assert day.come_back_utc_s > points.utc_s[-1]

    def test_a_day_to_come_back_on_really_reaches_it(self):
        context, points = day_of("tiltroll-ew", 12, day=1)
        solution = fit_exact(points.subset([0, 1]), context)
        back = plan(solution.posterior, context, float(points.utc_s[2])).come_back_utc_s
        dawn = back - DAY_S / 2
        assert plan(solution.posterior, context, dawn).reaches

    def test_enough_is_enough(self):
        context, points = day_of("azel", 20, noise_deg=0.01)
        solution = fit_exact(points, context)
        day = plan(solution.posterior, context, float(points.utc_s[10]))
        assert day.recommended.points == 0
        assert "no more points are needed" in day.sentence

    def test_before_the_first_point(self):
        context, points = day_of("azel", 2, JUNE)
        day = plan(prior_knowledge(Prior()), context, float(points.utc_s[0]))
        assert day.reaches
        assert day.now.year_p95_deg > 1.0


class TestWishes:
    def test_until(self):
        _, at = june_morning()
        day, _ = june_morning(until_utc_s=at + 2 * 3600.0)
        assert max(stop.stop_utc_s for stop in day.stops) <= at + 2 * 3600.0

    def test_number_of_points(self):
        day, _ = june_morning(points=3)
        assert max(stop.points for stop in day.stops) == 3
        assert day.recommended.points <= 3

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
