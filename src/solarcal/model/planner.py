"""When to take the next points, and when the calibration will be done.

Every remaining half hour is a possible end of the day. For each the best schedule is sought, of
fewer points than one every ``PACE_S``, and its forecast computed; the earliest end at which the
stopping rule will be met is recommended, with as few points as meet it. A plan is a pure function
of the points taken and of what is struck out: as long as its next point lies ahead it stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.forecast import Forecast
from solarcal.model.more_points import Candidate, DayStops, YearAhead, year_ahead
from solarcal.model.plan import JUMP_S, Basis, Plan, PlannedStop
from solarcal.model.points import Points
from solarcal.model.prior import MechanismPosterior, Prior
from solarcal.model.schedule import GAP_S, SLOT_S, Slots, day_slots
from solarcal.model.sky_context import SkyContext
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule, percent
from solarcal.timescale import SECONDS_PER_DAY, clock_utc, format_utc
from solarcal.units import FloatArray

NEAR_BEST = 1.10
"""Where the rule is out of reach, the day ends when its forecast is within a tenth of its best."""
HOPE = 0.5
"""A day whose best plan leaves less than this probability of the tolerance is not worth waiting
for: today's luck does not make up for more."""
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
    first: str = "",
    taken_utc_s: Sequence[float] = (),
    until_utc_s: float | None = None,
    points: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
) -> Plan:
    """Plan the rest of the solar day that ``at_utc_s`` lies in.

    Parameters
    ----------
    posterior : of a fit.
    rule : when the calibration is done.
    expected : the forecast of the points taken, where there is one. With what may be there beside
        P1..P6 it is of another posterior: more points remove none of that.
    clear : nothing known speaks against the fit: only then can the calibration be done.
    first : what to do about that which speaks against the fit and more points do not settle.
    taken_utc_s : when they were taken. The plan is the one made after the last of them, as long as
        its next point has not been missed.
    until_utc_s : the technician must leave then.
    points : exactly so many more, where the day has room; None: as many as are worth taking.
    struck : intervals (from, to) in which no point can be taken: cloud, lunch.
    """
    if until_utc_s is not None and until_utc_s < at_utc_s:
        raise ConfigurationError("the plan must end after it begins")
    # The units of the arithmetic; they never change the answer.
    unit = Prior().sigma_array()
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
        at_utc_s, posterior, context, unit, year, covariance, rule, now, clear, first,
        today, until_utc_s, points, tuple(struck),
    )  # fmt: skip
    return planner.plan()


@dataclass(frozen=True, eq=False, slots=True)
class _Planner:
    """What a plan is made from, whenever it is made."""

    at_utc_s: float
    posterior: MechanismPosterior
    context: SkyContext
    unit: FloatArray
    year: YearAhead
    covariance: FloatArray
    rule: StoppingRule
    now: PlannedStop
    clear: bool
    first: str
    today: list[float]
    until_utc_s: float | None
    points: int | None
    struck: tuple[tuple[float, float], ...]

    @property
    def done(self) -> bool:
        return self.clear and self.now.probability >= self.rule.probability

    def plan(self) -> Plan:
        """The plan made after the last point, or after the last planned one that was missed."""
        at_utc_s = self.at_utc_s
        if self.done:
            sentence = (
                "no more points are needed: "
                f"{percent(self.now.probability, self.rule.probability)} sure of "
                f"{self.rule.tolerance_deg:g} deg"
            )
            return self._concluded((), self.now, sentence)
        origin_s = self.today[-1] + GAP_S if self.today else at_utc_s
        missed_s = None
        for _ in range(MISSES_FOLLOWED):
            made = self._from(min(origin_s, max(at_utc_s, origin_s)))
            due_s = made.next_point_utc_s
            if due_s is None or due_s >= at_utc_s:
                break
            missed_s, origin_s = due_s, due_s + SLOT_S
        else:
            made = self._from(max(origin_s, at_utc_s))
        return self._explained(made.seen_later(at_utc_s), missed_s)

    def _explained(self, made: Plan, missed_s: float | None) -> Plan:
        due_s = made.next_point_utc_s
        if missed_s is None or due_s is None or due_s - missed_s <= JUMP_S:
            return made
        why = f"the point planned for {clock_utc(missed_s)} was not taken"
        return replace(made, sentence=f"{made.sentence}; {why}")

    def _from(self, origin_s: float) -> Plan:
        until_s = self.until_utc_s
        slots = Slots(np.zeros(0), np.zeros((0, 2, 6)), GAP_S)
        if until_s is None or origin_s <= until_s:
            slots = day_slots(
                self.posterior, self.context, origin_s, self.unit, until_s, self.struck,
                on_the_clock=True,
            )  # fmt: skip
        if len(slots) == 0 or self.points == 0:
            return self._coming_back((), self.now, self.covariance)
        return self._of_day(
            DayStops(slots, self.covariance, self.year, self.rule, self.today, self.points)
        )

    def _of_day(self, day: DayStops) -> Plan:
        ends_s = day.ends_s
        found = list(day.schedules(ends_s))
        stops = [stop for stop, _, _ in found]
        sure = next((i for i, stop in enumerate(stops) if day.meets(stop)), None)
        if sure is not None:
            begin_s = ends_s[sure - 1] if sure else float(day.slots.utc_s[0]) - 1.0
            stops[sure] = day.earliest(begin_s, found[sure])
            return self._reaching(stops, stops[sure], "")
        best = max(self.now.probability, *(stop.probability for stop in stops))
        if self.points is None:
            dense = next(day.schedules(ends_s[-1:], dense=True))
            if day.meets(dense[0]):
                low = day.first_dense(ends_s)
                stops[low] = day.earliest(ends_s[low - 1] if low else -np.inf, dense)
                return self._reaching(stops, stops[low], "denser than usual: ")
            best = max(best, dense[0].probability)
        if best >= HOPE:
            stops[-1] = day.polished(stops[-1], len(found[-1][1]), None)
            last, needed = stops[-1], self.rule.probability
            sentence = (
                f"today's {_count(last.points)} until {clock_utc(last.stop_utc_s)} make it "
                f"{percent(last.probability, needed)} sure, {100 * needed:g} % needed; next at "
                f"{clock_utc(last.times_utc_s[0])}"
            )
            return self._concluded(stops, last, sentence)
        return self._hopeless(day, found)

    def _reaching(self, stops: list[PlannedStop], stop: PlannedStop, how: str) -> Plan:
        sentence = (
            f"{how}{_count(stop.points)} until {clock_utc(stop.times_utc_s[-1])} for "
            f"{percent(stop.probability, self.rule.probability)} probability of "
            f"{self.rule.tolerance_deg:g} deg; next at {clock_utc(stop.times_utc_s[0])}"
        )
        if not self.first and self.now.probability >= self.rule.probability:
            sentence += (
                "; the verdict names what is against it now, and more points may settle that"
            )
        return self._concluded(stops, stop, sentence)

    def _hopeless(self, day: DayStops, found: Sequence[Candidate]) -> Plan:
        stops = [stop for stop, _, _ in found]
        limit = NEAR_BEST * min(stop.year_p95_deg for stop in (self.now, *stops))
        index = next((i for i, stop in enumerate(stops) if stop.year_p95_deg <= limit), None)
        recommended = self.now
        left = self.covariance
        if index is not None and self.now.year_p95_deg > limit:
            chosen, covariances = found[index][1:]
            stops[index] = day.polished(stops[index], len(chosen), None)
            recommended = stops[index]
            left = covariances[-1]
        return self._coming_back(stops, recommended, left)

    def _coming_back(
        self,
        stops: Sequence[PlannedStop],
        recommended: PlannedStop,
        covariance: FloatArray,
    ) -> Plan:
        surer = max(self.rule.probability, SECOND_VISIT_PROBABILITY)
        rule = StoppingRule(self.rule.tolerance_deg, surer)
        back_s = self.year.come_back(covariance, self.at_utc_s, rule)
        visit: tuple[float, ...] = ()
        if back_s is None:
            when = "no later day of the year alone would be enough"
        else:
            visit = self._second_visit(covariance, back_s, rule)
            when = f"come back around {format_utc(back_s, 0)[:10]}"
            if visit:
                last = f" to {clock_utc(visit[-1])}" if len(visit) > 1 else ""
                first = f"{'from' if last else 'at'} {clock_utc(visit[0])}"
                when += f" for {_count(len(visit), '')} {first}{last}"
        best, needed = max(stop.probability for stop in (self.now, *stops)), self.rule.probability
        sure = f"{percent(best, needed)} probability of {self.rule.tolerance_deg:g} deg"
        sentence = f"the best of today is {sure} ({100 * needed:g} % needed); {when}"
        if best >= needed:
            sentence = (
                f"{sure} would be enough, but the verdict names what else is against it; {when}"
            )
        return self._concluded(stops, recommended, sentence, True, back_s, visit)

    def _second_visit(
        self, covariance: FloatArray, noon_s: float, rule: StoppingRule
    ) -> tuple[float, ...]:
        """The points of the day to come back on, planned like today's."""
        slots = day_slots(
            self.posterior, self.context, noon_s - SECONDS_PER_DAY / 2.0, self.unit,
            on_the_clock=True,
        )  # fmt: skip
        if not len(slots):
            return ()
        day = DayStops(slots, covariance, replace(self.year, known=self.year.plain), rule)
        stops = [stop for stop, _, _ in day.schedules(day.ends_s)]
        return next((stop for stop in stops if day.meets(stop)), stops[-1]).times_utc_s

    def _concluded(
        self,
        stops: Sequence[PlannedStop],
        recommended: PlannedStop,
        sentence: str,
        hopeless: bool = False,
        back_s: float | None = None,
        visit: tuple[float, ...] = (),
    ) -> Plan:
        if self.first:
            sentence = f"{self.first}; by the points as they are: {sentence}"
        return Plan(
            at_utc_s=self.at_utc_s,
            rule=self.rule,
            now=self.now,
            stops=tuple(stops),
            recommended=recommended,
            done=self.done,
            first=self.first,
            hopeless=hopeless,
            come_back_utc_s=back_s,
            second_visit_utc_s=visit,
            sentence=sentence,
            basis=Basis(
                self.posterior.noise_median_deg, len(self.today), self.struck, self.until_utc_s
            ),
        )


def _count(points: int, more: str = "more ") -> str:
    return f"{points} {more}point{'' if points == 1 else 's'}"
