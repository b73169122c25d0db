"""Following the Sun in steps: who moves when, and what happens at a limit."""

from collections.abc import Sequence
from typing import Final

from solarcal.emulator.axis_control import AxisControl
from solarcal.emulator.beliefs import Beliefs
from solarcal.emulator.tracking import NEVER_S, TargetCurve

_ROUNDING_DEG: Final = 1e-6
"""The instant of an update is found to better than this."""
_TRY_AGAIN_S: Final = 1.0


class SunFollower:
    """Mode ``TRACK`` of a controller, for both axes. Times are seconds since the start."""

    def __init__(
        self, beliefs: Beliefs, axes: Sequence[AxisControl], update_range_deg: float
    ) -> None:
        self._beliefs = beliefs
        self._axes = axes
        self.update_range_deg = update_range_deg
        self._curve = TargetCurve(beliefs.targets_deg)
        self.within = False
        """The target lies within limits, the Sun above the horizon."""
        self._change_s = NEVER_S
        self._updates_s = [NEVER_S, NEVER_S]
        self._updated_s = 0.0

    def begin(self, now_s: float) -> None:
        """Follow from now on."""
        self._updated_s = now_s
        self.reconsider(now_s)

    def reconsider(self, now_s: float) -> None:
        """Think anew where clock, site, P, O or limits are others or a limit is met."""
        self._curve = TargetCurve(self._beliefs.targets_deg)
        self.within = self._curve.is_within(now_s)
        self._change_s = self._curve.next_change_s(self.within, now_s)
        self._updates_s = [NEVER_S, NEVER_S]
        for index, axis in enumerate(self._axes):
            if self.within:
                self.keep_up(index, now_s)
            else:
                axis.stop(now_s)

    def next_event_s(self) -> float:
        return min(self._change_s, *self._updates_s)

    def limit_due(self, now_s: float) -> bool:
        """Whether the target now crosses a limit, in or out."""
        return self._change_s <= now_s

    def update_due(self, now_s: float) -> None:
        for index, due_s in enumerate(self._updates_s):
            if due_s <= now_s:
                self.keep_up(index, now_s)

    def updated(self, index: int, now_s: float) -> None:
        """An axis has arrived half the range ahead of the Sun."""
        self._updated_s = now_s
        if self._axes[index].fell_short(now_s):
            self._updates_s[index] = now_s + _TRY_AGAIN_S
        else:
            self.keep_up(index, now_s)

    def keep_up(self, index: int, now_s: float) -> None:
        """Drive half the update range ahead of the Sun if an axis (0, 1) is due, else wait."""
        axis = self._axes[index]
        if not self.within or not axis.at_rest:
            self._updates_s[index] = NEVER_S
            return
        half_deg = 0.5 * self.update_range_deg
        # The loop closes on the encoder, not on a read-out that may be frozen.
        stands_deg = axis.encoder_reading_deg(now_s)
        sense = self._curve.sense(index, now_s)
        target_deg = self._curve.target_deg(index, now_s)
        lag_deg = (target_deg - stands_deg) * sense
        too_far_ahead = -lag_deg > half_deg + 2.0 * axis.count_deg()
        if lag_deg < half_deg - _ROUNDING_DEG and not too_far_ahead:
            self._updates_s[index] = self._curve.next_update_s(index, stands_deg, half_deg, now_s)
            return
        limits = (self._beliefs.limits.axis1, self._beliefs.limits.axis2)[index]
        aim_deg = min(max(target_deg + sense * half_deg, limits.low_deg), limits.high_deg)
        if axis.drive_to(aim_deg, now_s):
            self._updates_s[index] = NEVER_S
        else:
            # One count is more than the range: look again when the Sun has moved on.
            self._updates_s[index] = now_s + _TRY_AGAIN_S

    def phase(self, now_s: float) -> float:
        """How far the wait for the next update has gone, 0..1; 0 while both axes move."""
        due_s = min(self._updates_s)
        if not self._updated_s < due_s < NEVER_S:
            return 0.0
        return (now_s - self._updated_s) / (due_s - self._updated_s)
