"""When to take the next points, and when the calibration will be done.

Every remaining half hour is a possible end of the day. For each the best schedule is sought, of
fewer points than one every ``PACE_S``, and its forecast computed; the earliest end at which the
stopping rule will be met is recommended, with as few points as meet it. A plan is a pure function
of the points taken and of what is struck out: as long as its next point lies ahead it stays.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.forecast import Forecast
from solarcal.model.plan import JUMP_S, Basis, Plan, PlannedStop
from solarcal.model.points import Points
from solarcal.model.prior import MechanismPosterior, Prior
from solarcal.model.schedule import (
    GAP_S,
    SLOT_S,
    Slots,
    YearAhead,
    after,
    best_schedule,
    day_slots,
    gains,
    greedy_for_each,
    with_point,
    year_ahead,
)
from solarcal.model.sky_context import SkyContext
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule, percent
from solarcal.timescale import SECONDS_PER_DAY, format_utc
from solarcal.units import FloatArray

STOP_STEP_S = 1800.0
PACE_S = 1200.0
"""A technician without a plan takes a point every 20 minutes at most; a plan asks for fewer."""
MOST_POINTS = 30
NEAR_BEST = 1.10
"""Where the rule is out of reach, the day ends when its forecast is within a tenth of its best."""
HOPE = 0.5
"""A day whose best plan leaves less than this probability of the tolerance is not worth waiting
for: today's luck does not make up for more."""
WORTH_A_POINT = 0.002
"""Part of the mean square that one more point must save to be considered at all."""
MISSES_FOLLOWED = 2
SECOND_VISIT_PROBABILITY = 0.99
"""As long as only P1..P6 are not known: it leaves room for the rest."""


def times_of(points: Points) -> tuple[float, ...]:
    """When the points were taken, those without a time left out."""
    if points.utc_s is None:
        return ()
    return tuple(sorted(points.utc_s[np.isfinite(points.utc_s)].tolist()))


def plan(
    posterior: MechanismPosterior,
    context: SkyContext,
    at_utc_s: float,
    *,
    rule: StoppingRule = DEFAULT_RULE,
    expected: Forecast | None = None,
    clear: bool = False,
    taken_utc_s: Sequence[float] = (),
    until_utc_s: float | None = None,
    points: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    prior: Prior | None = None,
) -> Plan:
    """Plan the rest of the solar day that ``at_utc_s`` lies in.

    Parameters
    ----------
    posterior
        Of a fit.
    rule
        When the calibration is done.
    expected
        The forecast of the points taken, where there is one. With what may be there beside P1..P6
        it is of another posterior: more points remove none of that.
    clear
        Nothing known speaks against the fit: only then can the calibration be done.
    taken_utc_s
        When they were taken. The plan is the one made after the last of them, as long as its next
        point has not been missed.
    until_utc_s
        The technician must leave then.
    points
        Exactly so many more, where the day has room; None: as many as are worth taking.
    struck
        Intervals (from, to) in which no point can be taken: cloud, lunch.
    prior
        Whose spreads are the units of the arithmetic; never changes the answer.
    """
    if until_utc_s is not None and until_utc_s < at_utc_s:
        raise ConfigurationError("the plan must end after it begins")
    unit = (prior or Prior()).sigma_array()
    wider = expected is not None and expected.posterior is not posterior
    year = year_ahead(posterior, context, unit, expected if wider else None)
    covariance = posterior.covariance / np.outer(unit, unit)
    if expected is None:
        now = PlannedStop(at_utc_s, (), *year.expected(covariance, rule.tolerance_deg))
    else:
        rms, p95 = expected.year_rms_deg, expected.year_p95_deg
        now = PlannedStop(at_utc_s, (), rms, p95, expected.probability_within_tolerance)
    since_s = (at_utc_s - context.first_midnight_utc_s) % SECONDS_PER_DAY
    today = [t for t in taken_utc_s if at_utc_s - since_s <= t <= at_utc_s]
    planner = _Planner(
        posterior, context, unit, year, covariance, rule, now, clear,
        today, until_utc_s, points, tuple(struck),
    )  # fmt: skip
    return planner.plan(at_utc_s)


@dataclass(frozen=True, eq=False, slots=True)
class _Planner:
    """What a plan is made from, whenever it is made."""

    posterior: MechanismPosterior
    context: SkyContext
    unit: FloatArray
    year: YearAhead
    covariance: FloatArray
    rule: StoppingRule
    now: PlannedStop
    clear: bool
    today: list[float]
    until_utc_s: float | None
    points: int | None
    struck: tuple[tuple[float, float], ...]

    def plan(self, at_utc_s: float) -> Plan:
        """The plan made after the last point, or after the last planned one that was missed."""
        if self.clear and self.now.probability >= self.rule.probability:
            return self._without_points(at_utc_s, ())
        origin_s = self.today[-1] + GAP_S if self.today else at_utc_s
        missed_s = None
        for _ in range(MISSES_FOLLOWED):
            made = self._from(min(origin_s, max(at_utc_s, origin_s)), at_utc_s)
            due_s = made.next_point_utc_s
            if due_s is None or due_s >= at_utc_s:
                break
            missed_s, origin_s = due_s, due_s + SLOT_S
        else:
            made = self._from(max(origin_s, at_utc_s), at_utc_s)
        return self._explained(_still_ahead(made, at_utc_s), missed_s)

    def _explained(self, made: Plan, missed_s: float | None) -> Plan:
        due_s = made.next_point_utc_s
        if missed_s is None or due_s is None or due_s - missed_s <= JUMP_S:
            return made
        why = f"the point planned for {_clock(missed_s)} was not taken"
        return replace(made, sentence=f"{made.sentence}; {why}")

    def _from(self, origin_s: float, at_utc_s: float) -> Plan:
        until_s = self.until_utc_s
        slots = Slots(np.zeros(0), np.zeros((0, 2, 6)), GAP_S)
        if until_s is None or origin_s <= until_s:
            slots = day_slots(
                self.posterior, self.context, origin_s, self.unit, until_s, self.struck,
                on_the_clock=True,
            )  # fmt: skip
        if len(slots) == 0 or self.points == 0:
            return self._without_points(at_utc_s, ())
        return self._of_slots(slots, at_utc_s)

    def _of_slots(self, slots: Slots, at_utc_s: float) -> Plan:
        ends_s = _ends(slots)
        allowed = [self._allowed(slots, end_s) for end_s in ends_s]
        found = list(self._schedules(slots, ends_s, allowed))
        stops = [stop for stop, _, _ in found]
        sure = next((i for i, stop in enumerate(stops) if self._meets(stop)), None)
        if sure is not None:
            begin_s = ends_s[sure - 1] if sure else float(slots.utc_s[0]) - 1.0
            stops[sure] = self._earliest(slots, begin_s, found[sure])
            return self._reaching(at_utc_s, stops, stops[sure], "")
        last = found[-1]
        if self.points is None:
            dense = next(self._schedules(slots, ends_s[-1:], [len(slots)]))
            if self._meets(dense[0]):
                low = self._first_dense(slots, ends_s)
                stops[low] = self._earliest(slots, ends_s[low - 1] if low else -np.inf, dense)
                return self._reaching(at_utc_s, stops, stops[low], "denser than usual: ")
            best = max(dense[0].probability, *(stop.probability for stop in stops))
        else:
            best = max(stop.probability for stop in stops)
        best = max(best, self.now.probability)
        if best >= HOPE:
            stops[-1] = self._polished(slots, last[0], len(last[1]), None)
            return self._concluded(
                at_utc_s, stops, stops[-1],
                f"today's {_count(stops[-1].points)} until {_clock(stops[-1].stop_utc_s)} make it "
                f"{percent(best, self.rule.probability)} sure, {100 * self.rule.probability:g} % "
                f"needed; next at {_clock(stops[-1].times_utc_s[0])}",
            )  # fmt: skip
        return self._hopeless(at_utc_s, slots, found, best)

    def _allowed(self, slots: Slots, end_s: float) -> int:
        """Fewer points than one every ``PACE_S`` since the first of the day; one at least."""
        if self.points is not None:
            return self.points
        first_s = self.today[0] if self.today else float(slots.utc_s[0])
        return min(max(int((end_s - first_s) / PACE_S) - len(self.today), 1), MOST_POINTS)

    def _schedules(
        self, slots: Slots, ends_s: Sequence[float], allowed: Sequence[int]
    ) -> Iterator[tuple[PlannedStop, list[int], list[FloatArray]]]:
        """The greedy schedule of every end, with what is known after each of its points."""
        orders = greedy_for_each(
            slots,
            self.covariance,
            self.year.weight,
            max(allowed),
            np.array(ends_s),
            least_gain=WORTH_A_POINT if self.points is None else 0.0,
            floor=self.year.known_square,
        )
        for end_s, most, (chosen, covariances) in zip(ends_s, allowed, orders, strict=True):
            chosen, covariances = chosen[:most], covariances[:most]
            left = covariances[-1] if covariances else self.covariance
            yield self._stop(end_s, slots, chosen, left), chosen, covariances

    def _stop(
        self, end_s: float, slots: Slots, chosen: Sequence[int], covariance: FloatArray
    ) -> PlannedStop:
        times = tuple(float(slots.utc_s[i]) for i in sorted(chosen))
        return PlannedStop(end_s, times, *self.year.expected(covariance, self.rule.tolerance_deg))

    def _meets(self, stop: PlannedStop) -> bool:
        return stop.points > 0 and stop.probability >= self.rule.probability

    def _earliest(
        self,
        slots: Slots,
        begin_s: float,
        found: tuple[PlannedStop, list[int], list[FloatArray]],
    ) -> PlannedStop:
        """The first slot of the last half hour that will do, with as few points as will do."""
        inside = slots.utc_s[(slots.utc_s > begin_s) & (slots.utc_s < found[0].stop_utc_s)]
        if len(inside):
            ends_s = inside.tolist()
            dense = len(found[1]) > self._allowed(slots, found[0].stop_utc_s)
            allowed = [len(slots) if dense else self._allowed(slots, end_s) for end_s in ends_s]
            earlier = self._schedules(slots, ends_s, allowed)
            found = next((one for one in earlier if self._meets(one[0])), found)
        stop, chosen, covariances = found
        count = len(chosen)
        if self.points is None:
            low = 0
            while count - low > 1:
                middle = (low + count) // 2
                few = self._stop(stop.stop_utc_s, slots, chosen[:middle], covariances[middle - 1])
                if self._meets(few):
                    count, stop = middle, few
                else:
                    low = middle
        return self._polished(slots, stop, count, self.rule.probability)

    def _first_dense(self, slots: Slots, ends_s: Sequence[float]) -> int:
        low, high = 0, len(ends_s) - 1
        while low < high:
            middle = (low + high) // 2
            dense, *_ = next(self._schedules(slots, [ends_s[middle]], [len(slots)]))
            if self._meets(dense):
                high = middle
            else:
                low = middle + 1
        return high

    def _polished(
        self, slots: Slots, stop: PlannedStop, count: int, aim: float | None
    ) -> PlannedStop:
        """The stop with its points exchanged for better ones, and one fewer where that will do.

        Exchanges lower the rms; should the probability suffer by a hair, the stop stays.
        """
        best = stop
        for points in range(count, 0, -1):
            schedule = best_schedule(
                slots, self.covariance, self.year.weight, points, until_s=stop.stop_utc_s
            )
            left = after(slots, self.covariance, schedule)
            found = self._stop(stop.stop_utc_s, slots, schedule, left)
            if found.probability < (stop.probability if aim is None else aim):
                break
            best = found
            if aim is None or self.points is not None or points < count:
                break
        return best

    def _reaching(
        self, at_utc_s: float, stops: list[PlannedStop], stop: PlannedStop, how: str
    ) -> Plan:
        sentence = (
            f"{how}{_count(stop.points)} until {_clock(stop.times_utc_s[-1])} for "
            f"{percent(stop.probability, self.rule.probability)} probability of "
            f"{self.rule.tolerance_deg:g} deg; next at {_clock(stop.times_utc_s[0])}"
        )
        return self._concluded(at_utc_s, stops, stop, sentence)

    def _hopeless(
        self,
        at_utc_s: float,
        slots: Slots,
        found: Sequence[tuple[PlannedStop, list[int], list[FloatArray]]],
        best: float,
    ) -> Plan:
        stops = [stop for stop, _, _ in found]
        limit = NEAR_BEST * min(stop.year_p95_deg for stop in (self.now, *stops))
        index = next((i for i, stop in enumerate(stops) if stop.year_p95_deg <= limit), None)
        recommended = self.now
        left = self.covariance
        if index is not None and self.now.year_p95_deg > limit:
            chosen, covariances = found[index][1:]
            stops[index] = self._polished(slots, stops[index], len(chosen), None)
            recommended = stops[index]
            left = covariances[-1]
        return self._coming_back(at_utc_s, stops, recommended, left, best)

    def _without_points(self, at_utc_s: float, stops: Sequence[PlannedStop]) -> Plan:
        """Nothing can be taken today, or nothing is needed."""
        if self.clear and self.now.probability >= self.rule.probability:
            sentence = (
                "no more points are needed: "
                f"{percent(self.now.probability, self.rule.probability)} sure of "
                f"{self.rule.tolerance_deg:g} deg"
            )
            return self._concluded(at_utc_s, stops, self.now, sentence)
        best = self.now.probability
        return self._coming_back(at_utc_s, stops, self.now, self.covariance, best)

    def _coming_back(
        self,
        at_utc_s: float,
        stops: Sequence[PlannedStop],
        recommended: PlannedStop,
        covariance: FloatArray,
        best: float,
    ) -> Plan:
        back_s = come_back(self.year, covariance, at_utc_s, self.rule)
        visit: tuple[float, ...] = ()
        if back_s is None:
            when = "no later day of the year alone would be enough"
        else:
            visit = self._second_visit(covariance, back_s)
            when = f"come back around {format_utc(back_s, 0)[:10]}"
            if visit:
                when += (
                    f" for {_count(len(visit), '')} from {_clock(visit[0])} to {_clock(visit[-1])}"
                )
        sentence = (
            f"the best of today is {percent(best, self.rule.probability)} probability of "
            f"{self.rule.tolerance_deg:g} deg ({100 * self.rule.probability:g} % needed); "
            f"{when}"
        )
        return self._concluded(at_utc_s, stops, recommended, sentence, True, back_s, visit)

    def _second_visit(self, covariance: FloatArray, noon_s: float) -> tuple[float, ...]:
        """The points of the day to come back on, planned like today's."""
        slots = day_slots(
            self.posterior, self.context, noon_s - SECONDS_PER_DAY / 2.0, self.unit,
            on_the_clock=True,
        )  # fmt: skip
        if not len(slots):
            return ()
        visit = replace(self, covariance=covariance, today=[], until_utc_s=None, struck=())
        year = replace(self.year, known=self.year.plain)
        rule = StoppingRule(
            self.rule.tolerance_deg, max(self.rule.probability, SECOND_VISIT_PROBABILITY)
        )
        visit = replace(visit, points=None, year=year, rule=rule)
        ends_s = _ends(slots)
        allowed = [visit._allowed(slots, end_s) for end_s in ends_s]
        stops = [stop for stop, _, _ in visit._schedules(slots, ends_s, allowed)]
        return next((stop for stop in stops if visit._meets(stop)), stops[-1]).times_utc_s

    def _concluded(
        self,
        at_utc_s: float,
        stops: Sequence[PlannedStop],
        recommended: PlannedStop,
        sentence: str,
        hopeless: bool = False,
        back_s: float | None = None,
        visit: tuple[float, ...] = (),
    ) -> Plan:
        return Plan(
            at_utc_s=at_utc_s,
            rule=self.rule,
            now=self.now,
            stops=tuple(stops),
            recommended=recommended,
            done=self.clear and self.now.probability >= self.rule.probability,
            hopeless=hopeless,
            come_back_utc_s=back_s,
            second_visit_utc_s=visit,
            sentence=sentence,
            basis=Basis(
                self.posterior.noise_median_deg, len(self.today), self.struck, self.until_utc_s
            ),
        )


def _still_ahead(made: Plan, at_utc_s: float) -> Plan:
    """The same plan seen later: stops that are over go, and times that have passed."""
    if all(t >= at_utc_s for stop in made.stops for t in (stop.stop_utc_s, *stop.times_utc_s)):
        return made
    stops, recommended = [], made.recommended
    for stop in made.stops:
        if stop.stop_utc_s < at_utc_s:
            continue
        ahead = tuple(t for t in stop.times_utc_s if t >= at_utc_s)
        kept = stop if len(ahead) == stop.points else replace(stop, times_utc_s=ahead)
        stops.append(kept)
        if stop is made.recommended:
            recommended = kept
    return replace(made, stops=tuple(stops), recommended=recommended)


def _ends(slots: Slots) -> list[float]:
    """Every half hour of the clock from the first slot to the last, and the last slot itself."""
    first = STOP_STEP_S * math.ceil((float(slots.utc_s[0]) + 1.0) / STOP_STEP_S)
    last = float(slots.utc_s[-1])
    ends = np.arange(first, last, STOP_STEP_S).tolist()
    return [*ends, last]


def come_back(
    year: YearAhead, covariance: FloatArray, at_utc_s: float, rule: StoppingRule
) -> float | None:
    """Mean solar noon of the next day of the year's grid whose points meet the rule.

    The points are the best half hours of that day added to what is known today; noise alike.
    """
    if float(np.sqrt(year.known_square)) > rule.tolerance_deg:
        return None
    # Another day tells of what is there beside P1..P6, too; how much, nobody knows before.
    year = replace(year, known=year.plain)
    sure = max(rule.probability, SECOND_VISIT_PROBABILITY)
    days = len(year.day_rows)
    left = np.broadcast_to(covariance, (days, 6, 6)).copy()
    free = year.day_open.copy()
    for _ in range(MOST_POINTS):
        if not free.any():
            break
        gain = np.where(free, gains(year.day_rows, left, year.weight), -np.inf)
        best = np.argmax(gain, axis=1)
        possible = free[np.arange(days), best]
        row = np.where(
            possible[:, np.newaxis, np.newaxis], year.day_rows[np.arange(days), best], 0.0
        )
        left = with_point(left, row)
        free[np.arange(days), best] = False
    next_s = year.noons_after(at_utc_s)
    square = np.einsum("ij,dij->d", year.weight, left) + year.known_square
    for day in np.argsort(next_s):
        # A year rms near the tolerance leaves no room for 95 %: not worth a closer look.
        if square[day] > (0.8 * rule.tolerance_deg) ** 2:
            continue
        if year.expected(left[day], rule.tolerance_deg)[2] >= sure:
            return float(next_s[day])
    return None


def _count(points: int, more: str = "more ") -> str:
    return f"{points} {more}point{'' if points == 1 else 's'}"


def _clock(utc_s: float) -> str:
    return f"{format_utc(utc_s, 0)[11:16]} UTC"
