"""Motion of a unit that the station drives: steps after the Sun, what moves, and what is due.

``SunSteps`` says where the axes are sent while they track; ``MotionWatch`` sees from the read-outs
whether an axis moves; ``Pace`` has the unit act between commands.
"""

import threading
import weakref
from collections.abc import Callable
from typing import Protocol

from solarcal.decimals import Pair
from solarcal.mount.geometry import Limits
from solarcal.timescale import SystemClock

AHEAD_S = 30.0
"""Over this time the sense of the Sun's motion in an axis is taken."""

SOONEST_S, LATEST_S = 0.25, 20.0

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
        """Another client drives the axes, or none."""
        self.goals_deg = None

    def due(self, utc_s: float) -> Pair | None:
        """Where to send the axes now; ``None`` while the Sun has not run far enough."""
        targets = self._targets(utc_s)
        goals = list(self.goals_deg or targets)
        moved = self.goals_deg is None
        limits = (self._limits.axis1, self._limits.axis2)
        for axis, (lag, sense) in enumerate(self._lags(utc_s, targets)):
            if self.goals_deg is None or lag >= self._half_deg or lag < -1.5 * self._half_deg:
                goals[axis] = limits[axis].clamped_deg(targets[axis] + sense * self._half_deg)
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


LOOK_S = 0.4
"""An axis whose read-out has not changed for so long stands still."""

START_S = 2.0
"""A rotator that was sent somewhere may take so long to release brakes and set out."""


class MotionWatch:
    """Sense of motion of one axis, now and last.

    ``still_deg``: a change of the read-out by no more than this is its last digit, no motion.
    """

    def __init__(self, still_deg: float) -> None:
        self.moving = 0
        self.approach = 0
        """Sense of the last finished motion, 0 while none is known."""
        self._still_deg = still_deg
        self._stands_deg: float | None = None
        self._goal_deg: float | None = None
        self._since_s = 0.0

    def set_out(self, utc_s: float, goal_deg: float) -> None:
        """The axis was sent to a read-out."""
        self._goal_deg = goal_deg
        if self._stands_deg is None or self._arrived(self._stands_deg):
            return
        self.moving = 1 if goal_deg > self._stands_deg else -1
        self._since_s = utc_s + START_S - LOOK_S

    def halt(self) -> None:
        """It is on its way nowhere any more; whether it coasts is still to be seen."""
        self._goal_deg = None

    def seen(self, utc_s: float, reading_deg: float) -> None:
        """One look at the read-out."""
        if self._stands_deg is None:
            self._stands_deg, self._since_s = reading_deg, utc_s
            return
        moved_deg = reading_deg - self._stands_deg
        if abs(moved_deg) > self._still_deg:
            self.moving = 1 if moved_deg > 0.0 else -1
            self._stands_deg, self._since_s = reading_deg, utc_s
        # A clock that was set back meanwhile must not hold an axis in motion.
        elif utc_s - self._since_s >= LOOK_S or utc_s < self._since_s - START_S:
            self._rest()
        if self._arrived(reading_deg):
            self._rest()

    def _rest(self) -> None:
        if self.moving:
            self.approach = self.moving
        self.moving = 0

    def _arrived(self, reading_deg: float) -> bool:
        return self._goal_deg is not None and abs(reading_deg - self._goal_deg) <= self._still_deg


PACE_S = 0.25
"""How often is looked, real seconds."""


class Acting(Protocol):
    """Whoever has something due from time to time."""

    def act(self) -> None:
        """Do what is due; nothing where nothing is."""
        ...


class Pace(Protocol):
    """Has ``act`` called when something is due."""

    def begin(self, unit: Acting) -> None: ...

    def end(self) -> None: ...


class ThreadPace:
    """A thread that looks, several times a second, whether something is due.

    ``speed``: laptop seconds a real second; 0 while time moves only by calls of ``act``.
    """

    def __init__(self, speed: Callable[[], float] = lambda: 1.0) -> None:
        self._speed = speed
        self._clock: SystemClock | None = None

    def begin(self, unit: Acting) -> None:
        self.end()
        clock = self._clock = SystemClock()
        # Held weakly: a unit that nobody uses any more is not kept going.
        threading.Thread(
            target=self._run, args=(weakref.ref(unit), clock), name="pace of the unit", daemon=True
        ).start()

    def end(self) -> None:
        # Not joined: it may be waiting for the turn of whoever ends it, and finds nothing to do.
        clock, self._clock = self._clock, None
        if clock is not None:
            clock.wake()

    def _run(self, held: "weakref.ref[Acting]", clock: SystemClock) -> None:
        while self._clock is clock:
            speed = self._speed()
            unit = held()
            if unit is None:
                return
            if speed > 0.0 and self._clock is clock:
                unit.act()
            del unit
            clock.wait(PACE_S if speed <= 1.0 else max(PACE_S / speed, 0.01))
