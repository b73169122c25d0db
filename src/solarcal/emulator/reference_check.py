"""The reference check as the controller runs it: to the switch, behind it, slowly onto it again."""

from collections.abc import Sequence
from enum import Enum, auto

from solarcal.emulator.axis_control import AxisControl
from solarcal.unit.tracker import RefCheckResult


class _Stage(Enum):
    IDLE = auto()
    SEEK = auto()
    BACK_OFF = auto()
    APPROACH = auto()
    DONE = auto()


class ReferenceCheck:
    """Progress and result of the checks since power-up. O and P are none of its business."""

    def __init__(self) -> None:
        self.referenced = False
        self._number = 0
        self._stages = [_Stage.IDLE, _Stage.IDLE]
        self._differences = [0, 0]
        self._complete = False
        self._running = False

    def start(self, axes: Sequence[AxisControl], now_s: float) -> int:
        self._number += 1
        self._complete = False
        self._running = True
        self._differences = [0, 0]
        self._stages = [_Stage.SEEK, _Stage.SEEK]
        for axis in axes:
            axis.seek_switch(now_s)
        return self._number

    def motor_stopped(self, index: int, axis: AxisControl, now_s: float) -> bool:
        """The next leg of an axis. True when both have arrived and the check is complete."""
        stage = self._stages[index]
        if stage is _Stage.SEEK:
            self._stages[index] = _Stage.BACK_OFF
            axis.back_off(now_s)
        elif stage is _Stage.BACK_OFF:
            self._stages[index] = _Stage.APPROACH
            axis.approach_switch(now_s)
        elif stage is _Stage.APPROACH:
            self._stages[index] = _Stage.DONE
            self._differences[index] = axis.zero_register(now_s)
        if all(stage is _Stage.DONE for stage in self._stages):
            self._running = False
            self._complete = self.referenced = True
        return self._complete

    def interrupt(self) -> None:
        """Stopped before the end: the check is broken; a former one still counts."""
        self._running = False
        self._stages = [_Stage.IDLE, _Stage.IDLE]

    def result(self) -> RefCheckResult:
        return RefCheckResult(
            number=self._number,
            complete=self._complete,
            difference1=self._differences[0],
            difference2=self._differences[1],
            running=self._running,
        )
