"""Following the Sun in steps: once it is half the update range ahead, go half the range ahead."""

from collections.abc import Callable

from solarcal.mount.limits import Limits

AHEAD_S = 30.0
"""Over this time the sense of the Sun's motion in an axis is taken."""

SOONEST_S, LATEST_S = 0.25, 20.0

Pair = tuple[float, float]
Targets = Callable[[float], Pair]


class SunSteps:
    """Where the axes are sent while they track. Read-outs in degrees, times in UTC seconds.

    Parameters
    ----------
    targets : the read-outs that belong to the Sun at an instant: ideal + E + O.
    limits : of the read-outs; nothing is sent beyond them.
    """

    def __init__(self, targets: Targets, limits: Limits, update_range_deg: float) -> None:
        self._targets = targets
        self._limits = limits
        self._half_deg = 0.5 * update_range_deg
        self.goals_deg: Pair | None = None
        """Where the axes were sent last; ``None`` while they are not sent anywhere."""

    def within(self, utc_s: float) -> bool:
        """Whether the Sun's read-outs lie within the limits."""
        return float(self._limits.distance_deg(*self._targets(utc_s))) >= 0.0

    def forget(self) -> None:
        """Somebody else drives the axes, or nobody."""
        self.goals_deg = None

    def due(self, utc_s: float) -> Pair | None:
        """Where to send the axes now; ``None`` while the Sun has not run far enough."""
        targets = self._targets(utc_s)
        goals = list(self.goals_deg or targets)
        moved = self.goals_deg is None
        limits = (self._limits.axis1, self._limits.axis2)
        for axis, (lag, sense) in enumerate(self._lags(utc_s, targets)):
            if self.goals_deg is None or lag >= self._half_deg or lag < -1.5 * self._half_deg:
                ahead = targets[axis] + sense * self._half_deg
                goals[axis] = min(max(ahead, limits[axis].low_deg), limits[axis].high_deg)
                moved = moved or goals[axis] != self.goals_deg[axis]  # type: ignore[index]
        if not moved:
            return None
        self.goals_deg = (goals[0], goals[1])
        return self.goals_deg

    def phase(self, utc_s: float) -> float:
        """From 0 just after a step to 1 when the next is due, of the axis that is due first."""
        if self.goals_deg is None:
            return 0.0
        lags = [lag for lag, _ in self._lags(utc_s, self._targets(utc_s))]
        return min(max((max(lags) + self._half_deg) / (2.0 * self._half_deg), 0.0), 1.0)

    def next_s(self, utc_s: float) -> float:
        """When to ask ``due`` again."""
        targets, later = self._targets(utc_s), self._targets(utc_s + AHEAD_S)
        soonest = LATEST_S
        for axis, (lag, _) in enumerate(self._lags(utc_s, targets)):
            rate = abs(later[axis] - targets[axis]) / AHEAD_S
            if rate > 0.0:
                soonest = min(soonest, (self._half_deg - lag) / rate)
        return utc_s + max(soonest, SOONEST_S)

    def _lags(self, utc_s: float, targets: Pair) -> list[tuple[float, int]]:
        """How far each axis is behind the Sun, and the Sun's sense in it."""
        later = self._targets(utc_s + AHEAD_S)
        goals = self.goals_deg or targets
        senses = [1 if later[axis] >= targets[axis] else -1 for axis in (0, 1)]
        return [((targets[axis] - goals[axis]) * senses[axis], senses[axis]) for axis in (0, 1)]
