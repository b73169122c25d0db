"""What the technician wants of a day's plan: leave by then, so many points, not in those clouds."""

from dataclasses import dataclass, replace

from solarcal.model.analysis import Analysis
from solarcal.session.view import SessionView
from solarcal.station.analysing import analyse_session

HALF_HOUR_S = 1800.0
MOST_POINTS = 40


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """All open at first.

    Attributes
    ----------
    until_utc_s : the technician must leave then.
    points : of the whole calibration, those taken already among them.
    struck : beginnings (POSIX UTC seconds) of the half hours in which no point can be taken.
    """

    until_utc_s: float | None = None
    points: int | None = None
    struck: frozenset[float] = frozenset()

    def strike(self, begin_utc_s: float) -> "PlanOptions":
        """That half hour excluded, or restored."""
        return replace(self, struck=self.struck ^ {begin_utc_s})

    def leave_at(self, utc_s: float) -> "PlanOptions":
        """Leave then; the same time again lifts it."""
        return replace(self, until_utc_s=None if self.until_utc_s == utc_s else utc_s)

    def points_more(self, by: int, taken: int, planned: int) -> "PlanOptions":
        """One point more or less than requested, or than what is taken and planned."""
        now = taken + planned if self.points is None else self.points
        return replace(self, points=min(max(now + by, taken), MOST_POINTS))

    def points_left(self, taken: int) -> int | None:
        return None if self.points is None else max(0, self.points - taken)

    def intervals(self) -> tuple[tuple[float, float], ...]:
        """(from, to) of the struck half hours, seconds; the last second belongs to the next."""
        return tuple((begin, begin + HALF_HOUR_S - 1.0) for begin in sorted(self.struck))


DEFAULT_OPTIONS = PlanOptions()


def analyse_with_options(
    session: SessionView,
    plan_options: PlanOptions = DEFAULT_OPTIONS,
    at_utc_s: float | None = None,
) -> Analysis | None:
    """The analysis of a session, planned from ``at_utc_s`` (else from the newest point).

    A time to leave that has passed means: now.
    """
    until_utc_s = plan_options.until_utc_s
    if until_utc_s is not None and at_utc_s is not None:
        until_utc_s = max(until_utc_s, at_utc_s)
    return analyse_session(
        session,
        at_utc_s=at_utc_s,
        until_utc_s=until_utc_s,
        points_left=plan_options.points_left(len(session.accepted)),
        struck=plan_options.intervals(),
    )
