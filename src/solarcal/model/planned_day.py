"""What a plan says: the possible ends of a day, and the one to choose."""

from dataclasses import dataclass
from typing import Any

from solarcal.timescale import format_utc


@dataclass(frozen=True, slots=True)
class PlannedStop:
    """What stopping at one time would give: the points to take until then, and the forecast."""

    stop_utc_s: float
    times_utc_s: tuple[float, ...]
    year_rms_deg: float
    year_p95_deg: float

    @property
    def points(self) -> int:
        return len(self.times_utc_s)

    def as_json(self) -> dict[str, Any]:
        return {
            "stop": format_utc(self.stop_utc_s, 0),
            "points": [format_utc(time, 0) for time in self.times_utc_s],
            "year_rms_deg": self.year_rms_deg,
            "year_p95_deg": self.year_p95_deg,
        }


@dataclass(frozen=True, slots=True)
class Plan:
    """The rest of a day.

    Attributes
    ----------
    now
        The forecast as it stands, without another point.
    stops
        One for each remaining half hour.
    recommended
        One of ``stops`` (or ``now``), its schedule as short as its forecast allows.
    reaches
        Whether the recommended stop reaches the tolerance.
    come_back_utc_s
        Mean solar noon of the next date whose points would reach it; None: not needed or none.
    """

    at_utc_s: float
    tolerance_deg: float
    now: PlannedStop
    stops: tuple[PlannedStop, ...]
    recommended: PlannedStop
    come_back_utc_s: float | None
    sentence: str

    @property
    def reaches(self) -> bool:
        return self.recommended.year_p95_deg <= self.tolerance_deg

    @property
    def best_p95_deg(self) -> float:
        """The best that today can still give."""
        return min(stop.year_p95_deg for stop in (self.now, *self.stops))

    @property
    def next_point_utc_s(self) -> float | None:
        times = self.recommended.times_utc_s
        return times[0] if times else None

    def as_json(self) -> dict[str, Any]:
        next_s, back_s = self.next_point_utc_s, self.come_back_utc_s
        return {
            "at": format_utc(self.at_utc_s, 0),
            "tolerance_deg": self.tolerance_deg,
            "now": self.now.as_json(),
            "stops": [stop.as_json() for stop in self.stops],
            "recommended": self.recommended.as_json(),
            "reaches": self.reaches,
            "best_p95_deg": self.best_p95_deg,
            "next_point": None if next_s is None else format_utc(next_s, 0),
            "come_back": None if back_s is None else format_utc(back_s, 0)[:10],
            "sentence": self.sentence,
        }
