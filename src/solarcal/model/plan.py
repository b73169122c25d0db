"""A plan of the rest of a day: the times at which it could end, and what each would give."""

from dataclasses import dataclass, replace
from typing import Any

from solarcal.stopping_rule import StoppingRule
from solarcal.timescale import format_utc

NOISE_STEP = 1.15
JUMP_S = 1800.0
"""A next point that moves by more than this needs a reason."""


@dataclass(frozen=True, slots=True)
class PlannedStop:
    """What stopping at one time would give: the points to take until then, and the forecast."""

    stop_utc_s: float
    times_utc_s: tuple[float, ...]
    year_rms_deg: float
    year_p95_deg: float
    probability: float
    """Of the tracker's own 95th percentile within the tolerance."""

    @property
    def points(self) -> int:
        return len(self.times_utc_s)

    def as_json(self) -> dict[str, Any]:
        return {
            "stop": format_utc(self.stop_utc_s, 0),
            "points": [format_utc(time, 0) for time in self.times_utc_s],
            "year_rms_deg": self.year_rms_deg,
            "year_p95_deg": self.year_p95_deg,
            "probability_within_tolerance": self.probability,
        }


@dataclass(frozen=True, slots=True)
class Basis:
    """What a plan was made from: the noise of a point, the points taken, the intervals struck."""

    noise_deg: float
    points: int
    struck: tuple[tuple[float, float], ...]
    until_utc_s: float | None


@dataclass(frozen=True, slots=True)
class Plan:
    """The rest of a day.

    Attributes
    ----------
    now : the forecast as it stands, without another point.
    stops : one for each remaining half hour.
    recommended : one of ``stops`` (or ``now``), its schedule as short as the rule allows.
    done : nothing more is needed.
    first : what has to be done before any stop can be done, or nothing.
    hopeless : no schedule of today comes near the rule.
    come_back_utc_s : mean solar noon of the next date whose points would meet it; None: not needed
        or none.
    second_visit_utc_s : when to take points then.
    """

    at_utc_s: float
    rule: StoppingRule
    now: PlannedStop
    stops: tuple[PlannedStop, ...]
    recommended: PlannedStop
    done: bool
    first: str
    hopeless: bool
    come_back_utc_s: float | None
    second_visit_utc_s: tuple[float, ...]
    sentence: str
    basis: "Basis"

    @property
    def tolerance_deg(self) -> float:
        return self.rule.tolerance_deg

    def reached_by(self, stop: PlannedStop) -> bool:
        """Whether the calibration will be done at this stop."""
        reached = not self.first and stop.probability >= self.rule.probability
        return reached and (stop is not self.now or self.done)

    @property
    def reaches(self) -> bool:
        return self.reached_by(self.recommended)

    @property
    def best_p95_deg(self) -> float:
        """The best that today can still give."""
        return min(stop.year_p95_deg for stop in (self.now, *self.stops))

    @property
    def best_probability(self) -> float:
        return max(stop.probability for stop in (self.now, *self.stops))

    @property
    def next_point_utc_s(self) -> float | None:
        times = self.recommended.times_utc_s
        return times[0] if times else None

    def seen_later(self, at_utc_s: float) -> "Plan":
        """The same without the stops that are over and the times that have passed."""
        if all(t >= at_utc_s for stop in self.stops for t in (stop.stop_utc_s, *stop.times_utc_s)):
            return self
        stops, recommended = [], self.recommended
        for stop in self.stops:
            if stop.stop_utc_s < at_utc_s:
                continue
            ahead = tuple(t for t in stop.times_utc_s if t >= at_utc_s)
            kept = stop if len(ahead) == stop.points else replace(stop, times_utc_s=ahead)
            stops.append(kept)
            if stop is self.recommended:
                recommended = kept
        return replace(self, stops=tuple(stops), recommended=recommended)

    def compared_with(self, before: "Plan | None") -> "Plan":
        """The same, saying why where its last point moved by more than half an hour."""
        if before is None or not self.recommended.points or not before.recommended.points:
            return self
        later_s = self.recommended.times_utc_s[-1] - before.recommended.times_utc_s[-1]
        if abs(later_s) <= JUMP_S:
            return self
        new, old = self.basis, before.basis
        if (new.struck, new.until_utc_s) != (old.struck, old.until_utc_s):
            why = "the hours that can be used have changed"
        elif new.points != old.points:
            why = "the last point changed what is known of the unit"
            if not 1.0 / NOISE_STEP < new.noise_deg / old.noise_deg < NOISE_STEP:
                why = (
                    f"the last point makes the noise of one {new.noise_deg:.3f} deg instead of "
                    f"{old.noise_deg:.3f}"
                )
        else:
            why = "a planned point was not taken"
        way = "later" if later_s > 0.0 else "earlier"
        sentence = f"{self.sentence}; {abs(later_s) / 60.0:.0f} min {way} than planned: {why}"
        return replace(self, sentence=sentence)

    def as_json(self) -> dict[str, Any]:
        next_s, back_s = self.next_point_utc_s, self.come_back_utc_s
        return {
            "at": format_utc(self.at_utc_s, 0),
            "tolerance_deg": self.rule.tolerance_deg,
            "done_probability": self.rule.probability,
            "now": self.now.as_json(),
            "stops": [stop.as_json() for stop in self.stops],
            "recommended": self.recommended.as_json(),
            "reaches": self.reaches,
            "best_p95_deg": self.best_p95_deg,
            "best_probability": self.best_probability,
            "next_point": None if next_s is None else format_utc(next_s, 0),
            "come_back": None if back_s is None else format_utc(back_s, 0)[:10],
            "second_visit": [format_utc(time, 0) for time in self.second_visit_utc_s],
            "sentence": self.sentence,
        }
