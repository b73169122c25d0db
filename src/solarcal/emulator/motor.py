"""One axis of the real machine: motor, encoder, slack and reference switch.

Positions are MOTOR counts from the nominal switch point, and exact functions of time between two
events: nothing here is ticked, so the answer cannot depend on how often it is read.
"""

import math
from collections.abc import Callable

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import Drive, ScrewjackDrive
from solarcal.units import FloatArray

NEVER_S = math.inf
SLOW = 0.25
"""Fraction of the full speed at which a switch is approached for the last time."""


class Motor:
    """Motor-side truth of one axis. Times are seconds since the start of the emulation.

    The collector follows the motor through a play of ``backlash_deg``: it stands anywhere within
    half of it on either side, and lags by that half behind a motion that has taken up the slack.
    Encoder and reference switch sit on the motor side and know nothing of it.

    ``power_up_counts``: by how much the encoder disagrees with the switch before the first check.
    """

    def __init__(
        self,
        drive: Drive,
        switch_deg: float,
        stands_deg: float,
        speed_deg_s: float,
        backlash_deg: float,
        power_up_counts: int,
        switch_noise_counts: Callable[[], float],
    ) -> None:
        self._drive = drive
        self._switch_counts = float(drive.counts(switch_deg))
        per_deg = abs(float(drive.counts(switch_deg + 0.5) - drive.counts(switch_deg - 0.5)))
        self._full_speed = per_deg * speed_deg_s
        self._half_play_deg = 0.5 * backlash_deg
        self._switch_noise_counts = switch_noise_counts

        self._end_stops = _end_stops(drive, self._switch_counts)

        self._from = round(float(drive.counts(stands_deg)) - self._switch_counts)
        self._to = self._from
        self._since_s = 0.0
        self._speed = self._full_speed
        self._lost = power_up_counts
        self._encoder_goal: int | None = None
        self._collector_from_deg = self.angle_deg(self._from)
        self.stops_s = NEVER_S

    @property
    def sense(self) -> int:
        """Sense of the motion in counts, 0 at rest."""
        return (self._to > self._from) - (self._to < self._from)

    def angle_deg(self, counts: float) -> float:
        """True axis angle of a motor position without slack."""
        return float(self._drive.angle_deg(self._switch_counts + counts))

    def angles_deg(self, counts: FloatArray) -> FloatArray:
        """The same for an array of any shape."""
        return self._drive.angle_deg(self._switch_counts + counts)

    def position(self, now_s: float) -> float:
        """Motor counts from the nominal switch point."""
        if now_s >= self.stops_s or self.sense == 0:
            return self._to
        return self._from + self.sense * self._speed * (now_s - self._since_s)

    def encoder(self, now_s: float) -> int:
        """Whole counts since power-up as the encoder gave them, the lost ones included."""
        return math.floor(self.position(now_s) + 0.5) + self._lost

    def collector_deg(self, now_s: float) -> float:
        """Where the collector's side of the play truly stands, axis degrees."""
        motor_deg = self.angle_deg(self.position(now_s))
        low, high = motor_deg - self._half_play_deg, motor_deg + self._half_play_deg
        return min(max(self._collector_from_deg, low), high)

    @property
    def switch_sense(self) -> int:
        """The switch's own state, which tells where it lies: +1 at higher counts, -1 at lower."""
        return 1 if self._to < 0 else -1

    def run_to(self, encoder: int, now_s: float) -> None:
        """Run until the encoder reads that many counts."""
        self._settle(now_s)
        self._encoder_goal = encoder
        self._run(encoder - self._lost, self._full_speed)

    def run_to_switch(self, sense: int, now_s: float, *, slow: bool) -> None:
        """Run in one sense until the switch trips; ends at once where it has tripped already."""
        self._settle(now_s)
        self._encoder_goal = None
        trip = round(self._switch_noise_counts())
        if (trip - self._from) * sense < 0:
            trip = self._from
        self._run(trip, self._full_speed * (SLOW if slow else 1.0))

    def stop(self, now_s: float) -> None:
        """Stop on the next whole count."""
        self._settle(now_s)
        self._encoder_goal = None

    def arrive(self) -> None:
        """Called at ``stops_s``: the motion has ended there."""
        self._settle(self.stops_s)
        self._encoder_goal = None

    def lose(self, counts: int, now_s: float) -> None:
        """From now on the encoder reads ``counts`` too high; a motion under way follows it."""
        goal, speed, to, moving = self._encoder_goal, self._speed, self._to, self.stops_s < NEVER_S
        self._settle(now_s)
        self._lost += counts
        if moving:
            self._encoder_goal = goal
            self._run(to if goal is None else goal - self._lost, speed)

    def _settle(self, now_s: float) -> None:
        """Take the present state as the new beginning, at rest on a whole count."""
        position, sense = self.position(now_s), self.sense
        whole = math.ceil(position) if sense > 0 else math.floor(position)
        self._to = whole
        self.stops_s = NEVER_S
        self._collector_from_deg = self.collector_deg(now_s)
        self._from = whole
        self._since_s = now_s

    def _run(self, to: int, speed: float) -> None:
        low, high = self._end_stops
        self._to = int(min(max(to, low), high))
        self._speed = speed
        self.stops_s = self._since_s + abs(self._to - self._from) / speed


def _end_stops(drive: Drive, switch_counts: float) -> tuple[float, float]:
    """Motor counts between which the axis can turn: a jack jams before it is flat or closed."""
    if not isinstance(drive, ScrewjackDrive):
        return -math.inf, math.inf
    turns: list[float] = []
    for corner_deg in range(1, 180):
        try:
            turns.append(float(drive.counts(corner_deg - drive.beta_deg)) - switch_counts)
        except ConfigurationError:
            # The pivots come closer together here than the tube offset.
            continue
    return math.ceil(min(turns)), math.floor(max(turns))
