"""The rest of one day: the times at which it could end, and the best points until each."""

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.model.plan import PlannedStop
from solarcal.model.schedule import MOST_POINTS, Slots, after, best_schedule, greedy_for_each
from solarcal.model.year_ahead import YearAhead
from solarcal.stopping_rule import StoppingRule
from solarcal.units import FloatArray

STOP_STEP_S = 1800.0
PACE_S = 1200.0
"""A technician without a plan takes a point every 20 minutes at most; a plan asks for fewer."""
WORTH_A_POINT = 0.002
"""Part of the mean square that one more point must save to be considered at all."""

Candidate = tuple[PlannedStop, list[int], list[FloatArray]]
"""A stop, the slots of its points in the order of their worth, and what is known after each."""


@dataclass(frozen=True, eq=False, slots=True)
class DayStops:
    """The times at which a day of ``slots`` could end.

    ``covariance``: what is known before, in units of the prior; ``today``: when points were taken
    today; ``points``: exactly so many more, or as many as are worth taking.
    """

    slots: Slots
    covariance: FloatArray
    year: YearAhead
    rule: StoppingRule
    today: Sequence[float] = ()
    points: int | None = None

    @property
    def ends_s(self) -> list[float]:
        """Every half hour of the clock from the first slot to the last, and the last slot."""
        first = STOP_STEP_S * math.ceil((float(self.slots.utc_s[0]) + 1.0) / STOP_STEP_S)
        last = float(self.slots.utc_s[-1])
        return [*np.arange(first, last, STOP_STEP_S).tolist(), last]

    def allowed(self, end_s: float) -> int:
        """Fewer points than one every ``PACE_S`` since the first of the day; one at least."""
        if self.points is not None:
            return self.points
        first_s = self.today[0] if self.today else float(self.slots.utc_s[0])
        return min(max(int((end_s - first_s) / PACE_S) - len(self.today), 1), MOST_POINTS)

    def schedules(self, ends_s: Sequence[float], *, dense: bool = False) -> Iterator[Candidate]:
        """The greedy schedule of every end; ``dense``: with as many points as there is room for."""
        allowed = [len(self.slots) if dense else self.allowed(end_s) for end_s in ends_s]
        orders = greedy_for_each(
            self.slots,
            self.covariance,
            self.year.weight,
            allowed,
            np.array(ends_s),
            least_gain=WORTH_A_POINT if self.points is None else 0.0,
            floor=self.year.known_square,
        )
        for end_s, (chosen, covariances) in zip(ends_s, orders, strict=True):
            left = covariances[-1] if covariances else self.covariance
            yield self.stop(end_s, chosen, left), chosen, covariances

    def stop(self, end_s: float, chosen: Sequence[int], covariance: FloatArray) -> PlannedStop:
        times = tuple(float(self.slots.utc_s[i]) for i in sorted(chosen))
        return PlannedStop(end_s, times, *self.year.expected(covariance, self.rule.tolerance_deg))

    def meets(self, stop: PlannedStop) -> bool:
        return stop.points > 0 and stop.probability >= self.rule.probability

    def earliest(self, begin_s: float, found: Candidate) -> PlannedStop:
        """The first slot of the last half hour that will do, with as few points as will do."""
        last_s = found[0].stop_utc_s
        inside = [time for time in self.slots.utc_s.tolist() if begin_s < time < last_s]
        if inside:
            earlier = self.schedules(inside, dense=len(found[1]) > self.allowed(last_s))
            found = next((one for one in earlier if self.meets(one[0])), found)
        stop, chosen, covariances = found
        count = len(chosen)
        if self.points is None:
            low = 0
            while count - low > 1:
                middle = (low + count) // 2
                few = self.stop(stop.stop_utc_s, chosen[:middle], covariances[middle - 1])
                if self.meets(few):
                    count, stop = middle, few
                else:
                    low = middle
        return self.polished(stop, count, self.rule.probability)

    def first_dense(self, ends_s: Sequence[float]) -> int:
        """Which end is the first that points as dense as can be taken will do for."""

        def will_do(end_s: float) -> bool:
            dense, *_ = next(self.schedules([end_s], dense=True))
            return self.meets(dense)

        return bisect_left(ends_s, True, hi=len(ends_s) - 1, key=will_do)

    def polished(self, stop: PlannedStop, count: int, aim: float | None) -> PlannedStop:
        """The stop with its points exchanged for better ones, and one fewer where that will do.

        Exchanges lower the rms; should the probability suffer by a hair, the stop stays.
        """
        best = stop
        for points in range(count, 0, -1):
            schedule = best_schedule(
                self.slots, self.covariance, self.year.weight, points, until_s=stop.stop_utc_s
            )
            left = after(self.slots, self.covariance, schedule)
            found = self.stop(stop.stop_utc_s, schedule, left)
            if found.probability < (stop.probability if aim is None else aim):
                break
            best = found
            if aim is None or self.points is not None or points < count:
                break
        return best
