"""Does an axis move? A rotator does not say: its read-outs do, looked at more than once."""

LOOK_S = 0.4
"""An axis whose read-out has not changed for so long stands still."""

START_S = 2.0
"""A rotator that was sent somewhere may take so long to release brakes and set out."""

Pair = tuple[float, float]


class MotionWatch:
    """Sense of motion of one axis, now and last.

    Parameters
    ----------
    still_deg : a change of the read-out by no more than this is its last digit, no motion.
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
